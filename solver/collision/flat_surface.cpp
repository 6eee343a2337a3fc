// Finds plane surfaces that are not convex, and so are the faces of several parts: which faces
// belong together.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "solver/collision/narrowphase.h"
#include "solver/collision/surface_pieces.h"

namespace firn {
namespace {

struct SurfaceFace {
  int part, face;
  const ConvexPart::Face* plane;
  FlatSurface::Piece piece;
  double key;  // faces of one plane have like keys
};

// True when the two pieces of one plane have a stretch of an edge in common.
bool do_adjoin(const FlatSurface::Piece& a, const FlatSurface::Piece& b, double tolerance) {
  if ((a.center - b.center).norm() > a.radius + b.radius + tolerance) return false;
  for (std::size_t i = 0; i < a.corners.size(); ++i) {
    const LineSegment side = side_of(a, i);
    const double length = (side.to - side.from).norm();
    if (!(length > tolerance)) continue;
    for (std::size_t k = 0; k < b.corners.size(); ++k) {
      double from, to;
      if (!is_on_line(side, side_of(b, k), tolerance, from, to) || from < to) continue;
      if (std::min(from, length) - std::max(to, 0.0) > 10 * tolerance) return true;
    }
  }
  return false;
}

std::vector<SurfaceFace> faces_at_internal_faces(const std::vector<ConvexPart>& parts,
                                                 double size) {
  std::vector<SurfaceFace> faces;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (parts[p].internal_normals.empty()) continue;
    for (std::size_t f = 0; f < parts[p].faces.size(); ++f) {
      const ConvexPart::Face& face = parts[p].faces[f];
      if (face.internal) continue;
      const double key = face.normal.dot(Vec3(0.8231, 0.4157, 0.3869)) + face.offset / size * 0.713;
      faces.push_back(
          {static_cast<int>(p), static_cast<int>(f), &face, piece_of(parts[p], face), key});
    }
  }
  std::ranges::stable_sort(faces, {}, &SurfaceFace::key);
  return faces;
}

double extent_of(const std::vector<ConvexPart>& parts) {
  double extent = 0;
  for (const ConvexPart& part : parts) {
    for (int i = 0; i < part.vertex_count; ++i) extent = std::max(extent, part.vertex(i).norm());
  }
  return extent;
}

}  // namespace

int FlatSurfaces::find(const ConvexPart& part, int number, const ContactFeature& feature) const {
  if (empty()) return -1;
  const std::vector<std::int32_t>& own = of_face[static_cast<std::size_t>(number)];
  if (feature.kind == ContactFeature::Kind::face)
    return own[static_cast<std::size_t>(feature.face - part.faces.data())];
  if (feature.kind == ContactFeature::Kind::vertex) return -1;
  for (std::size_t f = 0; f < own.size(); ++f) {
    if (own[f] < 0) continue;
    const auto first = part.face_vertices.begin() + part.faces[f].first;
    const auto last = first + part.faces[f].count;
    if (std::find(first, last, feature.ends[0]) != last &&
        std::find(first, last, feature.ends[1]) != last)
      return own[f];
  }
  return -1;
}

FlatSurfaces find_flat_surfaces(const std::vector<ConvexPart>& parts) {
  constexpr double kParallel = 1e-6, kKey = 1e-5;
  FlatSurfaces out;
  const double size = extent_of(parts), tolerance = kNoGap * size;
  if (!(size > 0)) return out;
  const std::vector<SurfaceFace> faces = faces_at_internal_faces(parts, size);
  // Sets of faces that adjoin each other, by their first member.
  std::vector<int> first(faces.size());
  std::iota(first.begin(), first.end(), 0);
  const auto set_of = [&](int i) {
    while (first[static_cast<std::size_t>(i)] != i) {
      int& next = first[static_cast<std::size_t>(i)];
      next = first[static_cast<std::size_t>(next)];
      i = next;
    }
    return i;
  };
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (std::size_t k = i + 1; k < faces.size() && faces[k].key - faces[i].key <= kKey; ++k) {
      const ConvexPart::Face &a = *faces[i].plane, &b = *faces[k].plane;
      if (faces[i].part == faces[k].part || (a.normal - b.normal).norm() > kParallel ||
          std::abs(a.offset - b.offset) > tolerance ||
          !do_adjoin(faces[i].piece, faces[k].piece, tolerance))
        continue;
      const int one = set_of(static_cast<int>(i)), other = set_of(static_cast<int>(k));
      first[static_cast<std::size_t>(std::max(one, other))] = std::min(one, other);
    }
  }
  std::vector<std::vector<int>> sets(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i)
    sets[static_cast<std::size_t>(set_of(static_cast<int>(i)))].push_back(static_cast<int>(i));
  for (const std::vector<int>& set : sets) {
    if (set.size() < 2) continue;
    if (out.of_face.empty()) {
      for (const ConvexPart& part : parts) out.of_face.emplace_back(part.faces.size(), -1);
    }
    std::vector<FlatSurface::Piece> pieces;
    std::vector<Aabb> boxes;
    for (const int i : set) {
      const SurfaceFace& face = faces[static_cast<std::size_t>(i)];
      out.of_face[static_cast<std::size_t>(face.part)][static_cast<std::size_t>(face.face)] =
          static_cast<std::int32_t>(out.surfaces.size());
      const Vec3 reach = Vec3::Constant(face.piece.radius + 10 * tolerance);
      boxes.push_back({face.piece.center - reach, face.piece.center + reach});
      pieces.push_back(face.piece);
    }
    out.surfaces.push_back({std::move(pieces), AabbTree(std::move(boxes))});
  }
  return out;
}

}  // namespace firn
