// Material records as JSON, written and read without loss of bits. Layout:
// data/materials/record.schema.json and docs/materials.md.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/material_records/material_record.h"

namespace firn {

// The record without its hash, with keys in the order of the documentation.
nlohmann::ordered_json to_json(const MaterialRecord& record);

// The record with the names of format 1 as one line of JSON with sorted keys, no spaces and the
// shortest numbers that read back to the same bits, equal to the output of Python's json.dumps(x,
// sort_keys=True, separators=(",", ":"), ensure_ascii=False). record_hash(): SHA-256 of that line,
// the identity of the record.
std::string canonical_text(const MaterialRecord& record);
std::string record_hash(const MaterialRecord& record);

// {"format": "firn material records", "format_version": 2, "records": [...]}, each record with its
// hash as "sha256". Format 1, which has other names for some keys, is read as well.
std::string export_text(const std::vector<MaterialRecord>& records);

struct ReadRecord {
  MaterialRecord record;  // checked
  std::string sha256;     // as stated in the file; empty: not stated
};
// Throws InputError with one line `SOURCE:LINE: JSON: ...` or `SOURCE: PATH: FAULT; EXPECTATION`,
// with a PATH such as "records.0.parameters.2.unit".
std::vector<ReadRecord> read_records_text(std::string_view text, const std::string& source);
std::vector<ReadRecord> read_records_file(const std::string& file);

// Reads one record from canonical_text(). `source`: name in messages.
MaterialRecord read_canonical(std::string_view text, const std::string& source);

// Indented JSON text with arrays of numbers and of words on one line.
std::string pretty_json(const nlohmann::ordered_json& json);

}  // namespace firn
