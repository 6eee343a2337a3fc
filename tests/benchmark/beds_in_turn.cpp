// What a step of a bed costs per particle, compared with one of another size or with another number
// of threads, in the same state: some steps of the one, then for as long steps of the other, and so
// on. A machine whose speed changes from second to second, as others use it, changes it for both.
// And what the machine gives to runs that have nothing to do with each other: copies of the one bed
// side by side, as many as the other has threads.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <map>
#include <optional>
#include <thread>

#include "tests/benchmark/kept_beds.h"

namespace firn {
namespace {

// Particles' steps, at least one step: those that count of each bed in each round, some 40 ms, and
// those before them.
constexpr int kCounted = 200'000, kWarm = 20'000;
constexpr int kRestart = 1500;   // steps after which a bed is restored, to stay in its state
constexpr double kLeast = 2e-9;  // s per particle and step, phases that take less are left out

// Seconds per particle and step, by phase.
using Costs = std::map<std::string, double>;
constexpr const char* kWhole = "whole step";

// A bed whose steps are timed.
class TimedBed {
 public:
  TimedBed(beds::Bed bed, int along, int across, int threads)
      : solver_(beds::kept(bed, along, across, threads)), beginning_(solver_.save()) {}

  int timed() const { return timed_; }  // steps
  void step() {                         // one that does not count
    solver_.step_deferred();
    ++taken_;
  }
  int particles() const { return static_cast<int>(solver_.model().particles.size()); }

