// The store: versions, immutability, many writers, kills, foreign and newer files.
#include "experiments/material_records/material_database.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <set>
#include <thread>

#include "experiments/material_records/material_json.h"
#include "experiments/storage/sqlite_file.h"
#include "tests/support/error_of.h"
#include "tests/support/sample_records.h"

namespace firn {
namespace {

using test::calibrated_record;
using test::published_record;
using test::ScratchFolder;
using testing::HasSubstr;
using Access = MaterialDatabase::Access;

// Runs it in a separate process; its exit status, 99 for an exception.
pid_t in_process(const std::function<int()>& act) {
  const pid_t pid = fork();
  if (pid != 0) return pid;
  try {
    _exit(act());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    _exit(99);
  }
}
int wait_for(pid_t pid) {
  int status = 0;
  waitpid(pid, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

TEST(MaterialDatabase, VersionsSupersedeAndStay) {
  const ScratchFolder folder("versions");
  MaterialDatabase database(folder / "sub/m.db", Access::write);
  const StoredRecord first = database.add({published_record()}).front();
  MaterialRecord changed = published_record();
  changed.parameters[0].value = 0.2;
  const StoredRecord second = database.add({changed}).front();
  EXPECT_EQ(first.record.reference(), "ice-steel@1");
  EXPECT_EQ(second.record.reference(), "ice-steel@2");
  EXPECT_EQ(second.record.supersedes, first.sha256);
  const MaterialDatabase reader(folder / "sub/m.db");
  EXPECT_EQ(reader.find("ice-steel").sha256, second.sha256);
  EXPECT_EQ(reader.find("ice-steel", 1).record.parameters[0].value, 0.1);
  EXPECT_EQ(reader.history("ice-steel").size(), 2u);
  EXPECT_TRUE(reader.integrity_errors("ice-steel").empty());
  EXPECT_THAT(test::error_of([&] { reader.find("ice-steel", 3); }), HasSubstr("the newest is 2"));
  EXPECT_THAT(test::error_of([&] { reader.find("ice-stel"); }),
              HasSubstr("did you mean \"ice-steel\"?"));
}

TEST(MaterialDatabase, ShippedRecordsAreThereWithoutAFile) {
  const ScratchFolder folder("none");
  const MaterialDatabase database(folder / "m.db");
  EXPECT_EQ(database.find("paper-table-1").record.version, 1);
  EXPECT_TRUE(database.find("paper-table-1").shipped);
  EXPECT_FALSE(std::filesystem::exists(folder / "m.db"));  // reading makes nothing
  MaterialDatabase writer(folder / "m.db", Access::write);
  EXPECT_THAT(test::error_of([&] { writer.add({published_record("paper-table-1")}); }),
              HasSubstr("ships with Firn; expected another name"));
  EXPECT_THAT(test::error_of([&] { writer.require_writable_name("a@2"); }),
              HasSubstr("more than a name"));
}

TEST(MaterialDatabase, AddingIsAllOrNothing) {
  const ScratchFolder folder("atomic");
  MaterialDatabase database(folder / "m.db", Access::write);
  MaterialRecord bad = published_record("bad");
  bad.provenance.author = "";
  EXPECT_THAT(test::error_of([&] {
                database.add({published_record("good"), bad});
              }),
              HasSubstr("author"));
  EXPECT_THAT(test::error_of([&] { database.find("good"); }), HasSubstr("unknown"));
}

// Neither this program nor another one that opens the file can change or remove what is written.
TEST(MaterialDatabase, RowsCannotBeChanged) {
  const ScratchFolder folder("immutable");
  MaterialDatabase(folder / "m.db", Access::write).add({published_record()});
  sqlite::File raw(folder / "m.db", sqlite::File::Access::write);
  for (const char* sql :
       {"UPDATE records SET json = '{}'", "DELETE FROM records", "UPDATE records SET version = 7",
        "INSERT OR REPLACE INTO records VALUES "
        "('ice-steel', 1, 'x', '{}')"}) {
    EXPECT_THROW(raw.execute(sql), RunError) << sql;
  }
  EXPECT_TRUE(MaterialDatabase(folder / "m.db").integrity_errors("ice-steel").empty());
}

// Deliberate changes are possible once the triggers are removed. The hashes reveal them.
TEST(MaterialDatabase, TamperingIsFound) {
  const ScratchFolder folder("tampered");
  {
    MaterialDatabase database(folder / "m.db", Access::write);
    database.add({published_record(), published_record(), published_record()});
  }
  sqlite::File raw(folder / "m.db", sqlite::File::Access::write);
  raw.execute("DROP TRIGGER records_stay_as_they_are");
  raw.execute("UPDATE records SET json = replace(json, '0.3', '0.4') WHERE version = 2");
  const MaterialDatabase database(folder / "m.db");
  EXPECT_THAT(database.integrity_errors("ice-steel"),
              testing::ElementsAre("version 2 does not have the hash noted with it"));
  raw.execute("DROP TRIGGER records_stay");
  raw.execute("DELETE FROM records WHERE version = 2");
  EXPECT_THAT(database.integrity_errors("ice-steel"),
              testing::ElementsAre("version 2 is missing",
                                   "version 3 does not name the hash of the version before it"));
  raw.execute("UPDATE records SET json = '{' WHERE version = 1");
  EXPECT_THAT(database.integrity_errors("ice-steel").at(0), HasSubstr("ice-steel@1:1: JSON"));
}

TEST(MaterialDatabase, ExportAndImportAreExact) {
  const ScratchFolder folder("import");
  MaterialDatabase from(folder / "a.db", Access::write), to(folder / "b.db", Access::write);
  const std::vector<StoredRecord> all =
      from.add({published_record(), calibrated_record(), published_record("other")});
  std::vector<StoredRecord> turned = {all[1], all[2], all[0]};
  EXPECT_EQ(to.import(turned).size(), 3u);
  EXPECT_EQ(to.import(turned).size(), 0u);  // they are here
  for (const StoredRecord& s : all) {
    const StoredRecord back = to.find(s.record.name, s.record.version);
    EXPECT_EQ(back.sha256, s.sha256);
    EXPECT_EQ(canonical_text(back.record), canonical_text(s.record));
  }
  EXPECT_TRUE(to.integrity_errors("ice-steel").empty());
  // A history without its beginning, another content under the same name, a content not its own.
  MaterialDatabase third(folder / "c.db", Access::write);
  EXPECT_THAT(test::error_of([&] { third.import({all[1]}); }), HasSubstr("version 1 is not here"));
  MaterialRecord mine = published_record();
  mine.note = "mine";
  third.add({mine});
  EXPECT_THAT(test::error_of([&] { third.import({all[0]}); }), HasSubstr("another content"));
  EXPECT_THAT(test::error_of([&] { third.import({all[1]}); }), HasSubstr("does not supersede"));
  StoredRecord wrong = all[2];
  wrong.record.note = "changed on the way";
  EXPECT_THAT(test::error_of([&] { third.import({wrong}); }),
              HasSubstr("hash that the file gives"));
  // Shipped records come back in an export of everything.
  EXPECT_TRUE(third.import({third.find("paper-text")}).empty());
}

// ---- Many at once ----

TEST(MaterialDatabaseStress, EveryVersionOfManyWritersIsThereOnce) {
  const ScratchFolder folder("stress");
  constexpr int writers = 8, versions = 8;
  std::vector<pid_t> pids;
  for (int w = 0; w < writers; ++w)
    pids.push_back(in_process([&, w] {
      for (int i = 0; i < versions; ++i) {
        MaterialDatabase database(folder / "m.db", Access::write);  // the first makes the file
        MaterialRecord r = published_record();
        r.note = std::to_string(w) + "/" + std::to_string(i);
        if (database.add({r}).front().record.note != r.note) return 1;
        if (!database.integrity_errors("ice-steel").empty())
          return 2;  // checked while the others write
      }
      return 0;
    }));
  for (const pid_t pid : pids) EXPECT_EQ(wait_for(pid), 0);
  const MaterialDatabase database(folder / "m.db");
  EXPECT_TRUE(
      database.integrity_errors("ice-steel").empty());  // numbers without gaps, hashes linked
  std::set<std::string> notes;
  for (const StoredRecord& s : database.history("ice-steel")) notes.insert(s.record.note);
  EXPECT_EQ(database.history("ice-steel").size(), static_cast<std::size_t>(writers * versions));
  EXPECT_EQ(notes.size(), static_cast<std::size_t>(writers * versions));
}

TEST(MaterialDatabaseStress, AKilledWriterLosesNothingThatItConfirmed) {
  const ScratchFolder folder("killed");
  std::size_t confirmed = 0;
  for (int round = 0; round < 8; ++round) {
    int channel[2];
    ASSERT_EQ(pipe(channel), 0);
    const pid_t pid = in_process([&] {
      MaterialDatabase database(folder / "m.db", Access::write);
      for (;;) {
        database.add({published_record()});
        if (write(channel[1], "x", 1) != 1) return 1;
      }
    });
    close(channel[1]);
    char byte = 0;
    ASSERT_EQ(read(channel[0], &byte, 1), 1);  // it is at work
    ++confirmed;
    std::this_thread::sleep_for(std::chrono::microseconds(1700 * round));
    kill(pid, SIGKILL);
    EXPECT_EQ(wait_for(pid), 128 + SIGKILL);
    while (read(channel[0], &byte, 1) == 1) ++confirmed;
    close(channel[0]);
    const MaterialDatabase database(folder / "m.db");
    EXPECT_TRUE(database.integrity_errors("ice-steel").empty());
    const std::size_t kept = database.history("ice-steel").size();
    EXPECT_GE(kept, confirmed);
    // At most one unconfirmed version per round.
    EXPECT_LE(kept, confirmed + static_cast<std::size_t>(round) + 1);
  }
  sqlite::File raw(folder / "m.db", sqlite::File::Access::read);
  sqlite::Statement check(raw, "PRAGMA integrity_check");
  ASSERT_TRUE(check.next());
  EXPECT_EQ(check.text(0), "ok");
}

// A limit on the size of files stands for a disk that is full.
TEST(MaterialDatabase, AFullDiskIsReportedAndLosesNothing) {
  const ScratchFolder folder("full");
  MaterialDatabase(folder / "m.db", Access::write).add({published_record()});
  const pid_t pid = in_process([&] {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {128 * 1024, 128 * 1024};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) return 1;
    MaterialDatabase database(folder / "m.db", Access::write);
    try {
      for (int i = 0; i < 1000; ++i) database.add({published_record()});
    } catch (const RunError& e) {
      return std::string(e.what()).find("cannot write: File too large") == std::string::npos ? 2
                                                                                             : 0;
    }
    return 3;
  });
  EXPECT_EQ(wait_for(pid), 0);
  MaterialDatabase database(folder / "m.db", Access::write);
  EXPECT_TRUE(database.integrity_errors("ice-steel").empty());
  EXPECT_GT(database.history("ice-steel").size(), 1u);
  EXPECT_NO_THROW(database.add({published_record()}));
}

// The reader may not write there, and the folder has no log file of the database.
TEST(MaterialDatabase, AReadOnlyFolderCanBeRead) {
  const ScratchFolder folder("readonly");
  MaterialDatabase(folder / "m.db", Access::write).add({published_record()});
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0555));
  std::filesystem::permissions(folder / "m.db", std::filesystem::perms(0444));
  const pid_t pid = in_process([&] {
    if (geteuid() == 0 && setuid(65534) != 0) return 1;  // root may write everywhere
    if (MaterialDatabase(folder / "m.db").history("ice-steel").size() != 1) return 2;
    try {
      MaterialDatabase(folder / "m.db", Access::write).add({published_record()});
    } catch (const std::runtime_error& e) {
      return std::string(e.what()).find('\n') == std::string::npos ? 0 : 3;
    }
    return 4;
  });
  EXPECT_EQ(wait_for(pid), 0);
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0755));
}

