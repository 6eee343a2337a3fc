// [initial_state]: a case that begins where an earlier run ended.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "experiments/case_reader/read_case.h"
#include "experiments/results/results_file.h"
#include "experiments/run/run.h"
#include "tests/support/error_of.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

using testing::HasSubstr;

// A drawer that is pulled, cubes lying in it, one that flies, an arm that swings on a spring, and a
// top. Nothing but the cubes touches anything.
constexpr const char* kScene = R"(
[case]
duration = "0.3 s"
steps_per_loading = 6

[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "2 MPa"
[materials.plastic]
young_modulus = "2 GPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.2
[interactions.ice-plastic]
static_friction = 0.4
restitution = 0.2
[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
rounding = "1 mm"
[shapes.brick]
kind = "box"
size = "40 20 20 mm"
material = "ice"
rounding = "1 mm"

[[motion_frames]]
name = "drawer"
position = "0 0 -10 mm"
[[motion_frames.motions]]
kind = "translation"
velocity = "100 0 0 mm/s"
[[motion_frames]]
name = "arm"
position = "0 0 200 mm"
[motion_frames.free]
mass = "20 g"
[[motion_frames.free.joints]]
kind = "rotation"
direction = [0, 1, 0]
stiffness = "0.5 N m/rad"
spring_reference = "20 deg"
[[motion_frames]]
name = "top"
position = "0 200 200 mm"
[motion_frames.free]
mass = "20 g"
center = "5 200 200 mm"
inertia = "1e-6 2e-6 3e-6 kg m^2"
free_rotation = true

[[boundaries]]
name = "floor"
kind = "box"
material = "plastic"
size = "300 300 20 mm"
position = "0 0 -10 mm"
motion_frame = "drawer"
[[boundaries]]
name = "bar"
kind = "box"
material = "plastic"
size = "100 10 10 mm"
position = "60 0 200 mm"
motion_frame = "arm"
[[sensors]]
name = "low"
point = "0 0 15 mm"
normal = [0, 0, -1]
[output]
frame_interval = "10 ms"
)";

constexpr const char* kCubes = R"(
[[inlets]]
name = "row"
shape = "cube"
position = "-60 0 9.9 mm"
grid = [3, 1, 1]
spacing = "40 1 1 mm"
tag = 1
tag_mode = "batch"
[[inlets]]
name = "flying"
shape = "brick"
position = "0 80 100 mm"
velocity = "0.1 0.2 0.5 m/s"
rotation_jitter = "40 deg"
rotation_jitter_axis = [1, 2, 3]
tag = 7
start = "0.05 s"
)";

constexpr std::size_t kFrame = 15;  // at 0.15 s

class StartTest : public ResultsFolder {
 protected:
  Case read(const std::string& more, const std::vector<Override>& overrides = {}) const {
    return read_case_text(std::string(kScene) + more, "c.toml", path(""), overrides);
  }
  void run_whole(const std::vector<Override>& overrides = {}) {
    const RunSummary summary = run(read(kCubes, overrides), options("whole.h5"));
    ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  }
  std::string error_of(const std::string& more, const std::vector<Override>& overrides = {}) const {
    return test::error_if_any([&] { read(more, overrides); });
  }
};

constexpr const char* kMiddle = "[initial_state]\nfile = \"whole.h5\"\ntime = \"0.15 s\"\n";

double distance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return (Vec3(a.data()) - Vec3(b.data())).norm();
}

