// SQLite as this project uses it: safe against kill -9 and against several processes at once.
#pragma once

#include <cstdint>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace firn {

// One file. Every failure of SQLite is a RunError that names the file; nothing is lost by it.
class Database {
 public:
  // Opens or makes the file, with the given tables made where they are missing. Throws InputError
  // when it cannot be opened, is no database, or is of another format.
  Database(const std::string& file, const std::string& schema, int format);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  void execute(const std::string& sql);
  [[noreturn]] void fail(const std::string& what) const;
  sqlite3* handle() const { return db_; }

 private:
  void set_up(const std::string& schema, int format);

  std::string file_;
  sqlite3* db_ = nullptr;
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

  bool next();  // to the next row; false: none
  std::string text(int column) const;
  std::int64_t integer(int column) const;
  double real(int column) const;  // NULL: NaN
  bool null(int column) const;

 private:
  Statement& check(int rc);

  Database& db_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

// All or nothing.
class Transaction {
 public:
  explicit Transaction(Database& db) : db_(db) { db_.execute("BEGIN IMMEDIATE"); }
  ~Transaction();
  void commit();

 private:
  Database& db_;
  bool done_ = false;
};

}  // namespace firn
