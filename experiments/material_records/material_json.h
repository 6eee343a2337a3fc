// Material records as JSON, there and back without a bit lost. The layout is in
// data/materials/record.schema.json and docs/materials.md.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/material_records/material_record.h"

namespace firn {

// Everything but the hash, in the order in which people read it.
nlohmann::ordered_json to_json(const MaterialRecord& record);

// The content in the names of format 1, as one line of JSON with sorted keys, no spaces and the
// shortest numbers that read back to the same bits (as Python's json.dumps(x, sort_keys=True,
// separators=(",", ":"), ensure_ascii=False) spells them), and the SHA-256 of that line: the
// record's identity.
std::string canonical_text(const MaterialRecord& record);
std::string record_hash(const MaterialRecord& record);

// {"format": "firn material records", "format_version": 2, "records": [...]}, each record with its
// hash as "sha256". Format 1 has other names for some keys; it is read as well.
std::string export_text(const std::vector<MaterialRecord>& records);

struct ReadRecord {
  MaterialRecord record;  // checked
  std::string sha256;     // as the file gives it; empty: it does not
};
// Throws InputError with one line `SOURCE:LINE: JSON: ...` or `SOURCE: PATH: what is wrong; what is
// expected`, PATH being "records.0.parameters.2.unit".
std::vector<ReadRecord> read_records_text(std::string_view text, const std::string& source);
std::vector<ReadRecord> read_records_file(const std::string& file);

// One record as canonical_text() gave it; `source` names it in messages.
MaterialRecord read_canonical(std::string_view text, const std::string& source);

// A document in the spelling of the above: indented, arrays of numbers and words on one line.
std::string pretty_json(const nlohmann::ordered_json& json);

}  // namespace firn