TEST_F(StartTest, GoesOnAsTheEarlierRunDid) {
  run_whole();
  const RunSummary summary =
      run(read(kMiddle, {{"case.duration", "0.15 s"}}), options("second.h5"));
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  const Recording whole(path("whole.h5")), second(path("second.h5"));
  ASSERT_EQ(second.particle_count(), 4u);
  const std::vector<double> times = second.frame_times();
  ASSERT_GE(times.size(), 15u);
  const auto series = [&](const std::string& series_path, std::size_t width, std::size_t i) {
    const std::vector<double> a = whole.series(series_path), b = second.series(series_path);
    double most = 0;
    for (std::size_t k = 0; k < width; ++k)
      most = std::max(most, std::abs(a.at((kFrame + i) * width + k) - b.at(i * width + k)));
    return most;
  };
  bool landed = false;
  for (std::size_t i = 0; i < 15; ++i) {
    SCOPED_TRACE(i);
    const Frame a = whole.frame(kFrame + i), b = second.frame(i);
    ASSERT_NEAR(b.time, a.time - 0.15, 1e-4);
    // A body that touches nothing flies the same way. Contacts are searched at other times: bodies
    // that touch agree to the precision of that.
    const bool flies = a.position[3][2] > 25e-3;
    landed |= !flies;
    EXPECT_LT(distance(a.position[3], b.position[3]), flies ? 1e-12 : 2e-6);
    const double turned = distance(a.angular_velocity[3], b.angular_velocity[3]);
    EXPECT_LT(turned, flies ? 1e-9 : 0.1);
    for (std::size_t p = 0; p < 3; ++p) EXPECT_LT(distance(a.position[p], b.position[p]), 2e-6);
    EXPECT_LT(series("/motion_frames/drawer/position", 3, i), 1e-12);
    EXPECT_LT(series("/boundaries/floor/position", 3, i), 1e-12);
    EXPECT_LT(series("/motion_frames/arm/coordinate", 1, i), 1e-12);
    EXPECT_LT(series("/boundaries/bar/orientation", 4, i), 1e-12);
    EXPECT_LT(series("/motion_frames/top/orientation", 4, i), 1e-9);
    EXPECT_LT(series("/motion_frames/top/angular_velocity", 3, i), 1e-9);
  }
  EXPECT_TRUE(landed);
  EXPECT_LT(whole.series("/motion_frames/top/angular_velocity").at(3 * 29 + 1),
            -1.0);  // it does turn
}

// The cubes rest on the floor with an overlap above 1 % of their sweep radius.
TEST_F(StartTest, OverlapsOfTheStartAreNotLateContacts) {
  const std::vector<Override> softer = {{"materials.ice.young_modulus", "50 kPa"}};
  run_whole(softer);
  std::vector<Override> second = softer;
  second.emplace_back("case.duration", "10 ms");
  const RunSummary summary = run(read(kMiddle, second), options("second.h5"));
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  const Recording recording(path("second.h5"));
  const std::vector<double> overlap = recording.series("/diagnostics/largest_overlap");
  const std::vector<double> late = recording.series("/diagnostics/late_contacts");
  EXPECT_GT(overlap.back(), 0.01 * 1e-3);
  EXPECT_EQ(late.back(), 0);
}

TEST_F(StartTest, KeepsWhoParticlesAreAndSinceWhenTheyAreThere) {
  run_whole();
  const Case c = read(std::string(kMiddle) + "tags = [7]\n");
  ASSERT_EQ(c.placed.size(), 1u);
  EXPECT_EQ(c.model.shapes.at(static_cast<std::size_t>(c.model.particles[0].shape)).name, "brick");
  EXPECT_EQ(c.model.particles[0].tag, 7);
  EXPECT_EQ(c.placed[0].batch, 0);
  EXPECT_NEAR(c.placed[0].insert_time, -0.1, 1e-3);
  EXPECT_EQ(read(std::string(kMiddle) + "batches = [0]\n").placed.size(), 4u);
  // Before it came, it is not there.
  EXPECT_EQ(read(kMiddle, {{"start.time", "40 ms"}}).placed.size(), 3u);
  EXPECT_EQ(read("[initial_state]\nfile = \"whole.h5\"\n").placed.size(), 4u);  // the end
  EXPECT_THAT(c.start, HasSubstr("1 particles and 3 motion frames"));
}

TEST_F(StartTest, ResolvedCaseNeedsTheFileNoMore) {
  run_whole();
  const Case c = read(kMiddle);
  run_whole({{"sources.flying.velocity", "0 0 0.5 m/s"}});  // whole.h5 is another one now
  EXPECT_NE(case_hash(read(kMiddle)), case_hash(c));
  std::filesystem::remove(path("whole.h5"));
  const Case again = read_case_text(c.resolved, "again.toml", "/");
  EXPECT_EQ(again.resolved, c.resolved);
  ASSERT_EQ(again.placed.size(), c.placed.size());
  for (std::size_t i = 0; i < c.placed.size(); ++i) {
    EXPECT_EQ(again.placed[i].position, c.placed[i].position);
    EXPECT_EQ(again.placed[i].orientation.coeffs(), c.placed[i].orientation.coeffs());
    EXPECT_EQ(again.placed[i].velocity, c.placed[i].velocity);
  }
  // A request for another time is not ignored. It is an error if there is no state at that time.
  EXPECT_THROW(read_case_text(c.resolved, "again.toml", "/", {{"initial_state.time", "0.1 s"}}),
               InputError);
}

