// The results.json of a study, as it is written and read. docs/calibration.md describes the values.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/text/json_fields.h"

namespace firn {

// Standard uncertainties are one standard deviation. NaN: not known.
struct StudyDocument {
  using Interval = std::pair<double, double>;

  struct VarianceParts {  // standard deviations
    double measurement = 0, seed_noise = 0, surrogate = 0;
    std::optional<double> discrepancy;
    template <class Fields>
    void fields(Fields& f) {
      f.required("measurement", measurement);
      f.required("seed_noise", seed_noise);
      f.required("surrogate", surrogate);
      f.optional("discrepancy", discrepancy);
    }
  };

  struct Goodness {
    double chi_square = 0, degrees_of_freedom = 0, probability = 0;
    bool acceptable = false;
    NamedValues<double> standardized_residuals;  // by target
    template <class Fields>
    void fields(Fields& f) {
      f.required("chi_square", chi_square);
      f.required("degrees_of_freedom", degrees_of_freedom);
      f.required("probability", probability);
      f.required("acceptable", acceptable);
      f.optional("standardized_residuals", standardized_residuals);
    }
  };

  struct Marginal {
    double median = 0;
    Interval interval_68, interval_95;
    template <class Fields>
    void fields(Fields& f) {
      f.required("median", median);
      f.required("interval_68", interval_68);
      f.required("interval_95", interval_95);
    }
  };

  struct Distribution {
    struct Histogram {
      std::vector<double> edges, probability;  // [bins + 1], [bins]
      template <class Fields>
      void fields(Fields& f) {
        f.required("edges", edges);
        f.required("probability", probability);
      }
    };
    std::vector<double> quantiles;  // of 2.5, 16, 50, 84 and 97.5 %
    Histogram histogram;
    template <class Fields>
    void fields(Fields& f) {
      f.required("quantiles", quantiles);
      f.required("histogram", histogram);
    }
  };

  struct Target {
    struct Reach {
      double lowest = 0, highest = 0;
      bool bracketed = false, reachable = false;
      template <class Fields>
      void fields(Fields& f) {
        f.required("lowest", lowest);
        f.required("highest", highest);
        f.added("bracketed", bracketed);
        f.added("reachable", reachable);
      }
    };
    struct Predictive {
      std::vector<double> probabilities;
      Distribution mean_response, single_run;
      template <class Fields>
      void fields(Fields& f) {
        f.added("probabilities", probabilities);
        f.required("mean_response", mean_response);
        f.required("single_run", single_run);
      }
    };
    std::string response;
    double value = 0, uncertainty = 0;
    std::string unit = "1", source;
    std::optional<double> discrepancy;
    std::optional<Reach> reach;
    std::optional<VarianceParts> uncertainty_at_estimate;
    std::optional<double> other_surrogate_at_estimate;
    std::optional<Predictive> posterior_predictive;
    template <class Fields>
    void fields(Fields& f) {
      f.required("response", response);
      f.required("value", value);
      f.required("uncertainty", uncertainty);
      f.added("unit", unit);
      f.added("source", source);
      f.optional("discrepancy", discrepancy);
      f.optional("reach", reach);
      f.optional("uncertainty_at_estimate", uncertainty_at_estimate);
      f.optional("other_surrogate_at_estimate", other_surrogate_at_estimate);
      f.optional("posterior_predictive", posterior_predictive);
    }
  };

  struct Parameter {
    struct Prior {
      double mean = 0, sd = 0;
      template <class Fields>
      void fields(Fields& f) {
        f.required("mean", mean);
        f.required("sd", sd);
      }
    };
    struct Profile {
      Interval interval_95;
      std::vector<double> values, minus_twice_log_likelihood;
      template <class Fields>
      void fields(Fields& f) {
        f.required("interval_95", interval_95);
        f.required("values", values);
        f.required("minus_twice_log_likelihood", minus_twice_log_likelihood);
      }
    };
    std::string name;
    std::vector<std::string> keys;
    double min = 0, max = 0;
    std::string unit = "1", scale;  // "log" or "linear"
    std::optional<Prior> prior;
    // Of a study with a posterior.
    std::optional<double> median;
    std::optional<Interval> interval_68, interval_95;
    std::optional<double> posterior_to_prior_sd;
    std::optional<bool> at_min, at_max;
    std::optional<Profile> profile;
    bool logarithmic() const { return scale == "log"; }
    template <class Fields>
    void fields(Fields& f) {
      f.required("name", name);
      f.added("keys", keys);
      f.added("min", min);
      f.added("max", max);
      f.added("unit", unit);
      f.added("scale", scale);
      f.optional("prior", prior);
      f.optional("median", median);
      f.optional("interval_68", interval_68);
      f.optional("interval_95", interval_95);
      f.optional("posterior_to_prior_sd", posterior_to_prior_sd);
      f.optional("at_min", at_min);
      f.optional("at_max", at_max);
      f.optional("profile", profile);
    }
  };

