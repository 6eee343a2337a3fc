// SQLite databases: statements, transactions, schema migrations.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace firn::sqlite {

// The only triggers that a database may have: those of material records. Existing ones must not
// change; new ones may be added.
inline constexpr std::string_view record_triggers =
    R"(CREATE TRIGGER records_are_written_once BEFORE INSERT ON records  -- OR REPLACE would not be stopped
  WHEN EXISTS (SELECT 1 FROM records WHERE name = NEW.name AND version = NEW.version)
  BEGIN SELECT RAISE(ABORT, 'a record is never changed; add a version that supersedes it'); END;
CREATE TRIGGER records_stay_as_they_are BEFORE UPDATE ON records
  BEGIN SELECT RAISE(ABORT, 'a record is never changed; add a version that supersedes it'); END;
CREATE TRIGGER records_stay BEFORE DELETE ON records
  BEGIN SELECT RAISE(ABORT, 'a record is never removed'); END;
)";

// An open database file. Errors are RunError `FILE: ACTION: MESSAGE` with the message of SQLite,
// and WriteError where the system refused a write.
class File {
 public:
  enum class Access { read, write };  // write: creates a missing file and its folder
  // Uses a write-ahead log (WAL) with full durability. Waits up to `busy_timeout` ms for other
  // writers. A file on a read-only disk can be read. Throws InputError when the file cannot be
  // opened.
  File(const std::string& file, Access access, int busy_timeout = 30000);
  ~File();
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  void execute(const std::string& sql);
  const std::string& name() const { return name_; }
  sqlite3* handle() const { return db_; }
  // Throws the error of the last call of the library. `what`: the failed action.
  [[noreturn]] void fail(const std::string& what) const;
  // True if the file was renamed or removed. Later writes are lost.
  bool moved() const;

 private:
  void open(const std::string& uri, int flags);
  void use_log(int busy_timeout);
  void refuse_foreign_schema();
  void harden();

  std::string name_;
  sqlite3* db_ = nullptr;
};

// A prepared statement; parameters are bound in the order of its question marks.
class Statement {
 public:
  Statement(File& file, const char* sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(const std::string& text);
  Statement& bind(std::int64_t integer);
  Statement& bind(double number);  // NaN: NULL

  bool next();                         // advances to the next row; false: no more rows
  std::string text(int column) const;  // as encode::cleaned() returns it
  std::int64_t integer(int column) const;
  double real(int column) const;  // NULL: NaN
  bool null(int column) const;

 private:
  Statement& check_bound(int result);

  File& file_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

// A write transaction: all changes or none. The constructor acquires the write lock, so that data
// read within the transaction stays valid until commit(). commit() throws WriteError also when the
// file was removed. Without commit() the destructor rolls back.
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

// Version of the schema: the number of migration steps that created it (PRAGMA user_version).
int schema_version(File& file);
// Applies the missing migration steps, all or none. Safe with concurrent processes.
void migrate(File& file, std::span<const char* const> steps);

}  // namespace firn::sqlite