// A resolved case of an earlier version, as its results file has it.
TEST_F(StartTest, ReadsTheFirstNameOfTheAngularVelocityOfAFrame) {
  run_whole();
  const Case c = read(kMiddle);
  ASSERT_EQ(c.frame_starts.size(), 3u);
  EXPECT_GT(c.frame_starts[2].relative_angular_velocity.norm(), 0.1);
  const std::string name = "relative_angular_velocity";
  std::string first = c.resolved;
  ASSERT_NE(first.find(name), std::string::npos);
  first.replace(first.find(name), name.size(), "spin");
  ASSERT_EQ(first.find(name), std::string::npos);
  const Case again = read_case_text(first, "again.toml", "/", {}, {}, OldNames::accept);
  EXPECT_EQ(again.resolved, c.resolved);
  EXPECT_EQ(case_hash(again), case_hash(c));
  EXPECT_EQ(again.frame_starts.at(2).relative_angular_velocity,
            c.frame_starts[2].relative_angular_velocity);
}

TEST_F(StartTest, RefusesWhatDoesNotFit) {
  run_whole();
  const std::string file = path("whole.h5");
  EXPECT_THAT(error_of("[initial_state]\nfile = \"none.h5\"\n"),
              testing::MatchesRegex("c.toml:[0-9]+: initial_state.file: .*none.h5: no such file"));
  EXPECT_THAT(
      error_of("[initial_state]\nfile = \"whole.h5\"\ntime = \"2 s\"\n"),
      HasSubstr("initial_state.time: is 2 s, where \"" + file + "\" has no frame; expected"));
  EXPECT_THAT(error_of(std::string(kMiddle) + "tags = [8]\n"), HasSubstr("has none of the part"));
  EXPECT_THAT(error_of(std::string(kMiddle) + "tags = [\"a\"]\n"),
              HasSubstr("initial_state.tags: holds"));
  EXPECT_THAT(error_of(kMiddle, {{"shapes.cube.mass", "9 g"}}),
              HasSubstr("initial_state.file: shape \"cube\" is another one in \"" + file +
                        "\": mass is 0.009 kg here and 0.00733"));
  EXPECT_THAT(error_of(kMiddle, {{"shapes.brick.size", "41 20 20 mm"}}), HasSubstr("mass is"));
  EXPECT_THAT(error_of(kMiddle, {{"shapes.cube.rounding", "2 mm"}}), HasSubstr("rounding is"));
  EXPECT_THAT(error_of(kMiddle, {{"motion_frames.arm.position", "0 0 201 mm"}}),
              HasSubstr("motion frame \"arm\" is another one in \"" + file +
                        "\": its position differs; expected the same, or another name"));
  EXPECT_THAT(error_of(kMiddle, {{"motion_frames.arm.free.joints.0.direction", "[1, 0, 0]"}}),
              HasSubstr("its set of axes differs"));
  EXPECT_EQ(error_of(kMiddle, {{"shapes.cube.stiffness", "5e4 N/m"}}), "");
  std::ofstream(path("text.h5")) << "no results";
  EXPECT_THAT(error_of("[initial_state]\nfile = \"text.h5\"\n"), HasSubstr("not a results file"));
}

TEST_F(StartTest, TakesAnUnfinishedRunOnlyAtATime) {
  std::atomic<bool> stop = false;
  RunOptions stopped = options("whole.h5");
  stopped.interrupt = &stop;
  stopped.each_step = [&](const Solver& solver, bool) { stop = solver.time() > 0.2; };
  ASSERT_EQ(run(read(kCubes), stopped).status, RunStatus::interrupted);
  EXPECT_THAT(error_of("[initial_state]\nfile = \"whole.h5\"\n"),
              HasSubstr("holds a run that is not finished (interrupted); expected a finished one"));
  EXPECT_EQ(error_of(kMiddle), "");
}

}  // namespace
}  // namespace firn
