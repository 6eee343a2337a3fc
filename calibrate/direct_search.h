// Direct search: NLopt on the simulations instead of on a surrogate. It is a baseline for the
// calibration. The best evaluation of such a search is biased: it is the smallest of many noisy
// values.
#pragma once

#include "calibrate/output/calibration_result.h"
#include "calibrate/study/study_runs.h"
#include "experiments/batch/progress.h"

namespace firn {

// Minimizes the mean square of (simulated - target) / uncertainty over the targets, each simulated
// value the mean over the same budget.replicates_per_point seeds, and confirms the best with unused
// seeds. Every evaluation goes through the journal: a resumed study replays the search and repeats
// no run.
CalibrationResult direct_search(const Study& study, StudyRuns& study_runs, BatchProgress& progress);

}  // namespace firn
