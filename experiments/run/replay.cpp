#include "experiments/run/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>

#include "experiments/results/checkpoint.h"
#include "experiments/results/results_file.h"
#include "experiments/results/results_schema.h"
#include "experiments/results/results_writer.h"
#include "experiments/run/driver.h"
#include "experiments/storage/hdf5_file.h"
#include "experiments/storage/version.h"

namespace firn {
namespace {

bool same(double a, double b) {
  return std::memcmp(&a, &b, sizeof(a)) == 0 || (std::isnan(a) && std::isnan(b));
}

// Compares the frames of a replay with those of the file, number by number.
class FrameProof {
 public:
  FrameProof(const std::string& results_file, const Recording& recording, const Case& c)
      : name_(results_file),
        file_(results::open_file(results_file, hdf5::File::Access::read)),
        columns_(result_columns(c)),
        times_(recording.frame_times()),
        timestep_(c.model.timestep) {}

  // Throws RunError when the frame was recorded and is not the same.
  void compare(std::uint64_t frame, const std::vector<double>& row) {
    if (frame >= times_.size()) return;
    std::size_t at = 0;
    for (const Column& column : columns_) {
      if (!file_.contains(column.path)) {  // of an earlier version, which did not record it
        at += std::accumulate(column.row.begin(), column.row.end(), std::size_t{1},
                              std::multiplies<>());
        continue;
      }
      const std::vector<double> recorded = file_.read_rows(column.path, frame, 1);
      for (std::size_t k = 0; k < recorded.size(); ++k) {
        if (!same(recorded[k], row.at(at + k))) fail(frame, column, k, row[at + k], recorded[k]);
      }
      at += recorded.size();
    }
    ++equal_;
    until_ = frame;
  }

  // Whether a frame at this step or after it has been compared, or there is none.
  bool covers(std::uint64_t step) const {
    if (times_.empty() || step > step_of(times_.size() - 1)) return true;
    return until_ && step_of(*until_) >= step;
  }
  std::size_t equal() const { return equal_; }
  double until() const { return until_ ? times_[*until_] : 0; }  // s

 private:
  std::uint64_t step_of(std::size_t frame) const {
    return static_cast<std::uint64_t>(std::llround(times_[frame] / timestep_));
  }

  [[noreturn]] void fail(std::size_t frame, const Column& column, std::size_t k, double now,
                         double recorded) const {
    const bool of_particles = column.path.starts_with("/frames/") && column.row.size() == 2;
    throw RunError(fmt::format(
        "{}: the replay is not the run: frame {} at {:.9g} s differs in {}{}: {:.17g} now, {:.17g} "
        "recorded by firn {} ({}); this is firn {} ({}): run the case again with it",
        name_, frame, times_[frame], column.path,
        of_particles ? fmt::format(" of particle {}", k / column.row[1]) : "", now, recorded,
        file_.text_attribute("/", "firn_version"), file_.text_attribute("/", "git_commit"),
        firn_version(), firn_git_commit()));
  }

  std::string name_;
  hdf5::File file_;
  std::vector<Column> columns_;
  std::vector<double> times_;  // s
  double timestep_;            // s
  std::size_t equal_ = 0;
  std::optional<std::size_t> until_;  // the last frame compared
};

RunOptions run_options(const ReplayOptions& options) {
  RunOptions run;
  run.threads = options.threads;
  run.progress = options.progress;
  run.interrupt = options.interrupt;
  return run;
}

RunObserver replay_observer(const ReplayOptions& options) {
  RunObserver looks;
  looks.end_time_limit = options.end_time_limit;
  looks.step = [&options](const Solver& solver, bool last) {
    return (solver.steps() < options.from_step && !last) || options.observe(solver, last);
  };
  return looks;
}

// A driver at the newest state of the file that is not after the first step of interest, and fits.
std::unique_ptr<Driver> nearest_start(const std::string& results_file, const Case& c,
                                      const RunOptions& run, const RunObserver& looks,
                                      const ReplayOptions& options) {
  auto best = std::make_unique<Driver>(c, run, nullptr, looks);
  const auto offer = [&](const std::vector<std::byte>& payload) {
    auto driver = std::make_unique<Driver>(c, run, nullptr, looks);
    try {
      driver->restore(payload);
    } catch (const RunError&) {
      return;  // of another version: starts earlier, and the frames are compared with the recorded
               // ones
    }
    if (driver->steps() <= options.from_step && driver->steps() > best->steps())
      best = std::move(driver);
  };
  const hdf5::File file = results::open_file(results_file, hdf5::File::Access::read);
  const std::vector<std::uint64_t> kept = saved_states(file);
  for (auto step = kept.rbegin(); step != kept.rend() && best->steps() == 0; ++step) {
    if (*step > options.from_step) continue;
    if (const auto payload = read_state(file, *step)) offer(*payload);
  }
  for (const Checkpoint& checkpoint : read_checkpoints(file)) offer(checkpoint.payload);
  return best;
}

Replay outcome(const RunSummary& summary, const ReplayOptions& options) {
  if (summary.status == RunStatus::failed) throw RunError(summary.reason);
  Replay result;
  result.interrupted = options.interrupt && *options.interrupt;
  result.reason = summary.reason;
  result.simulated = summary.simulated;
  return result;
}

}  // namespace

Replay replay(const Case& c, const ReplayOptions& options) {
  const RunOptions run = run_options(options);
  Driver driver(c, run, nullptr, replay_observer(options));
  return outcome(driver.run(), options);
}

Replay replay(const std::string& results_file, const ReplayOptions& options) try {
  const Recording recording(results_file);
  const Case c = case_of(recording, "replayed");
  FrameProof proof(results_file, recording, c);
  const RunOptions run = run_options(options);
  RunObserver looks = replay_observer(options);
  bool enough = false;
  std::uint64_t seen = 0;
  looks.step = [&, observe = looks.step](const Solver& solver, bool last) {
    if (enough) return !proof.covers(seen);
    enough = !observe(solver, last);
    seen = solver.steps();
    return !enough || !proof.covers(seen);
  };
  looks.frame = [&](std::uint64_t frame, const std::vector<double>& row) {
    proof.compare(frame, row);
  };
  const std::unique_ptr<Driver> driver = nearest_start(results_file, c, run, looks, options);
  const std::uint64_t began_at = driver->steps();
  Replay result = outcome(driver->run(), options);
  result.began_at = began_at;
  result.frames_equal = proof.equal();
  result.verified_until = proof.until();
  return result;
} catch (const hdf5::Error& e) {
  throw InputError(fmt::format("{}: damaged or foreign results file: {}", results_file, e.what()));
}

}  // namespace firn