  struct Choices {
    struct Choice {
      std::string label;
      double prior = 0, probability = std::nan("");
      std::string verdict, headline;
      std::optional<Goodness> goodness_of_fit;
      NamedValues<double> estimate;      // by parameter
      NamedValues<Marginal> parameters;  // given this choice
      template <class Fields>
      void fields(Fields& f) {
        f.required("choice", label);
        f.required("prior", prior);
        f.required("probability", probability);
        f.added("verdict", verdict);
        f.added("headline", headline);
        f.optional("goodness_of_fit", goodness_of_fit);
        f.optional("estimate", estimate);
        f.optional("parameters", parameters);
      }
    };
    std::string parameter;
    std::vector<std::string> keys;
    std::string best;
    std::vector<Choice> choices;
    template <class Fields>
    void fields(Fields& f) {
      f.required("parameter", parameter);
      f.added("keys", keys);
      f.required("best", best);
      f.required("choices", choices);
    }
  };

  struct Curve {
    std::string label, unit = "1", x_unit;
    double uncertainty = std::nan(""), explained_variance = 0;
    double simulated_rest = std::nan(""), single_run_rest = std::nan(""), recorded_rest = 0;
    std::vector<double> x, recorded, simulated_mean;
    std::vector<std::vector<double>> components;
    template <class Fields>
    void fields(Fields& f) {
      f.required("curve", label);
      f.added("unit", unit);
      f.required("x_unit", x_unit);
      f.added("uncertainty", uncertainty);
      f.required("explained_variance", explained_variance);
      f.added("simulated_rest", simulated_rest);
      f.added("single_run_rest", single_run_rest);
      f.required("recorded_rest", recorded_rest);
      f.required("x", x);
      f.required("recorded", recorded);
      f.required("simulated_mean", simulated_mean);
      f.required("components", components);
    }
  };

  struct JointPrior {
    std::vector<std::string> parameters;
    std::string prior;
    template <class Fields>
    void fields(Fields& f) {
      f.required("parameters", parameters);
      f.required("prior", prior);
    }
  };

  struct Outlier {
    std::string response;
    NamedValues<double> parameters;
    std::uint64_t seed = 0;
    double value = 0, median_of_other_seeds = 0;
    template <class Fields>
    void fields(Fields& f) {
      f.required("response", response);
      f.required("parameters", parameters);
      f.required("seed", seed);
      f.required("value", value);
      f.required("median_of_other_seeds", median_of_other_seeds);
    }
  };

  struct Set {  // of parameters
    struct Fitted {
      double value = 0, uncertainty = 0;
      std::string unit = "1";
      template <class Fields>
      void fields(Fields& f) {
        f.required("value", value);
        f.required("uncertainty", uncertainty);
        f.added("unit", unit);
      }
    };
    struct Runs {
      int finished = 0, arched = 0, failed = 0, cut_short = 0;
      template <class Fields>
      void fields(Fields& f) {
        f.added("finished", finished);
        f.added("arched", arched);
        f.added("failed", failed);
        f.added("cut_short", cut_short);
      }
    };
    struct Simulated {
      double value = 0, standard_error = std::nan(""), sd_over_seeds = std::nan("");
      int seeds = 0;
      std::string unit = "1";
      template <class Fields>
      void fields(Fields& f) {
        f.required("value", value);
        f.added("standard_error", standard_error);
        f.added("sd_over_seeds", sd_over_seeds);
        f.added("seeds", seeds);
        f.added("unit", unit);
      }
    };
    std::string name;
    NamedValues<double> parameters;
    NamedValues<Fitted> fit;  // by target
    std::optional<double> hpd_level;
    std::optional<bool> inside_95_region;
    std::optional<Runs> runs;
    NamedValues<Simulated> simulated;  // by response
    template <class Fields>
    void fields(Fields& f) {
      f.required("name", name);
      f.required("parameters", parameters);
      f.optional("fit", fit);
      f.optional("hpd_level", hpd_level);
      f.optional("inside_95_region", inside_95_region);
      f.optional("runs", runs);
      f.optional("simulated", simulated);
    }
  };

  struct PosteriorSamples {
    std::uint64_t samples = 0;
    double effective_samples = 0;
    std::string file;
    template <class Fields>
    void fields(Fields& f) {
      f.required("samples", samples);
      f.required("effective_samples", effective_samples);
      f.required("file", file);
    }
  };

