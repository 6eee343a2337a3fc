#include "calibrate/journal.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <filesystem>
#include <limits>

#include "experiments/sha256.h"

namespace firn {
namespace {

constexpr int format_version = 2;

[[noreturn]] void fail(sqlite3* db, const std::string& what) {
  throw RunError(fmt::format("the study's journal: {}: {}", what, sqlite3_errmsg(db)));
}

// A prepared statement; parameters are bound in order, 1-based as SQLite counts them.
class Statement {
 public:
  Statement(sqlite3* db, const char* sql) : db_(db) {
    if (sqlite3_prepare_v2(db, sql, -1, &statement_, nullptr) != SQLITE_OK) fail(db, sql);
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(const std::string& s) {
    return check(sqlite3_bind_text(statement_, ++bound_, s.c_str(), static_cast<int>(s.size()),
                                   SQLITE_TRANSIENT));
  }
  Statement& bind(std::int64_t i) { return check(sqlite3_bind_int64(statement_, ++bound_, i)); }
  Statement& bind(double x) { return check(sqlite3_bind_double(statement_, ++bound_, x)); }

  bool next() {
    const int rc = sqlite3_step(statement_);
    if (rc != SQLITE_ROW && rc != SQLITE_DONE) fail(db_, "cannot be read or written");
    return rc == SQLITE_ROW;
  }
  std::string text(int column) const {
    const unsigned char* s = sqlite3_column_text(statement_, column);
    return s == nullptr ? "" : reinterpret_cast<const char*>(s);
  }
  std::int64_t integer(int column) const { return sqlite3_column_int64(statement_, column); }
  // SQLite has no NaN: it stores NULL.
  double real(int column) const {
    return sqlite3_column_type(statement_, column) == SQLITE_NULL
               ? std::numeric_limits<double>::quiet_NaN()
               : sqlite3_column_double(statement_, column);
  }
  bool null(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }

 private:
  Statement& check(int rc) {
    if (rc != SQLITE_OK) fail(db_, "cannot bind a value");
    return *this;
  }
  sqlite3* db_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

void execute(sqlite3* db, const char* sql) {
  if (sqlite3_exec(db, sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail(db, sql);
}

// All or nothing.
class Transaction {
 public:
  explicit Transaction(sqlite3* db) : db_(db) { execute(db, "BEGIN IMMEDIATE"); }
  ~Transaction() {
    if (!done_) sqlite3_exec(db_, "ROLLBACK", nullptr, nullptr, nullptr);
  }
  void commit() {
    execute(db_, "COMMIT");
    done_ = true;
  }

 private:
  sqlite3* db_;
  bool done_ = false;
};

constexpr const char* schema = R"(
CREATE TABLE IF NOT EXISTS study (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS runs (
  number INTEGER PRIMARY KEY,      -- order in which they were planned
  key TEXT NOT NULL UNIQUE,
  case_text TEXT NOT NULL,
  version TEXT NOT NULL,
  experiment TEXT NOT NULL, phase TEXT NOT NULL, point INTEGER NOT NULL,
  parameters TEXT NOT NULL, seed TEXT NOT NULL,
  status TEXT NOT NULL CHECK (status IN ('planned', 'running', 'finished', 'arched',
    'failed', 'crashed', 'timed out', 'out of memory')),
  reason TEXT NOT NULL DEFAULT '',
  attempts INTEGER NOT NULL DEFAULT 0,
  wall REAL NOT NULL DEFAULT 0);
CREATE TABLE IF NOT EXISTS responses (
  run TEXT NOT NULL REFERENCES runs (key),
  name TEXT NOT NULL, part INTEGER NOT NULL,  -- part: index into a response with several values
  value REAL, uncertainty REAL,               -- NULL: not a number; not known
  unit TEXT NOT NULL, method TEXT NOT NULL, method_version INTEGER NOT NULL,
  PRIMARY KEY (run, name, part)) WITHOUT ROWID;
)";

constexpr JobStatus outcomes[] = {JobStatus::finished,  JobStatus::arched,
                                  JobStatus::failed,    JobStatus::crashed,
                                  JobStatus::timed_out, JobStatus::out_of_memory};

// Nothing for a run that has not ended.
std::optional<JobStatus> outcome_of(const std::string& text) {
  for (const JobStatus status : outcomes)
    if (text == to_string(status)) return status;
  return std::nullopt;
}

}  // namespace

std::string run_key(const std::string& case_text, const std::string& version) {
  return sha256(version + '\n' + case_text).substr(0, 16);
}

Journal::Journal(const std::string& directory, const std::string& study_text, bool must_exist) {
  namespace fs = std::filesystem;
  const fs::path file = fs::path(directory) / "study.db";
  if (must_exist && !fs::exists(file))
    throw InputError(
        fmt::format("{}: nothing to resume: there is no study.db in it; expected the "
                    "directory of a study that was started before",
                    directory));
  std::error_code error;
  fs::create_directories(directory, error);
  if (error)
    throw InputError(fmt::format("{}: cannot be made: {}; expected a directory that can be written",
                                 directory, error.message()));
  if (sqlite3_open(file.c_str(), &db_) != SQLITE_OK) {
    sqlite3_close(db_);
    throw InputError(fmt::format("{}: cannot be opened; expected a directory that can be written",
                                 file.string()));
  }
  try {
    sqlite3_busy_timeout(db_, 10000);
    execute(db_, "PRAGMA journal_mode = WAL");
    execute(db_, "PRAGMA synchronous = FULL");
    execute(db_, "PRAGMA foreign_keys = ON");
    Transaction transaction(db_);
    execute(db_, schema);
    Statement format(db_, "SELECT value FROM study WHERE name = 'format'");
    if (format.next() && format.text(0) != std::to_string(format_version))
      throw InputError(
          fmt::format("{}: was written by another version of Firn; expected another directory "
                      "with -o",
                      file.string()));
    Statement known(db_, "SELECT value FROM study WHERE name = 'text'");
    if (!known.next()) {
      Statement(db_, "INSERT INTO study VALUES ('format', ?), ('text', ?)")
          .bind(std::to_string(format_version))
          .bind(study_text)
          .next();
    } else if (known.text(0) != study_text) {
      throw InputError(
          fmt::format("{}: holds the runs of another study (its text differs); expected "
                      "the same study, or another directory with -o",
                      directory));
    }
    transaction.commit();
  } catch (const RunError& e) {
    sqlite3_close(db_);
    throw InputError(
        fmt::format("{}: {}; expected the journal of a study", file.string(), e.what()));
  } catch (const InputError&) {
    sqlite3_close(db_);
    throw;
  }
}

Journal::~Journal() { sqlite3_close(db_); }

std::optional<JobResult> Journal::outcome(const std::string& key) {
  Statement run(db_, "SELECT status, reason, wall FROM runs WHERE key = ?");
  run.bind(key);
  if (!run.next()) return std::nullopt;
  const auto status = outcome_of(run.text(0));
  if (!status) return std::nullopt;
  JobResult result{*status, run.text(1), {}, run.real(2)};
  Statement row(db_,
                "SELECT name, value, uncertainty, unit, method, method_version FROM responses "
                "WHERE run = ? ORDER BY name, part");
  row.bind(key);
  while (row.next()) {
    if (result.responses.empty() || result.responses.back().name != row.text(0))
      result.responses.push_back(
          {row.text(0), {}, {}, row.text(3), row.text(4), static_cast<int>(row.integer(5))});
    Response& r = result.responses.back();
    r.value.push_back(row.real(1));
    if (!row.null(2)) r.uncertainty.push_back(row.real(2));
  }
  return result;
}

void Journal::plan(const std::vector<PlannedRun>& runs) {
  Transaction transaction(db_);
  for (const PlannedRun& run : runs)
    Statement(db_,
              "INSERT OR IGNORE INTO runs (key, case_text, version, experiment, phase, point, "
              "parameters, seed, status) VALUES (?, ?, ?, ?, ?, ?, ?, ?, 'planned')")
        .bind(run.key)
        .bind(run.case_text)
        .bind(run.version)
        .bind(run.label.experiment)
        .bind(run.label.phase)
        .bind(std::int64_t{run.label.point})
        .bind(run.label.parameters)
        .bind(std::to_string(run.label.seed))
        .next();
  transaction.commit();
}

void Journal::start(const std::string& key) {
  Statement(db_, "UPDATE runs SET status = 'running', attempts = attempts + 1 WHERE key = ?")
      .bind(key)
      .next();
}

void Journal::finish(const std::string& key, const JobResult& result) {
  Transaction transaction(db_);
  for (const Response& r : result.responses)
    for (std::size_t i = 0; i < r.value.size(); ++i) {
      // A NaN is bound as NULL.
      const double uncertainty =
          i < r.uncertainty.size() ? r.uncertainty[i] : std::numeric_limits<double>::quiet_NaN();
      Statement(db_, "INSERT OR REPLACE INTO responses VALUES (?, ?, ?, ?, ?, ?, ?, ?)")
          .bind(key)
          .bind(r.name)
          .bind(static_cast<std::int64_t>(i))
          .bind(r.value[i])
          .bind(uncertainty)
          .bind(r.unit)
          .bind(r.method)
          .bind(std::int64_t{r.method_version})
          .next();
    }
  Statement(db_, "UPDATE runs SET status = ?, reason = ?, wall = ? WHERE key = ?")
      .bind(std::string(to_string(result.status)))
      .bind(result.reason)
      .bind(result.wall)
      .bind(key)
      .next();
  transaction.commit();
}

std::vector<JournalRun> Journal::runs() {
  std::vector<JournalRun> all;
  Statement row(db_,
                "SELECT key, experiment, phase, point, parameters, seed, version, status, attempts "
                "FROM runs ORDER BY number");
  while (row.next()) {
    JournalRun run;
    run.key = row.text(0);
    run.label = {row.text(1), row.text(2), static_cast<int>(row.integer(3)), row.text(4),
                 std::stoull(row.text(5))};
    run.version = row.text(6);
    run.status = row.text(7);
    run.attempts = static_cast<int>(row.integer(8));
    if (const auto result = outcome(run.key)) run.result = *result;
    all.push_back(std::move(run));
  }
  return all;
}

}  // namespace firn
