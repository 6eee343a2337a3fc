// Runs a shipped bench test, changed by overrides, and measures it.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "experiments/case_reader/read_case.h"
#include "experiments/responses/measure.h"
#include "experiments/results/results_file.h"
#include "experiments/run/run.h"
#include "tests/support/scratch_folder.h"

namespace firn {

struct BenchRun {
  std::vector<Response> responses;
  std::vector<Response> measured_again;  // from the file, after the run

  const Response& operator[](const std::string& name) const {
    const auto found = std::ranges::find(responses, name, &Response::name);
    if (found == responses.end()) throw std::runtime_error("no response " + name);
    return *found;
  }
  bool has(const std::string& name) const {
    return std::ranges::count(responses, name, &Response::name) > 0;
  }
  double value(const std::string& name) const { return (*this)[name].value.at(0); }
};

inline BenchRun run_case(const Case& c) {
  const test::ScratchFolder folder("bench");
  RunOptions options;
  options.results_file = folder / "run.h5";
  const RunSummary summary = run(c, options);
  if (summary.status != RunStatus::finished) throw std::runtime_error(summary.reason);
  return {summary.responses, measure(Recording(options.results_file))};
}

// `name` below cases/, such as "tilt/case.toml".
inline BenchRun run_bench(const std::string& name, const std::vector<Override>& overrides = {}) {
  return run_case(read_case(FIRN_SOURCE_DIR "/cases/" + name, overrides));
}

}  // namespace firn
