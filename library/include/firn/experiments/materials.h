// Material records: parameters of materials with their sources. docs/materials.md describes them.
#pragma once

#include <string>
#include <vector>

namespace firn::experiments {

struct MaterialRecord {
  std::string name;
  int version = 1;
  std::string sha256;    // of the content
  bool shipped = false;  // part of Firn; else of the database
  std::string json;      // the record, layout in data/materials/record.schema.json
};

// All versions of all records, by name and version. `database`: a file as `firn materials
// --database` takes it; empty: the user's own. Throws InputError.
std::vector<MaterialRecord> material_records(const std::string& database = "");

}  // namespace firn::experiments
