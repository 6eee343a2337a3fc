// Runs whose response is an outlier among the seeds of the same parameters.
#pragma once

#include <string>
#include <vector>

#include "calibrate/study/study_runs.h"

namespace firn {

struct OutlierRun {
  ResponseId response;
  std::size_t point = 0, seed = 0;  // indices
  double value = 0, others = 0;     // median of the other seeds there
};

// Points with one or two runs that disagree with each other, or with the points around them, so
// far that more replicates are needed to decide which is wrong. At most `most`, the worst first.
std::vector<std::size_t> outlier_candidates(const Study& study, const std::vector<Point>& points,
                                            std::size_t most);

// Finds runs, at points with three or more, that are farther from the median of the others than the
// noise explains. Returns none for a response with many such runs: they are its scatter. Marks the
// runs in the points, which give no value of them afterwards.
std::vector<OutlierRun> mark_outliers(const Study& study, std::vector<Point>& points);

}  // namespace firn
