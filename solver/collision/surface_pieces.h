// Pieces of plane surfaces, and their edges.
#pragma once

#include <algorithm>
#include <cstddef>

#include "solver/collision/narrowphase.h"

namespace firn {

inline constexpr double kNoGap = 1e-6;  // of the size of the body

struct LineSegment {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
};

// The edge from corner i on.
inline LineSegment side_of(const FlatSurface::Piece& piece, std::size_t i) {
  return {piece.corners[i], piece.corners[i + 1 < piece.corners.size() ? i + 1 : 0]};
}

inline FlatSurface::Piece piece_of(const ConvexPart& part, const ConvexPart::Face& face) {
  FlatSurface::Piece piece;
  for (int i = 0; i < face.count; ++i)
    piece.corners.push_back(part.vertex(part.face_vertices[face.first + i]));
  for (const Vec3& x : piece.corners) piece.center += x / static_cast<double>(face.count);
  for (const Vec3& x : piece.corners)
    piece.radius = std::max(piece.radius, (x - piece.center).norm());
  return piece;
}

// The ends of b as lengths along a, if both lie on its line.
inline bool is_on_line(const LineSegment& a, const LineSegment& b, double tolerance, double& from,
                       double& to) {
  const double length = (a.to - a.from).norm();
  const Vec3 along = (a.to - a.from) / length;
  const Vec3 p = b.from - a.from, q = b.to - a.from;
  from = along.dot(p);
  to = along.dot(q);
  return (p - from * along).norm() <= tolerance && (q - to * along).norm() <= tolerance;
}

}  // namespace firn
