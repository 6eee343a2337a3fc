// Files and cases against the schema.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <optional>

#include "experiments/results/results_schema.h"
#include "experiments/results/results_writer.h"
#include "experiments/results/schema_paths.h"
#include "experiments/results/value_rules.h"

namespace firn::results {
namespace {

using hdf5::Error;
using hdf5::Shape;
using hdf5::Type;
using enum Presence;
using R = Rule;

// Of meshes, in each group that has one.
constexpr std::string_view kMeshSymbols[][2] = {{"V", "vertices"}, {"P", "triangles"}};

// The symbol whose rows a dataset has, when they grow.
const Symbol* growing(const Dataset& d) {
  const Symbol* first =
      symbol_of(split_list(d.shape, ',').empty() ? "" : split_list(d.shape, ',')[0]);
  return first && first->grows ? first : nullptr;
}

bool is_number(Type type) { return type == Type::real || type == Type::integer; }

std::string type_name(Type type) {
  switch (type) {
    case Type::real:
      return "numbers of 64 bits (floating point)";
    case Type::integer:
      return "whole numbers of 32 bits";
    case Type::natural:
      return "whole numbers of 64 bits without sign";
    case Type::byte:
      return "bytes";
    case Type::text:
      return "text";
    case Type::other:
      break;
  }
  return "another type";
}

std::string shape_text(const Shape& shape) {
  return shape.empty() ? "a scalar" : fmt::format("[{}]", fmt::join(shape, ", "));
}

std::string symbols_text(std::string_view shape) {
  if (shape.empty()) return "a scalar";
  if (shape == "k") return "a scalar or a list";
  return fmt::format("[{}]", fmt::join(split_list(shape, ','), ", "));
}

[[noreturn]] void refuse(std::string_view path, const std::string& what) {
  throw Error(fmt::format("{}: {}", path, what));
}

// Looks at a file part after part; each may rely on those before it.
class Check {
 public:
  explicit Check(const hdf5::File& file) : file_(file) {}

  Contents all() {
    if (!file_.has_attribute("/", "firn_version"))
      throw Error("no attribute firn_version; expected a file written by firn run");
    find_datasets();
    check_presence();
    check_attributes("/", "/", {});
    check_format();
    contents_.finished = file_.text_attribute("/", "status") == "finished";
    for (const Found& found : found_) check_kind(found);
    find_lengths();
    for (const Found& found : found_) check_shape(found);
    for (const Found& found : found_) check_storage(found);
    for (const Found& found : found_) check_attributes_of(found);
    for (const Found& found : found_)
      if (!growing(*found.dataset)) check_contents(found);
    cut_back();
    return std::move(contents_);
  }

 private:
  void check_format() const {
    if (!file_.has_attribute("/", "format_version")) return;
    if (const auto format = file_.integer_attribute("/", "format_version"); format != kFormat)
      refuse("/",
             fmt::format("is of format {}; expected {} or no format_version", format, kFormat));
  }

  struct Found {
    const Dataset* dataset;
    const hdf5::Object* object;
    std::string name;  // the part of the path that the schema leaves open
  };

  void find_datasets() {
    objects_ = file_.objects();
    for (const hdf5::Object& object : objects_) {
      for (const Dataset& d : datasets()) {
        const std::optional<std::string> name = Pattern(d.path).name_in(object.path);
        // A group may be on the way to a dataset whose name has a slash.
        if (!name || (object.is_group && Pattern(d.path).open)) continue;
        if (object.is_group) refuse(object.path, "is a group; expected a dataset");
        if (d.path == "/states/<step>" &&
            name->find_first_not_of("0123456789") != std::string::npos)
          refuse(object.path, "is not a number of a step; expected digits");
        found_.push_back({&d, &object, *name});
        contents_.datasets.emplace(object.path, &d);
        contents_.shapes.emplace(object.path, object.shape);
        break;
      }
    }
  }

  bool has(const std::string& path) const { return contents_.datasets.contains(path); }

  void check_presence() const {
    for (const Dataset& d : datasets())
      if (d.presence == always && !has(std::string(d.path)))
        refuse(d.path, fmt::format("is missing; expected {}", type_name(d.type)));
    for (const Found& found : found_) {
      const std::string with = Pattern(found.dataset->with).with(found.name);
      if (!with.empty() && !has(with))
        refuse(found.object->path, fmt::format("is there without {}; expected both", with));
      for (const Dataset& other : datasets()) {
        if (other.presence != together || other.with != found.dataset->path) continue;
        const std::string path = Pattern(other.path).with(found.name);
        if (!has(path))
          refuse(path, fmt::format("is missing; expected it together with {}", found.object->path));
      }
    }
  }

