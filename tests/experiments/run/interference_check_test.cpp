// Machines that cannot work are refused before a run begins.
#include "experiments/run/interference_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/analysis/random_stream.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/run/placement.h"
#include "experiments/run/run.h"
#include "firn/solver.h"
#include "tests/support/error_of.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

using testing::HasSubstr;
using testing::MatchesRegex;

constexpr const char* kHead = R"([case]
duration = "2 s"
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "2 MPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.2
[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
rounding = "0.1 mm"
)";

constexpr const char* kCube = "[[particles]]\nshape = \"cube\"\nposition = \"0 0 500 mm\"\n";

std::string box(const std::string& name, const std::string& size, const std::string& position,
                const std::string& more = "") {
  return "[[boundaries]]\nname = \"" + name + "\"\nkind = \"box\"\nmaterial = \"ice\"\nsize = \"" +
         size + " mm\"\nposition = \"" + position + " mm\"\n" + more + "\n";
}

std::string interference_error(const std::string& scene,
                               const std::vector<Override>& overrides = {}) {
  return test::error_if_any(
      [&] { check_machine(read_case_text(kHead + scene, "c.toml", ".", overrides)); });
}

// A blade of 100 mm that turns about z, and a post.
std::string blade(const std::string& post, const std::string& more = "") {
  return kCube +
         box("blade", "100 10 10", "50 0 0",
             more +
                 "[[boundaries.motions]]\nkind = \"rotation\"\naxis = [0, 0, 1]\n"
                 "angular_velocity = \"1 rpm\"\n") +
         box("post", "10 10 100", post);
}

TEST(MachineCheck, FindsWhatATurnRunsInto) {
  // 60 s a turn, in a case of 2 s: it comes 12 degrees far.
  EXPECT_EQ(interference_error(blade("0 90 0")), "");
  EXPECT_THAT(interference_error(blade("0 90 0"), {{"case.duration", "60 s"}}),
              MatchesRegex("c.toml:[0-9]+: boundaries.post: \"post\" overlaps boundary \"blade\" "
                           "1[0-9.]+ s after the start, by .* mm near .*; expected room between "
                           "them, or allow_overlap_with = ..blade.. where it does not matter"));
  EXPECT_EQ(interference_error(blade("0 120 0"), {{"case.duration", "60 s"}}), "");
  EXPECT_THAT(interference_error(blade("95 0 0")),
              HasSubstr("overlaps boundary \"blade\" at the start"));
  EXPECT_EQ(interference_error(blade("95 0 0", "allow_overlap_with = [\"post\"]\n")), "");
  EXPECT_EQ(interference_error(blade("106 0 0")), "");  // touches, and moves away
  EXPECT_THAT(interference_error(blade("95 0 0", "allow_overlap_with = [\"past\"]\n")),
              HasSubstr("boundaries.blade.allow_overlap_with: unknown boundary \"past\""));
}

TEST(MachineCheck, LeavesOutWhatIsFixedToEachOther) {
  const std::string frame =
      "[[motion_frames]]\nname = \"f\"\n[[motion_frames]]\nname = \"g\"\n"
      "parent = \"f\"\n";
  const std::string crossed = box("a", "20 20 20", "0 0 0", "motion_frame = \"f\"") +
                              box("b", "20 20 20", "5 0 0", "motion_frame = \"g\"");
  EXPECT_EQ(interference_error(frame + kCube + crossed), "");
  EXPECT_EQ(interference_error(frame + kCube + crossed,
                               {{"motion_frames.f.motions",
                                 "[{ kind = \"translation\", velocity = \"1 0 0 m/s\" }]"}}),
            "");
  EXPECT_THAT(interference_error(frame + kCube + crossed,
                                 {{"motion_frames.g.motions",
                                   "[{ kind = \"translation\", velocity = \"1 0 0 m/s\" }]"}}),
              HasSubstr("\"b\" overlaps boundary \"a\" at the start"));
}

