// What `firn materials` prints: for people, and of two records the difference for both.
#pragma once

#include <string>
#include <vector>

#include "app/output/response_output.h"
#include "experiments/material_records/material_database.h"

namespace firn {

std::string records_table(const std::vector<StoredRecord>& records);
Json records_json(const std::vector<StoredRecord>& records);  // a line's worth of each

std::string record_text(const StoredRecord& stored);
Json record_json(const StoredRecord& stored);  // all of it, as exported

// One value that differs. Elements of arrays go by their names.
struct RecordChange {
  std::string path;
  Json from, to;  // null: not there
};
std::vector<RecordChange> changes(const MaterialRecord& from, const MaterialRecord& to);
std::string changes_table(const std::vector<RecordChange>& all);
Json changes_json(const std::vector<RecordChange>& all);

}  // namespace firn