  static void check_kind(const Found& found) {
    const hdf5::Object& o = *found.object;
    const Dataset& d = *found.dataset;
    if (o.type != d.type)
      refuse(o.path, fmt::format("holds {}; expected {}", type_name(o.type), type_name(d.type)));
    if (!o.has_space)
      refuse(o.path, fmt::format("has no values and no shape; expected {}", symbols_text(d.shape)));
    const std::size_t rank = split_list(d.shape, ',').size();
    if (d.shape == "k" ? o.shape.size() > 1 : o.shape.size() != rank)
      refuse(o.path, fmt::format("has the wrong shape, {}; expected {}", shape_text(o.shape),
                                 symbols_text(d.shape)));
  }

  static std::string group_of(const std::string& path) {
    return path.substr(0, path.rfind('/') + 1);
  }

  // Lengths of a file, and those within a group under the group's path and the symbol's name.
  void find_lengths() {
    for (const Found& found : found_) {
      const std::vector<std::string_view> extents = split_list(found.dataset->shape, ',');
      for (const Symbol& s : symbols()) {
        if (s.anchor != found.dataset->path) continue;
        const auto at = std::ranges::find(extents, s.name) - extents.begin();
        known_[key(s.name, found.object->path)] = {
            found.object->shape[static_cast<std::size_t>(at)], found.object->path};
      }
      for (const auto& [symbol, dataset] : kMeshSymbols)
        if (found.object->path.ends_with(fmt::format("/{}", dataset)))
          known_[key(symbol, found.object->path)] = {found.object->shape[0], found.object->path};
    }
    for (const Symbol& s : symbols())
      if (const auto length = known_.find(s.name); length != known_.end())
        contents_.lengths.emplace(s.name, length->second.count);
    contents_.particles = contents_.lengths.at("N");
    if (contents_.particles == 0) refuse("/particles/id", "is empty; expected particles");
  }

  static std::string key(std::string_view symbol, const std::string& path) {
    const Symbol* s = symbol_of(symbol);
    const bool local = !s || Pattern(s->anchor).open;
    return local ? group_of(path) + std::string(symbol) : std::string(symbol);
  }

  struct Length {
    std::size_t count = 0;
    std::string anchor;
  };

  // Of a symbol in the shape or the rule of a dataset.
  const Length& length(std::string_view symbol, const std::string& path) const {
    const auto found = known_.find(key(symbol, path));
    if (found != known_.end()) return found->second;
    const Symbol* s = symbol_of(symbol);
    refuse(path, fmt::format("is there without {}; expected both",
                             s ? std::string(s->anchor) : "the mesh that it belongs to"));
  }

  void check_shape(const Found& found) const {
    const Shape& shape = found.object->shape;
    const std::string& path = found.object->path;
    if (found.dataset->shape == "k" || found.dataset->shape == "b") return;
    const std::vector<std::string_view> extents = split_list(found.dataset->shape, ',');
    Shape expected = shape;
    std::string as;  // the dataset that determines the expected size
    for (std::size_t k = 0; k < extents.size(); ++k) {
      std::string_view symbol = extents[k];
      if (symbol[0] >= '0' && symbol[0] <= '9' && symbol.size() == 1) {
        expected[k] = static_cast<std::size_t>(symbol[0] - '0');
        continue;
      }
      std::size_t more = 0;
      if (symbol.starts_with("1+")) {
        more = 1;
        symbol.remove_prefix(2);
      }
      const Length& is = length(symbol, path);
      const Symbol* s = symbol_of(symbol);
      // A writer that was killed leaves tables of different lengths.
      if (s && s->grows && !contents_.finished) continue;
      expected[k] = is.count + more;
      if (expected[k] != shape[k] && as.empty()) as = is.anchor;
    }
    if (expected == shape) return;
    const std::string source = as.empty() ? "" : ", as " + as;
    if (shape.size() == 1)
      refuse(path, fmt::format("has {} entr{}; expected {}{}", shape[0],
                               shape[0] == 1 ? "y" : "ies", expected[0], source));
    refuse(path, fmt::format("has the wrong shape, {}; expected {}{}", shape_text(shape),
                             shape_text(expected), source));
  }

