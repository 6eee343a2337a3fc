// The store of material records: those that ship with Firn, and a file of the user's own.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "experiments/material_records/material_record.h"

namespace firn {

// The file that an option names, else $FIRN_MATERIALS, else materials.db in $XDG_DATA_HOME/firn or
// ~/.local/share/firn. Empty when there is no home either.
std::string material_database_file(const std::string& option = {});

// A record as it is kept.
struct StoredRecord {
  MaterialRecord record;
  std::string sha256;  // as noted when it was written
  bool shipped = false;
};

// Records are never changed and never leave. A name has versions 1, 2, ...; each names the hash of
// the one before. Names of shipped records are taken: no file can add to them. Any number of
// processes may read and write at once.
class MaterialDatabase {
 public:
  enum class Access { read, write };
  // For reading, a file that does not exist holds nothing; it is made by the first writing. Throws
  // InputError for a file that is something else, or of a newer Firn.
  explicit MaterialDatabase(const std::string& file, Access access = Access::read);
  ~MaterialDatabase();
  MaterialDatabase(const MaterialDatabase&) = delete;
  MaterialDatabase& operator=(const MaterialDatabase&) = delete;

  const std::string& file() const { return file_; }
  std::vector<std::string> names() const;  // sorted
  // All versions, oldest first. Throws InputError for an unknown name, naming the nearest.
  std::vector<StoredRecord> history(const std::string& name) const;
  // That version, or the newest. Throws InputError.
  StoredRecord find(const std::string& name, int version = 0) const;

  // Throws InputError for a name that nothing can be added to, before any work is done.
  void require_free(const std::string& name) const;
  // Checks them, makes each the next version of its name, and returns what was written: all of
  // them, on the disk when this returns, or none. Throws InputError, and RunError when the disk is
  // full.
  std::vector<StoredRecord> add(const std::vector<MaterialRecord>& records);
  // Takes records as they were exported, with version and hash, all or none, and returns those that
  // were not here yet.
  std::vector<StoredRecord> import(std::vector<StoredRecord> records);

  // What is wrong with the records of a name that there is, one sentence each: content that cannot
  // be read or does not have its hash, a version that is missing or does not name the one before.
  std::vector<std::string> faults(const std::string& name) const;

 private:
  std::vector<StoredRecord> known(const std::string& name) const;  // none: not known

  struct Impl;
  std::string file_;
  std::unique_ptr<Impl> impl_;
};

// The shipped records, checked against their hashes when the program is tested.
const std::vector<StoredRecord>& shipped_materials();

}  // namespace firn
