// Limits on input files of the user, checked before they are parsed. Table: docs/case-files.md.
#pragma once

#include <cstddef>
#include <cstdint>

namespace firn::input_limits {

constexpr std::uintmax_t kMiB = std::uintmax_t{1} << 20;

// Size of a file, bytes.
constexpr std::uintmax_t toml_bytes = 128 * kMiB;  // a resolved case contains its meshes
constexpr std::uintmax_t json_bytes = 64 * kMiB;
constexpr std::uintmax_t csv_bytes = 64 * kMiB;
constexpr std::uintmax_t svg_bytes = 64 * kMiB;
constexpr std::uintmax_t raw_data_bytes = 4096 * kMiB;  // files that are hashed only

// Photographs.
constexpr std::uintmax_t photo_bytes = 128 * kMiB;
constexpr std::uint64_t photo_pixels = 64'000'000;  // of one photograph

// TOML.
constexpr int toml_key_parts = 32;              // parts of a dotted key or of a path of --set
constexpr int toml_depth = 32;                  // nesting of arrays and inline tables
constexpr std::size_t toml_tables = 200'000;    // of one file
constexpr std::size_t list_tables = 10'000;     // of one list, such as [[stages]]
constexpr std::size_t placed_tables = 100'000;  // [[particles]]
constexpr std::size_t bonded_pairs = 100'000;   // of one list of pairs or tags
constexpr int included_files = 100;             // by one file, directly and indirectly
constexpr std::size_t materials = 200;
constexpr std::size_t shapes = 2000;
constexpr std::size_t interactions = 20'000;
constexpr std::size_t boundary_contacts = 1000;
constexpr std::size_t couplings = 1000;

// JSON.
constexpr int json_depth = 64;             // nesting of arrays and objects
constexpr std::size_t json_keys = 10'000;  // of one object

// CSV.
constexpr std::size_t csv_rows = 1'000'000;
constexpr std::size_t csv_fields = 1000;  // of one row

// SQLite: size of a row, which may contain a resolved case.
constexpr std::uintmax_t sqlite_row_bytes = 256 * kMiB;

// Runs of a study, a sweep or a validation.
constexpr std::int64_t batch_runs = 100'000;

}  // namespace firn::input_limits
