// Comparison of simulation and experiment: the comparison error, its uncertainty budget by source,
// and the outcome. After ASME V&V 20-2009; docs/validation.md explains every step.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "experiments/batch/execution/executor.h"
#include "experiments/material_records/material_record.h"
#include "validation/comparison/curve_metrics.h"
#include "validation/comparison/strength_reliability.h"
#include "validation/statistics/distributions.h"
#include "validation/suite/suite_file.h"

namespace firn {

enum class ValidationVerdict {
  consistent,
  inconsistent,
  inconclusive,     // the uncertainty is too large to decide
  not_independent,  // inputs were chosen with these very data
  not_comparable,   // for a reason that the suite gives
  not_judged        // no criterion given
};
const char* to_string(ValidationVerdict verdict);

// The runs of one experiment with one parameter set and one set of numerics, in order of seeds.
struct RunGroup {
  enum class Purpose { base, input, timestep, stiffness, variant };
  std::size_t experiment = 0, parameter_set = 0;
  Purpose purpose = Purpose::base;
  double setting = 0;  // time step, s, or Young's modulus, Pa, of groups of these purposes
  std::vector<std::uint64_t> seeds;
  std::vector<std::string> keys;
  std::vector<JobResult> results;
  // Of groups of these purposes: number of the factor, Young's modulus or variant in the suite.
  std::size_t number = 0;

