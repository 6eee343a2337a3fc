#include "experiments/batch/run_store.h"

#include <filesystem>

#include "experiments/batch/run_tables.h"
#include "experiments/version.h"

namespace firn {
namespace {

constexpr int format = 0x46530001;  // "FS", 1

std::string schema() {
  return std::string(
             "CREATE TABLE runs (key TEXT PRIMARY KEY, case_text TEXT NOT NULL, "
             "program TEXT NOT NULL, git_commit TEXT NOT NULL, made_at TEXT NOT NULL, ") +
         outcome_columns + ") WITHOUT ROWID;" + responses_table;
}

std::string with_folder(const std::string& file) {
  std::error_code error;  // the database says it better
  std::filesystem::create_directories(std::filesystem::path(file).parent_path(), error);
  return file;
}

}  // namespace

RunStore::RunStore(const std::string& file) : db_(with_folder(file), schema(), format) {}

std::optional<JobResult> RunStore::find(const std::string& key) { return read_outcome(db_, key); }

void RunStore::add(const PlannedRun& run, const JobResult& result) {
  Transaction transaction(db_);
  const auto known = read_outcome(db_, run.key);
  if (known && !cut_short(known->status)) return;  // the same run, from another study
  Statement(db_,
            "INSERT OR IGNORE INTO runs (key, case_text, program, git_commit, made_at, status) "
            "VALUES (?, ?, ?, ?, datetime('now'), 'running')")
      .bind(run.key)
      .bind(run.case_text)
      .bind(run.program)
      .bind(std::string(firn_git_commit()))
      .next();
  write_outcome(db_, run.key, result);
  transaction.commit();
}

}  // namespace firn