  void check_storage(const Found& found) {
    const std::string& path = found.object->path;
    const auto [written, in_chunks] = file_.check_storage(path);
    const Symbol* s = growing(*found.dataset);
    // Their values are read later, chunk by chunk and without the HDF5 library.
    if ((s || found.dataset->type == Type::byte) && !in_chunks)
      refuse(path, "is kept in one piece; expected chunks");
    if (!s) return;
    if (written > 0) file_.read_rows(path, 0, 1);  // in the same way as readers
    if (contents_.finished && written < found.object->shape[0])
      refuse(path,
             fmt::format("lacks the values of row {}; expected all of a finished run", written));
    const auto [rows, is_first] = contents_.rows.emplace(s->name, written);
    if (!is_first) rows->second = std::min(rows->second, written);
  }

  void check_attributes(const std::string& path, std::string_view object,
                        const Shape& shape) const {
    for (const Attribute& a : attributes()) {
      if (a.object != object) continue;
      const std::string name(a.name);
      const std::string what = fmt::format("the attribute {} ", name);
      if (!file_.has_attribute(path, name)) {
        if (a.presence == always) refuse(path, what + "is missing; expected " + type_name(a.type));
        continue;
      }
      const hdf5::Attribute is = file_.attribute(path, name);
      if (is.type != a.type)
        refuse(path,
               what + fmt::format("holds {}; expected {}", type_name(is.type), type_name(a.type)));
      const Shape expected = a.shape == "k" ? shape : Shape{};
      if (!is.has_space || is.shape != expected)
        refuse(path, what + fmt::format("has the wrong shape; expected {}", shape_text(expected)));
      if (a.type == Type::text) {
        const std::string value = file_.text_attribute(path, name);
        if (a.rule == R::choice && !is_choice(value, a.limit))
          refuse(path,
                 what + fmt::format("is \"{}\"; expected one of {}", value, choices_text(a.limit)));
        continue;
      }
      const std::vector<double> values = file_.number_attribute(path, name);
      if (const auto wrong = first_wrong(a.rule, values, 1, {}))
        refuse(path, what + fmt::format("is {:.9g}; expected {}", values[*wrong],
                                        range_text(a.rule, {})));
    }
  }

  void check_attributes_of(const Found& found) const {
    const std::string& path = found.object->path;
    check_attributes(path, found.dataset->path, found.object->shape);
    const std::string_view unit = found.dataset->unit;
    if (unit.empty()) return;
    if (!file_.has_attribute(path, "unit")) {
      if (growing(*found.dataset))
        refuse(path, fmt::format("the attribute unit is missing; expected \"{}\"", unit));
      return;
    }
    const hdf5::Attribute is = file_.attribute(path, "unit");
    if (is.type != Type::text || !is.has_space || !is.shape.empty())
      refuse(path, fmt::format("the attribute unit is not a single text; expected \"{}\"", unit));
    if (const std::string value = file_.text_attribute(path, "unit"); value != unit)
      refuse(path, fmt::format("the attribute unit is \"{}\"; expected \"{}\"", value, unit));
  }

  Limits limits_of(const Dataset& d, const std::string& path) const {
    if (d.limit.empty() || d.rule == R::choice) return {};
    // A file without statistics does not list its boundaries: check_case() compares with the case.
    if (d.limit == "W" && !known_.contains("W"))
      return {static_cast<double>(contents_.particles), std::numeric_limits<double>::infinity()};
    return results::limits_of(d.rule, length(d.limit, path).count, contents_.particles);
  }

  void check_contents(const Found& found) const {
    const Dataset& d = *found.dataset;
    const std::string& path = found.object->path;
    if (d.type == Type::text) {
      for (const std::string& value : file_.read_strings(path))
        if (d.rule == R::choice && !is_choice(value, d.limit))
          refuse(path, fmt::format("has \"{}\"; expected one of {}", value, choices_text(d.limit)));
      return;
    }
    if (!is_number(d.type)) return;
    std::vector<double> values;
    if (d.type == Type::integer) {
      const std::vector<int> numbers = file_.read<int>(path);
      values.assign(numbers.begin(), numbers.end());
    } else {
      values = file_.read<double>(path);
    }
    check_numbers(path, d.rule, values, found.object->shape, limits_of(d, path), 0);
  }

