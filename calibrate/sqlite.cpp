#include "calibrate/sqlite.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <limits>

#include "solver/types.h"

namespace firn {
namespace {

constexpr int busy_timeout = 30000;  // ms, while another process writes

}  // namespace

Database::Database(const std::string& file, const std::string& schema, int format) : file_(file) {
  if (sqlite3_open(file.c_str(), &db_) != SQLITE_OK) {
    const std::string why = sqlite3_errmsg(db_);
    sqlite3_close(db_);
    throw InputError(
        fmt::format("{}: cannot be opened: {}; expected a folder that can be written", file, why));
  }
  try {
    set_up(schema, format);
  } catch (const RunError& e) {
    sqlite3_close(db_);
    throw InputError(
        fmt::format("{}; expected a folder that can be written, and no other file of "
                    "this name in it",
                    e.what()));
  } catch (const InputError&) {
    sqlite3_close(db_);
    throw;
  }
}

Database::~Database() { sqlite3_close(db_); }

void Database::set_up(const std::string& schema, int format) {
  sqlite3_busy_timeout(db_, busy_timeout);
  execute("PRAGMA journal_mode = WAL");
  execute("PRAGMA synchronous = FULL");
  execute("PRAGMA foreign_keys = ON");
  Transaction transaction(*this);
  Statement version(*this, "PRAGMA user_version");
  version.next();
  Statement tables(*this, "SELECT count(*) FROM sqlite_master");
  tables.next();
  const bool fresh = tables.integer(0) == 0;
  if (!fresh && version.integer(0) != format)
    throw InputError(fmt::format(
        "{}: is of another version of Firn, or no file of it; expected another folder", file_));
  if (!fresh) return;
  execute(schema);
  execute(fmt::format("PRAGMA user_version = {}", format));
  transaction.commit();
}

void Database::execute(const std::string& sql) {
  if (sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
    fail("cannot be read or written");
}

void Database::fail(const std::string& what) const {
  throw RunError(fmt::format("{}: {}: {}", file_, what, sqlite3_errmsg(db_)));
}

Statement::Statement(Database& db, const char* sql) : db_(db) {
  if (sqlite3_prepare_v2(db.handle(), sql, -1, &statement_, nullptr) != SQLITE_OK)
    db_.fail("cannot be read");
}

Statement::~Statement() { sqlite3_finalize(statement_); }

Statement& Statement::bind(const std::string& s) {
  return check(sqlite3_bind_text(statement_, ++bound_, s.c_str(), static_cast<int>(s.size()),
                                 SQLITE_TRANSIENT));
}

Statement& Statement::bind(std::int64_t i) {
  return check(sqlite3_bind_int64(statement_, ++bound_, i));
}

Statement& Statement::bind(double x) { return check(sqlite3_bind_double(statement_, ++bound_, x)); }

bool Statement::next() {
  const int rc = sqlite3_step(statement_);
  if (rc != SQLITE_ROW && rc != SQLITE_DONE) db_.fail("cannot be read or written");
  return rc == SQLITE_ROW;
}

std::string Statement::text(int column) const {
  const unsigned char* s = sqlite3_column_text(statement_, column);
  return s == nullptr ? "" : reinterpret_cast<const char*>(s);
}

std::int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(statement_, column);
}

double Statement::real(int column) const {
  return null(column) ? std::numeric_limits<double>::quiet_NaN()
                      : sqlite3_column_double(statement_, column);
}

bool Statement::null(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_NULL;
}

Statement& Statement::check(int rc) {
  if (rc != SQLITE_OK) db_.fail("cannot take a value");
  return *this;
}

Transaction::~Transaction() {
  if (!done_) sqlite3_exec(db_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() {
  db_.execute("COMMIT");
  done_ = true;
}

}  // namespace firn