TEST(MachineCheck, FollowsWhatAStageStarts) {
  const std::string scene =
      "[[motion_frames]]\nname = \"drawer\"\n" + std::string(kCube) +
      box("tray", "100 100 20", "0 0 0", "motion_frame = \"drawer\"") +
      box("door", "5 100 100", "60 0 0") +
      "[[boundaries]]\nname = \"floor\"\nkind = \"plane\"\nmaterial = \"ice\"\n"
      "point = \"0 0 -10 mm\"\nnormal = [0, 0, 1]\n"
      "[[stages]]\nname = \"wait\"\nmax_duration = \"1 s\"\n"
      "[[stages]]\nname = \"pull\"\nmax_duration = \"1 s\"\n"
      "[[stages.motions]]\nmotion_frame = \"drawer\"\nkind = \"translation\"\n"
      "velocity = \"0.1 0 0 m/s\"\nends_with_stage = true\n";
  EXPECT_THAT(interference_error(scene),
              MatchesRegex(".*\"door\" overlaps boundary \"tray\" 0.0?[0-9]+ s after the start in "
                           "stage \"pull\", by.*"));
  EXPECT_EQ(interference_error(scene, {{"stages.pull.remove", "[\"door\"]"}}), "");
  EXPECT_THAT(interference_error(scene, {{"stages.pull.remove", "[\"door\"]"},
                                         {"boundaries.floor.point", "0 0 -5 mm"}}),
              HasSubstr("\"floor\" overlaps boundary \"tray\" at the start, by 5 mm"));
}

// A hinged bar that a motor lifts towards a block above it.
TEST(MachineCheck, TakesFreeFramesWhereTheirDrivesDo) {
  const std::string scene =
      "[[motion_frames]]\nname = \"arm\"\n[motion_frames.free]\nmass = \"20 g\"\n"
      "[[motion_frames.free.joints]]\nkind = \"rotation\"\ndirection = [0, -1, 0]\n"
      "upper = \"80 deg\"\n[[motion_frames.free.joints.motors]]\nspeed = \"1 rad/s\"\n"
      "to = \"45 deg\"\n" +
      std::string(kCube) + box("bar", "100 10 10", "60 0 0", "motion_frame = \"arm\"") +
      box("mold", "20 20 20", "40 0 90");
  EXPECT_EQ(interference_error(scene), "");
  EXPECT_THAT(
      interference_error(scene, {{"motion_frames.arm.free.joints.0.motors.0.to", "70 deg"}}),
      MatchesRegex(".*\"mold\" overlaps boundary \"bar\" with \"arm\" at [56][0-9.]+ deg.*"));
}

TEST(MachineCheck, RefusesParticlesInWalls) {
  const std::string scene = std::string(kCube) + box("floor", "100 100 20", "0 0 -10");
  EXPECT_EQ(interference_error(scene, {{"particles.0.position", "0 0 9.5 mm"}}), "");
  EXPECT_THAT(interference_error(scene, {{"particles.0.position", "0 0 8.5 mm"}}),
              MatchesRegex("c.toml:14: particles.0: particle 0 lies more than 1 mm inside boundary "
                           "\"floor\"; expected a free place"));
}

TEST(MachineCheck, RefusesParticlesInParticles) {
  const std::string scene =
      std::string(kCube) + kCube + "[[particles]]\nshape = \"cube\"\nposition = \"40 0 0 mm\"\n";
  const auto error = [&](const std::string& second) {
    return interference_error(scene, {{"particles.1.position", second}});
  };
  EXPECT_EQ(error("0 0 480.5 mm"), "");
  EXPECT_THAT(error("0 0 481.5 mm"),
              MatchesRegex("c.toml:17: particles.1: particle 1 lies more than 1 mm inside particle "
                           "0; expected a free place"));
  EXPECT_THAT(error("0 0 500 mm"), HasSubstr("c.toml:17: particles.1:"));
  EXPECT_THAT(error("58.5 0 0 mm"), HasSubstr("c.toml:20: particles.2: particle 2 lies more"));
}

