// Journal of a batch: all runs that were started and their outcomes, consistent after a kill.
//
// A calibration stores no other state. It is a pure function of the study and of the results of its
// runs: a resumed study requests the same runs again and finds their outcomes in the journal.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiments/batch/execution/executor.h"
#include "experiments/batch/journal/tables_file.h"

namespace firn {

// Purpose of a run, for runs.csv.
struct RunLabel {
  std::string experiment;  // empty: the study has one only
  std::string phase;       // "center", "design", "refine 1", "compare: paper table", "confirm"
  int point = 0;           // number within the phase
  std::string parameters;  // "ice_ice=0.05 ice_plastic=0.1"
  std::uint64_t seed = 0;
};

struct PlannedRun {
  std::string key, case_text;
  std::string program;  // identity of the simulating program: program_identity()
  RunLabel label;
};

struct JournalRun {
  std::string key;
  RunLabel label;          // of its first use
  std::string program;     // identity of the program that ran it
  std::string git_commit;  // commit of that program; not part of the key
  std::string status;      // "planned", "running", or to_string(JobStatus)
  int attempts = 0;
  JobResult result;  // of a run that has ended
};

// Key of a run: hash of the complete case text and of the identity of the program.
std::string run_key(const std::string& case_text, const std::string& program);

// Runs submitted to a cluster as one job array.
struct Submission {
  std::string name;               // unique name in the cluster
  std::string job;                // number of the job in the cluster; empty: unknown
  std::vector<std::string> keys;  // [tasks]
};

// Path DIR/study.db; creates the directory. Throws InputError if it cannot be created, or if the
// file is missing and `must_exist`.
std::string journal_file(const std::string& directory, bool must_exist);

// Content of a journal for readers of a running batch.
struct JournalContent {
  std::vector<JournalRun> runs;  // in the order of planning, at most 100 000
  std::string progress;          // text of Journal::record_progress(); empty: none
};
// Reads a journal that another process may be writing. Throws InputError for a file that is not a
// journal.
JournalContent read_journal(const std::string& file);

// Writing functions throw WriteError. If DIR/study.db was removed, they restore it with its
// content, unless another file has that name, and throw a WriteError that reports it.
class Journal {
 public:
  // Opens or creates DIR/study.db. Throws InputError when the directory cannot be written, has
  // other content, or has the journal of another `study_text`.
  Journal(const std::string& directory, const std::string& study_text, bool must_exist);

  // Outcome of a run that has ended; else nothing.
  std::optional<JobResult> outcome(const std::string& key);
  // Adds the runs in one transaction. Known runs are not changed.
  void plan(const std::vector<PlannedRun>& runs);
  void start(const std::string& key);
  void finish(const std::string& key, const JobResult& result);

  void submit(const Submission& submission);  // adds or updates it
  void forget_submission(const std::string& name);
  std::vector<Submission> submissions();

  std::vector<JournalRun> runs();  // in the order of planning

  // Replaces the text that describes the progress of the batch (batch_state.h).
  void record_progress(const std::string& json);

  // Throws as writing functions if DIR/study.db was removed or replaced.
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
