// The little of SQLite that a store of records needs: statements, transactions, migrations.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace firn::sqlite {

// The only triggers that a database may have: those of material records. Never changed, only added
// to.
inline constexpr std::string_view record_triggers =
    R"(CREATE TRIGGER records_are_written_once BEFORE INSERT ON records  -- OR REPLACE would not be stopped
  WHEN EXISTS (SELECT 1 FROM records WHERE name = NEW.name AND version = NEW.version)
  BEGIN SELECT RAISE(ABORT, 'a record is never changed; add a version that supersedes it'); END;
CREATE TRIGGER records_stay_as_they_are BEFORE UPDATE ON records
  BEGIN SELECT RAISE(ABORT, 'a record is never changed; add a version that supersedes it'); END;
CREATE TRIGGER records_stay BEFORE DELETE ON records
  BEGIN SELECT RAISE(ABORT, 'a record is never removed'); END;
)";

// An open database file. Errors are RunError `FILE: what: SQLite's word for it`, and WriteError
// where the system refused a write.
class File {
 public:
  enum class Access { read, write };  // write makes the file and its folder where missing
  // WAL, full durability, and up to `busy_timeout` milliseconds of waiting for other writers. A
  // file on a disk that cannot be written can be read. Throws InputError when it cannot be opened.
  File(const std::string& file, Access access, int busy_timeout = 30000);
  ~File();
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  void execute(const char* sql);
  const std::string& name() const { return name_; }
  sqlite3* handle() const { return db_; }
  // Throws what the last call of the library failed with.
  [[noreturn]] void fail(const std::string& what) const;
  // Whether the file has lost its name: what is written then is lost.
  bool moved() const;

 private:
  void open(const std::string& uri, int flags);
  void use_log(int busy_timeout);
  void refuse_foreign_schema();
  void harden();

  std::string name_;
  sqlite3* db_ = nullptr;
};

// A prepared statement; parameters are bound in order.
class Statement {
 public:
  Statement(File& file, const char* sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(const std::string& text);
  Statement& bind(std::int64_t integer);
  bool next();  // true: there is a row
  std::string text(int column) const;
  std::int64_t integer(int column) const;

 private:
  File& file_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

// All or nothing. commit() throws WriteError also when the file was removed. It takes the one place
// of a writer at once, so that what is read within it is what the writing rests on.
class Transaction {
 public:
  explicit Transaction(File& file);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  File& file_;
  bool done_ = false;
};

// The version of a file's schema is the number of steps that made it (PRAGMA user_version).
int schema_version(File& file);
// Applies the migration steps that the file lacks, all or none. A second process finds none left.
void migrate(File& file, std::span<const char* const> steps);

}  // namespace firn::sqlite
