#include <fmt/format.h>

#include <algorithm>
#include <exception>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/results/results_file.h"
#include "experiments/run/run.h"
#include "experiments/text/response_aliases.h"
#include "experiments/text/toml_aliases.h"
#include "firn/experiments/run.h"
#include "library/experiments/case_facade.h"
#include "library/experiments/convert_response.h"

namespace firn::experiments {
namespace {

RunResult::Status public_status(RunStatus status) {
  switch (status) {
    case RunStatus::finished:
      return RunResult::Status::finished;
    case RunStatus::interrupted:
      return RunResult::Status::interrupted;
    case RunStatus::failed:
      break;
  }
  return RunResult::Status::failed;
}

// The callbacks of `options` on those of the run. The driver polls one flag: `stop`.
class Callbacks {
 public:
  Callbacks(const RunOptions& options, const firn::Case& c) : options_(options) {
    const std::uint64_t end = std::max<std::uint64_t>(1, to_steps(c, c.duration));
    // As the driver records frames.
    frame_steps_ =
        c.frame_interval > 0 ? std::max<std::uint64_t>(1, to_steps(c, c.frame_interval)) : end;
  }

  firn::RunOptions internal(const std::string& results_file) {
    firn::RunOptions o;
    o.results_file = results_file;
    o.threads = options_.threads;
    o.checkpoint_every = options_.checkpoint_every;
    o.interrupt = &stop_;
    if (options_.on_progress)
      o.progress = [this](const Progress& p) {
        stop_unless([&] { return options_.on_progress(p.time); });
      };
    if (options_.on_frame || options_.interrupt)
      o.each_step = [this](const Solver& solver, bool last) {
        if (options_.interrupt && *options_.interrupt) stop_ = true;
        if (!options_.on_frame || (!last && solver.steps() % frame_steps_ != 0)) return;
        stop_unless([&] { return options_.on_frame(solver); });
      };
    return o;
  }
  // What a callback has thrown, after the run.
  void rethrow() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

 private:
  template <class Callback>
  void stop_unless(const Callback& should_continue) {
    if (thrown_) return;
    try {
      if (!should_continue()) stop_ = true;
    } catch (...) {
      thrown_ = std::current_exception();
      stop_ = true;
    }
  }

  const RunOptions& options_;
  std::uint64_t frame_steps_ = 1;
  std::atomic<bool> stop_ = false;
  std::exception_ptr thrown_;
};

void check(const RunOptions& options) {
  if (options.threads < 1 || options.threads > 1024)
    throw InputError(
        fmt::format("threads: is {}; expected a number from 1 to 1024", options.threads));
  if (!(options.checkpoint_every > 0))
    throw InputError(fmt::format("checkpoint_every: is {} s; expected a time above 0",
                                 options.checkpoint_every));
}

RunResult public_result(RunSummary summary, const std::string& results_file) {
  RunResult r;
  r.status = public_status(summary.status);
  r.reason = std::move(summary.reason);
  r.responses = public_responses(summary.responses);
  r.simulated = summary.simulated;
  r.wall = summary.wall;
  r.steps = summary.steps;
  r.energy = summary.energy;
  r.diagnostics = summary.diagnostics;
  r.results_file = results_file;
  return r;
}

}  // namespace

std::string current_response_name(const std::string& name) {
  std::string current = firn::current_response_name(name);
  if (current != name) warn_of_old_name("response", {name, 0, name, current, false});
  return current;
}

const Response& RunResult::response(const std::string& asked) const {
  const std::string name = current_response_name(asked);
  const auto found = std::ranges::find(responses, name, &Response::name);
  if (found == responses.end())
    throw RunError(fmt::format("{}: has no response \"{}\"", results_file, name));
  return *found;
}

RunResult run(const Case& c, const RunOptions& options) {
  check(options);
  const firn::Case& checked = c.impl().checked;
  Callbacks callbacks(options, checked);
  RunSummary summary = firn::run(checked, callbacks.internal(options.results_file));
  callbacks.rethrow();
  return public_result(std::move(summary), options.results_file);
}

RunResult resume(const std::string& results_file, const RunOptions& options) {
  check(options);
  const firn::Case c = read_case(Recording(results_file));
  Callbacks callbacks(options, c);
  RunSummary summary = firn::resume(results_file, callbacks.internal(results_file), &c);
  callbacks.rethrow();
  return public_result(std::move(summary), results_file);
}

}  // namespace firn::experiments