  // How many rows of what grows are whole.
  void cut_back() {
    std::size_t& frames = contents_.rows.at("T");
    const std::vector<double> times = file_.read_rows("/frames/time", 0, frames);
    // A writer killed in the middle of a flush leaves rows whose time never arrived.
    if (!contents_.finished)
      while (frames > 0 && std::isnan(times[frames - 1])) --frames;
    check_numbers("/frames/time", R::ascending, std::span(times).first(frames), {frames}, {}, 0);
    contents_.frames = frames;
    if (contents_.finished) return;
    for (const auto& [symbol, path] : {std::pair{"E", "/events/body_a"},
                                       {"I", "/statistics/intervals/end"},
                                       {"M", "/samples/time"}}) {
      const auto rows = contents_.rows.find(symbol);
      if (rows == contents_.rows.end()) continue;
      const std::vector<double> values = file_.read_rows(path, 0, rows->second);
      rows->second = static_cast<std::size_t>(
          std::ranges::find_if(values, [](double v) { return std::isnan(v); }) - values.begin());
    }
  }

  const hdf5::File& file_;
  std::vector<hdf5::Object> objects_;
  std::vector<Found> found_;
  std::map<std::string, Length, std::less<>> known_;
  Contents contents_;
};

}  // namespace

std::optional<std::size_t> Contents::growing_rows(std::string_view path) const {
  const auto known = datasets.find(path);
  const Symbol* s = known == datasets.end() ? nullptr : growing(*known->second);
  return s ? std::optional(rows.find(s->name)->second) : std::nullopt;
}

Contents check_file(const hdf5::File& file) { return Check(file).all(); }

void check_values(const Contents& contents, const std::string& path, std::span<const double> values,
                  std::size_t first) {
  const auto known = contents.datasets.find(path);
  if (known == contents.datasets.end()) return;
  const Dataset& d = *known->second;
  Limits limits;
  if (const auto length = contents.lengths.find(d.limit); length != contents.lengths.end())
    limits = limits_of(d.rule, length->second, contents.particles);
  check_numbers(path, d.rule, values, contents.shapes.at(path), limits, first);
}

void check_case(const Contents& contents, const hdf5::File& file, const Case& c) {
  const auto expect = [&](std::string_view symbol, std::size_t count, std::string_view what) {
    const auto length = contents.lengths.find(symbol);
    if (length == contents.lengths.end() || length->second == count) return;
    refuse(symbol_of(symbol)->anchor,
           fmt::format("has {} entries; expected {}, the {} of the case in the file",
                       length->second, count, what));
  };
  expect("N", c.model.particles.size(), "particles");
  expect("H", c.model.shapes.size(), "shapes");
  expect("O", c.outlets.size(), "outlets");
  expect("B", c.model.bonds.size(), "bonds");
  expect("W", c.model.boundaries.size(), "boundaries");
  expect("G", c.sensors.size(), "sensors");
  if (contents.datasets.contains("/bonds/b")) {
    const std::vector<int> bodies = file.read<int>("/bonds/b");
    const auto boundaries = static_cast<int>(c.model.boundaries.size());
    for (std::size_t k = 0; k < bodies.size(); ++k)
      if (bodies[k] < -boundaries)
        refuse("/bonds/b", fmt::format("entry {} is {}; expected {} or more, as the case in the "
                                       "file",
                                       k, bodies[k], -boundaries));
  }
  if (contents.datasets.contains("/sensors/name")) {
    const std::vector<std::string> names = file.read_strings("/sensors/name");
    for (std::size_t g = 0; g < names.size(); ++g)
      if (names[g] != c.sensors[g].name)
        refuse("/sensors/name",
               fmt::format("entry {} is \"{}\"; expected \"{}\", as the case in the "
                           "file",
                           g, names[g], c.sensors[g].name));
  }
  std::vector<Column> columns = result_columns(c);
  std::ranges::copy(sample_columns(c), std::back_inserter(columns));
  for (const Column& column : columns) {
    const auto shape = contents.shapes.find(column.path);
    if (shape == contents.shapes.end()) continue;
    Shape expected{shape->second[0]};
    expected.insert(expected.end(), column.row.begin(), column.row.end());
    if (shape->second != expected)
      refuse(column.path,
             fmt::format("has the wrong shape, {}; expected {}, as the case in the file",
                         shape_text(shape->second), shape_text(expected)));
  }
}

}  // namespace firn::results
