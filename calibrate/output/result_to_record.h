// What a study found, as a material record with its whole provenance. docs/materials.md.
#pragma once

#include <string>
#include <vector>

#include "calibrate/output/calibration_result.h"
#include "calibrate/study/record_options.h"
#include "experiments/batch/execution/executor.h"

namespace firn {

// Throws InputError when the parameters of a study are none of a material, or of more than two.
void require_material(const Study& study);

// The ensemble that the answer's posterior describes: its moments, its samples thinned to some
// hundred of equal weight, the combinations that the data determine, and the parameter sets looked
// at closely. `runs` are those that the answer rests on.
PosteriorEnsemble posterior_ensemble(const Study& study, const CalibrationResult& result,
                                     const std::vector<JournalRun>& runs, Executor& executor);

// The whole record. `directory` holds runs.csv already. Throws InputError when the answer is none
// to keep: unconfirmed, infeasible, too few runs.
MaterialRecord material_record(const Study& study, const CalibrationResult& result,
                               const std::vector<JournalRun>& runs, Executor& executor,
                               const std::string& directory, const RecordOptions& label);

}  // namespace firn
