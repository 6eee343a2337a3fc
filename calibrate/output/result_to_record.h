// Converts the result of a study to a material record with its provenance (docs/materials.md).
#pragma once

#include <string>
#include <vector>

#include "calibrate/output/calibration_result.h"
#include "calibrate/study/record_options.h"
#include "experiments/batch/execution/executor.h"

namespace firn {

// Throws InputError when the parameters of a study belong to no material, or to more than two.
void require_material(const Study& study);

// Posterior ensemble of a result: moments, some hundred samples of equal weight, the combinations
// that the data determine, and the reference sets. `runs` are those on which the result is based.
PosteriorEnsemble posterior_ensemble(const Study& study, const CalibrationResult& result,
                                     const std::vector<JournalRun>& runs, Executor& executor);

// The whole record. `directory` holds runs.csv already. Throws InputError for a result that is
// unconfirmed, infeasible or based on too few runs.
MaterialRecord material_record(const Study& study, const CalibrationResult& result,
                               const std::vector<JournalRun>& runs, Executor& executor,
                               const std::string& directory, const RecordOptions& label);

}  // namespace firn
