#include "experiments/run/run.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <thread>

#include "experiments/case_reader/read_case.h"
#include "experiments/results/checkpoint.h"
#include "experiments/results/recorder.h"
#include "experiments/results/results_file.h"
#include "experiments/storage/hdf5_file.h"
#include "firn/contact_model.h"
#include "tests/support/error_of.h"
#include "tests/support/read_text.h"
#include "tests/support/results_folder.h"
#include "tests/support/results_readers.h"
#include "tests/support/tray_case.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

using RunTest = ResultsFolder;

void expect_equal_datasets(const std::string& a, const std::string& b) {
  const hdf5::File first = hdf5::File::open(a, hdf5::File::Access::read);
  const hdf5::File second = hdf5::File::open(b, hdf5::File::Access::read);
  ASSERT_THAT(second.datasets(), testing::ElementsAreArray(first.datasets()));
  for (const std::string& path : first.datasets()) {
    ASSERT_EQ(first.shape(path), second.shape(path)) << path;
    if (path.ends_with("/name") || path.ends_with("_name") || path.ends_with("/end_reason")) {
      EXPECT_EQ(first.read_strings(path), second.read_strings(path)) << path;
    } else {
      const std::vector<double> x = first.read<double>(path), y = second.read<double>(path);
      for (std::size_t i = 0; i < x.size(); ++i)
        ASSERT_TRUE(x[i] == y[i] || (std::isnan(x[i]) && std::isnan(y[i]))) << path << " " << i;
    }
  }
}

// Runs `work` in a separate process, which ends with it.
template <class Work>
pid_t start_process(Work&& work) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  try {
    work();
    ::_exit(0);
  } catch (...) {
    ::_exit(1);
  }
}

// What a results file holds at the moment.
struct Glance {
  bool readable = false, finished = false;
  std::size_t frames = 0;
};

// A separate process reads the file: HDF5 may crash on one that a run is just writing, or was
// killed while writing.
Glance glance_at(const std::string& file) {
  constexpr int kNotReadable = 255;
  const pid_t child = ::fork();
  if (child == 0) {
    int code = kNotReadable;
    try {
      const Recording recording(file);
      const int frames =
          static_cast<int>(std::min<std::size_t>(recording.frame_times().size(), 126));
      code = 2 * frames + (recording.status() == "finished" ? 1 : 0);
    } catch (const InputError&) {  // not there yet, or caught in the middle of a flush
    }
    ::_exit(code);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) == kNotReadable) return {};
  const int code = WEXITSTATUS(status);
  return {true, code % 2 == 1, static_cast<std::size_t>(code / 2)};
}

// Until the file of a run under way has so many frames, or has ended, or a minute has passed; how
// many it has.
std::size_t wait_for_frames(const std::string& file, std::size_t wanted) {
  std::size_t frames = 0;
  for (int i = 0; i < 30000 && frames < wanted; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    const Glance seen = glance_at(file);
    if (seen.readable) frames = seen.frames;
    if (seen.finished) break;
  }
  return frames;
}

