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

#include "experiments/batch/execution/executor.h"
#include "experiments/batch/journal/sqlite.h"

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
  std::string key, case_text;
  std::string program;  // identity of the program that simulates: firn_program()
  RunLabel label;
};

struct JournalRun {
  std::string key;
  RunLabel label;          // of its first use
  std::string program;     // that ran it
  std::string git_commit;  // it was built from: a fact, no identity
  std::string status;      // planned, running, or an outcome: to_string(JobStatus)
  int attempts = 0;
  JobResult result;  // when it has ended
};

// Key of the run of this complete case text by this program.
std::string run_key(const std::string& case_text, const std::string& program);

// Runs handed to a cluster as one array.
struct Submission {
  std::string name;               // unique: the cluster finds it by that
  std::string job;                // the cluster's number; empty: its answer was never seen
  std::vector<std::string> keys;  // by task index
};

// DIR/study.db; makes the directory. Throws InputError where that cannot be, or where the file must
// exist and does not.
std::string journal_file(const std::string& directory, bool must_exist);

// What readers of a running batch need of its journal.
struct JournalContent {
  std::vector<JournalRun> runs;  // in the order of planning, at most 100 000
  std::string progress;          // text of Journal::record_progress(); empty: none
};
// Reads FILE, which another process may be writing. Throws InputError for a file that is no
// journal.
JournalContent read_journal(const std::string& file);

// What writes throws WriteError. When DIR/study.db was removed meanwhile, it is made again with all
// that it held, unless another one has taken its place, and a WriteError says so.
class Journal {
 public:
  // Opens or makes DIR/study.db. Throws InputError when the directory cannot be written, holds
  // something else, or holds the study of another text.
  Journal(const std::string& directory, const std::string& study_text, bool must_exist);

  // Outcome of a run that has ended; nothing otherwise.
  std::optional<JobResult> outcome(const std::string& key);
  // Notes all of them at once; those that are known already stay as they are.
  void plan(const std::vector<PlannedRun>& runs);
  void start(const std::string& key);
  void finish(const std::string& key, const JobResult& result);

  void submit(const Submission& submission);  // notes it, or what has become known of it
  void forget_submission(const std::string& name);
  std::vector<Submission> submissions();

  std::vector<JournalRun> runs();  // in the order in which they were planned

  // Replaces the text that describes the progress of the batch (batch_state.h).
  void record_progress(const std::string& json);

  // Throws as the writing functions when DIR/study.db was removed or replaced.
  void require_in_place();

 private:
  template <class Write>
  void write(Write&& write);
  void insert(const std::vector<PlannedRun>& runs);
  [[noreturn]] void put_back();

  std::string directory_;
  Database db_;
};

}  // namespace firn
