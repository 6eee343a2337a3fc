// calibrate(study) -> answer: what `firn calibrate` does. The method is described in
// docs/calibration.md.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>

#include "calibrate/output/study_verdict.h"
#include "calibrate/study/record_options.h"

namespace firn {

class Executor;
struct Study;
struct Answer;

struct StudyOptions {
  std::string study_file;          // TOML
  std::string directory;           // where the journal and the reports go; empty: runs/<study name>
  int jobs = 0;                    // simulations side by side; 0: one per core
  bool resume = false;             // require that the directory holds this study already
  std::string executor = "local";  // or "slurm"
  std::string program;             // the firn executable that simulates; empty: this one
  std::string store;               // file of the outcomes that studies share; empty: none
  // In place of those of the study file's [execution]; 0: as it says.
  double time_limit = 0;                         // s of wall time of one run
  double memory_limit = 0;                       // bytes resident of one run
  bool show_progress = true;                     // on standard error
  bool json_progress = false;                    // as JSON, one event a line
  bool plot = true;                              // draw the fitted response with gnuplot
  const std::atomic<bool>* interrupt = nullptr;  // set from a signal handler: save and stop
  MaterialLabel save;  // also make a material record of the answer, when it has a name
  Executor* replace_executor = nullptr;  // not owned; a fake experiment, for tests
  // Called once with what was found, unless the study was interrupted.
  std::function<void(const Study&, const Answer&)> on_answer;
};

struct StudySummary {
  StudyVerdict verdict = StudyVerdict::interrupted;
  std::string headline;  // one sentence
  std::string table;     // for people: what was found, with uncertainty; ends in a new line
  std::string json;      // the same for programs; also results.json in the directory
  std::string directory;
  std::optional<MaterialRecord> record;  // of StudyOptions::save; not yet in a database
  std::string not_saved;                 // why there is none
  std::string example_run;  // results file of a simulation at the answer; empty: none was made
  int exit_status() const;  // 0 done, 1 too few runs, 130 interrupted
};

// Runs or continues the study. Nothing goes to standard output: the caller prints `table` or
// `json`. Throws InputError for a wrong study file, a directory that holds another study, or one
// that another process is working in.
StudySummary calibrate(const StudyOptions& options);
// The same of a study that has been read; `options.study_file` is not used.
StudySummary calibrate(Study study, const StudyOptions& options);

}  // namespace firn
