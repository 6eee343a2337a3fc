// Studies of a parameter with choices: a calibration for each choice, and how probable each is.
#pragma once

#include <memory>
#include <vector>

#include "calibrate/output/calibration_result.h"
#include "calibrate/study/study_file.h"
#include "calibrate/study/study_runs.h"
#include "experiments/batch/progress.h"

namespace firn {

// The runs of each part of a study.
using PartRuns = std::vector<std::unique_ptr<StudyRuns>>;

// The study for each choice alone, with the choice set in its experiments; without choices, the
// study itself.
std::vector<Study> parts_of(const Study& study);

// Carries out all parts, `runs[i]` being those of `parts[i]`, and gives the result of the best one
// with the probabilities of all. A choice is as probable as its prior times its evidence: the mean
// likelihood over the ranges of the other parameters. The final models of a choice
// use the noise estimated from the runs of all choices, where their scatter agrees.
CalibrationResult calibrate_choices(const std::vector<Study>& parts, const PartRuns& runs,
                                    BatchProgress& progress);

}  // namespace firn
