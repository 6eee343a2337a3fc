// The results.json of a sweep, as it is written and read.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "experiments/text/json_fields.h"

namespace firn {

struct SweepDocument {
  struct NamedResponse {
    std::string name, unit;
    template <class Fields>
    void fields(Fields& f) {
      f.required("name", name);
      f.required("unit", unit);
    }
  };
  struct Scatter {  // over the seeds; NaN: undefined
    double mean = std::nan(""), standard_deviation = std::nan("");
    int runs = 0;
    template <class Fields>
    void fields(Fields& f) {
      f.required("mean", mean);
      f.required("standard_deviation", standard_deviation);
      f.required("runs", runs);
    }
  };
  struct Combination {
    NamedValues<std::string> values;  // by name of the swept key, as people write them
    NamedValues<Scatter> responses;
    template <class Fields>
    void fields(Fields& f) {
      f.required("values", values);
      f.optional("responses", responses);
    }
  };
  struct Power {
    double exponent = 0, standard_error = 0;  // NaN: not known
    template <class Fields>
    void fields(Fields& f) {
      f.required("exponent", exponent);
      f.required("standard_error", standard_error);
    }
  };
  // Elementary effects of one factor on one response, in units of the response over the whole range
  // of the factor. NaN: undefined.
  struct Effect {
    double mean_absolute = 0;
    std::pair<double, double> interval_95;  // of mean_absolute
    double mean = 0, standard_deviation = 0;
    double noise = 0;  // mean absolute effect that the scatter over seeds alone gives
    int count = 0;     // of effects
    template <class Fields>
    void fields(Fields& f) {
      f.required("mean_absolute", mean_absolute);
      f.required("interval_95", interval_95);
      f.required("mean", mean);
      f.required("standard_deviation", standard_deviation);
      f.required("noise", noise);
      f.required("count", count);
    }
  };
  struct Run {
    std::size_t combination = 0;
    std::uint64_t seed = 0;
    std::string key, status, reason;
    double wall = 0;             // s
    std::vector<double> values;  // of `responses`; NaN: undefined
    std::string results_file;
    template <class Fields>
    void fields(Fields& f) {
      f.required("combination", combination);
      f.required("seed", seed);
      f.required("key", key);
      f.required("status", status);
      f.required("reason", reason);
      f.required("wall", wall);
      f.required("values", values);
      f.required("results_file", results_file);
    }
  };

  std::string kind = "sweep";
  std::string name, case_file;
  std::vector<NamedResponse> responses;
  std::vector<Combination> combinations;
  NamedValues<Power> powers;                 // by response
  NamedValues<NamedValues<Effect>> effects;  // by response and factor, the most important first
  std::vector<Run> runs;
  template <class Fields>
  void fields(Fields& f) {
    f.required("kind", kind);
    f.required("name", name);
    f.required("case", case_file);
    f.required("responses", responses);
    f.optional("combinations", combinations);
    f.optional("powers", powers);
    f.optional("effects", effects);
    f.optional("runs", runs);
  }
};

// Throws InputError for a file that is no results.json of a sweep.
SweepDocument read_sweep_document(const ResultsJson& results);

}  // namespace firn
