// The results.json of a validation, as it is written and read. docs/validation.md describes the
// values.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/text/json_fields.h"

namespace firn {

// NaN: not known.
struct ValidationDocument {
  using Interval = std::pair<double, double>;

  struct Component {  // of the validation uncertainty
    std::string name;
    double value = std::nan("");  // one standard deviation; NaN: not evaluated
    double degrees_of_freedom = std::nan("");
    std::string evaluation_method;
    template <class Fields>
    void fields(Fields& f) {
      f.required("name", name);
      f.required("value", value);
      f.added("degrees_of_freedom", degrees_of_freedom);
      f.required("evaluation_method", evaluation_method);
    }
  };

  struct Value {
    std::string unit;
    double simulated = 0, standard_deviation = std::nan("");
    int runs = 0;
    std::vector<double> samples;
    double measured = 0, comparison_error = std::nan(""), validation_uncertainty = 0;
    double expanded_uncertainty = std::nan("");
    std::optional<double> simulated_expanded, measured_expanded;
    double p_value = std::nan("");
    std::vector<Component> components;
    std::optional<Interval> area_metric;
    template <class Fields>
    void fields(Fields& f) {
      f.required("unit", unit);
      f.required("simulated", simulated);
      f.added("standard_deviation", standard_deviation);
      f.added("runs", runs);
      f.added("samples", samples);
      f.required("measured", measured);
      f.added("comparison_error", comparison_error);
      f.required("validation_uncertainty", validation_uncertainty);
      f.added("expanded_uncertainty", expanded_uncertainty);
      f.optional("simulated_expanded", simulated_expanded);
      f.optional("measured_expanded", measured_expanded);
      f.added("p_value", p_value);
      f.optional("components", components);
      f.added("area_metric", area_metric);
    }
  };

  struct CriterionRow {
    std::string statement, relation, rationale;
    int observed_once_in = 0, holds_in = 0, runs = 0;
    int failed = 0, missing = 0;  // failed runs among `runs`; further runs without an answer
    Interval probability_90;
    std::string verdict;
    std::vector<double> lhs, rhs;
    std::string unit;
    template <class Fields>
    void fields(Fields& f) {
      f.required("statement", statement);
      f.required("relation", relation);
      f.required("rationale", rationale);
      f.added("observed_once_in", observed_once_in);
      f.required("holds_in", holds_in);
      f.required("runs", runs);
      f.added("failed", failed);
      f.added("missing", missing);
      f.required("probability_90", probability_90);
      f.required("verdict", verdict);
      f.added("lhs", lhs);
      f.added("rhs", rhs);
      f.added("unit", unit);
    }
  };

  struct Passed {  // share of particles that have left, by time
    std::vector<double> x, share, error;
    std::uint64_t still_inside = 0;
    template <class Fields>
    void fields(Fields& f) {
      f.required("x", x);
      f.required("share", share);
      f.required("error", error);
      f.required("still_inside", still_inside);
    }
  };

  struct Area {
    double value = 0, p_value = 0;
    template <class Fields>
    void fields(Fields& f) {
      f.required("value", value);
      f.required("p_value", p_value);
    }
  };

  struct Distribution {
    std::string response, unit;
    bool by_class = false;
    std::vector<std::string> classes;
    std::vector<double> measured, simulated, deviation;
    std::string verdict;
    std::optional<Passed> measured_passed, simulated_passed;
    std::optional<double> distance, p_value, critical_distance;
    std::optional<bool> dependent;
    std::optional<double> dispersion, value_apart;
    std::optional<Area> area;
    template <class Fields>
    void fields(Fields& f) {
      f.required("response", response);
      f.required("unit", unit);
      f.required("by_class", by_class);
      f.required("classes", classes);
      f.required("measured", measured);
      f.required("simulated", simulated);
      f.required("deviation", deviation);
      f.added("verdict", verdict);
      f.optional("measured_passed", measured_passed);
      f.optional("simulated_passed", simulated_passed);
      f.optional("distance", distance);
      f.optional("p_value", p_value);
      f.optional("critical_distance", critical_distance);
      f.optional("dependent", dependent);
      f.optional("dispersion", dispersion);
      f.optional("value_apart", value_apart);
      f.optional("area", area);
    }
  };

