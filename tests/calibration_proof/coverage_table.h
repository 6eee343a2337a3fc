// The table of the coverage studies, and the limits that its rows are checked against.
#pragma once

#include <string>
#include <vector>

#include "tests/calibration_proof/coverage_record.h"

namespace firn::proof {

// Sums over studies.
struct CoverageCounts {
  int studies = 0;
  int region_95 = 0, region_68 = 0;  // truths that the regions hold
  int ideal_95 = 0, ideal_68 = 0;    // and those of the ideal
  int parameters = 0, intervals = 0;
  int determined = 0, far_off = 0;
  int infeasible = 0, ideal_infeasible = 0, unconfirmed = 0, cautioned = 0;
  int confirmed = 0, modeled = 0;  // values with an error over its stated standard error
  double confirmed_z2 = 0, model_z2 = 0;
  double log_width = 0;  // over the parameters
  double cost = 0;

  void add(const CoverageOutcome& outcome);
  void add(const CoverageCounts& other);
  double width() const;  // over the ideal's: geometric mean
};

// The studies of one problem with truths of one kind, by one engine.
struct CoverageRow {
  std::string problem, truth;
  std::string older = {};  // "older engine 1f3a9c20b7de", "older text"; empty: present ones
  CoverageCounts counts = {};
};

// Sorted rows of the present engine and of the problems as they are. In addition for each row, the
// older engine or text with the most studies, while it has more of them. Recorded studies of other
// problems are left out.
std::vector<CoverageRow> coverage_rows(const std::vector<RecordedStudy>& record,
                                       const std::vector<CoveredProblem>& problems);

// A Markdown table with a last line for all rows of the present engine, and one for older ones.
std::string coverage_table(const std::vector<CoverageRow>& rows);

// A row is checked from so many studies on.
inline constexpr int coverage_least_studies = 100;

// Limits that a row of the present engine exceeds, a clause each; empty below
// coverage_least_studies. A region exceeds a limit if the 99 % interval of the share of truths that
// it holds is outside 95 +- 2 % or 68 +- 4 %. At a border or in a corner, the exact posterior holds
// another share of the truths: there the limits are as far from the nominal share or from the
// ideal's in the same studies, whichever is farther out.
std::vector<std::string> exceeded_limits(const CoverageRow& row);

}  // namespace firn::proof
