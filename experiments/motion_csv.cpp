#include "experiments/motion_csv.h"

#include <csv.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <memory>

namespace firn {
namespace {

using Fields = std::vector<std::string>;

struct Row {
  unsigned line = 0;  // on which it ends
  Fields fields;
};

std::string trimmed(std::string s) {
  constexpr const char* kBlank = " \t\r";
  s.erase(0, s.find_first_not_of(kBlank));
  s.erase(s.find_last_not_of(kBlank) + 1);
  return s;
}

// Hands libcsv a line at a time, so that every row knows where it stands.
class RowReader {
 public:
  explicit RowReader(std::string file) : file_(std::move(file)) {
    if (csv_init(&parser_, CSV_STRICT | CSV_STRICT_FINI) != 0) throw std::bad_alloc();
  }
  RowReader(const RowReader&) = delete;
  RowReader& operator=(const RowReader&) = delete;
  ~RowReader() { csv_free(&parser_); }

  std::vector<Row> read() {
    std::ifstream in(file_, std::ios::binary);
    if (!in) throw InputError(file_ + ": cannot be opened; expected a CSV file");
    std::string text;
    while (std::getline(in, text)) {
      ++line_;
      constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
      if (line_ == 1 && text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
      if (text.starts_with('#')) continue;
      if (rows_.empty() && fields_.empty() && text.find(',') == text.npos)
        csv_set_delim(&parser_, ';');
      feed(text + "\n");
    }
    if (csv_fini(&parser_, on_field, on_row, this) != 0) fail();
    return std::move(rows_);
  }

 private:
  static void on_field(void* data, std::size_t size, void* self) {
    static_cast<RowReader*>(self)->fields_.push_back(
        trimmed(std::string(static_cast<const char*>(data), size)));
  }
  static void on_row(int, void* self) {
    auto* reader = static_cast<RowReader*>(self);
    reader->rows_.push_back({reader->line_, std::exchange(reader->fields_, {})});
  }
  void feed(const std::string& text) {
    if (csv_parse(&parser_, text.data(), text.size(), on_field, on_row, this) != text.size())
      fail();
  }
  [[noreturn]] void fail() {
    throw InputError(fmt::format("{}:{}: CSV: {}; expected fields between commas, quotes in pairs",
                                 file_, line_, csv_strerror(csv_error(&parser_))));
  }

  std::string file_;
  csv_parser parser_{};
  unsigned line_ = 0;
  Fields fields_;
  std::vector<Row> rows_;
};

struct Heading {
  std::string name, unit;
};

// "way [mm]" or "way (mm)"
Heading heading_of(const std::string& field) {
  const std::size_t open = field.find_first_of("[(");
  if (open == field.npos) return {field, ""};
  const std::size_t shut = field.find_last_of("])");
  if (shut == field.npos || shut < open) return {field, ""};
  return {trimmed(field.substr(0, open)), trimmed(field.substr(open + 1, shut - open - 1))};
}

struct Column {
  std::string name;
  std::size_t index = 0;
  double unit = 1;  // SI
};

Column find_column(const std::string& file, const Row& header, const std::string& name,
                   const Dimension& dimension) {
  const auto fail = [&](const std::string& what) {
    throw InputError(fmt::format("{}:{}: {}: {}", file, header.line, name, what));
  };
  std::vector<std::string> names;
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < header.fields.size(); ++i) {
    names.push_back('"' + heading_of(header.fields[i]).name + '"');
    if (heading_of(header.fields[i]).name == name) found.push_back(i);
  }
  if (found.empty())
    fail(fmt::format("no such column; the header has {}; expected one \"{} [UNIT]\"",
                     comma_list(names), name));
  if (found.size() > 1) fail("heads two columns; expected one");
  const std::string unit = heading_of(header.fields[found[0]]).unit;
  if (unit.empty())
    fail(fmt::format("names no unit; expected one in brackets, such as \"{} [{}]\"", name,
                     dimension == dimension::time    ? "s"
                     : dimension == dimension::angle ? "deg"
                                                     : "mm"));
  try {
    return {name, found[0], parse_quantity("1 " + unit, dimension)};
  } catch (const InputError& e) {
    fail(fmt::format("is in \"{}\": {}", unit, e.what()));
  }
  return {};
}

double value_of(const std::string& file, const Row& row, const Column& column) {
  const std::string& text = row.fields[column.index];
  const char *first = text.data() + text.starts_with('+'), *last = text.data() + text.size();
  double value = 0;
  const auto [end, error] = std::from_chars(first, last, value);
  if (text.empty() || error != std::errc() || end != last || !std::isfinite(value))
    throw InputError(fmt::format("{}:{}: {}: is \"{}\"; expected a finite number, with a point",
                                 file, row.line, column.name, text));
  return value * column.unit;
}

}  // namespace

MotionCsv read_motion_csv(const std::string& file, const std::string& time_column,
                          const std::string& way_column, const Dimension& way) {
  const std::vector<Row> rows = RowReader(file).read();
  if (rows.empty()) throw InputError(file + ":1: CSV: is empty; expected a header and rows");
  const Row& header = rows.front();
  const Column time = find_column(file, header, time_column, dimension::time);
  const Column moved = find_column(file, header, way_column, way);
  MotionCsv table;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i].fields.size() != header.fields.size())
      throw InputError(fmt::format("{}:{}: CSV: has {} fields; expected {}, as in the header", file,
                                   rows[i].line, rows[i].fields.size(), header.fields.size()));
    table.times.push_back(value_of(file, rows[i], time));
    table.ways.push_back(value_of(file, rows[i], moved));
    table.lines.push_back(rows[i].line);
  }
  return table;
}

}  // namespace firn
