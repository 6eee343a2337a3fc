// SQLite databases of journals and run caches: adds real numbers, including NaN, to
// experiments/storage/sqlite_file.h.
#pragma once

#include <cstdint>
#include <string>

#include "experiments/storage/sqlite_file.h"

namespace firn {

// A database file with tables of one format. Every failure of SQLite is a RunError that names the
// file and leaves the data unchanged.
class Database {
 public:
  // Opens or creates the file, and creates missing tables of `schema`. Throws InputError when it
  // cannot be opened, is not a database, or has another format.
  Database(const std::string& file, const std::string& schema, int format);
  // Opens an existing file for reading only. Throws InputError as above.
  Database(const std::string& file, int format);

  void execute(const std::string& sql) { file_.execute(sql.c_str()); }
  [[noreturn]] void fail(const std::string& what) const { file_.fail(what); }
  sqlite3* handle() const { return file_.handle(); }
  sqlite::File& file() { return file_; }

 private:
  void set_up(const std::string& schema, int format);
  void require_format(int format);

  sqlite::File file_;
};

// A prepared statement; parameters are bound in the order of its question marks.
class Statement {
 public:
  Statement(Database& db, const char* sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(const std::string& s);
  Statement& bind(std::int64_t i);
  Statement& bind(double x);  // NaN: NULL

  bool next();                         // to the next row; false: none
  std::string text(int column) const;  // as encode::cleaned() returns it
  std::int64_t integer(int column) const;
  double real(int column) const;  // NULL: NaN
  bool null(int column) const;

 private:
  Statement& check(int rc);

  Database& db_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

// A transaction: all changes or none.
class Transaction : public sqlite::Transaction {
 public:
  explicit Transaction(Database& db) : sqlite::Transaction(db.file()) {}
};

}  // namespace firn