TEST_F(RunTest, DrivesStagesFillsOutletsAndFrames) {
  const Case c = tray();
  const RunSummary summary = run(c, options("run.h5"));
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  EXPECT_THAT(summary.reason, HasSubstr("\"drop\" ended: "));

  const Recording recording(options("run.h5").results_file);
  EXPECT_EQ(recording.status(), "finished");
  ASSERT_EQ(recording.particle_count(), 13u);
  const std::vector<StageRecord> stages = recording.stages();
  ASSERT_EQ(stages.size(), 2u);
  EXPECT_EQ(stages[0].start, 0);
  EXPECT_EQ(stages[1].start, stages[0].end);
  EXPECT_GT(stages[0].end, 0.07);  // not before the second batch and the hold time

  // Frames: exact multiples of a whole number of steps; the last state besides.
  const std::vector<double> times = recording.frame_times();
  const double dt = recording.timestep();
  const auto steps = std::llround(0.01 / dt);
  for (std::size_t i = 0; i + 1 < times.size(); ++i)
    EXPECT_EQ(times[i], static_cast<double>(steps * static_cast<long long>(i)) * dt);
  EXPECT_EQ(times.back(), summary.simulated);

  // The first batch is there at the start, the second one is not; NaN until it is.
  const Frame first = recording.frame(0), sixth = recording.frame(6);
  EXPECT_FALSE(std::isnan(first.position[8][0]));
  EXPECT_TRUE(std::isnan(first.position[9][0]));
  EXPECT_FALSE(std::isnan(sixth.position[12][2]));
  EXPECT_EQ(recording.tag()[0], 5);

  // The floor is gone in the second stage; the lid moves by 0.1 m/s for 0.1 s.
  EXPECT_TRUE(recording.boundary("floor", times.size() - 1).position.hasNaN());
  if (stages[1].end - stages[1].start > 0.16) {
    EXPECT_NEAR(recording.boundary("lid", times.size() - 1).position.z(), 0.51, 1e-9);
  }

  // A cube that leaves is beyond the outlet by no more than it falls in the 16 steps between looks.
  const std::vector<double> exit = recording.exit_time();
  int left = 0;
  for (std::size_t i = 0; i < exit.size(); ++i) {
    if (std::isnan(exit[i])) continue;
    ++left;
    EXPECT_GT(exit[i], stages[1].start);
    EXPECT_EQ(std::llround(exit[i] / dt) % 16, 0);
  }
  EXPECT_GT(left, 0);
  EXPECT_TRUE(std::isnan(recording.discharge_time()[0]));  // no door in this case
  for (double peak : recording.peak_normal_force()) EXPECT_GT(peak, 0);
}

// The floor bears what rests on it: the mean force over the last intervals of the first stage is
// the weight of 13 cubes, 13 * 916.7 kg/m^3 * (0.02 m)^3 * 9.81 m/s^2 (rounded edges: a bit less).
TEST_F(RunTest, BoundaryForceIsTheWeightAtRest) {
  Case c = tray();
  c.stages.resize(1);
  c.stages[0].end_when = {Stage::EndEvent::time};
  c.stages[0].max_duration = 0.6;
  ASSERT_EQ(run(c, options("run.h5")).status, RunStatus::finished);
  const Recording recording(options("run.h5").results_file);
  double weight = 0, mean = 0;
  for (double mass : recording.mass()) weight += 9.81 * mass;
  const std::size_t frames = recording.frame_times().size();
  for (std::size_t i = frames - 11; i < frames - 1; ++i)
    mean += recording.boundary("floor", i).force.z() / 10;
  EXPECT_NEAR(-mean, weight, 0.05 * weight);
  EXPECT_EQ(recording.boundary("floor", 0).force.norm(), 0);
}

TEST_F(RunTest, SameCaseSameFile) {
  run(tray(), options("a.h5"));
  run(tray(), options("b.h5"));
  expect_equal_datasets(options("a.h5").results_file, options("b.h5").results_file);
}

TEST_F(RunTest, InterruptedRunGoesOnBitForBit) {
  const RunOptions whole = options("whole.h5");
  ASSERT_EQ(run(tray(), whole).status, RunStatus::finished);

  std::atomic<bool> interrupt = false;
  RunOptions parts = options("parts.h5");
  parts.interrupt = &interrupt;
  parts.checkpoint_every = 0;
  // Each session is interrupted after some steps, as by a signal handler during a step.
  int steps_left = 0;
  parts.each_step = [&](const Solver&, bool) { interrupt = --steps_left < 0; };
  const auto interrupted_after = [&](int steps, auto&& simulate) {
    steps_left = steps;
    interrupt = false;
    return simulate();
  };
  RunSummary summary = interrupted_after(50, [&] { return run(tray(), parts); });
  for (const int steps : {0, 1, 70}) {
    ASSERT_EQ(summary.status, RunStatus::interrupted);
    EXPECT_EQ(Recording(parts.results_file).status(), "interrupted");
    EXPECT_TRUE(Recording(parts.results_file).has_checkpoint());
    summary = interrupted_after(steps, [&] { return resume(parts.results_file, parts); });
  }
  ASSERT_EQ(summary.status, RunStatus::interrupted);
  parts.each_step = nullptr;
  interrupt = false;
  ASSERT_EQ(resume(parts.results_file, parts).status, RunStatus::finished);
  expect_equal_datasets(whole.results_file, parts.results_file);
}