// ---- Files of other kinds and times ----

TEST(MaterialDatabase, ForeignFilesAreRefusedAndLeftAlone) {
  const ScratchFolder folder("foreign");
  std::ofstream(folder / "text") << "this is no database, but long enough to be looked at as one";
  for (const Access access : {Access::read, Access::write})
    EXPECT_THAT(test::error_of([&] { MaterialDatabase(folder / "text", access); }),
                HasSubstr("expected"));
  {
    sqlite::File other(folder / "study.db", sqlite::File::Access::write);
    other.execute("CREATE TABLE runs (x)");
  }
  for (const Access access : {Access::read, Access::write})
    EXPECT_THAT(test::error_of([&] { MaterialDatabase(folder / "study.db", access); }),
                HasSubstr("is the database of something else"));
  EXPECT_THAT(test::error_of([&] { MaterialDatabase(folder.path().string(), Access::write); }),
              HasSubstr("expected"));
}

TEST(MaterialDatabase, ANewerSchemaIsRefused) {
  const ScratchFolder folder("newer");
  MaterialDatabase(folder / "m.db", Access::write).add({published_record()});
  {
    sqlite::File raw(folder / "m.db", sqlite::File::Access::write);
    raw.execute("PRAGMA user_version = 99");
  }
  for (const Access access : {Access::read, Access::write})
    EXPECT_THAT(test::error_of([&] { MaterialDatabase(folder / "m.db", access); }),
                HasSubstr("its schema is of version 99, of a newer Firn; this one reads up to 1"));
}

