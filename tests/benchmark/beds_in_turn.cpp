// What a step of a large bed costs per particle beside one of 880 crescents in the same state: one
// step of the large bed, then as many particles' worth of steps of the small one, and so on. A
// machine whose speed changes from second to second, as others use it, changes it for both.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <optional>

#include "tests/benchmark/kept_beds.h"

namespace firn {
namespace {

constexpr int kWarm = 20;       // steps of the small bed, not counted, after those of the large one
constexpr int kRestart = 1500;  // steps after which the small bed begins anew, to stay in its state
constexpr double kLeast = 2e-9;  // s per particle and step, phases that take less are left out

// Seconds per particle and step, by phase.
using Costs = std::map<std::string, double>;

// A bed whose steps are timed.
class TimedBed {
 public:
  TimedBed(beds::Bed bed, int along, int across, int threads)
      : solver_(beds::kept(bed, along, across, threads)), beginning_(solver_.save()) {}

  int timed() const { return timed_; }  // steps
  int particles() const { return static_cast<int>(solver_.model().particles.size()); }

  void warm_up(int steps) {
    if (taken_ + steps > kRestart) {
      solver_.restore(beginning_);
      taken_ = 0;
    }
    for (int k = 0; k < steps; ++k) solver_.step();
    taken_ += steps;
  }

  // Costs of the next steps. Those with a new list are left out, and their lists are noted.
  std::optional<Costs> time(int steps) {
    Costs sum;
    int counted = 0;
    for (int k = 0; k < steps; ++k) {
      const Costs before = so_far();
      const std::uint64_t lists = solver_.health().rebuilds;
      solver_.step();
      Costs step = so_far();
      for (const auto& [phase, seconds] : before) step[phase] -= seconds;
      if (solver_.health().rebuilds > lists) {
        list_costs.push_back(step["neighbour list"]);
        continue;
      }
      ++counted;
      for (const auto& [phase, seconds] : step) sum[phase] += seconds;
    }
    taken_ += steps;
    timed_ += steps;
    if (counted == 0) return std::nullopt;
    double all = 0;
    for (auto& [phase, seconds] : sum) all += seconds /= counted;
    sum["whole step"] = all;
    return sum;
  }

  std::vector<double> list_costs;  // s per particle and new list

 private:
  Costs so_far() const {
    Costs costs;
    for (const PhaseTime& p : solver_.profile()) costs[p.name] = p.seconds / particles();
    return costs;
  }

  Solver solver_;
  std::vector<std::byte> beginning_;
  int taken_ = 0, timed_ = 0;  // steps, since the beginning and in all
};

double quantile(std::vector<double> values, double q) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

struct Series {
  std::vector<double> large, small, ratio;
};

void print(const std::map<std::string, Series>& phases) {
  fmt::print("{:<20}{:>10}{:>10}{:>8}{:>18}\n", "ns/particle/step", "large", "small", "ratio",
             "8 of 10 rounds");
  for (const auto& [phase, s] : phases) {
    const double large = quantile(s.large, 0.5);
    if (large < kLeast) continue;
    fmt::print("{:<20}{:>10.1f}{:>10.1f}{:>8.3f}{:>10.2f} to {:.2f}\n", phase, 1e9 * large,
               1e9 * quantile(s.small, 0.5), quantile(s.ratio, 0.5), quantile(s.ratio, 0.1),
               quantile(s.ratio, 0.9));
  }
}

void print_lists(const char* which, const TimedBed& bed) {
  if (bed.list_costs.empty()) return;
  fmt::print("{} bed: {} new lists in {} steps, {:.2f} us/particle each (median)\n", which,
             bed.list_costs.size(), bed.timed(), 1e6 * quantile(bed.list_costs, 0.5));
}

void compare(beds::Bed bed, int along, int across, int rounds, int threads) {
  TimedBed large(bed, along, across, threads), small(bed, 1, 1, threads);
  large.warm_up(3);
  std::map<std::string, Series> phases;
  for (int k = 0; k < rounds; ++k) {
    const std::optional<Costs> of_large = large.time(1);
    small.warm_up(kWarm);
    const std::optional<Costs> of_small = small.time(along * across);
    if (!of_large || !of_small) continue;
    for (const auto& [phase, seconds] : *of_large) {
      const auto beside = of_small->find(phase);
      if (beside == of_small->end()) continue;
      Series& s = phases[phase];
      s.large.push_back(seconds);
      s.small.push_back(beside->second);
      s.ratio.push_back(seconds / beside->second);
    }
  }
  fmt::print("{}, {} and {} particles, {} rounds, {} thread{}\n", beds::name_of(bed),
             large.particles(), small.particles(), rounds, threads, threads == 1 ? "" : "s");
  print(phases);
  print_lists("large", large);
  print_lists("small", small);
}

}  // namespace
}  // namespace firn

int main(int count, char** words) {
  using firn::beds::Bed;
  CLI::App app("Steps of a bed of boxes side by side, and of one box, in turn");
  const std::map<std::string, Bed> beds = {
      {"settled", Bed::settled}, {"discharging", Bed::discharging}, {"stirred", Bed::stirred}};
  std::string bed;
  int along = 6, across = 19, rounds = 60, threads = 1;
  app.add_option("bed", bed, "its state")->required()->check(CLI::IsMember(&beds));
  const auto number = [&](const char* name, int& value, const char* meaning) {
    app.add_option(name, value, meaning)->capture_default_str()->check(CLI::PositiveNumber);
  };
  number("--along", along, "boxes of the large bed along x");
  number("--across", across, "boxes of the large bed across");
  number("--rounds", rounds, "steps of the large bed");
  number("--threads", threads, "threads of either");
  CLI11_PARSE(app, count, words);
  firn::compare(beds.at(bed), along, across, rounds, threads);
}