  // Of the finished runs.
  std::vector<const JobResult*> finished() const;
  // One value for each finished run, NaN where undefined. Throws InputError as evaluate() does.
  std::vector<double> values(const std::string& operand) const;
};

const char* to_string(RunGroup::Purpose purpose);

// All groups of an experiment with a parameter set, and what they are run with.
struct ComparisonRuns {
  const RunGroup* base = nullptr;
  const RunGroup* input = nullptr;  // draws from the posterior ensemble, one run each; may be null
  const RunGroup* numerics_base = nullptr;  // reference of the groups below
  const RunGroup* timestep = nullptr;       // may be null
  std::vector<const RunGroup*> stiffness;   // ascending modulus, without the base
  double base_modulus = 0;                  // Pa; 0: not known
  const MaterialRecord* material = nullptr;
  struct Other {
    const Variant* what = nullptr;
    const RunGroup* runs = nullptr;
  };
  std::vector<Other> variants = {};
  std::vector<const RunGroup*> timesteps =
      {};  // all groups with other time steps; `timestep` is the finest
  // Calibrated records whose values the case has, from any source.
  std::vector<const MaterialRecord*> same_values = {};
};

// One component of the validation uncertainty, one standard deviation.
struct UncertaintyComponent {
  // "run-to-run variability", "time step", "stiffness", "input parameters", "experiment", or a
  // variant's
  std::string name;
  std::optional<double> value;  // nothing: not evaluated
  std::string evaluation_method;
  double freedom = std::numeric_limits<double>::infinity();  // degrees of freedom of the estimate
};

struct ValueComparison {
  SampleStatistics simulation;  // over seeds
  double measured = 0;
  std::string unit;
  double difference = 0;   // simulation - measured
  double uncertainty = 0;  // one standard deviation, root of the sum of squares of the parts
  // Expanded uncertainties (95 %) of the comparison error, the simulation and the experiment. Wider
  // than two standard deviations where few runs, draws or repeats give the scatter.
  double expanded = 0, simulated_expanded = 0, measured_expanded = 0;
  double p_value = 1;  // of such a comparison error or a larger one under that uncertainty alone
  std::vector<UncertaintyComponent> components;
  std::optional<Interval> area;  // metric, in `unit`
  std::vector<double> samples;   // of the runs
};

struct CriterionResult {
  Criterion criterion;
  int holds = 0, runs = 0;  // runs in which it holds, and all runs that answer it
  int failed = 0;           // failed runs among these (Criterion::if_run_fails)
  int missing = 0;          // further runs, without an answer
  // That it holds in a run: 95 % on either side, for every outcome that the missing runs can have.
  Interval probability;
  ValidationVerdict verdict = ValidationVerdict::inconclusive;
  std::vector<double> lhs, rhs;  // by finished run
  std::string unit;
};

// Values or counts of an experiment compared with those of all runs (two_sample_tests.h). Without
// data of the experiment, those of the runs.
struct DistributionResult {
  std::string response, unit;
  bool by_class = false;
  std::vector<std::string> classes;         // with
  std::vector<double> measured, simulated;  // counts by class; else values, ascending
  // By class: of a run's share, over the runs; not below a multinomial's.
  std::vector<double> deviation;
  // Right-censored values: residence times of particles still inside.
  std::vector<double> measured_at_least, simulated_at_least;
  double distance = 0;  // by class: share that would have to be exchanged; else Smirnov's, of
                        // Kaplan and Meier's shares as far as both reach where values are open
  double p_value = 1;   // of as much difference or more, were both of one distribution
  double area = 0;      // between the cumulative distributions, in `unit`; none by class; NaN: open
  double area_p_value = 1;
  double critical = 2;     // critical distance at 5 % significance; above 1: none is significant
  bool dependent = false;  // values of one run are correlated: the experiment counts as one run
  double dispersion = 1;   // by class: variance of counts over a multinomial's
  std::optional<double> apart;  // an outlier
  ValidationVerdict verdict = ValidationVerdict::inconclusive;
};

struct BreakageResult {
  std::string response;
  int particles = 0;               // of all runs
  double largest = 0, median = 0;  // N
  BreakageProbability free, weibull;
  std::vector<double> loads;  // N, all runs, ascending
};

struct StiffnessScalingResult {
  std::string response, unit;
  std::vector<double> modulus, mean, error;  // by stiffness, ascending
  std::vector<int> runs;                     // number of runs of each mean
  double exponent = 0;                       // of response ~ modulus^exponent
  double exponent_error = 0;                 // half of an interval of 68 %; NaN: too few runs
  // At the real modulus, 95 %. NaN: not enough data (three runs at each of three stiffnesses, and
  // an interval within a factor of ten).
  Interval extrapolated;
  double extrapolation_factor = 0;  // real modulus over the largest simulated
  std::string interpretation;       // a clause
};

// Effect of a numerical variant, or of a variant of the instrument, on a response.
struct VariantEffect {
  std::string response, unit, variant;
  int seeds = 0;                 // finished with both
  double before = 0, after = 0;  // means over these
  double error = 0;              // of their difference, one standard deviation; NaN: one seed
};

// Verdict at an end of the range of an assumption.
struct AssumptionResult {
  std::string name;
  int runs = 0;
  std::string outcome;   // the headline there
  bool changes = false;  // the verdict, or on which side of the rule a statement is
};

struct Comparison {
  std::string name, title, note, experiment, parameter_set;
  ComparisonKind kind = ComparisonKind::value;
  ValidationVerdict verdict = ValidationVerdict::inconclusive;
  std::string headline;            // one sentence
  std::string recommended_action;  // what would decide, where the verdict is inconclusive
  std::string measurement;         // in words, with its source
  std::string measurement_status;
  bool code_to_code = false;  // with the result of another simulation: no validation
  std::vector<std::string> caveats;
  int runs = 0, finished = 0;
  std::vector<AssumptionResult> assumptions;
  std::optional<ValueComparison> value;
  std::vector<CriterionResult> criteria;
  std::optional<DistributionResult> distribution;
  std::vector<BreakageResult> breakage;
  std::optional<WeibullFit> strength;
  Measurement breaking_force;  // of a comparison of breakage
  std::vector<StiffnessScalingResult> stiffness_scaling;
  std::vector<VariantEffect> variants;
  std::optional<CurveComparison> curve;
};

// "consistent", or "consistent (code-to-code)".
std::string verdict_words(const Comparison& comparison);

// Throws InputError for a response that a finished run of the experiment, as the suite has it, must
// have for the comparison and does not have, or has in another unit.
void require_responses(const SuiteComparison& what, const JobResult& run);

// Pure function of its arguments. Throws InputError for responses that runs do not have, or whose
// unit is not the measurement's.
Comparison compare(const Suite& suite, const SuiteComparison& what, const ParameterSet& parameters,
                   const ComparisonRuns& evidence);

}  // namespace firn
