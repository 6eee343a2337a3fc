// What a results file holds: every object once, with all that readers rely on. The table in
// docs/results.md is made from it, and every file is checked against it when it is opened.
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

// Of the files that this version writes: their attribute `format_version`. Files of format 1 lack
// it and have other names.
inline constexpr std::uint64_t kFormat = 2;

// Values of numbers are below this in magnitude: their products are finite, too.
inline constexpr double kLargestNumber = 1e30;

enum class Rule {
  any,
  finite,
  positive,
  non_negative,
  finite_or_nan,
  non_negative_or_nan,
  vector_or_nan,    // the last dimension is one vector: all of it NaN, or nothing
  rotation,         // four values: a unit quaternion
  rotation_or_nan,  // or all four NaN
  ascending,        // from 0 or more, no value below the one before
  counting,         // 0, 1, 2, ...
  flag,             // 0 or 1
  batch,            // -1 or more
  index,            // 0 to the limit, exclusive
  index_or_none,    // the same, or -1
  body,             // a particle, or -1 - the number of a boundary
  body_or_nan,
  choice,  // one of the texts, or one of them followed by ": " and more
};

enum class Presence {
  always,    // a file without it is refused
  newer,     // written always now; older builds did not
  together,  // there exactly when `with` is there
  optional,  // may be there when `with` is there
};

// A dataset. In a path, a word in angle brackets stands for a name. A shape is a list of numbers
// and of symbols of `symbols()`; empty: a scalar; "k": a scalar or a list.
struct Dataset {
  std::string_view path;
  Presence presence;
  std::string_view with;  // path of the same schema
  hdf5::Type type;
  std::string_view shape;
  std::string_view unit;  // of the attribute `unit`; empty: not checked
  Rule rule;
  std::string_view limit;  // symbol of an index; texts of a choice, separated by '|'
  std::string_view meaning;
  std::string_view first_name = {};  // path in files of format 1; empty: the same
};

struct Attribute {
  std::string_view object, name;
  Presence presence;
  hdf5::Type type;
  std::string_view shape;  // empty: a scalar; "k": as the dataset
  Rule rule;
  std::string_view limit;
  std::string_view meaning;
  std::string_view first_name = {};  // as of a dataset
};

// A length that several datasets share: that of the dimension in `anchor` that has its name.
struct Symbol {
  std::string_view name, anchor;
  bool grows;  // with the run: values are checked when they are read
  std::string_view meaning;
};

std::span<const Dataset> datasets();
std::span<const Attribute> attributes();
std::span<const Symbol> symbols();

// Of a file that keeps to the schema.
struct Contents {
  bool finished = false;
  std::map<std::string, const Dataset*, std::less<>> datasets;  // of the schema, by path
  std::map<std::string, hdf5::Shape, std::less<>> shapes;
  std::size_t particles = 0;
  std::size_t frames = 0;  // that are whole
  // Rows that count of the datasets with this first symbol, T and others that grow.
  std::map<std::string, std::size_t, std::less<>> rows;
  std::map<std::string, std::size_t, std::less<>> lengths;  // of the other symbols

  // Rows of a dataset that grows which count; those beyond are what a killed writer left.
  std::optional<std::size_t> growing_rows(std::string_view path) const;
};

// Opens a file under the names of this version, of any format. Throws hdf5::Error.
hdf5::File open_file(const std::string& path, hdf5::File::Access access);
// The path in this version for one of format 1; `path` itself when it has no other.
std::string current_path(const std::string& path);

// Throws hdf5::Error, "PATH: what is wrong; what is expected". Reads all values but those that grow
// with the run. Unknown objects are not looked at beyond their place.
Contents check_file(const hdf5::File& file);

// That rows of a dataset which grows are what the schema says, `first` being the first of them.
void check_values(const Contents& contents, const std::string& path, std::span<const double> values,
                  std::size_t first);

// That the file belongs to the case: as many particles, shapes, sensors, outlets, bonds,
// boundaries, and rows of the same size. Throws hdf5::Error.
void check_case(const Contents& contents, const hdf5::File& file, const Case& c);

// All of it in Markdown, for docs/results.md.
std::string description();

}  // namespace firn::results