TEST_F(RunTest, KilledRunGoesOnBitForBit) {
  std::string text = kTray;
  const auto last = text.find("remove_boundaries = [\"floor\"]");
  text.replace(text.rfind("0.3 s"), 5, "1.5 s");
  ASSERT_LT(last, text.rfind("1.5 s"));
  const auto read = [&] { return read_case_text(text, "tray.toml", "."); };
  const RunOptions whole = options("whole.h5");
  int status = -1;
  ::waitpid(start_process([&] { run(read(), whole); }), &status, 0);
  ASSERT_EQ(status, 0);
  RunOptions parts = options("parts.h5");
  parts.checkpoint_every = 0.01;
  // A step takes a millisecond, so that no run ends before it is killed.
  parts.each_step = [](const Solver&, bool) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  std::size_t frames = 0;
  int killed_on_the_way = 0;
  for (int session = 0; session < 3; ++session) {
    const pid_t child = start_process([&] {
      if (session == 0)
        run(read(), parts);
      else
        resume(parts.results_file, parts);
    });
    frames = wait_for_frames(parts.results_file, frames + 2);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    killed_on_the_way += !glance_at(parts.results_file).finished;
  }
  EXPECT_GT(frames, 5u);
  EXPECT_EQ(killed_on_the_way, 3);
  parts.each_step = nullptr;
  const RunSummary last_session = resume(parts.results_file, parts);
  ASSERT_EQ(last_session.status, RunStatus::finished) << last_session.reason;
  expect_equal_datasets(whole.results_file, parts.results_file);
}

// Killed after the last word on the run and before the rest of the housekeeping.
TEST_F(RunTest, RunOfAnotherContactModelIsNotResumed) {
  std::atomic<bool> interrupt = false;
  RunOptions parts = options("parts.h5");
  parts.interrupt = &interrupt;
  parts.each_step = [&](const Solver& solver, bool) { interrupt = solver.time() > 0.01; };
  ASSERT_EQ(run(tray(), parts).status, RunStatus::interrupted);
  EXPECT_EQ(Recording(parts.results_file).contact_model(), kContactModel);
  const std::uint64_t other = kContactModel - 1;
  {
    hdf5::File file = hdf5::File::open(parts.results_file, hdf5::File::Access::write);
    file.set_attribute("/", "contact_model", other);
  }
  const std::string before = test::read_text(parts.results_file);
  EXPECT_EQ(test::error_of([&] { resume(parts.results_file, parts); }),
            fmt::format("{}: cannot be resumed: it was made with contact model {}, and "
                        "this build has {}; run the case again",
                        parts.results_file, other, kContactModel));
  EXPECT_EQ(test::read_text(parts.results_file), before);
}

TEST_F(RunTest, ResumeTidiesARunKilledAtItsEnd) {
  Case c = tray();
  c.duration = 0.02;
  run(c, options("whole.h5"));
  fs::copy_file(options("whole.h5").results_file, options("cut.h5").results_file);
  {
    hdf5::File file = hdf5::File::open(options("cut.h5").results_file, hdf5::File::Access::write);
    file.remove("/responses");
    write_checkpoint(file, {1, {std::byte{1}}});
  }
  const RunSummary summary = resume(options("cut.h5").results_file, options("cut.h5"));
  EXPECT_EQ(summary.status, RunStatus::finished);
  EXPECT_FALSE(summary.responses.empty());
  expect_equal_datasets(options("whole.h5").results_file, options("cut.h5").results_file);
}

