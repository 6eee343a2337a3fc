// The record of the coverage studies: a CSV file with one line for each finished study, so that a
// table is measured in pieces. The line of a study does not depend on others: records of several
// machines are merged by concatenation.
#pragma once

#include <compare>
#include <string>
#include <vector>

#include "tests/calibration_proof/coverage_study.h"

namespace firn::proof {

struct StudyKey {
  std::string engine;      // coverage_engine()
  std::string problem;     // name
  std::string truth;       // "prior", "border", "corner"
  std::string definition;  // hash of CoveredProblem::definition, 8 hex digits
  int index = 0;

  auto operator<=>(const StudyKey&) const = default;
};

struct RecordedStudy {
  StudyKey key;
  CoverageOutcome outcome;
};

// The key of a study by the present engine.
StudyKey study_key(const CoveredProblem& problem, const std::string& truth, int index);

// Studies in the order of the lines, of equal keys the first. Empty if the file does not exist.
// Throws InputError.
std::vector<RecordedStudy> read_coverage_record(const std::string& file);

// Sorted lines below a heading of comments.
std::string coverage_record_text(const std::vector<RecordedStudy>& studies);

// Adds studies that the record lacks and sorts it. The file is complete at any time. Processes may
// add to one record at the same time. Throws as read_coverage_record() and write_file().
void add_to_coverage_record(const std::string& file, const std::vector<RecordedStudy>& studies);

}  // namespace firn::proof
