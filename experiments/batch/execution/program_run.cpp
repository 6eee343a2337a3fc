#include "experiments/batch/execution/program_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "experiments/system/input_file.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/csv/csv_reader.h"
#include "experiments/text/json_fields.h"
#include "experiments/text/units.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_responses = 1000, longest_name = 200;

// The filled template, an object within the text of a run.
struct InputOf {
  ProgramRun& run;
};

// A response that a program wrote: a number, null where it is undefined, or an object.
struct ProgramResponse {
  std::optional<double> value;
  std::string unit;
  std::optional<double> uncertainty;
};

template <class Fields>
void fields(Fields& f, InputOf& input) {
  f.required("name", input.run.input_name);
  f.required("text", input.run.input_text);
}

Response response_of(const std::string& name, double value, const std::string& unit) {
  return {name, {value}, {}, unit.empty() ? "1" : plain_unit(unit), "user program", 1};
}

template <class Fields>
void fields(Fields& f, ProgramResponse& r) {
  f.required("value", r.value);
  f.optional("unit", r.unit);
  f.optional("uncertainty", r.uncertainty);
}

// By name.
std::vector<Response> read_json_responses(const std::string& file) {
  JsonFile output = read_json_file(file, "the responses of the program");
  if (!output.document.is_object())
    throw InputError(fmt::format("{}: is no JSON object; expected {{\"RESPONSE\": NUMBER, ...}}",
                                 json_place(file, output.text, {})));
  for (auto& [name, value] : output.document.items())
    if (!value.is_object()) value = Json{{"value", value}};
  std::vector<Response> responses;
  for (auto& [name, read] :
       document_from_json<std::map<std::string, ProgramResponse>>(output, JsonReading::strict)) {
    responses.push_back(response_of(name, read.value.value_or(kUndefined), std::move(read.unit)));
    if (read.uncertainty) responses.back().uncertainty = {*read.uncertainty};
  }
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
template <class Fields>
static void fields(Fields& f, ProgramRun& run) {
  f.required("arguments", run.arguments);
  f.required("input", InputOf{run});
  f.required("inputs", run.inputs);
  f.required("responses", run.responses);
  f.required("values", run.values);
}

std::string program_run_text(ProgramRun run) { return json_text(std::move(run), 1) + '\n'; }

ProgramRun parse_program_run(const std::string& text) {
  const std::string source = "run of a program";
  auto run =
      document_from_json<ProgramRun>(parse_json(text, source), source, JsonReading::strict, text);
  if (run.arguments.empty())
    throw InputError(fmt::format("{}: document: names no program", source));
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
