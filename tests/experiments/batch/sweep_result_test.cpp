#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "experiments/batch/sweep/sweep.h"
#include "experiments/results/response.h"

namespace firn {
namespace {

// A screening of four factors of two levels with one response of given values [combinations].
SweepResult screened(const std::function<double(const std::vector<std::size_t>&)>& response) {
  SweepResult r;
  r.sweep.name = "screened";
  r.sweep.seeds = {1};
  r.sweep.design = SweepDesign::morris;
  for (const char* name : {"a", "b", "c", "d"})
    r.sweep.vary.push_back({name, {std::string("case.") + name}, {"0", "1"}});
  r.sweep.screening = screening_design({2, 2, 2, 2}, 8, 1);
  r.responses = {"y"};
  r.units = {"N"};
  for (std::size_t c = 0; c < r.sweep.combinations(); ++c) {
    SweepRun run;
    run.combination = c;
    run.seed = 1;
    run.result.status = JobStatus::finished;
    run.values = {response(r.sweep.screening.points[c])};
    r.runs.push_back(run);
  }
  return r;
}

std::vector<std::string> order_of(const SweepResult& r) {
  const auto document = nlohmann::ordered_json::parse(render_json(r));
  std::vector<std::string> names;
  for (const auto& [name, effect] : document["effects"]["y"].items()) names.push_back(name);
  return names;
}

TEST(SweepResult, RanksFactorsByTheirEffects) {
  const SweepResult r = screened([](const std::vector<std::size_t>& x) {
    return 1.0 * static_cast<double>(x[0]) - 5.0 * static_cast<double>(x[1]) +
           3.0 * static_cast<double>(x[3]);
  });
  EXPECT_THAT(order_of(r), testing::ElementsAre("b", "d", "a", "c"));
}

// Where the response is undefined on one side of a factor, this factor has no effect at all.
TEST(SweepResult, PutsFactorsWithoutADefinedEffectLast) {
  const SweepResult r = screened([](const std::vector<std::size_t>& x) {
    return x[0] == 1 ? kUndefined : static_cast<double>(x[2]);
  });
  EXPECT_THAT(order_of(r), testing::ElementsAre("c", "b", "d", "a"));
  EXPECT_THAT(render_table(r), testing::ContainsRegex("a +- +- to - +- +-"));
}

}  // namespace
}  // namespace firn
