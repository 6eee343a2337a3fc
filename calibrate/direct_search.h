// Direct search: NLopt on the simulations themselves. A baseline for the calibration, and its
// warning: what such a search claims of its best evaluation is partly luck.
#pragma once

#include "calibrate/output/calibration_result.h"
#include "calibrate/study/study_runs.h"
#include "experiments/batch/progress.h"

namespace firn {

// Minimises the mean square of (simulated - target) / uncertainty over the targets, each simulated
// value the mean over the same budget.replicates_per_point seeds, and confirms the best with fresh
// ones. Every evaluation goes through the journal: a resumed study replays the search and repeats
// no run.
CalibrationResult direct_search(const Study& study, StudyRuns& study_runs, BatchProgress& progress);

}  // namespace firn
