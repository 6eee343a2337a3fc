// A tower of cubes, through the public solver alone. The verification suite holds the rest.
#include <gtest/gtest.h>

#include "validation/verification/closed_forms.h"

namespace firn {
namespace {

using scenes::kGravity;
using verification::cube;

// The weight of ten cubes stands on the floor, and the tower stands still.
TEST(Stack, TenCubesStandAndWeighTenCubes) {
  const double edge = 0.1;
  Model model = scenes::empty(scenes::law(0.3, 0.3), scenes::law(0.3, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, cube(edge, 1, 1e6, 1e-3)), 10);
  scenes::add_plane(model, Vec3::Zero(), Vec3::UnitZ());
  model.timestep = 2e-5;
  Solver solver(model);
  // Each cube starts in the dent that the load above it makes: a spring that never exceeds its
  // largest load again does not lose energy, and the tower would ring.
  double sunk = 0;
  for (int i = 0; i < 10; ++i) {
    const double load = (10 - i) * kGravity, stiffness = i == 0 ? 1e6 : 0.5e6;
    sunk += load / stiffness;
    solver.insert(i, {0, 0, (i + 0.5) * edge - sunk}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  }
  scenes::run(solver, 0.5);
  const std::vector<Vec3> before = solver.particles().position;
  solver.clear_boundary_loads();
  scenes::run(solver, 0.3);
  EXPECT_NEAR(solver.boundaries()[0].impulse.z(), -10 * kGravity * 0.3, 1e-3 * 10 * kGravity * 0.3);
  EXPECT_LT(solver.energy().kinetic, 1e-6);
  for (int i = 0; i < 10; ++i) {
    EXPECT_LT((solver.particles().position[i] - before[i]).norm(), 2e-6) << "cube " << i;
  }
}

}  // namespace
}  // namespace firn
