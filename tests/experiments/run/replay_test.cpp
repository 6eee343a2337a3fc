#include "experiments/run/replay.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <map>

#include "experiments/results/checkpoint.h"
#include "experiments/results/results_file.h"
#include "experiments/storage/hdf5_file.h"
#include "tests/support/error_of.h"
#include "tests/support/results_folder.h"
#include "tests/support/tray_case.h"

namespace firn {
namespace {

using testing::HasSubstr;

class ReplayTest : public ResultsFolder {
 protected:
  // Runs the case and keeps the hash of every step.
  std::string run_and_note(const Case& c, const std::string& name) {
    RunOptions options;
    options.results_file = path(name);
    options.each_step = [&](const Solver& solver, bool last) {
      hashes_[solver.steps()] = solver.hash();
      if (last) last_step_ = solver.steps();
    };
    EXPECT_EQ(run(c, options).status, RunStatus::finished);
    return options.results_file;
  }

  // Looks at the steps from `from` on and stops at `to`; every hash must be the run's.
  Replay look(const std::string& file, std::uint64_t from, std::uint64_t to, int threads = 1) {
    ReplayOptions options;
    options.threads = threads;
    options.from_step = from;
    std::uint64_t expected = from;
    options.observe = [&](const Solver& solver, bool) {
      EXPECT_EQ(solver.steps(), expected++);
      EXPECT_EQ(solver.hash(), hashes_.at(solver.steps())) << "step " << solver.steps();
      return solver.steps() < to;
    };
    Replay replayed = replay(file, options);
    EXPECT_EQ(expected, to + 1);
    return replayed;
  }