  // Costs of some steps, after some that do not count. Those with a new list are left out, and
  // their lists are noted.
  std::optional<Costs> time() {
    if (taken_ > kRestart) {
      solver_.restore(beginning_);
      taken_ = 0;
    }
    const int warm = std::max(1, kWarm / particles()), steps = std::max(1, kCounted / particles());
    for (int k = 0; k < warm; ++k) solver_.step_deferred();
    Costs sum;
    int counted = 0;
    for (int k = 0; k < steps; ++k) {
      const Costs before = so_far();
      const std::uint64_t lists = solver_.diagnostics().rebuilds;
      solver_.step_deferred();
      Costs step = so_far();
      for (const auto& [phase, seconds] : before) step[phase] -= seconds;
      if (solver_.diagnostics().rebuilds > lists) {
        list_costs.push_back(step["neighbor list"]);
        continue;
      }
      ++counted;
      for (const auto& [phase, seconds] : step) sum[phase] += seconds;
    }
    taken_ += warm + steps;
    timed_ += steps;
    if (counted == 0) return std::nullopt;
    double all = 0;
    for (auto& [phase, seconds] : sum) all += seconds /= counted;
    sum[kWhole] = all;
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
  std::vector<double> one, other, ratio;
};

void print(const std::map<std::string, Series>& phases) {
  fmt::print("{:<20}{:>10}{:>10}{:>8}{:>18}\n", "ns/particle/step", "one", "other", "ratio",
             "8 of 10 rounds");
  for (const auto& [phase, s] : phases) {
    const double one = quantile(s.one, 0.5);
    if (one < kLeast) continue;
    fmt::print("{:<20}{:>10.1f}{:>10.1f}{:>8.3f}{:>10.2f} to {:.2f}\n", phase, 1e9 * one,
               1e9 * quantile(s.other, 0.5), quantile(s.ratio, 0.5), quantile(s.ratio, 0.1),
               quantile(s.ratio, 0.9));
  }
}

void print_lists(const char* which, const TimedBed& bed) {
  if (bed.list_costs.empty()) return;
  fmt::print("{}: {} new lists in {} steps, {:.2f} us/particle each (median)\n", which,
             bed.list_costs.size(), bed.timed(), 1e6 * quantile(bed.list_costs, 0.5));
}

// How much more the beds get done side by side, a thread for each, than one of them that needs
// `alone` seconds per particle and step. Nothing if one of them made a new list in every step.
std::optional<double> gain_side_by_side(std::vector<TimedBed>& beds, double alone) {
  std::vector<double> costs(beds.size(), 0);
  std::atomic<std::size_t> done = 0;
  {
    std::vector<std::jthread> threads;
    for (std::size_t k = 0; k < beds.size(); ++k) {
      threads.emplace_back([&, k] {
        if (const std::optional<Costs> of_bed = beds[k].time()) costs[k] = of_bed->at(kWhole);
        // A bed that is done first continues, to keep up the load on the machine.
        for (++done; done < beds.size();) beds[k].step();
      });
    }
  }
  double gain = 0;
  for (const double cost : costs) {
    if (cost == 0) return std::nullopt;
    gain += alone / cost;
  }
  return gain;
}

struct Choice {
  int along, across, threads;
};

void compare(beds::Bed bed, const Choice& a, const Choice& b, int rounds, bool side_by_side) {
  TimedBed one(bed, a.along, a.across, a.threads), other(bed, b.along, b.across, b.threads);
  std::vector<TimedBed> copies;
  for (int k = 0; side_by_side && k < b.threads; ++k)
    copies.emplace_back(bed, a.along, a.across, a.threads);
  std::vector<double> gains;
  std::map<std::string, Series> phases;
  for (int k = 0; k < rounds; ++k) {
    const std::optional<Costs> of_one = one.time(), of_other = other.time();
    if (!of_one || !of_other) continue;
    for (const auto& [phase, seconds] : *of_one) {
      const auto counterpart = of_other->find(phase);
      if (counterpart == of_other->end()) continue;
      Series& s = phases[phase];
      s.one.push_back(seconds);
      s.other.push_back(counterpart->second);
      s.ratio.push_back(seconds / counterpart->second);
    }
    if (!side_by_side) continue;
    if (const std::optional<double> gain = gain_side_by_side(copies, of_one->at(kWhole)))
      gains.push_back(*gain);
  }
  fmt::print("{}, {} rounds: one of {} particles with {} thread{}, other of {} with {}\n",
             beds::name_of(bed), rounds, one.particles(), a.threads, a.threads == 1 ? "" : "s",
             other.particles(), b.threads);
  print(phases);
  if (!gains.empty()) {
    fmt::print("{} of one side by side get {:.3f} times as much done ({:.2f} to {:.2f})\n",
               copies.size(), quantile(gains, 0.5), quantile(gains, 0.1), quantile(gains, 0.9));
  }
  print_lists("one", one);
  print_lists("other", other);
}

}  // namespace
}  // namespace firn

int main(int count, char** words) {
  using firn::beds::Bed;
  CLI::App app("Steps of two beds of boxes side by side, in turn");
  const std::map<std::string, Bed> beds = {
      {"settled", Bed::settled}, {"discharging", Bed::discharging}, {"stirred", Bed::stirred}};
  std::string bed;
  firn::Choice one{6, 19, 1}, other{1, 1, 1};
  int rounds = 60;
  app.add_option("bed", bed, "state of both")->required()->check(CLI::IsMember(&beds));
  const auto number = [&](const char* name, int& value, const char* meaning) {
    app.add_option(name, value, meaning)->capture_default_str()->check(CLI::PositiveNumber);
  };
  number("--along", one.along, "boxes along x");
  number("--across", one.across, "boxes across");
  number("--threads", one.threads, "threads");
  number("--other-along", other.along, "boxes along x of the other bed");
  number("--other-across", other.across, "boxes across of the other bed");
  number("--other-threads", other.threads, "threads of the other bed");
  number("--rounds", rounds, "how often both are stepped");
  bool side_by_side = false;
  app.add_flag("--side-by-side", side_by_side,
               "also step copies of the one side by side, as many as the other has threads");
  CLI11_PARSE(app, count, words);
  firn::compare(beds.at(bed), one, other, rounds, side_by_side);
}
