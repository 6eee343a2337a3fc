// The scene language in runs: frames, inlets, limit switches, sensors, tags, events.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <string>
#include <vector>

#include "experiments/results/results_file.h"
#include "experiments/run/run.h"
#include "experiments/storage/hdf5_file.h"
#include "tests/experiments/run/harvest_scene.h"
#include "tests/support/error_of.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using harvest_scene::kHarvest;
using harvest_scene::kWalls;
using harvest_scene::read;
using harvest_scene::scene_error;
using testing::HasSubstr;

class SceneTest : public ResultsFolder {};

// A closed outlet is a result: the run ends in time, and says how far it came.
TEST_F(SceneTest, WaitingForWhatNeverComesStatesHowManyCame) {
  const Case c = read(kHarvest, {{"stages.drop.remove", "[]"},
                                 {"stages.drop.until", "passed"},
                                 {"stages.drop.max_duration", "0.1 s"}});
  const RunSummary summary = run(c, options("run.h5"));
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  EXPECT_THAT(summary.reason, testing::MatchesRegex(".*time limit: 0 of [0-9]+ particles came "
                                                    "through \"below\""));
}

TEST_F(SceneTest, ARunThatEndsBeforeAnyParticleComesHasResults) {
  const Case c = read(kHarvest, {{"inlets.mold.start", "1 s"}, {"case.duration", "0.1 s"}});
  const RunSummary summary = run(c, options("run.h5"));
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  const Recording recording((directory_ / "run.h5").string());
  const std::vector<Response> responses = recording.responses();
  const auto peaks = std::ranges::find(responses, "peak_normal_forces", &Response::name);
  ASSERT_NE(peaks, responses.end());
  EXPECT_TRUE(peaks->value.empty());
}

// Of what passes a sensor, that of an earlier stage is not counted since a later one.
TEST_F(SceneTest, PassagesAreCountedSinceEachStage) {
  const auto counts = [&](const std::vector<Override>& overrides) {
    const RunSummary summary = run(read(kHarvest, overrides), options("run.h5"));
    EXPECT_EQ(summary.status, RunStatus::finished) << summary.reason;
    std::vector<double> out;
    for (const char* name : {"below_count", "below_count_since_drop"})
      out.push_back(std::ranges::find(summary.responses, name, &Response::name)->value.at(0));
    return out;
  };
  EXPECT_EQ(counts({}), (std::vector<double>{3, 3}));
  // At half of the way into the column: passed before the floor vanishes.
  EXPECT_EQ(counts({{"sensors.below.point", "0 0 65 mm"}}), (std::vector<double>{3, 0}));
  const std::vector<double> early = counts({{"case.duration", "0.2 s"}});
  EXPECT_EQ(early[0], 0);
  EXPECT_TRUE(std::isnan(early[1]));
}

TEST_F(SceneTest, HarvestEndsWhenTheColumnHoldsThePlate) {
  const Case c = read(kHarvest);
  EXPECT_EQ(c.model.particles.size(), 20u);
  RunOptions watched = options("run.h5");
  std::string progress;
  watched.progress = [&](const Progress& p) { progress = stage_text(p); };
  const RunSummary summary = run(c, watched);
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  const Recording recording((directory_ / "run.h5").string());
  const std::vector<StageRecord> stages = recording.stages();
  EXPECT_EQ(stages.at(0).end_reason, "switch \"full\"");
  EXPECT_EQ(stages.at(1).end_reason, "passed \"below\"");
  EXPECT_EQ(progress, "drop, 3 particles, 17 to come, 3 through below");
  // Three cubes came, 20 mm each: the plate rests 30 mm higher than it was drawn.
  const std::vector<double> inserted = recording.insert_time();
  EXPECT_NEAR(inserted[0], 0.1, 1e-4);
  EXPECT_NEAR(inserted[1], 0.4, 1e-4);
  EXPECT_NEAR(inserted[2], 0.7, 1e-4);
  EXPECT_TRUE(std::isnan(inserted[3]));
  EXPECT_THAT(recording.batch(), testing::Contains(2).Times(1));
  // It was let go at 0.75 s, and stayed up for the hold time.
  EXPECT_NEAR(stages[0].end, 0.75 + 0.12, 2e-3);
  // Tags by height at the start of the drop replace those by batch.
  const std::vector<int> tags = recording.tag();
  EXPECT_EQ(std::vector<int>(tags.begin(), tags.begin() + 4), (std::vector<int>{1, 2, 3, 10}));
  const std::vector<double> passed = recording.sensor_time("below");
  EXPECT_LT(passed[0], passed[1]);
  EXPECT_LT(passed[1], passed[2]);
  EXPECT_NEAR(passed[2], stages[1].end, 1e-3);
  EXPECT_TRUE(std::isnan(passed[3]));
  // Strictly by age; of the first two of three, a third would have to be exchanged.
  const auto response = [&](const char* name) {
    return std::ranges::find(summary.responses, name, &Response::name)->value;
  };
  EXPECT_EQ(response("below_order_index"), std::vector<double>{1});
  EXPECT_EQ(response("below_count_by_tag"), (std::vector<double>{1, 1, 1}));
  // Nothing lay in the fourth column.
  EXPECT_EQ(response("below_count_by_column"), (std::vector<double>{1, 1, 1, 0}));
  EXPECT_NEAR(response("below_first_half_similarity").at(0), 2.0 / 3, 1e-12);
  // Two of three that came singly: by whatever order, a third would have to be exchanged.
  EXPECT_NEAR(response("below_first_half_similarity_at_random").at(0), 2.0 / 3, 1e-12);
  EXPECT_EQ(response("below_residence_times").size(), 3u);
  EXPECT_NEAR(response("below_residence_times").at(1), passed[1] - inserted[1], 1e-12);
  EXPECT_NEAR(response("drop_time_to_count").at(0), stages[1].end - stages[1].start, 1e-12);
  EXPECT_EQ(response("peak_normal_forces").size(), 3u);
  EXPECT_NEAR(response("mean_particle_mass").at(0), recording.mass()[0], 1e-12);
  // The plate's own series: where it was, and that the column bore its weight.
  const std::vector<double> plate = recording.series("/motion_frames/plate/coordinate");
  const std::vector<double> times = recording.frame_times();
  double resting = 0, up = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    up = std::max(up, plate[i]);
    if (times[i] <= stages[0].end) resting = plate[i];
  }
  EXPECT_NEAR(up, 0.08, 1e-3);
  EXPECT_NEAR(resting, 0.03, 2e-3);
}