  struct Probability {
    Interval each;
    double each_best = std::nan("");
    Interval any;
    double any_best = std::nan("");
    template <class Fields>
    void fields(Fields& f) {
      f.required("each", each);
      f.added("each_best", each_best);
      f.required("any", any);
      f.added("any_best", any_best);
    }
  };

  struct Breakage {
    std::string response;
    int particles = 0;
    double largest = 0, median = 0;
    Probability distribution_free, weibull;
    std::vector<double> loads;
    template <class Fields>
    void fields(Fields& f) {
      f.required("response", response);
      f.added("particles", particles);
      f.required("largest", largest);
      f.required("median", median);
      f.required("distribution_free", distribution_free);
      f.required("weibull", weibull);
      f.required("loads", loads);
    }
  };

  struct StiffnessScaling {
    std::string response, unit;
    std::vector<double> modulus, mean, error;
    std::vector<int> runs;
    double exponent = 0, exponent_error = 0;
    Interval extrapolated_95;
    double extrapolation_factor = std::nan("");
    std::string interpretation;
    template <class Fields>
    void fields(Fields& f) {
      f.required("response", response);
      f.required("unit", unit);
      f.required("modulus", modulus);
      f.required("mean", mean);
      f.required("error", error);
      f.added("runs", runs);
      f.required("exponent", exponent);
      f.required("exponent_error", exponent_error);
      f.required("extrapolated_95", extrapolated_95);
      f.added("extrapolation_factor", extrapolation_factor);
      f.required("interpretation", interpretation);
    }
  };

  struct Curve {
    std::string x_name, x_unit, y_name, unit;
    int runs = 0, repeats = 0;
    std::vector<double> x, measured, measured_error, simulated, simulated_error;
    double shift = std::nan(""), range = std::nan(""), comparison_error = std::nan("");
    double validation_uncertainty = std::nan(""), expanded_uncertainty = std::nan("");
    double largest = std::nan(""), at = std::nan("");
    template <class Fields>
    void fields(Fields& f) {
      f.required("x_name", x_name);
      f.required("x_unit", x_unit);
      f.required("y_name", y_name);
      f.required("unit", unit);
      f.added("runs", runs);
      f.added("repeats", repeats);
      f.required("x", x);
      f.required("measured", measured);
      f.required("measured_error", measured_error);
      f.required("simulated", simulated);
      f.required("simulated_error", simulated_error);
      f.added("shift", shift);
      f.added("range", range);
      f.required("comparison_error", comparison_error);
      f.added("validation_uncertainty", validation_uncertainty);
      f.added("expanded_uncertainty", expanded_uncertainty);
      f.added("largest", largest);
      f.added("at", at);
    }
  };

  struct NumericalVariant {
    std::string response, unit, variant;
    int seeds = 0;
    double before = 0, after = 0, error = 0;
    template <class Fields>
    void fields(Fields& f) {
      f.required("response", response);
      f.required("unit", unit);
      f.required("variant", variant);
      f.required("seeds", seeds);
      f.required("before", before);
      f.required("after", after);
      f.required("error", error);
    }
  };

  struct Assumption {
    std::string name;
    int runs = 0;
    std::string outcome;
    bool changes_the_verdict = false;
    template <class Fields>
    void fields(Fields& f) {
      f.required("name", name);
      f.required("runs", runs);
      f.required("outcome", outcome);
      f.required("changes_the_verdict", changes_the_verdict);
    }
  };

  struct Strength {  // N
    double minimum = 0, mean = std::nan(""), maximum = 0;
    int tests = 0;
    template <class Fields>
    void fields(Fields& f) {
      f.required("minimum", minimum);
      f.added("mean", mean);
      f.required("maximum", maximum);
      f.added("tests", tests);
    }
  };

