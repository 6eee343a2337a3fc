#include "experiments/material_records/material_database.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <set>

#include "experiments/material_records/embedded_materials.h"
#include "experiments/material_records/material_json.h"
#include "experiments/storage/sqlite_file.h"
#include "experiments/system/output_file.h"
#include "experiments/text/suggestions.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

// Step i brings a file from schema version i to i + 1. Steps are never changed, only added.
const std::string first_step = std::string(R"(
PRAGMA application_id = 1179210308;  -- "FIRD"
CREATE TABLE records (
  name TEXT NOT NULL,
  version INTEGER NOT NULL CHECK (version >= 1),
  sha256 TEXT NOT NULL,  -- of json
  json TEXT NOT NULL,    -- the whole record, in its canonical spelling
  PRIMARY KEY (name, version)) WITHOUT ROWID;
)") + std::string(sqlite::record_triggers);
const char* const steps[] = {first_step.c_str()};
constexpr std::int64_t application_id = 1179210308;

std::int64_t number(sqlite::File& db, const char* sql) {
  sqlite::Statement statement(db, sql);
  return statement.next() ? statement.integer(0) : 0;
}

void require_ours(sqlite::File& db) {
  const bool empty = number(db, "SELECT count(*) FROM sqlite_master") == 0;
  if (!empty && number(db, "PRAGMA application_id") != application_id)
    throw InputError(fmt::format(
        "{}: is the database of something else; expected one of material records, or a new file",
        db.name()));
}

const StoredRecord* find_in(const std::vector<StoredRecord>& all, int version) {
  if (version == 0) return all.empty() ? nullptr : &all.back();
  const auto it =
      std::ranges::find_if(all, [&](const StoredRecord& s) { return s.record.version == version; });
  return it == all.end() ? nullptr : &*it;
}

}  // namespace

struct MaterialDatabase::Impl {
  explicit Impl(const std::string& file, sqlite::File::Access access) : db(file, access) {}
  mutable sqlite::File db;

  std::vector<StoredRecord> versions(const std::string& name) const {
    std::vector<StoredRecord> all;
    sqlite::Statement row(db,
                          "SELECT version, sha256, json FROM records WHERE name = ? "
                          "ORDER BY version");
    row.bind(name);
    while (row.next()) {
      const std::string source = fmt::format("{}: {}@{}", db.name(), name, row.integer(0));
      all.push_back({read_canonical(row.text(2), source), row.text(1), false});
    }
    return all;
  }

  void insert(const StoredRecord& s) {
    sqlite::Statement(db, "INSERT INTO records (name, version, sha256, json) VALUES (?, ?, ?, ?)")
        .bind(s.record.name)
        .bind(std::int64_t{s.record.version})
        .bind(s.sha256)
        .bind(canonical_text(s.record))
        .next();
  }
};

std::string material_database_file(const std::string& option) {
  if (!option.empty()) return option;
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::string(value == nullptr ? "" : value);
  };
  if (const std::string named = variable("FIRN_MATERIALS"); !named.empty()) return named;
  if (const std::string data = variable("XDG_DATA_HOME"); !data.empty())
    return (fs::path(data) / "firn" / "materials.db").string();
  const std::string home = variable("HOME");
  return home.empty() ? "" : (fs::path(home) / ".local/share/firn/materials.db").string();
}

const std::vector<StoredRecord>& shipped_materials() {
  static const std::vector<StoredRecord> all = [] {
    std::vector<StoredRecord> records;
    for (const auto& [file, text] : embedded_materials())
      for (const ReadRecord& r : read_records_text(text, std::string(file)))
        records.push_back({r.record, r.sha256, true});
    std::ranges::sort(records, {}, [](const StoredRecord& s) {
      return std::pair(s.record.name, s.record.version);
    });
    return records;
  }();
  return all;
}

MaterialDatabase::MaterialDatabase(const std::string& file, Access access) : file_(file) {
  std::error_code unreadable;  // as a name that is too long
  if (access == Access::read && (file.empty() || !fs::exists(file, unreadable))) return;
  if (file.empty())
    throw InputError(
        "materials: there is no home folder to keep them in; expected --database FILE or "
        "$FIRN_MATERIALS");
  try {
    impl_ = std::make_unique<Impl>(
        file, access == Access::write ? sqlite::File::Access::write : sqlite::File::Access::read);
    require_ours(impl_->db);
    if (access == Access::read) {
      const int version = sqlite::schema_version(impl_->db);
      if (version == 0) {  // a writer has created the file but not yet its tables
        impl_.reset();
        return;
      }
      if (version < static_cast<int>(std::size(steps))) {
        impl_.reset();
        impl_ = std::make_unique<Impl>(file, sqlite::File::Access::write);
      }
    }
    sqlite::migrate(impl_->db, steps);
  } catch (const WriteError&) {
    throw;
  } catch (const RunError& e) {
    throw InputError(fmt::format("{}; expected a database of material records", e.what()));
  }
}

MaterialDatabase::~MaterialDatabase() = default;

