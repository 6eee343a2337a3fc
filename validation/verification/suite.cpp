#include "validation/verification/suite.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <numeric>
#include <set>

#include "firn/math.h"

namespace firn::verification {

bool passed(const CaseResult& result) {
  return result.ran && result.error.empty() && !result.checks.empty() &&
         std::all_of(result.checks.begin(), result.checks.end(),
                     [](const Check& c) { return passed(c); });
}

double most_used(const CaseResult& result) {
  double most = 0;
  for (const Check& c : result.checks) most = std::max(most, used(c));
  return most;
}

std::vector<VerificationCase> select(const std::vector<std::string>& names, bool full) {
  std::vector<VerificationCase> cases = all_cases();
  std::set<std::string> known_groups;
  for (const VerificationCase& c : cases) known_groups.insert(group(c));
  const auto named = [&](const VerificationCase& c) {
    return std::any_of(names.begin(), names.end(),
                       [&](const std::string& n) { return n == c.name || n == group(c); });
  };
  for (const std::string& name : names) {
    const bool known =
        known_groups.contains(name) ||
        std::any_of(cases.begin(), cases.end(), [&](const auto& c) { return c.name == name; });
    if (!known) {
      throw InputError(
          fmt::format("{}: no such verification case; expected a group ({}) or a name that `firn "
                      "verify --list` prints",
                      name, fmt::join(known_groups, ", ")));
    }
  }
  std::erase_if(cases, [&](const VerificationCase& c) {
    if (names.empty()) return c.tier == Tier::full && !full;
    // A group brings its long cases only when asked for; a case that is named is wanted.
    const bool by_name = std::find(names.begin(), names.end(), c.name) != names.end();
    return !named(c) || (c.tier == Tier::full && !full && !by_name);
  });
  return cases;
}

namespace {

CaseResult run_case(const VerificationCase& c) {
  CaseResult result;
  const auto begin = std::chrono::steady_clock::now();
  try {
    result.checks = c.run();
  } catch (const std::exception& e) {
    result.error = e.what();
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  result.ran = true;
  return result;
}

}  // namespace

std::vector<CaseResult> run_cases(
    const std::vector<VerificationCase>& cases, int jobs,
    const std::function<void(std::size_t, const std::vector<CaseResult>&)>& done) {
  std::vector<CaseResult> results(cases.size());
  std::vector<std::size_t> order(cases.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  // Long ones first, so that none of them is left over at the end.
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return cases[a].tier > cases[b].tier; });
  std::mutex one_at_a_time;
  std::atomic<std::size_t> next = 0;
  const auto work = [&](int) {
    for (std::size_t i = next++; i < order.size(); i = next++) {
      const std::size_t k = order[i];
      // A case that uses threads itself must not pick up another one while it waits for them.
      CaseResult result = tbb::this_task_arena::isolate([&] { return run_case(cases[k]); });
      const std::lock_guard lock(one_at_a_time);
      results[k] = std::move(result);
      done(k, results);
    }
  };
  tbb::task_arena arena(std::max(jobs, 1));
  arena.execute([&] { tbb::parallel_for(0, std::max(jobs, 1), work); });
  return results;
}

}  // namespace firn::verification