  struct WeibullShape {
    double median = 0;
    Interval interval_95;
    template <class Fields>
    void fields(Fields& f) {
      f.required("median", median);
      f.required("interval_95", interval_95);
    }
  };

  struct ComparisonRow {
    std::string name, title, note, kind, experiment, parameter_set, verdict, headline;
    std::string recommended_action, measurement, measurement_status;
    bool code_to_code = false;
    std::vector<std::string> caveats;
    int runs = 0, finished = 0;
    std::vector<Assumption> assumptions;
    std::optional<Value> value;
    std::vector<CriterionRow> criteria;
    std::optional<Distribution> distribution;
    std::vector<Breakage> breakage;
    std::optional<Strength> strength;
    std::optional<WeibullShape> weibull_shape;
    std::vector<StiffnessScaling> stiffness_scaling;
    std::vector<NumericalVariant> numerical_variants;
    std::optional<Curve> curve;
    template <class Fields>
    void fields(Fields& f) {
      f.required("name", name);
      f.required("title", title);
      f.required("note", note);
      f.required("kind", kind);
      f.required("experiment", experiment);
      f.required("parameter_set", parameter_set);
      f.required("verdict", verdict);
      f.required("headline", headline);
      f.required("recommended_action", recommended_action);
      f.required("measurement", measurement);
      f.required("measurement_status", measurement_status);
      f.added("code_to_code", code_to_code);
      f.required("caveats", caveats);
      f.added("runs", runs);
      f.added("finished", finished);
      f.optional("assumptions", assumptions);
      f.optional("value", value);
      f.optional("criteria", criteria);
      f.optional("distribution", distribution);
      f.optional("breakage", breakage);
      f.optional("strength", strength);
      f.optional("weibull_shape", weibull_shape);
      f.optional("stiffness_scaling", stiffness_scaling);
      f.optional("numerical_variants", numerical_variants);
      f.optional("curve", curve);
    }
  };

  struct RunRow {
    std::string key, parameter_set, purpose;
    double setting = 0;
    std::string variant;
    std::uint64_t seed = 0;
    std::string status, reason;
    double wall = 0;
    std::string results_file;
    template <class Fields>
    void fields(Fields& f) {
      f.required("key", key);
      f.required("parameter_set", parameter_set);
      f.required("purpose", purpose);
      f.added("setting", setting);
      f.required("variant", variant);
      f.required("seed", seed);
      f.required("status", status);
      f.added("reason", reason);
      f.required("wall", wall);
      f.added("results_file", results_file);
    }
  };

  struct ExperimentRow {
    std::string name, case_file;
    std::vector<RunRow> runs;
    template <class Fields>
    void fields(Fields& f) {
      f.required("name", name);
      f.required("case", case_file);
      f.optional("runs", runs);
    }
  };

  struct ParameterSetRow {
    std::string name, note, material;
    NamedValues<std::string> set;
    int samples = 0;
    template <class Fields>
    void fields(Fields& f) {
      f.required("name", name);
      f.required("note", note);
      f.required("material", material);
      f.required("set", set);
      f.added("samples", samples);
    }
  };

  std::string kind = "validation", name, title, note, suite_file, suite, command, firn_version;
  std::string git_commit;
  int contact_model = 1;
  std::vector<ParameterSetRow> parameter_sets;
  std::vector<ExperimentRow> experiments;
  std::vector<ComparisonRow> comparisons;
  template <class Fields>
  void fields(Fields& f) {
    f.required("kind", kind);
    f.required("name", name);
    f.required("title", title);
    f.required("note", note);
    f.added("suite_file", suite_file);
    f.added("suite", suite);
    f.required("command", command);
    f.required("firn_version", firn_version);
    f.required("git_commit", git_commit);
    f.added("contact_model", contact_model);
    f.optional("parameter_sets", parameter_sets);
    f.optional("experiments", experiments);
    f.optional("comparisons", comparisons);
  }
};

// Throws InputError for a file that is no results.json of a validation.
ValidationDocument read_validation_document(const ResultsJson& results);

}  // namespace firn
