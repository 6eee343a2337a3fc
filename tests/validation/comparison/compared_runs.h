// Runs with given values, and a comparison of them with a measurement.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "validation/comparison/comparison.h"

namespace firn::test {

inline JobResult finished(const std::vector<Response>& responses) {
  JobResult r;
  r.status = JobStatus::finished;
  r.responses = responses;
  return r;
}

inline Response response(const std::string& name, std::vector<double> value,
                         const std::string& unit) {
  return {name, std::move(value), {}, unit, "", 1};
}

inline RunGroup group(RunGroup::Purpose purpose, const std::vector<double>& values,
                      double setting = 0) {
  RunGroup g;
  g.purpose = purpose;
  g.setting = setting;
  for (std::size_t i = 0; i < values.size(); ++i) {
    g.seeds.push_back(i + 1);
    g.results.push_back(finished({response("angle", {values[i]}, "deg")}));
  }
  return g;
}

// An experiment that gives 10 deg ± 0.1 in 100 repeats.
struct Comparisons : testing::Test {
  Comparisons() {
    suite.experiments.push_back({"heap", "", {}, {1, 2, 3}, {}});
    what.kind = ComparisonKind::value;
    what.responses = {"angle"};
    what.measurement.value = 10;
    what.measurement.unit = "deg";
    what.measurement.repeats = 100;
    what.measurement.standard_deviation = 1;
    what.measurement.scatter = ScatterKind::standard_deviation;
    what.measurement.source = "a notebook";
  }
  Comparison result() { return compare(suite, what, {}, evidence); }

  Suite suite;
  SuiteComparison what;
  ComparisonRuns evidence;
};

}  // namespace firn::test
