// The row "progress" of the journal of a batch.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/text/json_fields.h"

namespace firn {

// Estimates of a study from the runs that have ended so far.
struct BatchKnowledge {
  struct Estimate {  // value and 95 % interval, in `unit`
    double value = 0, low = 0, high = 0;
    std::string unit;
    template <class Fields>
    void fields(Fields& f) {
      f.required("value", value);
      f.required("low", low);
      f.required("high", high);
      f.added("unit", unit);
    }
  };
  struct Determined {  // a combination of parameters
    std::string combination;
    double value = 0, uncertainty = 0;  // one standard deviation
    std::string text() const;           // "ln(mu) = -2.3 ± 0.25"
    template <class Fields>
    void fields(Fields& f) {
      f.required("combination", combination);
      f.required("value", value);
      f.required("uncertainty", uncertainty);
    }
  };
  struct FittedTarget {
    std::string response;
    double value = 0;  // measured, in the unit of the response
    template <class Fields>
    void fields(Fields& f) {
      f.required("response", response);
      f.required("value", value);
    }
  };
  NamedValues<Estimate> best;  // by parameter, after the latest fit
  std::vector<Determined> determined;
  std::vector<FittedTarget> targets;
  template <class Fields>
  void fields(Fields& f) {
    f.required("best", best);
    f.added("determined", determined);
    f.optional("targets", targets);
  }
};

struct BatchProgressRecord {
  std::string command;                      // "calibrate", "validate" or "sweep"
  int most_runs = 0;                        // that are planned
  int jobs = 0;                             // simulations at the same time; 0: not known
  std::optional<BatchKnowledge> knowledge;  // of a study, after its first fit
  template <class Fields>
  void fields(Fields& f) {
    f.required("command", command);
    f.required("most_runs", most_runs);
    f.required("jobs", jobs);
    f.optional("knowledge", knowledge);
  }
};

}  // namespace firn
