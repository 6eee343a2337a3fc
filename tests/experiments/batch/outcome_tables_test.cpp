// Outcomes in memory are those that a later session reads from the journal.
#include "experiments/batch/journal/outcome_tables.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "experiments/batch/journal/journal.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

class RandomResults {
 public:
  explicit RandomResults(std::uint32_t seed) : random_(seed) {}

  JobResult next() {
    JobResult result;
    result.status = outcomes[below(std::size(outcomes))];
    result.reason = below(2) == 0 ? "" : "a reason, \"quoted\"\nand of two lines";
    result.wall = std::abs(number());
    result.simulated = std::abs(number());
    result.limit = static_cast<double>(below(1000));
    result.results_file = "runs/" + std::to_string(below(1000)) + ".h5";
    // Names in any order, each once.
    std::vector<std::string> names = {"b", "a_left", "a", "Z", "b_left", "ä", "mass"};
    std::ranges::shuffle(names, random_);
    for (std::size_t k = 0, count = below(names.size()); k < count; ++k) {
      Response r{names[k], {}, {}, below(2) == 0 ? "1" : "deg", "a method", 1};
      r.method_version = static_cast<int>(below(5));
      for (std::size_t i = below(4); i > 0; --i) r.value.push_back(number());
      for (std::size_t i = below(4); i > 0; --i)
        r.uncertainty.push_back(below(5) == 0 ? kNaN : std::abs(number()));
      result.responses.push_back(r);
    }
    return result;
  }

 private:
  std::size_t below(std::size_t n) { return random_() % n; }
  double number() {
    const std::size_t kind = below(200);
    if (kind == 0) return kNaN;
    if (kind == 1) return 1e31;  // implausible
    return std::normal_distribution<double>(0, 1e3)(random_);
  }

  std::mt19937_64 random_;
};

std::vector<std::uint64_t> bits(const std::vector<double>& values) {
  std::vector<std::uint64_t> out;
  for (const double v : values) out.push_back(std::isnan(v) ? 0 : std::bit_cast<std::uint64_t>(v));
  return out;
}

void expect_equal(const JobResult& a, const JobResult& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.reason, b.reason);
  EXPECT_EQ(a.results_file, b.results_file);
  EXPECT_EQ(bits({a.wall, a.simulated, a.limit}), bits({b.wall, b.simulated, b.limit}));
  ASSERT_EQ(a.responses.size(), b.responses.size());
  for (std::size_t k = 0; k < a.responses.size(); ++k) {
    const Response &r = a.responses[k], &s = b.responses[k];
    EXPECT_EQ(r.name, s.name);
    EXPECT_EQ(r.unit, s.unit);
    EXPECT_EQ(r.method, s.method);
    EXPECT_EQ(r.method_version, s.method_version);
    EXPECT_EQ(bits(r.value), bits(s.value));
    EXPECT_EQ(bits(r.uncertainty), bits(s.uncertainty));
  }
}

TEST(OutcomeTables, TheStoredFormIsWhatTheJournalGives) {
  const test::ScratchFolder folder("outcomes");
  Journal journal(folder.path().string(), "a study", false);
  RandomResults random(5);
  int with_responses = 0;
  for (int k = 0; k < 200; ++k) {
    const std::string key = "run " + std::to_string(k);
    const JobResult result = plausible(random.next());
    journal.plan({{key, "case", "program", {}}});
    journal.finish(key, result);
    const auto stored = journal.outcome(key);
    ASSERT_TRUE(stored.has_value());
    expect_equal(stored_form(result), *stored);
    with_responses += stored->responses.size() > 1 ? 1 : 0;
  }
  EXPECT_GT(with_responses, 50);
}

}  // namespace
}  // namespace firn
