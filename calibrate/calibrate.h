// Runs a calibration study, as `firn calibrate` does. docs/calibration.md describes the method.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "calibrate/output/study_document.h"
#include "calibrate/output/study_verdict.h"
#include "calibrate/study/record_options.h"
#include "experiments/batch/batch_folder.h"

namespace firn {

class Executor;
struct Study;
struct CalibrationResult;

struct StudyOptions : BatchOptions {
  std::string study_file;       // TOML
  bool allow_programs = false;  // the study may start user programs (docs/calibration.md)
  // Override the limits of [execution] in the study file; 0: no override.
  double time_limit = 0;    // s of wall time of one run
  double memory_limit = 0;  // bytes resident of one run
  bool plot = true;         // draw the fitted response with gnuplot
  RecordOptions save;       // also make a material record of the estimate, when it has a name
  // Called once with the result, unless the study was interrupted.
  std::function<void(const Study&, const CalibrationResult&)> on_result;
};

struct StudySummary {
  StudyVerdict verdict = StudyVerdict::interrupted;
  std::string headline;  // one sentence
  std::string table;     // text: the result with uncertainties; ends in a new line
  StudyDocument document;
  std::string json;  // the text of `document`; also results.json in the directory
  std::string directory;
  std::optional<MaterialRecord> record;  // of StudyOptions::save; not yet in a database
  std::string not_saved;                 // why `record` is empty
  std::string example_run;  // results file of a simulation at the estimate; empty: none
  int exit_status() const;  // 0 done, 1 too few runs, 130 interrupted
};

// Runs or continues the study. Nothing goes to standard output: the caller prints `table` or
// `json`. Throws InputError for a wrong study file, a directory that holds another study, or one
// that another process is working in.
StudySummary calibrate(const StudyOptions& options);
// Runs or continues a study that has been read. `options.study_file` is not used.
StudySummary calibrate(Study study, const StudyOptions& options);

}  // namespace firn
