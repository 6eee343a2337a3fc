#include "experiments/batch/journal/journal.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "experiments/batch/journal/outcome_tables.h"
#include "experiments/storage/sha256.h"
#include "experiments/storage/version.h"
#include "experiments/system/output_file.h"

namespace firn {
namespace {

constexpr int format = 0x464A0002;  // "FJ", 2

std::string schema() {
  return std::string(
             "CREATE TABLE study (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;"
             "CREATE TABLE runs (number INTEGER PRIMARY KEY, "  // order in which they were planned
             "key TEXT NOT NULL UNIQUE, case_text TEXT NOT NULL, program TEXT NOT NULL, "
             "git_commit TEXT NOT NULL, experiment TEXT NOT NULL, phase TEXT NOT NULL, point "
             "INTEGER NOT NULL, "
             "parameters TEXT NOT NULL, seed TEXT NOT NULL, attempts INTEGER NOT NULL DEFAULT "
             "0, ") +
         outcome_columns + ");" + responses_table +
         // Arrays handed to a cluster that may still be under way.
         "CREATE TABLE submissions (name TEXT PRIMARY KEY, job TEXT NOT NULL, "  // '': no answer
                                                                                 // yet
         "tasks TEXT NOT NULL) WITHOUT ROWID;";                                  // keys, by index
}

}  // namespace

std::string journal_file(const std::string& directory, bool must_exist) {
  namespace fs = std::filesystem;
  const fs::path file = fs::path(directory) / "study.db";
  if (must_exist && !fs::exists(file))
    throw InputError(
        fmt::format("{}: nothing to resume: there is no study.db in it; expected the "
                    "directory of a study that was started before",
                    directory));
  make_output_folder(directory);
  return file.string();
}

std::string run_key(const std::string& case_text, const std::string& program) {
  return sha256(program + '\n' + case_text).substr(0, 16);
}

namespace {

[[noreturn]] void refuse(Database& db, const char* column, const std::string& text,
                         const char* expected) {
  throw InputError(fmt::format("{}: {}: is \"{}\"; expected {}", db.name(), column,
                               text.substr(0, 40), expected));
}

std::uint64_t seed_of(Database& db, const std::string& text) {
  std::uint64_t seed = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, seed);
  if (error != std::errc() || last != end) refuse(db, "seed", text, "a whole number");
  return seed;
}

}  // namespace

Journal::Journal(const std::string& directory, const std::string& study_text, bool must_exist)
    : directory_(directory), db_(journal_file(directory, must_exist), schema(), format) {
  Transaction transaction(db_);
  Statement known(db_, "SELECT value FROM study WHERE name = 'text'");
  if (!known.next())
    Statement(db_, "INSERT INTO study VALUES ('text', ?)").bind(study_text).next();
  else if (known.text(0) != study_text)
    throw InputError(
        fmt::format("{}: holds the runs of another study (its text differs); expected "
                    "the same study, or another directory with -o",
                    directory));
  transaction.commit();
}

std::optional<JobResult> Journal::outcome(const std::string& key) { return read_outcome(db_, key); }

template <class Write>
void Journal::write(Write&& write) {
  require_in_place();
  Transaction transaction(db_);
  write();
  try {
    transaction.commit();
  } catch (const WriteError&) {
    require_in_place();
    throw;
  }
}

void Journal::require_in_place() {
  if (db_.moved()) put_back();
}

// The removed file can be read as long as it is open.
void Journal::put_back() {
  namespace fs = std::filesystem;
  const std::string file = (fs::path(directory_) / "study.db").string();
  const char* const removed = "it was removed or replaced during the work";
  std::error_code error;  // the database reports the error
  fs::create_directories(directory_, error);
  if (fs::exists(file, error)) throw WriteError(directory_, removed);
  try {
    Statement(db_, "VACUUM INTO ?").bind(file).next();
    sync_path(file);
  } catch (const RunError& e) {
    throw RunError(
        fmt::format("{}: {}, and its journal cannot be written again: {}; its finished runs are in "
                    "the store of runs, if it has one",
                    directory_, removed, e.what()));
  }
  throw WriteError(directory_, fmt::format("{}; its journal was written again", removed));
}