// A shaft that takes cubes of 20 mm one on the other, one every 0.5 s.
const std::string kShaft = std::string(R"(
[case]
duration = "4 s"
steps_per_loading = 6
[[boundaries]]
name = "floor"
kind = "plane"
material = "plastic"
normal = [0, 0, 1]
[[fills]]
shape = "cube"
count = 10
batch = 1
interval = "0.5 s"
random_orientation = false
region_min = "-10.9 -10.9 75 mm"
region_max = "10.9 10.9 140 mm"
stage = "fill"
[[stages]]
name = "fill"
end_when = "filled"
fill_height = "49 mm"
fill_count = 1
max_duration = "3 s"
[[stages]]
name = "wait"
max_duration = "0.6 s"
)") + kWalls;

// The third cube's center rests at 50 mm. It comes at 1 s and falls by 90 mm at most; the fourth
// one would come at 1.5 s.
TEST_F(SceneTest, AFillEndsAtItsHeight) {
  const RunSummary summary = run(read(kShaft), options("run.h5"));
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  const Recording recording((directory_ / "run.h5").string());
  EXPECT_EQ(recording.stages().at(0).end_reason, "filled");
  EXPECT_GT(recording.stages().at(0).end, 1.2);
  EXPECT_LT(recording.stages().at(0).end, 1.5);
  EXPECT_EQ(std::ranges::count_if(recording.insert_time(), [](double t) { return t >= 0; }), 3);
  EXPECT_THAT(scene_error(kShaft, {{"case.gravity", "0 0 0 m/s^2"}}), HasSubstr("without gravity"));
  EXPECT_THAT(scene_error(kShaft, {{"stages.fill.until", "time"}}),
              HasSubstr("without end_when = \"filled\"; expected both"));
}

TEST_F(SceneTest, HarvestGoesOnFromACheckpointBitForBit) {
  const std::string joint = "motion_frames.plate.free.joints.0.";
  // The bearing is off the center of the plate: its weight causes a moment.
  const std::vector<Override> smooth = {{"motion_frames.plate.position", "5 0 30 mm"}};
  std::vector<Override> rough = smooth;
  rough.insert(rough.end(),
               {{joint + "friction_coefficient", "0.3"}, {joint + "bearing_length", "10 mm"}});
  std::vector<double> sums;  // N, of the motor's load over all frames
  for (const auto& overrides : {std::vector<Override>(), smooth, rough}) {
    const Case c = read(kHarvest, overrides);
    std::atomic<bool> stop{false};
    RunOptions interrupted = options("part.h5");
    interrupted.interrupt = &stop;
    interrupted.each_step = [&](const Solver& solver, bool) {
      if (solver.time() > 0.7) stop = true;
    };
    EXPECT_EQ(run(c, interrupted).status, RunStatus::interrupted);
    EXPECT_EQ(resume((directory_ / "part.h5").string(), options("part.h5")).status,
              RunStatus::finished);
    ASSERT_EQ(run(c, options("whole.h5")).status, RunStatus::finished);
    const Recording a((directory_ / "whole.h5").string()), b((directory_ / "part.h5").string());
    EXPECT_EQ(a.frame_times(), b.frame_times());
    for (const char* path : {"/motion_frames/plate/coordinate", "/motion_frames/plate/force",
                             "/boundaries/plate/torque", "/energy/kinetic"})
      EXPECT_EQ(a.series(path), b.series(path)) << path;
    EXPECT_EQ(a.tag(), b.tag());
    EXPECT_EQ(a.stages().back().end, b.stages().back().end);
    const std::vector<double> load = a.series("/motion_frames/plate/motor_load");
    sums.push_back(std::accumulate(load.begin(), load.end(), 0.0));
    fs::remove(directory_ / "part.h5");
    fs::remove(directory_ / "whole.h5");
  }
  EXPECT_NEAR(sums[0], sums[1], 1e-6 * sums[0]);
  EXPECT_GT(sums[2], 1.01 * sums[1]);
}

