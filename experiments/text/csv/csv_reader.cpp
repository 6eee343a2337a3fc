#include "experiments/text/csv/csv_reader.h"

#include <csv.h>
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <new>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "firn/math.h"

namespace firn {
namespace {

constexpr std::string_view kBlanks = " \t\r";

// What separates the fields of a file whose first row is this line. A tab next to a comma is blank.
char separator_of(std::string_view header) {
  bool quoted = false, tab = false;
  for (std::size_t i = 0; i < header.size(); ++i) {
    if (header[i] == '"') quoted = !quoted;
    if (quoted) continue;
    if (header[i] == ';') return ';';
    const bool next_to_comma = (i > 0 && header[i - 1] == ',') || header.substr(i + 1, 1) == ",";
    tab = tab || (header[i] == '\t' && !next_to_comma);
  }
  return tab ? '\t' : ',';
}

// The number that a whole field holds; nothing for any other text.
std::optional<double> number_of(const std::string& text) {
  const char *first = text.data() + text.starts_with('+'), *last = text.data() + text.size();
  double value = 0;
  const auto [end, error] = std::from_chars(first, last, value);
  if (text.empty() || error != std::errc() || end != last) return std::nullopt;
  return value;
}

// The same with a comma for the point; nothing for a text without a comma.
std::optional<double> decimal_comma_number_of(std::string text) {
  const std::size_t comma = text.find(',');
  if (comma == text.npos || text.find('.') != text.npos) return std::nullopt;
  text[comma] = '.';
  return number_of(text);
}

// Passes one line at a time to libcsv, so that every row has its line number.
class RowReader {
 public:
  explicit RowReader(std::string file) : file_(std::move(file)) {
    if (csv_init(&parser_, CSV_STRICT | CSV_STRICT_FINI) != 0) throw std::bad_alloc();
  }
  RowReader(const RowReader&) = delete;
  RowReader& operator=(const RowReader&) = delete;
  ~RowReader() { csv_free(&parser_); }

  std::vector<CsvRow> read() {
    const std::string bytes = read_input_file(file_, "a CSV file", input_limits::csv_bytes);
    require_plain_text(bytes, file_, "a CSV file");
    std::istringstream in(bytes);
    std::string text;
    while (std::getline(in, text)) {
      ++line_;
      constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
      if (line_ == 1 && text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
      if (text.starts_with('#')) continue;
      if (rows_.empty() && fields_.empty()) {
        separator_ = separator_of(text);
        csv_set_delim(&parser_, static_cast<unsigned char>(separator_));
      }
      feed(text + "\n");
    }
    if (csv_fini(&parser_, on_field, on_row, this) != 0) fail();
    return std::move(rows_);
  }

 private:
  static void on_field(void* data, std::size_t size, void* self) {
    auto* reader = static_cast<RowReader*>(self);
    if (reader->fields_.size() < input_limits::csv_fields)
      reader->fields_.push_back(trimmed({static_cast<const char*>(data), size}, kBlanks));
    else
      reader->too_many_fields_ = true;  // nothing is thrown through the library
  }
  static void on_row(int, void* self) {
    auto* reader = static_cast<RowReader*>(self);
    reader->rows_.push_back(
        {reader->line_, reader->separator_, std::exchange(reader->fields_, {})});
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
    const int error = csv_error(&parser_);
    throw InputError(
        fmt::format("{}:{}: CSV: {}; expected fields between commas, quotes in pairs", file_, line_,
                    error == CSV_EPARSE ? "a quote does not close, or is inside a field"
                                        : csv_strerror(error)));
  }

  std::string file_;
  csv_parser parser_{};
  unsigned line_ = 0;
  char separator_ = ',';
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
  return {trimmed(field.substr(0, open), kBlanks),
          trimmed(field.substr(open + 1, shut - open - 1), kBlanks)};
}

std::vector<CsvRow> read_csv_table(const std::string& file) {
  std::vector<CsvRow> rows = read_csv_rows(file);
  if (rows.empty()) throw InputError(file + ":1: CSV: is empty; expected a header and rows");
  const CsvRow& header = rows.front();
  for (CsvRow& row : rows) {
    while (row.fields.size() > header.fields.size() && row.fields.back().empty())
      row.fields.pop_back();
    if (row.fields.size() != header.fields.size())
      throw InputError(
          fmt::format("{}:{}: CSV: has {} fields; expected {}, as in the header, line {}{}", file,
                      row.line, row.fields.size(), header.fields.size(), header.line,
                      header.fields.size() == 1 ? "; lines above the header must begin with #"
                      : header.separator == ',' && row.fields.size() == 2 * header.fields.size()
                          ? "; numbers with a decimal comma need semicolons or tabs between them"
                          : ""));
  }
  // 1,234 and 5.6 in one column: the first may be a thousand.
  for (std::size_t i = 0; header.separator != ',' && i < header.fields.size(); ++i) {
    unsigned point = 0, comma = 0;  // a line that has one
    for (const CsvRow& row : rows) {
      const std::string& text = row.fields[i];
      if (decimal_comma_number_of(text)) comma = row.line;
      if (text.find('.') != text.npos && number_of(text)) point = row.line;
    }
    if (point > 0 && comma > 0)
      throw InputError(fmt::format(
          "{}:{}: {}: has a decimal comma here and a decimal point in line {}; expected one of the "
          "two",
          file, comma, csv_heading(header.fields[i]).name, point));
  }
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
  if (unit.empty() && *dimension == dimension::none) return {name, found[0], 1};
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
  std::optional<double> value = number_of(text);
  if (!value && row.separator != ',') value = decimal_comma_number_of(text);
  if (!value || !std::isfinite(*value * column.unit))
    throw InputError(fmt::format("{}:{}: {}: is \"{}\"; expected a finite number, such as 1.5{}",
                                 file, row.line, column.name, text,
                                 row.separator == ',' ? "" : " or 1,5"));
  return *value * column.unit;
}

}  // namespace firn
