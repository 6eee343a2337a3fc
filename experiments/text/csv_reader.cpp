#include "experiments/text/csv_reader.h"

#include <csv.h>
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <new>
#include <sstream>
#include <string_view>
#include <utility>

#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "firn/math.h"

namespace firn {
namespace {

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

  std::vector<CsvRow> read() {
    std::istringstream in(read_input_file(file_, "a CSV file", input_limits::csv_bytes));
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
    auto* reader = static_cast<RowReader*>(self);
    if (reader->fields_.size() < input_limits::csv_fields)
      reader->fields_.push_back(trimmed(std::string(static_cast<const char*>(data), size)));
    else
      reader->too_many_fields_ = true;  // nothing is thrown through the library
  }
  static void on_row(int, void* self) {
    auto* reader = static_cast<RowReader*>(self);
    reader->rows_.push_back({reader->line_, std::exchange(reader->fields_, {})});
  }
  void feed(const std::string& text) {
    if (csv_parse(&parser_, text.data(), text.size(), on_field, on_row, this) != text.size())
      fail();
    if (too_many_fields_)
      throw InputError(fmt::format("{}:{}: CSV: a row has more than {} fields; expected fewer",
                                   file_, line_, input_limits::csv_fields));
    if (rows_.size() > input_limits::csv_rows)
      throw InputError(fmt::format("{}:{}: CSV: has more than {} rows; expected fewer", file_,
                                   line_, input_limits::csv_rows));
  }
  [[noreturn]] void fail() {
    throw InputError(fmt::format("{}:{}: CSV: {}; expected fields between commas, quotes in pairs",
                                 file_, line_, csv_strerror(csv_error(&parser_))));
  }

  std::string file_;
  csv_parser parser_{};
  unsigned line_ = 0;
  bool too_many_fields_ = false;
  std::vector<std::string> fields_;
  std::vector<CsvRow> rows_;
};

}  // namespace

std::vector<CsvRow> read_csv_rows(const std::string& file) { return RowReader(file).read(); }

CsvHeading csv_heading(const std::string& field) {
  const std::size_t open = field.find_first_of("[(");
  if (open == field.npos) return {field, ""};
  const std::size_t shut = field.find_last_of("])");
  if (shut == field.npos || shut < open) return {field, ""};
  return {trimmed(field.substr(0, open)), trimmed(field.substr(open + 1, shut - open - 1))};
}

std::vector<CsvRow> read_csv_table(const std::string& file) {
  std::vector<CsvRow> rows = read_csv_rows(file);
  if (rows.empty()) throw InputError(file + ":1: CSV: is empty; expected a header and rows");
  for (const CsvRow& row : rows)
    if (row.fields.size() != rows.front().fields.size())
      throw InputError(fmt::format("{}:{}: CSV: has {} fields; expected {}, as in the header", file,
                                   row.line, row.fields.size(), rows.front().fields.size()));
  return rows;
}

CsvColumn find_csv_column(const std::string& file, const CsvRow& header, const std::string& name,
                          const std::optional<Dimension>& dimension) {
  const auto fail = [&](const std::string& what) {
    throw InputError(fmt::format("{}:{}: {}: {}", file, header.line, name, what));
  };
  std::vector<std::string> names;
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < header.fields.size(); ++i) {
    names.push_back('"' + csv_heading(header.fields[i]).name + '"');
    if (csv_heading(header.fields[i]).name == name) found.push_back(i);
  }
  if (found.empty())
    fail(fmt::format("no such column; the header has {}; expected one \"{}{}\"", comma_list(names),
                     name, dimension ? " [UNIT]" : ""));
  if (found.size() > 1) fail("heads two columns; expected one");
  if (!dimension) return {name, found[0], 1};
  const std::string unit = csv_heading(header.fields[found[0]]).unit;
  if (unit.empty())
    fail(fmt::format("names no unit; expected one in brackets, such as \"{} [{}]\"", name,
                     dimension == dimension::time    ? "s"
                     : dimension == dimension::angle ? "deg"
                                                     : "mm"));
  try {
    return {name, found[0], parse_quantity("1 " + unit, *dimension)};
  } catch (const InputError& e) {
    fail(fmt::format("is in \"{}\": {}", unit, e.what()));
  }
  return {};
}

double csv_number(const std::string& file, const CsvRow& row, const CsvColumn& column) {
  const std::string& text = row.fields[column.index];
  const char *first = text.data() + text.starts_with('+'), *last = text.data() + text.size();
  double value = 0;
  const auto [end, error] = std::from_chars(first, last, value);
  if (text.empty() || error != std::errc() || end != last || !std::isfinite(value * column.unit))
    throw InputError(fmt::format("{}:{}: {}: is \"{}\"; expected a finite number, with a point",
                                 file, row.line, column.name, text));
  return value * column.unit;
}

}  // namespace firn