std::vector<std::string> MaterialDatabase::names() const {
  std::set<std::string> all;
  for (const StoredRecord& s : shipped_materials()) all.insert(s.record.name);
  if (impl_) {
    sqlite::Statement row(impl_->db, "SELECT DISTINCT name FROM records");
    while (row.next()) all.insert(row.text(0));
  }
  return {all.begin(), all.end()};
}

std::vector<StoredRecord> MaterialDatabase::known(const std::string& name) const {
  std::vector<StoredRecord> all;
  for (const StoredRecord& s : shipped_materials())
    if (s.record.name == name) all.push_back(s);
  if (all.empty() && impl_) all = impl_->versions(name);
  return all;
}

std::vector<StoredRecord> MaterialDatabase::history(const std::string& name) const {
  std::vector<StoredRecord> all = known(name);
  if (!all.empty()) return all;
  const std::vector<std::string> others = names();
  throw InputError(fmt::format("material {}: unknown (looked in {}); {}", name,
                               impl_ ? file_ + " and what ships with Firn" : "what ships with Firn",
                               suggestion(name, {others.begin(), others.end()})));
}

StoredRecord MaterialDatabase::find(const std::string& name, int version) const {
  const std::vector<StoredRecord> all = history(name);
  if (const StoredRecord* found = find_in(all, version)) return *found;
  throw InputError(fmt::format("material {}@{}: no such version; the newest is {}", name, version,
                               all.back().record.version));
}

void MaterialDatabase::require_writable_name(const std::string& name) const {
  if (parse_material_choice(name).name != name)
    throw InputError(fmt::format(
        "material {}: is more than a name; expected one without @ and #, which come by themselves",
        name));
  for (const StoredRecord& s : shipped_materials())
    if (s.record.name == name)
      throw InputError(fmt::format(
          "material {}: is a record that ships with Firn; expected another name", name));
}

std::vector<StoredRecord> MaterialDatabase::add(const std::vector<MaterialRecord>& records) {
  for (const MaterialRecord& record : records) {
    check(record);
    require_writable_name(record.name);
  }
  std::vector<StoredRecord> written;
  sqlite::Transaction transaction(impl_->db);
  for (MaterialRecord record : records) {
    const std::vector<StoredRecord> before = impl_->versions(record.name);
    record.version = before.empty() ? 1 : before.back().record.version + 1;
    record.supersedes = before.empty() ? "" : before.back().sha256;
    written.push_back({record, record_hash(record), false});
    impl_->insert(written.back());
  }
  transaction.commit();
  return written;
}

std::vector<StoredRecord> MaterialDatabase::import(std::vector<StoredRecord> records) {
  std::ranges::stable_sort(records, {}, [](const StoredRecord& s) {
    return std::pair(s.record.name, s.record.version);
  });
  std::vector<StoredRecord> written;
  sqlite::Transaction transaction(impl_->db);
  for (const StoredRecord& s : records) {
    const MaterialRecord& r = s.record;
    check(r);
    const std::string place = "material " + r.reference();
    if (r.version < 1)
      throw InputError(place + ": has no version; expected an exported record, or `add`");
    if (record_hash(r) != s.sha256)
      throw InputError(
          fmt::format("{}: its content does not have the hash that the file gives; expected the "
                      "record as it was exported",
                      place));
    const std::vector<StoredRecord> here = known(r.name);
    if (const StoredRecord* same = find_in(here, r.version)) {
      if (same->sha256 == s.sha256) continue;
      throw InputError(fmt::format(
          "{}: is here already with another content; expected another name for one of them",
          place));
    }
    require_writable_name(r.name);
    const StoredRecord* previous = r.version == 1 ? nullptr : find_in(here, r.version - 1);
    if (r.version > 1 && previous == nullptr)
      throw InputError(fmt::format(
          "{}: version {} is not here; expected the export of all versions", place, r.version - 1));
    if (r.supersedes != (previous == nullptr ? "" : previous->sha256))
      throw InputError(fmt::format(
          "{}: does not supersede the version before it; expected the export of one database",
          place));
    impl_->insert(s);
    written.push_back(s);
  }
  transaction.commit();
  return written;
}

std::vector<std::string> MaterialDatabase::integrity_errors(const std::string& name) const {
  std::vector<StoredRecord> all;
  try {
    all = known(name);
  } catch (const InputError& e) {
    return {e.what()};
  }
  std::vector<std::string> found;
  std::string previous;
  int expected = 1;
  for (const StoredRecord& s : all) {
    const std::string reference = fmt::format("version {}", s.record.version);
    if (s.record.name != name)
      found.push_back(fmt::format("{} says that its name is {}", reference, s.record.name));
    if (s.record.version != expected)
      found.push_back(fmt::format("version {} is missing", expected));
    if (record_hash(s.record) != s.sha256)
      found.push_back(fmt::format("{} does not have the hash noted with it", reference));
    if (s.record.supersedes != previous)
      found.push_back(fmt::format("{} does not name the hash of the version before it", reference));
    previous = s.sha256;
    expected = s.record.version + 1;
  }
  return found;
}

}  // namespace firn