  struct Round {
    std::string after;
    std::uint64_t runs = 0;
    NamedValues<Marginal> parameters;
    template <class Fields>
    void fields(Fields& f) {
      f.required("after", after);
      f.required("runs", runs);
      f.required("parameters", parameters);
    }
  };

  struct Combination {
    struct Term {
      std::string parameter, of;  // "logarithm" or "value"
      double coefficient = 0;
      template <class Fields>
      void fields(Fields& f) {
        f.required("parameter", parameter);
        f.added("of", of);
        f.required("coefficient", coefficient);
      }
    };
    bool identifiable = false;
    std::vector<Term> terms;
    double value = std::nan(""), uncertainty = std::nan("");
    double uncertainty_near_estimate = std::nan("");
    double spread_over_posterior = std::nan(""), singular_value = std::nan("");
    std::optional<VarianceParts> split;  // of an identifiable one
    template <class Fields>
    void fields(Fields& f) {
      f.added("identifiable", identifiable);
      f.required("terms", terms);
      f.added("value", value);
      f.added("uncertainty", uncertainty);
      f.added("uncertainty_near_estimate", uncertainty_near_estimate);
      f.added("spread_over_posterior", spread_over_posterior);
      f.added("singular_value", singular_value);
      f.optional("split", split);
    }
  };

  struct Sensitivity {
    struct Indices {
      double first = 0;
      std::optional<Interval> first_interval_95;
      std::optional<double> total;
      std::optional<Interval> total_interval_95;
      template <class Fields>
      void fields(Fields& f) {
        f.required("first", first);
        f.optional("first_interval_95", first_interval_95);
        f.optional("total", total);
        f.optional("total_interval_95", total_interval_95);
      }
    };
    std::string response;
    double noise_share = std::nan("");
    NamedValues<Indices> parameters;
    template <class Fields>
    void fields(Fields& f) {
      f.required("response", response);
      f.added("noise_share", noise_share);
      f.required("parameters", parameters);
    }
  };

  struct Numerics {
    struct Shift {
      double shift = 0, standard_error = 0;
      std::string unit = "1";
      template <class Fields>
      void fields(Fields& f) {
        f.required("shift", shift);
        f.required("standard_error", standard_error);
        f.added("unit", unit);
      }
    };
    std::string name;
    NamedValues<Shift> shifts;  // by response
    template <class Fields>
    void fields(Fields& f) {
      f.required("name", name);
      f.required("shifts", shifts);
    }
  };

  struct LowFidelity {
    NamedValues<std::string> set;     // TOML texts by key
    NamedValues<Set::Fitted> biases;  // by response: low minus high, at the estimate
    int runs = 0, high_fidelity_runs = 0;
    double wall_seconds = 0, high_fidelity_wall_seconds = 0;
    template <class Fields>
    void fields(Fields& f) {
      f.required("set", set);
      f.required("biases", biases);
      f.required("runs", runs);
      f.required("wall_seconds", wall_seconds);
      f.required("high_fidelity_runs", high_fidelity_runs);
      f.required("high_fidelity_wall_seconds", high_fidelity_wall_seconds);
    }
  };

  struct Advice {  // on what to measure
    std::string response;
    bool repeats_a_target = false;
    double uncertainty = 0;
    std::string unit = "1";
    double information_bits = 0, remaining_extent = std::nan("");
    std::optional<double> discrepancy, effort_seconds;
    template <class Fields>
    void fields(Fields& f) {
      f.required("response", response);
      f.added("repeats_a_target", repeats_a_target);
      f.required("uncertainty", uncertainty);
      f.added("unit", unit);
      f.required("information_bits", information_bits);
      f.added("remaining_extent", remaining_extent);
      f.optional("discrepancy", discrepancy);
      f.optional("effort_seconds", effort_seconds);
    }
  };

  struct DirectSearch {
    std::string search;
    int evaluations = 0;
    double best_observed_distance = 0, confirmed_distance = 0;
    template <class Fields>
    void fields(Fields& f) {
      f.required("search", search);
      f.required("evaluations", evaluations);
      f.required("best_observed_distance", best_observed_distance);
      f.required("confirmed_distance", confirmed_distance);
    }
  };

  struct RunBudget {
    int runs = 0, reused = 0, left = 0;
    std::string left_because;
    template <class Fields>
    void fields(Fields& f) {
      f.required("runs", runs);
      f.added("reused", reused);
      f.added("left", left);
      f.added("left_because", left_because);
    }
  };

  struct Refinement {
    int rounds = 0;
    std::string stopped;
    template <class Fields>
    void fields(Fields& f) {
      f.required("rounds", rounds);
      f.added("stopped", stopped);
    }
  };