TEST(SqliteFile, MigrationsAreTakenInOrderOnceByTheFirstProcess) {
  const ScratchFolder folder("migrate");
  const char* const first[] = {"CREATE TABLE t (a INTEGER); INSERT INTO t VALUES (1), (2)"};
  const char* const both[] = {first[0],
                              "ALTER TABLE t ADD COLUMN b INTEGER; UPDATE t SET b = 10 * a"};
  {
    sqlite::File old(folder / "m.db", sqlite::File::Access::write);
    sqlite::migrate(old, first);
    EXPECT_EQ(sqlite::schema_version(old), 1);
  }
  std::vector<pid_t> pids;
  for (int i = 0; i < 4; ++i)
    pids.push_back(in_process([&] {
      sqlite::File file(folder / "m.db", sqlite::File::Access::write);
      sqlite::migrate(file, both);
      return sqlite::schema_version(file) == 2 ? 0 : 1;
    }));
  for (const pid_t pid : pids) EXPECT_EQ(wait_for(pid), 0);
  sqlite::File file(folder / "m.db", sqlite::File::Access::write);
  {
    sqlite::Statement sum(file, "SELECT sum(b), count(*) FROM t");
    ASSERT_TRUE(sum.next());
    EXPECT_EQ(sum.integer(0), 30);
    EXPECT_EQ(sum.integer(1), 2);
  }
  EXPECT_THAT(test::error_of([&] { sqlite::migrate(file, first); }), HasSubstr("of a newer Firn"));
}

