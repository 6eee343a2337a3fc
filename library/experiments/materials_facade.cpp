#include "experiments/material_records/material_database.h"
#include "experiments/material_records/material_json.h"
#include "firn/experiments/materials.h"

namespace firn::experiments {

std::vector<MaterialRecord> material_records(const std::string& database) {
  const MaterialDatabase records(material_database_file(database));
  std::vector<MaterialRecord> all;
  for (const std::string& name : records.names())
    for (const StoredRecord& stored : records.history(name))
      all.push_back({name, stored.record.version, stored.sha256, stored.shipped,
                     to_json(stored.record).dump()});
  return all;
}

}  // namespace firn::experiments
