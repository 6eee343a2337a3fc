#include "solver/collision/corner_points.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "tests/support/dice.h"

namespace firn {
namespace {

// A rounded polyhedron of this size (m) about the origin.
ConvexPart cut_polyhedron(Dice& dice, double size) {
  std::vector<HalfSpace> sides;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0})
      sides.push_back({sign * Vec3::Unit(axis), dice(0.3, 0.5) * size});
  }
  for (int k = 0; k < 4; ++k) sides.push_back({dice.vector(1).normalized(), dice(0.3, 0.5) * size});
  return convex_part(sides, dice(0.01, 0.05) * size);
}

// The corners that add_corners() takes are those whose gap, computed corner by corner, is within
// the contact margin, for sizes from dust to buildings, in both roles.
TEST(CornerPoints, AreAllCornersWithinTheContactMargin) {
  Dice dice(5);
  int within = 0, beyond = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const double size = std::pow(10, dice(-5, 2)), margin = dice(1e-4, 1e-2) * size;
    const ConvexPart part = cut_polyhedron(dice, size);
    const ContactBasis frame(dice.vector(1).normalized());
    const Pose pose{dice.turn().toRotationMatrix(), dice.vector(3 * size)};
    const ProjectedPart view(part, frame, pose);
    const bool is_a = trial % 2 == 0;
    HeightGradient plane(0);
    plane.du = dice(-0.5, 0.5);
    plane.dv = dice(-0.5, 0.5);
    // Through a random vertex, about as far from it as the margin reaches.
    const int near = static_cast<int>(dice(0, part.vertex_count - 1e-9));
    const double radius = dice(0, 0.05) * size, radii = part.radius + radius;
    const PlanePoint at = view.flat(near);
    plane.at_origin = view.height(near) - plane.du * at.u - plane.dv * at.v +
                      (is_a ? 1 : -1) * (radii + dice(-3, 3) * margin);
    const auto gap_of = [&](int i) {
      const double apart = plane.height(view.flat(i)) - view.height(i);
      return (is_a ? apart : -apart) - radii;
    };
    ContactRegion region(part.vertex_count, size);
    add_corners(
        view, is_a, {}, {plane, radius}, margin, [](const PlanePoint&, double) { return true; },
        region);
    std::multiset<double> expected, found;
    for (int i = 0; i < part.vertex_count; ++i) {
      if (gap_of(i) < margin) expected.insert(view.flat(i).u);
    }
    for (int i = 0; i < region.count; ++i) found.insert(region.points[i].at.u);
    EXPECT_EQ(found, expected) << "trial " << trial;
    within += region.count;
    beyond += part.vertex_count - region.count;
  }
  EXPECT_GT(within, 2000);
  EXPECT_GT(beyond, 2000);
}

}  // namespace
}  // namespace firn
