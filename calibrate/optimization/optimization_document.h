// The results.json of an optimization, as it is written and read. docs/optimization.md describes
// the values.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/text/json_fields.h"

namespace firn {

// Standard uncertainties are one standard deviation. NaN: not known.
struct OptimizationDocument {
  using Interval = std::pair<double, double>;

  struct DesignParameter {
    std::string name, unit, scale;  // "linear" or "log"
    std::vector<std::string> keys;
    double min = 0, max = 0;
    template <class Fields>
    void fields(Fields& f) {
      f.required("name", name);
      f.required("unit", unit);
      f.required("scale", scale);
      f.required("keys", keys);
      f.required("min", min);
      f.required("max", max);
    }
  };
  struct Limit {
    std::string response, side;  // of the event: the response is "above" or "below" the threshold
    double threshold = 0;
    std::string unit;
    double probability = 0;  // the largest that is allowed
    template <class Fields>
    void fields(Fields& f) {
      f.required("response", response);
      f.required("side", side);
      f.required("threshold", threshold);
      f.required("unit", unit);
      f.required("probability", probability);
    }
  };
  struct Event {  // of a limit, in the order of `limits`
    int events = 0, runs = 0;
    Interval interval_95;             // of the probability, from these runs alone
    double predicted = std::nan("");  // probability by the model of all runs
    template <class Fields>
    void fields(Fields& f) {
      f.required("events", events);
      f.required("runs", runs);
      f.required("interval_95", interval_95);
      f.required("predicted", predicted);
    }
  };
  struct Design {
    std::string name;  // phase of the search, or name of the compared design
    std::vector<double> values;
    int runs = 0, finished = 0;
    double mean = std::nan(""), standard_deviation = std::nan("");  // objective, over the runs
    double predicted_mean = std::nan(""), predicted_sd = std::nan("");
    double limits_kept = std::nan("");  // probability
    std::vector<Event> events;
    template <class Fields>
    void fields(Fields& f) {
      f.required("name", name);
      f.required("values", values);
      f.required("runs", runs);
      f.required("finished", finished);
      f.required("mean", mean);
      f.required("standard_deviation", standard_deviation);
      f.required("predicted_mean", predicted_mean);
      f.required("predicted_sd", predicted_sd);
      f.required("limits_kept", limits_kept);
      f.optional("events", events);
    }
  };
  struct Prediction {  // of the objective of one more run of the best design
    Interval interval_95;
    template <class Fields>
    void fields(Fields& f) {
      f.required("interval_95", interval_95);
    }
  };
  struct Gain {  // of the best design over a compared one, over common seeds
    std::string over;
    double mean = std::nan("");
    Interval interval_95;
    int pairs = 0;
    template <class Fields>
    void fields(Fields& f) {
      f.required("over", over);
      f.required("mean", mean);
      f.required("interval_95", interval_95);
      f.required("pairs", pairs);
    }
  };
  struct Slice {  // of the models along one parameter, through the best design
    std::string parameter;
    std::vector<double> values, mean, standard_deviation, limits_kept;
    template <class Fields>
    void fields(Fields& f) {
      f.required("parameter", parameter);
      f.required("values", values);
      f.required("mean", mean);
      f.required("standard_deviation", standard_deviation);
      f.required("limits_kept", limits_kept);
    }
  };

  std::string kind = "optimization";
  std::string name, case_file, verdict, headline, goal;  // goal: "maximize" or "minimize"
  std::string objective, unit, material;
  double confidence = 0;
  int runs = 0, not_finished = 0;
  std::vector<DesignParameter> parameters;
  std::vector<Limit> limits;
  std::vector<Design> designs, compared;
  std::optional<Design> best;
  std::optional<Prediction> prediction;
  std::vector<Gain> gains;
  std::vector<Slice> slices;
  template <class Fields>
  void fields(Fields& f) {
    f.required("kind", kind);
    f.required("name", name);
    f.required("case", case_file);
    f.required("verdict", verdict);
    f.required("headline", headline);
    f.required("goal", goal);
    f.required("objective", objective);
    f.required("unit", unit);
    f.required("material", material);
    f.required("confidence", confidence);
    f.required("runs", runs);
    f.required("not_finished", not_finished);
    f.required("parameters", parameters);
    f.optional("limits", limits);
    f.optional("best", best);
    f.optional("prediction", prediction);
    f.optional("gains", gains);
    f.optional("compared", compared);
    f.optional("designs", designs);
    f.optional("slices", slices);
  }
};

// Throws InputError for a file that is no results.json of an optimization.
OptimizationDocument read_optimization_document(const ResultsJson& results);

}  // namespace firn
