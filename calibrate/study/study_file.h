// A study file: cases, parameters with their ranges, target measurements and the budget of runs.
// Keys: docs/calibration.md.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/numerics/optimize.h"
#include "calibrate/study/constraint.h"
#include "calibrate/study/curve_target.h"
#include "calibrate/study/parameters.h"
#include "calibrate/study/prior.h"
#include "calibrate/study/user_program.h"
#include "experiments/batch/execution/execution_settings.h"
#include "experiments/case/case.h"
#include "experiments/system/value_place.h"

namespace firn {

// One of the simulated experiments of a study.
struct Experiment {
  std::string name;                         // empty: the study's only one, not named
  std::string case_file;                    // resolved against the study's folder; empty: no case
  std::vector<Override> set;                // case keys held at other values than the file's
  std::vector<bool> takes;                  // [parameters], which parameters its case has
  std::optional<UserProgram> program = {};  // simulates in place of Firn; there is no case then
  bool takes_choice = true;                 // whether it is given Study::choice, where there is one
  std::vector<ValuePlace> set_places = {};  // [set] for messages
  // Whether Firn computes its responses, which then have the names of docs/responses.md.
  bool is_case() const { return !case_file.empty(); }
  // Where its responses come from, for messages.
  std::string source() const {
    if (program) return program->responses;
    return is_case() ? case_file : "the simulator";
  }
};

// A response of one of the experiments.
struct ResponseId {
  std::size_t experiment = 0;
  std::string name;   // as the run measures it
  std::string label;  // for output: the name, after that of its experiment where there are several
};

// A response that the simulation has to reproduce.
struct Target {
  ResponseId response;
  double value = 0;        // in the response's unit
  double uncertainty = 0;  // one standard deviation of the measured value, same unit, > 0
  std::string unit;        // as the response states it: "deg", "1", ...
  std::string source;      // in words: of the measurement, or that the study states it
  double effort = 0;       // s of work to measure it once more; 0: not said
  std::string file{};      // of the measurement; empty for a value given in place
  // Standard deviation of the simulator's systematic error in this response, same unit: reality is
  // the mean response plus an error of mean zero, the same in every measurement. 0: none.
  double discrepancy = 0;

  // What the measured value and the mean response at the true parameters differ by.
  double variance() const { return uncertainty * uncertainty + discrepancy * discrepancy; }
  double sd() const { return std::hypot(uncertainty, discrepancy); }
};

// A response that is modeled and reported in addition to the targets. With an uncertainty it is a
// possible measurement: its expected narrowing of the posterior is reported.
struct Observed {
  ResponseId response;
  double uncertainty = 0;  // one standard deviation of such a measurement; 0: not said
  std::string unit;        // of the uncertainty
  double effort = 0;       // s of work; 0: not said
  double discrepancy = 0;  // as of a target, in the unit of the uncertainty
};

// A parameter set with given values that is simulated for comparison.
struct CompareSet {
  std::string name;
  std::vector<double> values;  // in order of Study::parameters
};

// Runs at the middle of the ranges with other numerics, to estimate their effect.
struct NumericsCheck {
  std::string name;
  std::vector<Override> set;
  std::optional<std::size_t> only;          // experiment; without it, all
  std::vector<ValuePlace> set_places = {};  // [set] for messages
};

// A cheaper form of the case, which explores the ranges in place of the case itself.
struct LowFidelity {
  std::vector<Override> set;
  std::optional<std::size_t> only;          // experiment; without it, all
  int pairs = 0;                            // points of the design that are simulated in both forms
  std::vector<ValuePlace> set_places = {};  // [set] for messages
  bool applies(std::size_t experiment) const { return !only || *only == experiment; }
};

// Numbers of points and simulations by purpose. A point is one parameter set; a run is one seed of
// it in every experiment.
struct Budget {
  int runs = 0;                  // most seeds of all points together; 0: the numbers below alone
  int center_replicates = 0;     // seeds at the middle of the ranges
  int numerics_replicates = 0;   // seeds of each numerics check, at the middle
  int design_points = 0;         // spread over the ranges, besides the middle
  int replicates_per_point = 0;  // seeds at each point of the design and of the refinement
  // Where the noise is small compared with the uncertainty of the measurements, the study runs one
  // seed per point and correspondingly more points.
  bool allow_single_replicate = false;
  // Maximum number of refinement rounds. Follows from `runs` where that is stated and this is not.
  int refine_rounds = 0;
  bool rounds_stated = false;
  bool reuse = true;                // begin with runs of other studies; only with `runs`
  int refine_points = 0;            // points in each
  int confirmation_replicates = 0;  // unused seeds at the estimate; only these are reported
  int endpoint_replicates = 0;      // unused seeds at either end of a ridge; 0: none
  int compare_replicates = 0;       // seeds at each compare set
  double time =
      0;  // s of simulation, all processes together, after which refinement ends; 0: no limit
  // Refinement ends when exactly known responses would narrow no target by more than this share.
  double min_improvement = 0.1;
};

const char* to_string(DirectSearch search);  // as a study file has it

struct Study {
  std::string name;
  std::string source;  // file it was read from
  std::string text;    // its whole text
  std::vector<Experiment> experiments;
  std::uint64_t seed = 1;
  int threads = 1;  // of each simulation
  Budget budget;
  // Other than none: searches on the simulations instead of on surrogates, as a baseline.
  DirectSearch direct = DirectSearch::none;
  int direct_evaluations = 0;
  std::vector<Parameter> parameters;
  std::optional<ChoiceParameter> choice;  // besides the parameters
  // Of the choices, the one that holds in all runs (choices.h): a part of the whole study.
  std::optional<std::size_t> chosen;
  std::vector<Prior> priors;  // in addition to those of single parameters
  Constraints constraints;
  std::vector<Target> targets;
  std::vector<CurveTarget> curves;  // become targets once some were simulated (curve_scores.h)
  std::vector<Observed> observed;
  std::vector<CompareSet> compare;
  std::vector<NumericsCheck> numerics;
  std::optional<LowFidelity> low_fidelity;
  Execution execution;
  // Material record: the run of seed k uses draw k of its posterior ensemble. Empty: none.
  std::string drawn_material;

  int largest_total() const;  // simulations at most
  // How many choices it is carried out for.
  int choice_count() const {
    return choice && !chosen ? static_cast<int>(choice->values.size()) : 1;
  }
  // "law=hertz" of a part of a study; empty for a study without choices.
  std::string chosen_text() const {
    return choice && chosen ? choice->name + "=" + choice->labels[*chosen] : "";
  }
};

// Reads and checks a study. Throws InputError with one line
// `FILE:LINE: KEY: what is wrong; what is expected`.
Study read_study(const std::string& file, Programs programs = Programs::refused);
// A study of a function instead of cases, from text; `source` names it in messages. Its parameters
// have their names as keys.
Study read_function_study(const std::string& text, const std::string& source);

}  // namespace firn
