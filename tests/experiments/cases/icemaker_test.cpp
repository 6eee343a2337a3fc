// The shipped icemaker at full size: its geometry, and that it works as a machine.
#include <gtest/gtest.h>

#include "experiments/case/case.h"
#include "experiments/case_reader/read_case.h"
#include "firn/solver.h"

namespace firn {
namespace {

// Materials, the cube and a placement, over cases/icemaker/machine.toml.
Case icemaker(const std::string& more) {
  const std::string text = R"(
include = "machine.toml"
[case]
duration = "10 s"
steps_per_loading = 6
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "0.01 GPa"
[materials.plastic]
young_modulus = "2 GPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.3
[interactions.ice-plastic]
static_friction = 0.2
restitution = 0.3
[shapes.cube]
kind = "crescent"
material = "ice"
rounding = "1 mm"
)" + more;
  const std::string folder = std::string(FIRN_SOURCE_DIR) + "/cases/icemaker";
  return read_case_text(text, folder + "/test.toml", folder);
}

// In the cavities, where the water froze.
const char* const kFrozen = R"(
[[particles]]
shape = "cube"
grid = [8, 1, 1]
spacing = "25 1 1 mm"
position = "-102.5 -45 172.943 mm"
orientation = [0.7071067811865476, 0, 0, 0.7071067811865476]
)";

Solver started(const Case& c) {
  Solver solver(c.model);
  for (const Case::InitialParticle& p : c.placed) {
    solver.insert(p.particle, p.position, p.orientation, p.velocity, p.angular_velocity);
  }
  return solver;
}

void run_until(Solver& solver, double time) {
  while (solver.time() < time) solver.step();
}

TEST(Icemaker, IsClosedAndHoldsItsCrescents) {
  const Case c = icemaker(kFrozen);
  for (const Boundary& b : c.model.boundaries) {
    EXPECT_TRUE(inspect(b.mesh).is_valid()) << b.name << ": " << inspect(b.mesh).to_message();
  }
  Solver solver(c.model);
  for (const Case::InitialParticle& p : c.placed) {
    // The clearance is 1 mm, less the flats of both arcs, 0.05 and 0.09 mm.
    EXPECT_FALSE(solver.overlaps(0, p.position, p.orientation, 0.8e-3));
    EXPECT_TRUE(solver.overlaps(0, p.position, p.orientation, 1.1e-3));
  }
}

TEST(IcemakerLong, EjectorSweepsTheCrescentsOverTheStripperIntoTheBucket) {
  const Case c = icemaker(std::string(kFrozen) + R"(
[[boundaries]]
name = "ejector"
[[boundaries.motions]]
kind = "rotation"
axis = [1, 0, 0]
center = "0 -45 200 mm"
angular_velocity = "-30 rpm"
start = "0.2 s"
stop = "2.2 s"
[[boundaries]]
name = "arm"
[[boundaries.motions]]
kind = "rotation"
axis = [1, 0, 0]
center = "0 -55 190 mm"
angular_velocity = "75 deg/s"
stop = "0.6 s"
)");
  Solver solver = started(c);
  run_until(solver, 3);
  for (const Vec3& p : solver.particles().position) {
    EXPECT_LT(std::abs(p.x()), 150e-3);
    EXPECT_LT(std::abs(p.y()), 75e-3);
    EXPECT_GT(p.z(), 0);
    EXPECT_LT(p.z(), 100e-3);
  }
  EXPECT_LT(solver.diagnostics().largest_overlap, 1e-3);
}

}  // namespace
}  // namespace firn