// What a schema can do by itself: compute without end, or change what is written.
TEST(SqliteFile, OnlyTablesIndicesAndItsOwnTriggersAreTaken) {
  const std::pair<const char*, const char*> schemas[] = {
      {"CREATE TRIGGER t AFTER INSERT ON runs BEGIN DELETE FROM runs; END", "the trigger \"t\""},
      {"CREATE TRIGGER records_stay AFTER INSERT ON runs BEGIN SELECT (WITH RECURSIVE c(x) AS "
       "(SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT count(*) FROM c); END",
       "the trigger \"records_stay\""},
      {"CREATE VIEW v AS SELECT 1", "the view \"v\""},
      {"ALTER TABLE runs ADD COLUMN z GENERATED ALWAYS AS (hex(zeroblob(9)))",
       "the computed column \"runs.z\""}};
  for (const auto& [sql, said] : schemas) {
    const ScratchFolder folder("schema");
    {
      sqlite::File made(folder / "m.db", sqlite::File::Access::write);
      made.execute("CREATE TABLE runs (x)");
      made.execute(sql);
    }
    for (const auto access : {sqlite::File::Access::read, sqlite::File::Access::write})
      EXPECT_THAT(test::error_of([&] { sqlite::File(folder / "m.db", access); }),
                  HasSubstr(std::string("has ") + said + ", which Firn does not make"));
  }
}

TEST(SqliteFile, LongRowsAreRefused) {
  const ScratchFolder folder("long");
  sqlite::File file(folder / "m.db", sqlite::File::Access::write);
  EXPECT_THAT(test::error_of([&] { sqlite::Statement(file, "SELECT zeroblob(300000000)").next(); }),
              HasSubstr("holds more than 268435456 bytes in one row"));
}

TEST(SqliteFile, AMigrationThatFailsLeavesTheFileAsItWas) {
  const ScratchFolder folder("failing");
  const char* const steps[] = {"CREATE TABLE t (a)", "CREATE TABLE u (a); no SQL at all"};
  sqlite::File file(folder / "m.db", sqlite::File::Access::write);
  EXPECT_THROW(sqlite::migrate(file, steps), RunError);
  EXPECT_EQ(sqlite::schema_version(file), 0);
  sqlite::Statement tables(file, "SELECT count(*) FROM sqlite_master");
  ASSERT_TRUE(tables.next());
  EXPECT_EQ(tables.integer(0), 0);
}

TEST(MaterialDatabase, WhereItLies) {
  setenv("FIRN_MATERIALS", "/a/m.db", 1);
  EXPECT_EQ(material_database_file("b.db"), "b.db");
  EXPECT_EQ(material_database_file(), "/a/m.db");
  unsetenv("FIRN_MATERIALS");
  setenv("XDG_DATA_HOME", "/data", 1);
  EXPECT_EQ(material_database_file(), "/data/firn/materials.db");
  unsetenv("XDG_DATA_HOME");
  setenv("HOME", "/home/x", 1);
  EXPECT_EQ(material_database_file(), "/home/x/.local/share/firn/materials.db");
}

}  // namespace
}  // namespace firn
