// Convex solids as the intersection of half-spaces.
#pragma once

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "firn/convex_part.h"

namespace firn {

// A convex polyhedron that is cut by one plane after another. Points within `tolerance` of a plane
// count as lying on it, so slivers thinner than that never arise.
class Polyhedron {
 public:
  static constexpr int kStart = -1;

  struct Facet {
    int plane = kStart;     // index of the plane that made it; kStart: a face of the box
    std::vector<int> loop;  // points, counter-clockwise seen from outside
  };

  // A box as the start.
  Polyhedron(const Vec3& lower, const Vec3& upper, double tolerance);

  // Keeps the side n . x <= offset. False when nothing is left.
  bool cut(int plane, const Vec3& n, double offset);

  const std::vector<Vec3>& points() const { return points_; }
  const std::vector<Facet>& facets() const { return facets_; }
  double tolerance() const { return tolerance_; }

 private:
  std::vector<int> clip(const std::vector<int>& loop);

  // The intersection of edge a-b and the plane. The two facets at the edge share this point.
  int crossing(int a, int b);

  // Adds the directed edges of a loop to the rim; opposite ones cancel.
  void count_edges(const std::vector<int>& loop, int sign);

  // Closes the hole of a cut with new facets. The rim contains the edges of the removed loops minus
  // those of the clipped loops. Closing it edge by edge keeps the surface closed, whatever the
  // rounding errors.
  void add_caps(int plane);

  double tolerance_;
  std::vector<Vec3> points_;
  std::vector<int> live_ = {0, 1, 2, 3, 4, 5, 6, 7};  // points not cut away
  std::vector<Facet> facets_;
  std::vector<double> height_;                    // m, [points] over the plane of the present cut
  std::map<std::pair<int, int>, int> crossings_;  // edge -> point
  std::map<std::pair<int, int>, int> rim_;        // edge, low to high -> uses
};

// Cuts by all half-spaces; plane numbers are their indices. False when nothing is left.
bool cut_by_all(Polyhedron& solid, const std::vector<HalfSpace>& half_spaces);

// The outcome of all cuts: points that three facets share, numbered without gaps.
struct SolidCorners {
  std::vector<Vec3> points;
  std::vector<Polyhedron::Facet> facets;  // by index into points
};

// Throws InputError for a solid that its planes leave open, or so thin that rounding closes it.
SolidCorners solid_corners(const Polyhedron& solid, const std::vector<HalfSpace>& half_spaces);

// m, corners of the box around the intersection. Throws InputError when it is empty or open.
std::array<Vec3, 2> solid_extents(const std::vector<HalfSpace>& half_spaces);

}  // namespace firn
