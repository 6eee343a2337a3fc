// Result of a study as plain data. Tables, JSON and plots are made from it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/inference/curve_scores.h"
#include "calibrate/inference/goodness_of_fit.h"
#include "calibrate/inference/identifiability.h"
#include "calibrate/inference/measurement_planning.h"
#include "calibrate/inference/outliers.h"
#include "calibrate/inference/posterior_predictive.h"
#include "calibrate/numerics/sobol_indices.h"
#include "calibrate/output/study_document.h"
#include "calibrate/output/study_verdict.h"

namespace firn {

// Simulated values of one response, of unused seeds or of all seeds of a point.
struct Observation {
  std::string response, unit;
  Sample sample;
  double standard_error = 0;  // of the mean, by the pooled noise and this sample together
};

// A parameter set with the predictions of the surrogate and, where it was simulated, the responses
// of the runs.
struct CheckedSet {
  std::string name;
  std::vector<double> values;
  std::vector<Prediction> predicted;  // of the targets
  std::vector<Observation> observed;  // targets, then observed responses; empty: not run
  // Share of the posterior that is denser than this set: above 0.95, the set is outside the 95 %
  // region. Only of compare sets within the ranges.
  std::optional<double> hpd_level;
  int finished = 0, arched = 0, failed = 0, cut_short = 0;
  bool run() const { return finished + arched + failed + cut_short > 0; }
};

// Effect of other numerics, relative to those of the case, at the middle of the ranges.
struct NumericsOutcome {
  std::string name;
  struct Shift {
    std::string response, unit;
    double value = 0;           // mean there minus mean at the middle
    double standard_error = 0;  // of that difference
  };
  std::vector<Shift> shifts;  // of targets and observed responses that have values
};

// Of a study with a low fidelity: its bias, and the runs of both forms.
struct FidelityOutcome {
  struct Bias {
    std::string response, unit;
    FidelityBias bias;  // at the estimate
  };
  struct Runs {
    int count = 0;
    double wall = 0;  // s, of all together
  };
  std::vector<Bias> biases;  // of the responses that it changes; empty: nothing was fitted
  Runs low, high;
};

// Sobol indices of a response over the ranges, and its noise.
struct Sensitivity {
  std::string response;
  SobolIndices indices;
  double noise_share = 0;  // variance of one run between seeds over that of the response
};

// Result of a direct search on the simulations.
struct DirectSearchResult {
  int evaluations = 0;
  // Root mean square of (simulated - target) / uncertainty over the targets: at the best evaluation
  // of the search, and with unused seeds at the same parameters.
  double best_observed = 0, confirmed = 0;
};

struct ReachedRange {              // of one target
  double lowest = 0, highest = 0;  // of the surrogate over the ranges
  bool bracketed = false;          // simulated means lie on both sides of the target
  bool reachable = false;          // within two standard deviations somewhere
};

// The estimate after a round of runs.
struct EstimateRound {
  std::string after;                // "design", "refinement 1", ..., "confirmation"
  int runs = 0;                     // different runs that the study had asked for by then
  std::vector<Marginal> marginals;  // in order of the parameters
};

// Result for one choice, in a study of a parameter with choices.
struct ChoiceOutcome {
  std::string label;
  double prior = 0;
  std::optional<double> probability;  // among the choices that could be fitted; nothing: not fitted
  StudyVerdict verdict = StudyVerdict::too_few_runs;
  std::string headline;
  std::vector<double> best;               // parameters
  std::vector<Marginal> marginals;        // of the parameters, given this choice; empty: not fitted
  std::optional<GoodnessOfFit> goodness;  // of all targets together
};

struct CalibrationResult {
  StudyVerdict verdict = StudyVerdict::too_few_runs;
  std::string headline;
  std::vector<CheckedSet> compare;
  std::vector<Point> points;             // of the fit: all but those with other numerics
  std::optional<ResponseModels> models;  // the rest is empty without it
  std::vector<ReachedRange> reach;       // in order of the targets
  CheckedSet best;                   // confirmed with unused seeds, unless the verdict excludes it
  std::vector<double> cross_check;   // targets: prediction of the other surrogate at `best`
  std::vector<VarianceSplit> split;  // targets: variance that the fit used at `best`
  std::vector<Combination> combinations;
  std::optional<Posterior> posterior;
  std::vector<EstimateRound> estimate_history;  // in order of the runs; the last is the posterior's
  std::vector<std::optional<PosteriorPredictive>> predictive;  // in order of the targets
  std::vector<CheckedSet> ridge;  // empty when every direction is identified
  std::vector<NumericsOutcome> numerics;
  std::optional<FidelityOutcome> fidelity;
  std::vector<Sensitivity> sensitivity;         // targets, then observed responses
  std::vector<Profile> profiles;                // in order of the parameters
  std::vector<MeasurementValue> advice;         // best first
  int rounds = 0;                               // of refinement
  std::string stopped;                          // why refinement ended, a sentence
  int reused = 0;                               // runs of other studies with which it began
  int budget_runs = 0, budget_left = 0;         // of Budget::runs, all experiments together
  std::string left_because;                     // why runs are left, a sentence
  std::optional<GoodnessOfFit> goodness;        // of all targets together, and of the priors
  std::optional<GoodnessOfFit> without_priors;  // where there are priors
  std::vector<OutlierRun> outliers;             // of `points`: left out
  std::vector<std::string> caveats;             // limits of the verdict, a clause each
  double cut_short_share = 0;  // of runs near the estimate that failed or met a limit
  std::optional<DirectSearchResult> direct;
  int runs = 0, finished = 0, arched = 0, failed = 0, crashed = 0, timed_out = 0, out_of_memory = 0;
  std::vector<std::string> cut_short;  // where: a sentence for each run that a limit stopped
  int other_version = 0;               // runs in the journal made by another program: not used
  double wall = 0;                     // s, of all runs together
  // In order of Study::choice; empty without one. All else is that of `best_choice`.
  std::vector<ChoiceOutcome> choices;
  std::size_t best_choice = 0;
  // In order of Study::curves, once enough were simulated, and the study with the targets that they
  // became; null where the study has no curve.
  std::vector<CurveBasis> curves;
  std::shared_ptr<const Study> study;
};

// Rendering: result_table.cpp, result_json.cpp.
std::string combination_text(const Study& study, const Combination& combination);
std::string render_table(const Study& study, const CalibrationResult& result);
StudyDocument study_document(const Study& study, const CalibrationResult& result);
// All samples of the posterior (there must be one): parameters in their units, weights that add up
// to 1, and the logarithm of the density over the unit cube up to a constant.
std::string render_posterior_csv(const Study& study, const CalibrationResult& result);
// Writes the posterior, resampled to 4096 draws of equal weight, as a netCDF-4 file in the
// InferenceData layout. The file also has the density, the targets, and posterior predictive draws
// of their measurements (with the uncertainties of measurement and model), mean responses and
// single runs (posterior_predictive.h). Throws WriteError.
void write_inference_data(const Study& study, const CalibrationResult& result,
                          const std::string& file);
std::string render_runs_csv(const Study& study, const std::vector<JournalRun>& runs);

// Fitted response of the first target (there must be a fit) over the parameters, as
// fitted_response.png and .svg: result_plot.cpp. Empty when both were drawn, else why not.
std::string plot_fitted_response(const Study& study, const CalibrationResult& result,
                                 const std::string& directory);

}  // namespace firn
