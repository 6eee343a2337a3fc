// An optimization file: a case, its design parameters, the response to maximize or minimize, and
// limits of the probabilities of events. Keys: docs/optimization.md.
#pragma once

#include <string>
#include <vector>

#include "calibrate/study/study_file.h"

namespace firn {

// A limit of the probability of an event: that a response lies above, or below, a threshold.
struct EventLimit {
  std::size_t response = 0;  // of Study::observed
  bool above = true;
  double threshold = 0;    // unit of the response
  double probability = 0;  // the largest that is allowed, over seeds and material

  bool happens(double value) const { return above ? value > threshold : value < threshold; }
};

struct OptimizationStudy {
  // Parameters, the experiment, designs to compare with, and limits of the runs. Its observed
  // responses are the objective, the first, and those of the limits. It has no targets.
  Study study;
  bool maximize = true;
  std::vector<EventLimit> limits;
  int runs = 0;                     // at most, all together
  int replicates_per_design = 0;    // seeds of each design of the search: the same for all
  int designs_per_round = 0;        // chosen together, from one fit
  int confirmation_replicates = 0;  // unused seeds at the best design and at each one compared
  // A design is recommended if it keeps all limits with this probability.
  double confidence = 0.9;

  const ResponseId& objective() const { return study.observed.front().response; }
  std::string event_text(const EventLimit& limit) const;  // "dispense_stalled above 0.5"
  std::int64_t confirmation_runs() const;
  int largest_designs() const;  // that the search can simulate besides
};

// Throws InputError with one line `FILE:LINE: KEY: what is wrong; what is expected`.
OptimizationStudy read_optimization(const std::string& file);

}  // namespace firn