void Journal::plan(const std::vector<PlannedRun>& runs) {
  write([&] { insert(runs); });
}

void Journal::insert(const std::vector<PlannedRun>& runs) {
  for (const PlannedRun& run : runs)
    Statement(db_,
              "INSERT OR IGNORE INTO runs (key, case_text, program, git_commit, experiment, phase, "
              "point, parameters, seed, status) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, 'planned')")
        .bind(run.key)
        .bind(run.case_text)
        .bind(run.program)
        .bind(std::string(firn_git_commit()))
        .bind(run.label.experiment)
        .bind(run.label.phase)
        .bind(std::int64_t{run.label.point})
        .bind(run.label.parameters)
        .bind(std::to_string(run.label.seed))
        .next();
}

void Journal::start(const std::string& key) {
  write([&] {
    Statement(db_, "UPDATE runs SET status = 'running', attempts = attempts + 1 WHERE key = ?")
        .bind(key)
        .next();
  });
}

void Journal::finish(const std::string& key, const JobResult& result) {
  const bool good = result.status == JobStatus::finished || result.status == JobStatus::arched;
  if (db_.moved() && good) write_outcome(db_, key, result);  // others end with the folder
  write([&] { write_outcome(db_, key, result); });
}

namespace {

std::vector<JournalRun> read_runs(Database& db, std::int64_t most) {
  std::vector<JournalRun> all;
  Statement row(db,
                "SELECT key, experiment, phase, point, parameters, seed, program, git_commit, "
                "status, attempts FROM runs ORDER BY number LIMIT ?");
  row.bind(most);
  while (row.next()) {
    JournalRun run;
    run.key = row.text(0);
    run.label = {row.text(1), row.text(2), static_cast<int>(row.integer(3)), row.text(4),
                 seed_of(db, row.text(5))};
    run.program = row.text(6);
    run.git_commit = row.text(7);
    run.status = row.text(8);
    run.attempts = static_cast<int>(row.integer(9));
    if (const auto result = read_outcome(db, run.key)) {
      run.result = *result;
      run.status = to_string(result->status);  // implausible ones have failed
    }
    all.push_back(std::move(run));
  }
  return all;
}

}  // namespace

std::vector<JournalRun> Journal::runs() {
  return read_runs(db_, std::numeric_limits<std::int64_t>::max());
}

void Journal::record_progress(const std::string& json) {
  {
    Statement known(db_, "SELECT value FROM study WHERE name = 'progress'");
    if (known.next() && known.text(0) == json) return;
  }
  write([&] {
    Statement(db_, "INSERT OR REPLACE INTO study VALUES ('progress', ?)").bind(json).next();
  });
}

JournalContent read_journal(const std::string& file) {
  constexpr std::int64_t kMost = 100'000;
  try {
    Database db(file, format);
    JournalContent content{read_runs(db, kMost), {}};
    Statement progress(db, "SELECT value FROM study WHERE name = 'progress'");
    if (progress.next()) content.progress = progress.text(0);
    return content;
  } catch (const WriteError&) {
    throw;
  } catch (const RunError& e) {
    throw InputError(fmt::format("{}; expected the journal of a batch", e.what()));
  }
}

void Journal::submit(const Submission& s) {
  write([&] {
    Statement(db_, "INSERT OR REPLACE INTO submissions VALUES (?, ?, ?)")
        .bind(s.name)
        .bind(s.job)
        .bind(nlohmann::json(s.keys).dump())
        .next();
  });
}

void Journal::forget_submission(const std::string& name) {
  Statement(db_, "DELETE FROM submissions WHERE name = ?").bind(name).next();
}

std::vector<Submission> Journal::submissions() {
  std::vector<Submission> all;
  Statement row(db_, "SELECT name, job, tasks FROM submissions ORDER BY name");
  while (row.next()) {
    const nlohmann::json tasks = nlohmann::json::parse(row.text(2), nullptr, false);
    const bool texts =
        tasks.is_array() && std::ranges::all_of(tasks, [](const auto& t) { return t.is_string(); });
    if (!texts) refuse(db_, "tasks", row.text(2), "a list of keys");
    all.push_back({row.text(0), row.text(1), tasks.get<std::vector<std::string>>()});
  }
  return all;
}

}  // namespace firn
