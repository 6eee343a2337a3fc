// Schema of results files: all objects with their types, shapes and ranges. The table in
// docs/results.md is generated from it. Every file is checked against it when it is opened.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/storage/hdf5_file.h"

namespace firn::results {

// Attribute `format_version` of the files that this version writes. Files of format 1 lack it and
// have other names.
inline constexpr std::uint64_t kFormat = 2;

// Limit of the magnitude of numbers, so that products are finite.
inline constexpr double kLargestNumber = 1e30;

// Range of the values of a dataset or attribute.
enum class Rule {
  any,
  finite,
  positive,
  non_negative,
  finite_or_nan,
  non_negative_or_nan,
  vector_or_nan,    // along the last dimension: all NaN or all finite
  rotation,         // unit quaternions
  rotation_or_nan,  // the same, or all four NaN
  ascending,        // non-negative, not decreasing
  counting,         // 0, 1, 2, ...
  flag,             // 0 or 1
  batch,            // -1 or more
  index,            // 0 to the limit, exclusive
  index_or_none,    // the same, or -1
  body,             // number of a particle, or -1 - number of a boundary
  body_or_nan,
  choice,  // one of the texts, optionally followed by ": " and other text
};

// Condition for the existence of an object.
enum class Presence {
  always,    // required
  newer,     // written by this version; may be missing in files of earlier ones
  together,  // exists if and only if `with` exists
  optional,  // may exist if `with` exists
};

// A dataset. A word in angle brackets in a path stands for a name. A shape is a list of numbers and
// of symbols of symbols(); empty: a scalar; "k": a scalar or a list.
struct Dataset {
  std::string_view path;
  Presence presence;
  std::string_view with;  // path of the same schema
  hdf5::Type type;
  std::string_view shape;
  std::string_view unit;  // required value of the attribute `unit`; empty: any
  Rule rule;
  std::string_view limit;  // symbol of an index; texts of a choice, separated by '|'
  std::string_view meaning;
  std::string_view first_name = {};  // path in files of format 1; empty: the same
};

struct Attribute {
  std::string_view object, name;
  Presence presence;
  hdf5::Type type;
  std::string_view shape;  // empty: a scalar; "k": the shape of the dataset
  Rule rule;
  std::string_view limit;
  std::string_view meaning;
  std::string_view first_name = {};  // see Dataset
};

// A length that several datasets share, defined by the dimension with its name in the dataset
// `anchor`.
struct Symbol {
  std::string_view name, anchor;
  bool grows;  // grows with the run; values are checked when they are read
  std::string_view meaning;
};

std::span<const Dataset> datasets();
std::span<const Attribute> attributes();
std::span<const Symbol> symbols();

// Contents of a file that satisfies the schema.
struct Contents {
  bool finished = false;
  std::map<std::string, const Dataset*, std::less<>> datasets;  // of the schema, by path
  std::map<std::string, hdf5::Shape, std::less<>> shapes;
  std::size_t particles = 0;
  std::size_t frames = 0;  // complete frames
  // Valid rows of the datasets with this first symbol: T and others that grow with the run.
  std::map<std::string, std::size_t, std::less<>> rows;
  std::map<std::string, std::size_t, std::less<>> lengths;  // of the other symbols

  // Number of valid rows of a dataset that grows; a killed writer can leave more. Nothing for other
  // datasets.
  std::optional<std::size_t> growing_rows(std::string_view path) const;
};

// Opens a file of any format with the names of this version. Throws hdf5::Error.
hdf5::File open_file(const std::string& path, hdf5::File::Access access);
// The path in this version for a path of format 1; unchanged if it was not renamed.
std::string current_path(const std::string& path);

// Throws hdf5::Error "PATH: FAULT; EXPECTATION". Reads all values except those that grow with the
// run. Unknown objects are not read.
Contents check_file(const hdf5::File& file);

// Checks rows of a dataset that grows with the run, from the row `first` on. Throws hdf5::Error.
void check_values(const Contents& contents, const std::string& path, std::span<const double> values,
                  std::size_t first);

// Checks that the file matches the case: numbers of particles, shapes, sensors, outlets, bonds and
// boundaries, and sizes of rows. Throws hdf5::Error.
void check_case(const Contents& contents, const hdf5::File& file, const Case& c);

// The schema as Markdown, for docs/results.md.
std::string description();

}  // namespace firn::results
