// Calibration problems whose answer is known: formulas in place of experiments, with noise.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/support/fake_experiment.h"

namespace firn::proof {

struct ProofResponse {
  std::string name;
  double uncertainty = 0;  // of the measurement that is the target
  double noise = 0;        // sd of one run between seeds
  std::function<double(const std::vector<double>&)> value;
};

struct Problem {
  std::string name;
  struct Range {
    double min, max;
    bool logarithmic;
  };
  std::vector<Range> parameters;  // p0, p1, ...
  std::vector<double> truth;
  std::vector<ProofResponse> responses;
  // How a run ends; `luck` is the deviate of its first response. Empty: every run finishes.
  std::function<JobStatus(const std::vector<double>&, double luck)> ends = {};

  std::vector<double> values(const std::map<std::string, double>& by_key) const {
    std::vector<double> v;
    for (std::size_t i = 0; i < parameters.size(); ++i)
      v.push_back(by_key.at("p" + std::to_string(i)));
    return v;
  }
  FakeExperiment experiment() const {
    return FakeExperiment([this](const FakeExperiment::Values& keys, std::mt19937_64& random) {
      std::vector<Response> all;
      JobStatus status = JobStatus::finished;
      for (const ProofResponse& r : responses) {
        const double luck = normal_deviate(random);
        if (ends && all.empty()) status = ends(values(keys), luck);
        all.push_back(scalar(r.name, r.value(values(keys)) + r.noise * luck, "1"));
      }
      return status == JobStatus::finished ? finished(all) : JobResult{status, "a gap", {}, 1.0};
    });
  }
  // Root mean square of (true response - target) / uncertainty over the responses.
  double distance(const std::vector<double>& p, const std::vector<double>& target) const {
    double sum = 0;
    for (std::size_t k = 0; k < responses.size(); ++k)
      sum += std::pow((responses[k].value(p) - target[k]) / responses[k].uncertainty, 2);
    return std::sqrt(sum / static_cast<double>(responses.size()));
  }
};

// Heap of spheres (Zhou et al. as coded in Lethe, without its rolling and size terms), a flow rate
// whose lines of equal value cross the heap's, a rebound; Forrester's, Branin's and Hartmann's
// functions (Surjanovic and Bingham's collection) as responses to be met. "Heap with gaps" fails at
// low friction, and more often the higher its heap would have been; it arches at high wall
// friction. Its truth lies where a quarter of the runs fail and a seventh arch.
std::vector<Problem> reference_problems();

// The study of a problem with these measured values, `runs` simulations and this first seed; the
// truth stands in it as a set to compare.
std::string study_text(const Problem& problem, const std::vector<double>& target, int runs,
                       int seed, const std::string& more = "");

}  // namespace firn::proof