// A killed run leaves a copy next to its results file. A later run keeps that copy.
TEST_F(RunTest, NewRunKeepsAKilledOneWhole) {
  Case c = tray();
  c.duration = 0.02;
  const std::string file = options("run.h5").results_file;
  run(c, options("run.h5"));
  ResultsLock(file).save_copy();
  fs::resize_file(file, fs::file_size(file) / 2);
  const RunSummary again = run(c, options("run.h5"));
  expect_equal_datasets(file, again.renamed_earlier_file);
  EXPECT_FALSE(fs::exists(file + ".saved"));
}

TEST_F(RunTest, FileOfALivingRunIsNotTakenFromIt) {
  Case c = tray();
  c.duration = 0.02;
  const std::string file = options("run.h5").results_file;
  run(c, options("run.h5"));
  ResultsLock(file).save_copy();
  struct stat before = {}, after = {};
  ASSERT_EQ(::stat(file.c_str(), &before), 0);
  Recorder writer = Recorder::reopen(file, {});
  EXPECT_THROW(resume(file, options("run.h5")), InputError);
  EXPECT_THROW(run(c, options("run.h5")), InputError);
  ASSERT_EQ(::stat(file.c_str(), &after), 0);
  EXPECT_EQ(after.st_ino, before.st_ino);
}

TEST_F(RunTest, FinishedRunIsNotRunAgain) {
  Case c = tray();
  c.duration = 0.01;
  run(c, options("run.h5"));
  const RunSummary again = resume(options("run.h5").results_file, options("run.h5"));
  EXPECT_EQ(again.status, RunStatus::finished);
  EXPECT_EQ(again.steps, 0u);
  EXPECT_NEAR(again.simulated, 0.01, 1e-4);
  const RunSummary repeated = run(c, options("run.h5"));
  EXPECT_EQ(repeated.renamed_earlier_file, (directory_ / "run.1.h5").string());
}

// A cube that starts deep inside another one: beyond the overlap limit in the first step.
TEST_F(RunTest, FailedRunSaysSoInItsFile) {
  Case c = tray();
  c.fills.clear();
  c.model.particles.resize(1);
  c.placed[0].velocity.z() = -30;  // m/s: deeper into the floor than the limit
  const RunSummary summary = run(c, options("run.h5"));
  EXPECT_EQ(summary.status, RunStatus::failed);
  EXPECT_THAT(summary.reason, HasSubstr("particle 0 overlaps boundary \"floor\" by"));
  const Recording recording(options("run.h5").results_file);
  EXPECT_EQ(recording.status(), "failed: " + summary.reason);
  EXPECT_GE(recording.frame_times().size(), 1u);
}

TEST_F(RunTest, ImpossibleFillIsTheUsersMistake) {
  Case c = tray();
  c.fills[0].region_max = c.fills[0].region_min + Vec3(0.03, 0.03, 0.03);
  EXPECT_THAT(test::error_of([&] { run(c, options("run.h5")); }),
              testing::ContainsRegex(":[0-9]+: fills.0: impossible fill"));
  EXPECT_THAT(Recording(options("run.h5").results_file).status(), HasSubstr("impossible fill"));
}

TEST_F(RunTest, ReportsProgress) {
  Case c = tray();
  std::vector<Progress> seen;
  RunOptions o = options("run.h5");
  o.progress = [&](const Progress& p) { seen.push_back(p); };
  const RunSummary summary = run(c, o);
  ASSERT_GE(seen.size(), 2u);  // at the start and at the end at least
  EXPECT_EQ(seen.front().time, 0);
  EXPECT_EQ(seen.back().time, summary.simulated);
  for (const Progress& p : seen) {
    EXPECT_EQ(p.present + p.waiting + p.left, 13u);
    EXPECT_LE(p.time, p.end_time_limit);
    EXPECT_FALSE(p.stage.empty());
  }
}

}  // namespace
}  // namespace firn
