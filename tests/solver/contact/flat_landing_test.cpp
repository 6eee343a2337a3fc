// Prisms whose base is not convex land flat on a plane.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

// Boxes of one height on connected cells of a grid, a prism whose center of mass is over the
// centroid of its base.
Shape polyomino(scenes::Random& random, int cells) {
  constexpr double kCell = 10e-3, kHeight = 8e-3, kDensity = 900;
  std::vector<std::array<int, 2>> taken = {{0, 0}};
  while (static_cast<int>(taken.size()) < cells) {
    const std::array<int, 2> from =
        taken[static_cast<std::size_t>(random.uniform(0, 1) * static_cast<double>(taken.size()))];
    const int way = static_cast<int>(random.uniform(0, 4));
    const std::array<int, 2> next = {from[0] + (way == 0) - (way == 1),
                                     from[1] + (way == 2) - (way == 3)};
    if (std::ranges::find(taken, next) == taken.end()) taken.push_back(next);
  }
  const ShapeOptions options = scenes::ice_options(0, 1e5, 1e-5);
  std::vector<Component> components;
  for (const auto& [i, k] : taken) {
    ShapeOptions own = options;
    own.density = kDensity;
    components.push_back({make_box({kCell, kCell, kHeight}, own),
                          {Mat3::Identity(), Vec3(i * kCell, k * kCell, 0)}});
  }
  return make_compound(components,
                       scenes::ice_options(kDensity * cells * kCell * kCell * kHeight, 1e5, 1e-5));
}

TEST(FlatLanding, PrismsOfAnyOutlineReboundWithoutSpin) {
  constexpr double kRestitution = 0.5, kSpeed = 0.2;
  scenes::Random random(61);
  int not_convex = 0;
  for (int member = 0; member < 40; ++member) {
    const Shape shape = polyomino(random, 2 + member % 5);
    not_convex += shape.parts.size() > 1;
    Model model = scenes::body_on_plane(shape, scenes::law(0, kRestitution));
    model.gravity.setZero();
    model.timestep = advise_timestep(model, 20).timestep;
    Solver solver(model);
    solver.insert(0, {0, 0, 4e-3 + 5e-6}, Quat::Identity(), {0, 0, -kSpeed}, Vec3::Zero());
    const double period = std::sqrt(shape.mass / shape.stiffness);
    scenes::run(solver, 5e-6 / kSpeed + 8 * period);
    const std::string what =
        "member " + std::to_string(member) + ", " + std::to_string(shape.parts.size()) + " parts";
    EXPECT_NEAR(solver.particles().velocity[0].z(), kRestitution * kSpeed, 0.01 * kSpeed) << what;
    EXPECT_LT(solver.particles().angular_velocity[0].norm() * shape.bounding_radius, 0.02 * kSpeed)
        << what;
  }
  EXPECT_GT(not_convex, 15);
}

}  // namespace
}  // namespace firn
