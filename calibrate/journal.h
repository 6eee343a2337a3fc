// The study's memory: every run that was ever started and what came of it, safe against kill -9.
//
// The calibration itself keeps no state between sessions. It is a pure function of the study and
// of the results of its runs; going on means asking for the same runs again and finding them here.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/executor.h"

struct sqlite3;

namespace firn {

// What a run is for, as people read it in runs.csv.
struct RunLabel {
  std::string experiment;  // empty: the study's only one
  std::string phase;       // "centre", "design", "refine 1", "compare: paper table", "confirm"
  int point = 0;           // within the phase
  std::string parameters;  // "ice_ice=0.05 ice_plastic=0.1"
  std::uint64_t seed = 0;
};

struct PlannedRun {
  std::string key, case_text, version;
  RunLabel label;
};

struct JournalRun {
  std::string key;
  RunLabel label;       // of its first use
  std::string version;  // of the program that ran it
  std::string status;   // planned, running, or an outcome: to_string(JobStatus)
  int attempts = 0;
  JobResult result;  // when it has ended
};

// Key of the run of this complete case text by this version of the program.
std::string run_key(const std::string& case_text, const std::string& version);

class Journal {
 public:
  // Opens or makes DIR/study.db. Throws InputError when the directory cannot be written, holds
  // something else, or holds the study of another text.
  Journal(const std::string& directory, const std::string& study_text, bool must_exist);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  // Outcome of a run that has ended; nothing for one that has not.
  std::optional<JobResult> outcome(const std::string& key);
  // Notes all of them at once; those that are known already stay as they are.
  void plan(const std::vector<PlannedRun>& runs);
  void start(const std::string& key);
  void finish(const std::string& key, const JobResult& result);

  std::vector<JournalRun> runs();  // in the order in which they were planned

 private:
  sqlite3* db_ = nullptr;
};

}  // namespace firn