  struct Model {
    struct SeedNoise {
      double sd = 0;
      bool relative = false;  // the likelier of both; sd is then a fraction of the response
      double relative_probability = 0;
      int degrees_of_freedom = 0;
      bool uniform = true;
      template <class Fields>
      void fields(Fields& f) {
        f.required("sd", sd);
        f.added("relative", relative);
        f.added("relative_probability", relative_probability);
        f.added("degrees_of_freedom", degrees_of_freedom);
        f.added("uniform", uniform);
      }
    };
    std::string response, unit = "1", surrogate;
    double gp_residual_sd = std::nan("");
    std::vector<double> lengths;
    std::string cross_check;
    std::uint64_t points = 0;
    std::optional<double> largest_leave_one_out_z;
    bool passes_cross_validation = false;
    std::optional<SeedNoise> seed_noise;
    template <class Fields>
    void fields(Fields& f) {
      f.required("response", response);
      f.added("unit", unit);
      f.added("surrogate", surrogate);
      f.added("gp_residual_sd", gp_residual_sd);
      f.added("lengths", lengths);
      f.added("cross_check", cross_check);
      f.required("points", points);
      f.optional("largest_leave_one_out_z", largest_leave_one_out_z);
      f.added("passes_cross_validation", passes_cross_validation);
      f.optional("seed_noise", seed_noise);
    }
  };

  struct RunCounts {
    int total = 0, finished = 0, arched = 0, failed = 0, timed_out = 0, out_of_memory = 0;
    int crashed = 0;
    std::vector<std::string> cut_short;  // a sentence each
    int by_another_version = 0;          // of Firn; the study does not use them
    template <class Fields>
    void fields(Fields& f) {
      f.added("total", total);
      f.added("finished", finished);
      f.added("arched", arched);
      f.added("failed", failed);
      f.added("timed_out", timed_out);
      f.added("out_of_memory", out_of_memory);
      f.added("crashed", crashed);
      f.added("cut_short", cut_short);
      f.added("by_another_version", by_another_version);
    }
  };

  std::string study, verdict, headline, firn_version, git_commit;
  int contact_model = 1;
  std::vector<Target> targets;
  std::vector<Parameter> parameters;
  std::optional<Choices> choice;
  std::vector<Curve> curves;
  std::vector<JointPrior> priors;
  std::vector<std::string> constraints, cautions;
  std::vector<Outlier> outliers;
  std::optional<Set> estimate;
  std::optional<Goodness> goodness_of_fit, goodness_of_fit_without_priors;
  std::optional<PosteriorSamples> posterior;
  std::vector<Round> estimate_history;
  std::vector<Combination> combinations;
  std::vector<Set> ridge, compare;
  std::vector<Sensitivity> sensitivity;
  std::vector<Numerics> numerics;
  std::optional<LowFidelity> low_fidelity;
  std::vector<Advice> measure_next;
  std::optional<DirectSearch> direct_search;
  std::optional<RunBudget> budget;
  std::optional<Refinement> refinement;
  std::vector<Model> models;
  RunCounts runs;
  std::optional<double> wall_seconds;
  template <class Fields>
  void fields(Fields& f) {
    f.required("study", study);
    f.required("verdict", verdict);
    f.added("headline", headline);
    f.added("firn_version", firn_version);
    f.added("git_commit", git_commit);
    f.added("contact_model", contact_model);
    f.added("targets", targets);
    f.required("parameters", parameters);
    f.optional("choice", choice);
    f.optional("curves", curves);
    f.optional("priors", priors);
    f.optional("constraints", constraints);
    f.added("cautions", cautions);
    f.added("outliers", outliers);
    f.optional("estimate", estimate);
    f.optional("goodness_of_fit", goodness_of_fit);
    f.optional("goodness_of_fit_without_priors", goodness_of_fit_without_priors);
    f.optional("posterior", posterior);
    f.added("estimate_history", estimate_history);
    f.added("combinations", combinations);
    f.added("ridge", ridge);
    f.added("compare", compare);
    f.added("sensitivity", sensitivity);
    f.added("numerics", numerics);
    f.optional("low_fidelity", low_fidelity);
    f.added("measure_next", measure_next);
    f.optional("direct_search", direct_search);
    f.optional("budget", budget);
    f.optional("refinement", refinement);
    f.added("models", models);
    f.added("runs", runs);
    f.optional("wall_seconds", wall_seconds);
  }
};

std::string render_json(StudyDocument document);
// Throws InputError for a file that is no results.json of a study.
StudyDocument read_study_document(const ResultsJson& results);

}  // namespace firn
