#include "experiments/batch/journal/run_cache.h"

#include <charconv>
#include <filesystem>

#include "experiments/batch/journal/outcome_tables.h"
#include "experiments/storage/version.h"

namespace firn {
namespace {

constexpr int store_format = 0x46530001;  // "FS", 1

std::string store_schema() {
  return std::string(
             "CREATE TABLE runs (key TEXT PRIMARY KEY, case_text TEXT NOT NULL, "
             "program TEXT NOT NULL, git_commit TEXT NOT NULL, made_at TEXT NOT NULL, ") +
         outcome_columns + ") WITHOUT ROWID;" + responses_table;
}

std::string with_folder(const std::string& file) {
  std::error_code error;  // the database reports it with more detail
  std::filesystem::create_directories(std::filesystem::path(file).parent_path(), error);
  return file;
}

// The statement ends here. SQLite cannot wait for a lock while a statement of the same connection
// still reads.
bool has_table(Database& db, const char* name) {
  Statement known(db, "SELECT count(*) FROM sqlite_master WHERE name = ?");
  known.bind(std::string(name)).next();
  return known.integer(0) > 0;
}

}  // namespace

RunCache::RunCache(const std::string& file, const std::string& study)
    : study_(study), db_(with_folder(file), store_schema(), store_format) {
  // Stores made before have no labels; their runs are found by key all the same.
  if (has_table(db_, "labels")) return;
  db_.execute(
      "CREATE TABLE IF NOT EXISTS labels (number INTEGER PRIMARY KEY, key TEXT NOT NULL UNIQUE, "
      "program TEXT NOT NULL, study TEXT NOT NULL, parameters TEXT NOT NULL, seed TEXT NOT NULL)");
}

std::optional<JobResult> RunCache::find(const std::string& key) { return read_outcome(db_, key); }

void RunCache::add(const PlannedRun& run, const JobResult& result) {
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
  if (!run.label.parameters.empty())
    Statement(db_,
              "INSERT OR IGNORE INTO labels (key, program, study, parameters, seed) "
              "VALUES (?, ?, ?, ?, ?)")
        .bind(run.key)
        .bind(run.program)
        .bind(study_)
        .bind(run.label.parameters)
        .bind(std::to_string(run.label.seed))
        .next();
  transaction.commit();
}

std::vector<RunCache::Known> RunCache::of_other_studies(const std::string& program) {
  Statement rows(db_,
                 "SELECT parameters, seed FROM labels WHERE program = ? AND study != ? "
                 "ORDER BY number");
  rows.bind(program).bind(study_);
  std::vector<Known> all;
  while (rows.next()) {
    const std::string seed = rows.text(1);
    Known known{rows.text(0), 0};
    const auto [end, error] = std::from_chars(seed.data(), seed.data() + seed.size(), known.seed);
    if (error == std::errc() && end == seed.data() + seed.size()) all.push_back(known);
  }
  return all;
}

}  // namespace firn