// Random pairs of concave cubes. What is refused is what an inlet takes for an obstacle. The first
// step of the solver alone does not see all of it: contacts at internal faces of two bodies that
// lie in each other have no force. Depths near the limit are left out of that comparison, since the
// solver measures them along the normal of the contact.
TEST(MachineCheck, RefusesWhatInletsAndTheFirstStepRefuse) {
  const std::string scene = R"([shapes.lump]
kind = "crescent"
material = "ice"
rounding = "0.5 mm"
[[particles]]
shape = "lump"
position = "0 0 0 m"
[[particles]]
shape = "lump"
position = "0 0 0 m"
)";
  Case c = read_case_text(kHead + scene, "c.toml", ".");
  const int shape = c.model.particles[1].shape;
  const double limit = 0.05 * c.model.shapes[static_cast<std::size_t>(shape)].box.minCoeff();
  RandomStream random(1, 0, 0);
  int refused = 0, accepted = 0, stopped = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 direction = random.uniform_rotation() * Vec3::UnitX();
    const double distance = 0.005 + 0.04 * random.uniform();
    for (Case::InitialParticle& p : c.placed) p.orientation = random.uniform_rotation();
    const auto refuses = [&](double at) {
      c.placed[1].position = at * direction;
      return !test::error_if_any([&] { check_machine(c); }).empty();
    };
    const bool near_limit = refuses(distance - 1e-3) != refuses(distance + 1e-3);
    const bool refuses_it = refuses(distance);
    ++(refuses_it ? refused : accepted);
    Solver one(c.model), both(c.model);
    const Case::InitialParticle &a = c.placed[0], &b = c.placed[1];
    one.insert(0, a.position, a.orientation, a.velocity, a.angular_velocity);
    EXPECT_EQ(refuses_it, one.overlaps(shape, b.position, b.orientation, -limit)) << i;
    place_start(both, c);
    const bool stops = !test::error_if_any<RunError>([&] { both.step(); }).empty();
    stopped += stops;
    EXPECT_TRUE(refuses_it || !stops || near_limit) << i;
  }
  EXPECT_GT(refused, 50);
  EXPECT_GT(accepted, 50);
  EXPECT_GT(stopped, 20);
}

class MachineCheckRun : public ResultsFolder {};

TEST_F(MachineCheckRun, StopsARunBeforeItsFileIsMade) {
  const Case c = read_case_text(kHead + blade("95 0 0"), "c.toml", ".");
  EXPECT_THROW(run(c, options("run.h5")), InputError);
  EXPECT_FALSE(std::filesystem::exists(path("run.h5")));
}

TEST_F(MachineCheckRun, RefusesASourceInAWallHoweverSharpItsShapes) {
  const std::string scene =
      "[[inlets]]\nname = \"s\"\nshape = \"cube\"\nposition = \"0 0 8 mm\"\n" +
      box("floor", "100 100 20", "0 0 -10");
  EXPECT_THAT(
      test::error_of([&] { run(read_case_text(kHead + scene, "c.toml", "."), options("run.h5")); }),
      HasSubstr("c.toml:14: inlets.s: body 1 of \"s\" at t = 0 s overlaps boundary \"floor\""));
}

TEST(SceneNames, AreUniqueAndNoPaths) {
  const std::string source = "[[inlets]]\nname = \"s\"\nshape = \"cube\"\nposition = \"0 0 0 m\"\n";
  EXPECT_THAT(interference_error(source + source),
              HasSubstr("inlets.1.name: \"s\" is taken already"));
  for (const char* what : {"inlets.0.name", "stages.0.name"})
    EXPECT_THAT(interference_error(source + "[[stages]]\nname = \"a\"\nmax_duration = \"1 s\"\n",
                                   {{what, "a/b"}}),
                HasSubstr(".\"a/b\".name: is \"a/b\"; expected a name without slashes"));
}

// The shipped machine with one dimension wrong.
TEST(MachineCheckIcemaker, PassesAsShippedAndNotWithATooLargeAuger) {
  const std::string folder = std::string(FIRN_SOURCE_DIR) + "/cases/icemaker/";
  for (const char* name :
       {"harvest", "bucket_pull", "bucket_pull_paddle", "auger_half", "auger_full",
        "auger_compression", "auger_press", "arm_binding", "arm_linkage", "arm_clearance",
        "glass_impact", "platen_test", "full_cycle"})
    EXPECT_NO_THROW(check_machine(read_case(folder + name + ".toml"))) << name;
  const auto refused = [&](const std::string& key, const std::string& value) {
    return test::error_of([&] {
      check_machine(read_case(folder + "auger_half.toml", {{key, value}}));
    });
  };
  EXPECT_THAT(refused("boundaries.auger.position", "-76 0 28 mm"),
              MatchesRegex(".*process.toml:[0-9]+: boundaries.auger: \"auger\" overlaps boundary "
                           "\"bucket\" at the start.*"));
  EXPECT_THAT(refused("boundaries.ejector.tip_radius", "38.6 mm"),
              HasSubstr("\"ejector\" overlaps boundary \"mold\""));
}

}  // namespace
}  // namespace firn
