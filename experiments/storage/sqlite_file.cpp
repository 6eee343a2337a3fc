#include "experiments/storage/sqlite_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <limits>
#include <thread>

#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/system/output_file.h"
#include "experiments/system/text_encoding.h"
#include "firn/math.h"

namespace firn::sqlite {
namespace {

namespace fs = std::filesystem;

// A path as part of a URI.
std::string escaped(const std::string& path) {
  std::string text;
  for (const char c : path) {
    if (c == '%' || c == '?' || c == '#')
      text += fmt::format("%{:02x}", static_cast<unsigned char>(c));
    else
      text += c;
  }
  return text;
}

// errno of the last file that could not be made. SQLite then tries other ways to open it and drops
// the reason of the first failure.
thread_local int open_error = 0;

int remembering_open(const char* path, int flags, int mode) {
  const int descriptor = ::open(path, flags, mode);
  if (descriptor < 0 && (flags & O_CREAT) != 0) open_error = errno;
  return descriptor;
}

void remember_open_errors() {
  static const bool done = [] {
    sqlite3_vfs* const system = sqlite3_vfs_find(nullptr);
    return system->xSetSystemCall(system, "open",
                                  reinterpret_cast<sqlite3_syscall_ptr>(remembering_open)) ==
           SQLITE_OK;
  }();
  static_cast<void>(done);
}

bool is_refused_by_device() { return open_error != 0 && !is_path_error(open_error); }

// errno behind an SQLITE_IOERR. The connection has it only for open files, and a rollback journal
// is closed by then. `last` is errno after the failure.
int system_error(sqlite3* db, int last) {
  int error = sqlite3_system_errno(db);
  if (error != 0) return error;
  sqlite3_file_control(db, "main", SQLITE_FCNTL_LAST_ERRNO, &error);
  if (error != 0) return error;
  sqlite3_file* log = nullptr;
  if (sqlite3_file_control(db, "main", SQLITE_FCNTL_JOURNAL_POINTER, static_cast<void*>(&log)) ==
          SQLITE_OK &&
      log != nullptr && log->pMethods != nullptr)
    log->pMethods->xFileControl(log, SQLITE_FCNTL_LAST_ERRNO, &error);
  if (error != 0) return error;
  return last == ENOSPC || last == EDQUOT || last == EFBIG || last == EROFS ? last : EIO;
}

}  // namespace

File::File(const std::string& file, Access access, int busy_timeout) : name_(file) {
  const std::string uri = "file:" + escaped(file);
  if (std::error_code error; fs::exists(file, error)) require_regular_file(file, "a database");
  if (access == Access::write) {
    std::error_code error;
    if (const fs::path folder = fs::path(file).parent_path(); !folder.empty())
      fs::create_directories(folder, error);
    if (error.value() == ENOSPC || error.value() == EDQUOT || error.value() == EROFS ||
        error.value() == EIO)
      throw WriteError(file, error.value());
    if (error)
      throw InputError(
          fmt::format("{}: its folder cannot be made: {}; expected a file that can be "
                      "written",
                      file, error.message()));
    open(uri, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
  } else {
    open(uri, SQLITE_OPEN_READONLY);
  }
  try {
    sqlite3_busy_timeout(db_, busy_timeout);
    if (access == Access::write) {
      use_log(busy_timeout);
      execute("PRAGMA synchronous = FULL");
      refuse_foreign_schema();
      return;
    }
    // Readers of a log need a file for its index in the same folder. Where nothing can be written
    // and no log was left, the file cannot change, and none is needed.
    const int rc = sqlite3_exec(db_, "SELECT 1 FROM sqlite_master", nullptr, nullptr, nullptr);
    if ((rc == SQLITE_CANTOPEN || rc == SQLITE_READONLY) && !fs::exists(file + "-wal")) {
      sqlite3_close(db_);
      db_ = nullptr;
      open(uri + "?immutable=1", SQLITE_OPEN_READONLY);
    }
    refuse_foreign_schema();
    execute("SELECT 1 FROM sqlite_master");
  } catch (const WriteError&) {
    sqlite3_close(db_);
    throw;
  } catch (const RunError& e) {
    sqlite3_close(db_);
    throw InputError(fmt::format("{}; expected a database {}", e.what(),
                                 access == Access::write ? "that can be written" : "of Firn"));
  }
}

// Views, virtual tables, triggers and computed columns of others could compute without end, or
// change what is written. Throws RunError.
void File::refuse_foreign_schema() {
  Statement found(
      *this,
      "SELECT type, name, sql FROM sqlite_master WHERE "
      "NOT (type = 'table' AND sql LIKE 'CREATE TABLE %') AND NOT (type = 'index' AND "
      "(sql IS NULL OR sql LIKE 'CREATE INDEX %' OR sql LIKE 'CREATE UNIQUE INDEX %'))");
  while (found.next()) {
    const std::string type = found.text(0), sql = found.text(2);
    if (type == "trigger" && record_triggers.find(sql) != record_triggers.npos) continue;
    throw RunError(
        fmt::format("{}: has the {} \"{}\", which Firn does not make", name_, type, found.text(1)));
  }
  Statement computed(*this,
                     "SELECT m.name, x.name FROM sqlite_master m, pragma_table_xinfo(m.name) x "
                     "WHERE m.type = 'table' AND x.hidden IN (2, 3)");
  if (computed.next())
    throw RunError(fmt::format("{}: has the computed column \"{}.{}\", which Firn does not make",
                               name_, computed.text(0), computed.text(1)));
}

// Disables views, virtual tables and unsafe functions of the schema: the file may be hostile.
void File::harden() {
  sqlite3_db_config(db_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(db_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(db_, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_drop_modules(db_, nullptr);
  sqlite3_limit(db_, SQLITE_LIMIT_LENGTH, static_cast<int>(input_limits::sqlite_row_bytes));
}

// Several may do this to a new file at once, and SQLite does not wait here by itself.
void File::use_log(int busy_timeout) {
  constexpr int pause = 10;  // ms
  for (int waited = 0;; waited += pause) {
    const int rc = sqlite3_exec(db_, "PRAGMA journal_mode = WAL", nullptr, nullptr, nullptr);
    if (rc == SQLITE_OK) return;
    if (rc != SQLITE_BUSY || waited >= busy_timeout) fail("cannot be written");
    std::this_thread::sleep_for(std::chrono::milliseconds(pause));
  }
}

void File::open(const std::string& uri, int flags) {
  remember_open_errors();
  open_error = 0;
  if (sqlite3_open_v2(uri.c_str(), &db_, flags | SQLITE_OPEN_URI, nullptr) == SQLITE_OK) {
    harden();
    return;
  }
  sqlite3_close(db_);
  db_ = nullptr;
  if (is_refused_by_device()) throw WriteError(name_, open_error);
  throw InputError(
      fmt::format("{}: cannot be opened; expected a database that can be {}", name_,
                  (flags & SQLITE_OPEN_READONLY) != 0 ? "read" : "written, or a place for one"));
}

File::~File() { sqlite3_close(db_); }

bool File::moved() const {
  int moved = 0;
  return sqlite3_file_control(db_, "main", SQLITE_FCNTL_HAS_MOVED, &moved) == SQLITE_OK &&
         moved != 0;
}

void File::fail(const std::string& what) const {
  const int last = errno, code = sqlite3_extended_errcode(db_), kind = code & 0xff;
  const bool reading = code == SQLITE_IOERR_READ || code == SQLITE_IOERR_SHORT_READ;
  if (kind == SQLITE_READONLY && ::access(name_.c_str(), W_OK) != 0 && errno == EROFS)
    throw WriteError(name_, EROFS);
  if (kind == SQLITE_CANTOPEN && is_refused_by_device()) throw WriteError(name_, open_error);
  if (kind == SQLITE_TOOBIG)
    throw InputError(fmt::format("{}: holds more than {} bytes in one row; expected fewer", name_,
                                 input_limits::sqlite_row_bytes));
  if (kind == SQLITE_FULL) throw WriteError(name_, ENOSPC);
  if (kind == SQLITE_IOERR && !reading) throw WriteError(name_, system_error(db_, last));
  throw RunError(fmt::format("{}: {}: {}", name_, what, sqlite3_errmsg(db_)));
}

void File::execute(const std::string& sql) {
  if (sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
    fail("cannot be read or written");
}

Statement::Statement(File& file, const char* sql) : file_(file) {
  if (sqlite3_prepare_v2(file.handle(), sql, -1, &statement_, nullptr) != SQLITE_OK)
    file.fail("cannot be read or written");
}

Statement::~Statement() { sqlite3_finalize(statement_); }

Statement& Statement::bind(const std::string& text) {
  return check_bound(sqlite3_bind_text(statement_, ++bound_, text.c_str(),
                                       static_cast<int>(text.size()), SQLITE_TRANSIENT));
}

Statement& Statement::bind(std::int64_t integer) {
  return check_bound(sqlite3_bind_int64(statement_, ++bound_, integer));
}

Statement& Statement::bind(double number) {
  return check_bound(sqlite3_bind_double(statement_, ++bound_, number));
}

Statement& Statement::check_bound(int result) {
  if (result != SQLITE_OK) file_.fail("cannot bind a value");
  return *this;
}

bool Statement::next() {
  const int rc = sqlite3_step(statement_);
  if (rc != SQLITE_ROW && rc != SQLITE_DONE) file_.fail("cannot be read or written");
  return rc == SQLITE_ROW;
}

std::string Statement::text(int column) const {
  const unsigned char* s = sqlite3_column_text(statement_, column);
  const int size = sqlite3_column_bytes(statement_, column);
  return s == nullptr ? std::string()
                      : encode::cleaned(std::string(reinterpret_cast<const char*>(s),
                                                    static_cast<std::size_t>(size)));
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

Transaction::Transaction(File& file) : file_(file) { file.execute("BEGIN IMMEDIATE"); }

Transaction::~Transaction() {
  if (!done_) sqlite3_exec(file_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() {
  file_.execute("COMMIT");
  done_ = true;
  if (file_.moved()) throw WriteError(file_.name(), "it was removed or replaced while in use");
}

int schema_version(File& file) {
  Statement statement(file, "PRAGMA user_version");
  statement.next();
  return static_cast<int>(statement.integer(0));
}

void migrate(File& file, std::span<const char* const> steps) {
  const auto newest = static_cast<int>(steps.size());
  if (schema_version(file) == newest) return;
  Transaction transaction(file);
  const int version = schema_version(file);  // another process may have migrated it
  if (version > newest)
    throw InputError(fmt::format(
        "{}: its schema is of version {}, of a newer Firn; this one reads up to {}; expected "
        "another Firn, or another file",
        file.name(), version, newest));
  for (int step = version; step < newest; ++step)
    file.execute(steps[static_cast<std::size_t>(step)]);
  file.execute(fmt::format("PRAGMA user_version = {}", newest));
  transaction.commit();
}

}  // namespace firn::sqlite
