#include "validation/verification/suite.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <iterator>
#include <mutex>
#include <numeric>
#include <set>
#include <thread>

#include "firn/math.h"
#include "validation/verification/assemblies/cases.h"
#include "validation/verification/robustness/cases.h"
#include "validation/verification/single_body/cases.h"

namespace firn::verification {

bool passed(const CaseResult& result) {
  return result.ran && result.error.empty() && !result.checks.empty() &&
         std::all_of(result.checks.begin(), result.checks.end(),
                     [](const Check& c) { return passed(c); });
}

double max_tolerance_fraction(const CaseResult& result) {
  double most = 0;
  for (const Check& c : result.checks) most = std::max(most, tolerance_fraction(c));
  return most;
}

std::vector<VerificationCase> all_cases() {
  std::vector<VerificationCase> all;
  for (auto* cases :
       {impact_cases, energy_cases, body_cases, structure_cases, bulk_cases, machine_cases,
        invariance_cases, mesh_cases, tessellation_cases, curved_wall_cases, robustness_cases}) {
    std::vector<VerificationCase> some = cases();
    all.insert(all.end(), std::make_move_iterator(some.begin()),
               std::make_move_iterator(some.end()));
  }
  return all;
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
    // A group includes its long cases only on request; a case that is named is always run.
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
  std::exception_ptr failure;  // of `done`
  const auto work = [&] {
    for (std::size_t i = next++; i < order.size(); i = next++) {
      const std::size_t k = order[i];
      CaseResult result = run_case(cases[k]);
      const std::lock_guard lock(one_at_a_time);
      results[k] = std::move(result);
      if (failure) return;
      try {
        done(k, results);
      } catch (...) {
        failure = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> others;
    for (int j = 1; j < jobs; ++j) others.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
  return results;
}

}  // namespace firn::verification