TEST_F(SceneTest, ABatchThatIsStillInItsPlaceIsNotReleased) {
  // The third cube came at 0.7 s and has fallen by some micrometers.
  const RunSummary summary = run(read(kHarvest, {{"case.duration", "0.702 s"}}), options("run.h5"));
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  const auto response = [&](const char* name) {
    return std::ranges::find(summary.responses, name, &Response::name)->value.at(0);
  };
  EXPECT_EQ(response("mold_batches"), 3);
  EXPECT_EQ(response("mold_batches_released"), 2);
}

TEST_F(SceneTest, ABlockedSourceFailsTheRunAndSaysByWhom) {
  // Without a plate to wait for, the shaft fills up to where the cubes come from.
  const RunSummary summary =
      run(read(kHarvest, {{"stages.harvest.until", "[\"time\", \"switch\"]"},
                          {"sources.mold.position", "0 0 45 mm"},
                          {"boundaries.plate.position", "0 300 35 mm"},
                          {"boundaries.plate.allow_overlap_with", "[\"back\"]"}}),
          options("run.h5"));
  EXPECT_EQ(summary.status, RunStatus::failed);
  EXPECT_THAT(summary.reason, HasSubstr("inlet \"mold\" is blocked: place 1 of batch 3 is taken by "
                                        "particle 1"));
  // The file says the same, and shows who is in the way.
  const Recording recording((directory_ / "run.h5").string());
  EXPECT_THAT(recording.status(), testing::StartsWith("failed: stage \"harvest\" ended: inlet"));
  EXPECT_THAT(recording.stages().back().end_reason, HasSubstr("is blocked"));
  EXPECT_NEAR(recording.frame_times().back(), summary.simulated, 1e-9);
}

TEST_F(SceneTest, ASourceInAWallIsRefused) {
  EXPECT_THAT(test::error_of([&] {
                run(read(kHarvest, {{"sources.mold.position", "0 0 5 mm"}}), options("run.h5"));
              }),
              HasSubstr("overlaps boundary \"floor\"; expected a free place"));
}

TEST_F(SceneTest, ADriveThatStallsEndsItsStageAndStatesWhere) {
  const char* press = R"(
[case]
duration = "2 s"
steps_per_loading = 6
[[motion_frames]]
name = "ram"
[motion_frames.free]
density = "1000 kg/m^3"
[[motion_frames.free.joints]]
kind = "translation"
direction = [0, 0, 1]
[[motion_frames.free.joints.motors]]
speed = "-0.2 m/s"
max_load = "30 N"
[[boundaries]]
name = "ram"
kind = "box"
material = "plastic"
size = "40 40 20 mm"
position = "0 0 60 mm"
motion_frame = "ram"
[[boundaries]]
name = "anvil"
kind = "plane"
material = "plastic"
normal = [0, 0, 1]
[[particles]]
shape = "cube"
position = "0 0 10 mm"
[[stages]]
name = "press"
end_when = "stalled"
stall_frame = "ram"
stall_hold = "0.1 s"
max_duration = "1.5 s"
)";
  const Case c = read(press);
  EXPECT_NEAR(c.model.frames[0].free->mass, 0.032, 1e-9);
  const RunSummary summary = run(c, options("run.h5"));
  EXPECT_THAT(summary.reason, HasSubstr("stalled: boundary \"ram\" presses particle 0 with "));
  EXPECT_THAT(summary.reason, HasSubstr("against boundary \"anvil\" with "));
  const Recording recording((directory_ / "run.h5").string());
  // The motor gives what it can, and the cube and the weight take it.
  EXPECT_NEAR(recording.series("/motion_frames/ram/motor_load").back(), -30, 1e-6);
  EXPECT_LT(summary.simulated, 0.4);
  const auto stalled = [](const RunSummary& of) {
    return std::ranges::find(of.responses, "press_stalled", &Response::name)->value;
  };
  EXPECT_EQ(stalled(summary), std::vector<double>{1});
  std::string free = press;
  const std::string motor = "stall_hold = \"0.1 s\"\nmax_duration = \"1.5 s\"";
  ASSERT_NE(free.find(motor), std::string::npos);
  free.replace(free.find(motor), motor.size(),
               "stall_hold = \"0.1 s\"\nmax_duration = \"20 ms\"");  // before it touches
  const RunSummary unhindered = run(read(free), options("free.h5"));
  EXPECT_EQ(stalled(unhindered), std::vector<double>{0}) << unhindered.reason;
}

}  // namespace
}  // namespace firn