  std::map<std::uint64_t, std::uint64_t> hashes_;
  std::uint64_t last_step_ = 0;
};

// Through batches, a stage that ends at rest, a floor that goes, a lid that moves, an outlet.
TEST_F(ReplayTest, IsTheRunAtEveryStep) {
  const std::string file = run_and_note(tray(), "run.h5");
  const Replay whole = look(file, 0, last_step_, 2);
  EXPECT_EQ(whole.began_at, 0u);
  EXPECT_EQ(whole.frames_equal, Recording(file).frame_times().size());
  EXPECT_EQ(whole.verified_until, Recording(file).frame_times().back());
}

TEST_F(ReplayTest, GoesOnToTheNextFrameToProveItself) {
  const std::string file = run_and_note(tray(), "run.h5");
  const std::vector<double> times = Recording(file).frame_times();
  const double dt = tray().model.timestep;
  const auto step = static_cast<std::uint64_t>(std::llround(times[3] / dt)) + 1;
  const Replay replayed = look(file, step, step);
  EXPECT_EQ(replayed.frames_equal, 5u);  // 0 ... 4
  EXPECT_EQ(replayed.verified_until, times[4]);
}

TEST_F(ReplayTest, KeptStatesShortenIt) {
  run_and_note(tray(), "plain.h5");
  const std::map<std::uint64_t, std::uint64_t> plain = hashes_;
  const Case c = tray({{"output.state_interval", "0.1 s"}});
  const std::string file = run_and_note(c, "run.h5");
  EXPECT_EQ(hashes_, plain);  // keeping states changes nothing
  const hdf5::File open = hdf5::File::open(file, hdf5::File::Access::read);
  const std::vector<std::uint64_t> kept = saved_states(open);
  ASSERT_GE(kept.size(), 3u);
  // At a kept state, one before it and one after it, and long after the last.
  EXPECT_EQ(look(file, kept[1], kept[1] + 5).began_at, kept[1]);
  EXPECT_EQ(look(file, kept[1] - 1, kept[1] + 5).began_at, kept[0]);
  EXPECT_EQ(look(file, kept[1] + 1, kept[1] + 5).began_at, kept[1]);
  EXPECT_EQ(look(file, last_step_, last_step_).began_at, kept.back());
  EXPECT_EQ(look(file, 0, 5).began_at, 0u);
}

TEST_F(ReplayTest, ResumedRunKeepsTheSameStates) {
  const Case c = tray({{"output.state_interval", "50 ms"}});
  const std::string whole = run_and_note(c, "whole.h5");
  std::atomic<bool> interrupt = false;
  RunOptions options;
  options.results_file = path("parts.h5");
  options.interrupt = &interrupt;
  options.each_step = [&](const Solver& solver, bool) {
    if (solver.steps() % 1777 == 0) interrupt = true;
  };
  RunSummary summary = run(c, options);
  int parts = 0;
  for (; parts < 50 && summary.status == RunStatus::interrupted; ++parts) {
    interrupt = false;
    summary = resume(options.results_file, options);
  }
  ASSERT_EQ(summary.status, RunStatus::finished);
  EXPECT_GT(parts, 5);
  const hdf5::File a = hdf5::File::open(whole, hdf5::File::Access::read);
  const hdf5::File b = hdf5::File::open(options.results_file, hdf5::File::Access::read);
  ASSERT_EQ(saved_states(a), saved_states(b));
  for (const std::uint64_t step : saved_states(a)) {
    ASSERT_TRUE(read_state(a, step));
    EXPECT_TRUE(read_state(a, step) == read_state(b, step)) << "step " << step;
  }
}

// One bit of one number of a frame is enough.
TEST_F(ReplayTest, OfAnotherRunIsRefused) {
  const std::string file = run_and_note(tray(), "run.h5");
  {
    hdf5::File open = hdf5::File::open(file, hdf5::File::Access::write);
    const hdf5::Shape shape = open.shape("/frames/velocity");
    std::vector<double> values = open.read<double>("/frames/velocity");
    double& changed = values[(2 * shape[1] + 0) * 3 + 2];  // frame 2, particle 0, z
    changed = std::nextafter(changed, 1);
    open.write<double>("/frames/velocity", shape, values);
    open.close();
  }
  ReplayOptions options;
  options.observe = [&](const Solver&, bool) { return true; };
  const std::string message = test::error_of<RunError>([&] { replay(file, options); });
  EXPECT_THAT(message, HasSubstr("the replay is not the run: frame 2 at "));
  EXPECT_THAT(message, HasSubstr("/frames/velocity of particle 0"));
}

TEST_F(ReplayTest, DamagedStateIsPassedOver) {
  const Case c = tray({{"output.state_interval", "0.1 s"}});
  const std::string file = run_and_note(c, "run.h5");
  std::vector<std::uint64_t> kept;
  {
    hdf5::File open = hdf5::File::open(file, hdf5::File::Access::write);
    kept = saved_states(open);
    open.write_bytes(fmt::format("/states/{:012}", kept[1]),
                     std::vector<std::byte>(100, std::byte{7}));
    open.close();
  }
  EXPECT_EQ(look(file, kept[1], kept[1] + 5).began_at, kept[0]);
}

TEST_F(ReplayTest, OfACaseNeedsNoFile) {
  const Case c = tray();
  run_and_note(c, "run.h5");
  ReplayOptions options;
  std::uint64_t seen = 0;
  bool ended = false;
  options.observe = [&](const Solver& solver, bool last) {
    EXPECT_EQ(solver.hash(), hashes_.at(solver.steps()));
    ++seen;
    ended = last;
    return true;
  };
  const Replay replayed = replay(c, options);
  EXPECT_EQ(seen, hashes_.size());
  EXPECT_TRUE(ended);
  EXPECT_THAT(replayed.reason, HasSubstr("\"drop\" ended"));
}

TEST_F(ReplayTest, FailureIsReportedAsOne) {
  Case c = tray();
  c.model.numerics.overlap_limit = 1e-5;
  ReplayOptions options;
  options.observe = [](const Solver&, bool) { return true; };
  EXPECT_THROW(replay(c, options), RunError);
  EXPECT_THROW(replay(path("nowhere.h5"), options), InputError);
}

}  // namespace
}  // namespace firn
