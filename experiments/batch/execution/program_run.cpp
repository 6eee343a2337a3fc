#include "experiments/batch/execution/program_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/csv_reader.h"
#include "experiments/text/json_reader.h"

namespace firn {
namespace {

using nlohmann::json;

constexpr std::size_t most_responses = 1000, longest_name = 200;

// The filled template, an object within the text of a run.
struct InputOf {
  ProgramRun& run;
};

void fields(StrictFields& f, InputOf& input) {
  f.required("name", input.run.input_name);
  f.required("text", input.run.input_text);
}

Response response_of(const std::string& name, double value, std::string unit) {
  return {name, {value}, {}, unit.empty() ? "1" : std::move(unit), "user program", 1};
}

Response read_json_response(const std::string& name, const json& value, const std::string& file) {
  if (value.is_null()) return response_of(name, kUndefined, "");
  const json whole = value.is_object() ? value : json{{"value", value}};
  const JsonReader reader(whole, file, name);
  reader.allow({"value", "unit", "uncertainty"});
  if (!whole.contains("value")) reader.number("value");  // throws
  Response r = response_of(name, reader.optional_number("value").value_or(kUndefined),
                           reader.string_or_empty("unit"));
  if (const auto u = reader.optional_number("uncertainty")) r.uncertainty = {*u};
  return r;
}

std::vector<Response> read_json_responses(const std::string& file) {
  const json document = parse_json(
      read_input_file(file, "the responses of the program", input_limits::json_bytes), file);
  if (!document.is_object())
    throw InputError(
        fmt::format("{}: is no JSON object; expected {{\"RESPONSE\": NUMBER, ...}}", file));
  std::vector<Response> responses;
  for (const auto& item : document.items())
    responses.push_back(read_json_response(item.key(), item.value(), file));
  return responses;
}

std::vector<Response> read_csv_responses(const std::string& file) {
  const std::vector<CsvRow> rows = read_csv_table(file);
  const CsvColumn name = find_csv_column(file, rows.front(), "response", {});
  const CsvColumn value = find_csv_column(file, rows.front(), "value", {});
  const auto& header = rows.front().fields;
  const auto unit = std::find(header.begin(), header.end(), "unit") - header.begin();
  std::vector<Response> responses;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const auto& fields = rows[i].fields;
    const double number =
        fields[value.index].empty() ? kUndefined : csv_number(file, rows[i], value);
    const auto column = static_cast<std::size_t>(unit);
    responses.push_back(
        response_of(fields[name.index], number, column < fields.size() ? fields[column] : ""));
  }
  return responses;
}

}  // namespace

// In alphabetical order: keys of runs are computed from the text.
static void fields(StrictFields& f, ProgramRun& run) {
  f.required("arguments", run.arguments);
  f.required("input", InputOf{run});
  f.required("inputs", run.inputs);
  f.required("responses", run.responses);
  f.required("values", run.values);
}

std::string program_run_text(ProgramRun run) { return json_of(run).dump(1) + '\n'; }

ProgramRun parse_program_run(const std::string& text) {
  const std::string source = "run of a program";
  const json document = parse_json(text, source);
  const JsonReader reader(document, source);
  ProgramRun run;
  read_object(reader, run);
  if (run.arguments.empty()) reader.fail("names no program");
  return run;
}

std::vector<Response> read_program_responses(const std::string& file) {
  std::vector<Response> responses = std::filesystem::path(file).extension() == ".csv"
                                        ? read_csv_responses(file)
                                        : read_json_responses(file);
  if (responses.size() > most_responses)
    throw InputError(fmt::format("{}: has {} responses; expected at most {}", file,
                                 responses.size(), most_responses));
  std::set<std::string> names;
  for (const Response& r : responses) {
    for (const std::string& text : {r.name, r.unit})
      if (text.empty() || text.size() > longest_name || !encode::first_unprintable(text).empty())
        throw InputError(
            fmt::format("{}: \"{}\" is not a name of a response or unit; expected printable text",
                        file, shortened(text)));
    if (!names.insert(r.name).second)
      throw InputError(
          fmt::format("{}: has \"{}\" twice; expected each response once", file, r.name));
  }
  return responses;
}

}  // namespace firn
