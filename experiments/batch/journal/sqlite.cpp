#include "experiments/batch/journal/sqlite.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <limits>

#include "experiments/system/output_file.h"
#include "experiments/system/text_encoding.h"

namespace firn {

Database::Database(const std::string& file, const std::string& schema, int format)
    : file_(file, sqlite::File::Access::write) {
  try {
    set_up(schema, format);
  } catch (const WriteError&) {
    throw;
  } catch (const RunError& e) {
    throw InputError(
        fmt::format("{}; expected a folder that can be written, and no other file of "
                    "this name in it",
                    e.what()));
  }
}

void Database::set_up(const std::string& schema, int format) {
  execute("PRAGMA foreign_keys = ON");
  Transaction transaction(*this);
  Statement tables(*this, "SELECT count(*) FROM sqlite_master");
  tables.next();
  const bool fresh = tables.integer(0) == 0;
  if (!fresh) return require_format(format);
  execute(schema);
  execute(fmt::format("PRAGMA user_version = {}", format));
  transaction.commit();
}

Database::Database(const std::string& file, int format) : file_(file, sqlite::File::Access::read) {
  require_format(format);
}

void Database::require_format(int format) {
  if (sqlite::schema_version(file_) != format)
    throw InputError(
        fmt::format("{}: is of another version of Firn, or no file of it; expected another folder",
                    file_.name()));
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
  return s == nullptr ? "" : encode::cleaned(reinterpret_cast<const char*>(s));
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

}  // namespace firn
