// Database of material records: those shipped with Firn, and a file of the user.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "experiments/material_records/material_record.h"

namespace firn {

// Path of the database file: `option`, else $FIRN_MATERIALS, else materials.db in
// $XDG_DATA_HOME/firn or ~/.local/share/firn. Empty without a home folder.
std::string material_database_file(const std::string& option = {});

// A record of the database.
struct StoredRecord {
  MaterialRecord record;
  std::string sha256;  // as recorded when it was written
  bool shipped = false;
};

// Records cannot be changed or removed. A name has versions 1, 2, ...; each version states the hash
// of the previous one. Versions cannot be added to names of shipped records. Concurrent processes
// may read and write.
class MaterialDatabase {
 public:
  enum class Access { read, write };
  // A missing file is empty for reading and is created for writing. Throws InputError for a file
  // that is not such a database, or of a newer version of Firn.
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

  // Throws InputError for a name to which no version can be added.
  void require_writable_name(const std::string& name) const;
  // Checks the records, writes each as the next version of its name, and returns them as written.
  // All or none are written; they are on the disk on return. Throws InputError, and WriteError when
  // the disk is full.
  std::vector<StoredRecord> add(const std::vector<MaterialRecord>& records);
  // Adds exported records with their version and hash, all or none. Returns those that are new.
  std::vector<StoredRecord> import(std::vector<StoredRecord> records);

  // Integrity errors of all versions of a name, one sentence each: unreadable content, wrong hash,
  // missing version, wrong hash of the previous version.
  std::vector<std::string> integrity_errors(const std::string& name) const;

 private:
  std::vector<StoredRecord> known(const std::string& name) const;  // none: not known

  struct Impl;
  std::string file_;
  std::unique_ptr<Impl> impl_;
};

// The shipped records. A test of the program compares their hashes.
const std::vector<StoredRecord>& shipped_materials();

}  // namespace firn
