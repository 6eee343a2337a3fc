// The kinds of comparisons. Each function fills in its members of Comparison. Pure functions, for
// compare() alone.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "experiments/system/value_place.h"
#include "validation/comparison/comparison.h"

namespace firn::comparison {

// Probability limits: an event that was observed once must not be improbable; one that is observed
// as a rule must have a probability above `rule`.
inline constexpr double improbable = 0.05, rule = 0.5;
// Largest share of missing runs with which a statistic of the others is judged.
inline constexpr double missing_limit = 0.05;
bool too_many_missing(std::size_t missing, std::size_t all);
// "1 of 5 runs is missing (failed)": what a verdict on the others cannot say.
std::string missing_words(const RunGroup& base, std::size_t missing);

// A number with three significant digits and its unit.
std::string rounded_text(double value, const std::string& unit);
std::vector<double> defined(std::vector<double> values);
// Throws InputError unless runs give the response in the measurement's unit.
void require_unit(const std::string& response, const RunGroup& base, const Measurement& m);
// One curve a finished run: NAME_curve_x and NAME_curve_y of its responses, in the units of the
// measurement. Throws InputError where a run has none.
std::vector<SampledCurve> curves_of(const RunGroup& base, const MeasuredData& data);
// The response of the run that the data measure. Throws InputError if it is missing.
const Response& response_of(const JobResult& run, const MeasuredData& data);
// "time step 5 us" or "Young's modulus 0.03 GPa", of a group with such a setting.
std::string describe_setting(const RunGroup& group);
// Means over the seeds that two groups share, and the standard error of the difference.
struct Change {
  int seeds = 0;
  double before = 0, after = 0;
  double error = 0;  // one standard deviation, estimated from the seeds; NaN: one seed
};
Change change_between(const RunGroup& base, const RunGroup& changed, const std::string& operand);

void compare_value(const SuiteComparison& what, const ComparisonRuns& e, Comparison& c);
void compare_criteria(const SuiteComparison& what, const ComparisonRuns& e, Comparison& c);
void compare_breakage(const SuiteComparison& what, const ComparisonRuns& e, Comparison& c);
void compare_curve(const SuiteComparison& what, const ComparisonRuns& e, Comparison& c);
void compare_variants(const SuiteComparison& what, const ComparisonRuns& e, Comparison& c);

}  // namespace firn::comparison
