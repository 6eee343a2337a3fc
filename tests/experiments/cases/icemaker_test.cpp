// The shipped icemaker at full size: its geometry, and that it works as a machine.
#include <gtest/gtest.h>

#include <algorithm>

#include "experiments/case/case.h"
#include "experiments/case_reader/process/insertion.h"
#include "experiments/case_reader/read_case.h"
#include "firn/solver.h"
#include "tests/support/dice.h"

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

// Pressed in the middle between two supports, by slow enough a platen, a cube of two halves bears
// F = 4 W sigma / l: W of the section, l between the supports. The contact of the halves at the
// compressed edge adds some of it, and the way in which the cube bends.
TEST(Icemaker, ACubeOfTwoHalvesBearsTheStrengthOfItsBond) {
  const std::string file = std::string(FIRN_SOURCE_DIR) + "/cases/icemaker/bending_test.toml";
  Dice dice(3);
  for (int trial = 0; trial < 6; ++trial) {
    const double strength = dice(0.03, 0.2);  // MPa
    const std::string text = "\"" + std::to_string(strength) + " MPa\"";
    const Case c =
        read_case(file, {{"bonds.0.tensile_strength", text}, {"bonds.0.shear_strength", text}});
    const BeamSection& section = c.model.beams[0].section;
    const double modulus = section.inertia.y() / section.half_height, span = 44e-3;
    Solver solver(c.model);
    for (int piece = 0; piece < 2; ++piece) {
      const InletPose pose = inlet_pose(c.inlets[0], index(piece), piece, c.seed);
      solver.insert(piece, pose.position, pose.orientation, Vec3::Zero(), Vec3::Zero());
    }
    double largest = 0;
    while (solver.bond(0).acts && solver.time() < 1) {
      solver.step();
      largest = std::max(largest, solver.frame_load(0).force.norm());
    }
    ASSERT_FALSE(solver.bond(0).acts);
    const double expected = 4 * modulus * 1e6 * strength / span;
    EXPECT_GT(largest, 0.95 * expected) << strength;
    EXPECT_LT(largest, 1.25 * expected) << strength;
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
