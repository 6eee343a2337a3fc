#include "experiments/material_records/material_json.h"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/storage/sha256.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/json_aliases.h"
#include "experiments/text/json_reader.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* format_name = "firn material records";
constexpr int format_version = 2;  // 1: other names of keys (json_aliases.h)

// ---- Writing ----

void put(Json& object, const char* key, const std::string& text) {
  if (!text.empty()) object[key] = text;
}
void put(Json& object, const char* key, const std::optional<double>& value) {
  if (value) object[key] = *value;
}
void put(Json& object, const char* key, const std::optional<Interval>& interval) {
  if (interval) object[key] = {interval->low, interval->high};
}
// Of each element; nothing for none.
template <class Elements, class Make>
void put_all(Json& object, const char* key, const Elements& elements, Make make) {
  if (elements.empty()) return;
  Json array = Json::array();
  for (const auto& element : elements) array.push_back(make(element));
  object[key] = array;
}

Json parameter_json(const MaterialParameter& p) {
  Json j = {{"name", p.name}, {"keys", p.keys}, {"value", p.value}, {"unit", p.unit}};
  put(j, "uncertainty", p.uncertainty);
  put(j, "interval_95", p.interval_95);
  put(j, "note", p.note);
  return j;
}

Json property_json(const MaterialProperty& p) {
  Json j = {{"name", p.name}};
  put(j, "value", p.value);
  put(j, "uncertainty", p.uncertainty);
  put(j, "range", p.range);
  put(j, "unit", p.unit);
  put(j, "conditions", p.conditions);
  put(j, "statement", p.statement);
  return j;
}

Json response_json(const MaterialResponse& r) {
  Json j = {{"name", r.name}, {"value", r.value}};
  put(j, "uncertainty", r.uncertainty);
  j["unit"] = r.unit;
  return j;
}

Json reference_set_json(const ReferenceSet& a) {
  Json j = {{"name", a.name}, {"values", a.values}};
  put_all(j, "predicted", a.predicted, response_json);
  put_all(j, "runs", a.runs, [](const ReferenceRun& run) {
    Json r = Json::object();
    put(r, "experiment", run.experiment);
    r["seed"] = run.seed;
    put_all(r, "responses", run.responses, response_json);
    return r;
  });
  return j;
}

Json ensemble_json(const PosteriorEnsemble& f) {
  Json j = Json::object();
  put_all(j, "axes", f.axes, [](const EnsembleAxis& a) {
    return Json{{"parameter", a.parameter},
                {"scale", a.scale == Scale::logarithmic ? "log" : "linear"},
                {"min", a.bounds.low},
                {"max", a.bounds.high},
                {"mean", a.mean}};
  });
  j["covariance"] = f.covariance;
  put_all(j, "combinations", f.combinations, [](const EnsembleCombination& c) {
    Json one = {{"coefficients", c.coefficients}, {"identifiable", c.identifiable}};
    if (c.identifiable) one["value"] = c.value;
    put(one, "uncertainty", c.uncertainty);
    return one;
  });
  put_all(j, "samples", f.samples, [](const EnsembleSample& p) {
    return Json{{"values", p.values}, {"weight", p.weight}};
  });
  put_all(j, "reference_sets", f.reference_sets, reference_set_json);
  return j;
}

Json provenance_json(const Provenance& p) {
  Json j = {{"author", p.author}, {"date", p.date}, {"source", p.source}};
  put_all(j, "raw_data", p.raw_data, [](const RawData& d) {
    return Json{{"what", d.what}, {"file", d.file}, {"sha256", d.sha256}};
  });
  put_all(j, "measurements", p.measurements, [](const UsedMeasurement& m) {
    Json one = Json::object();
    put(one, "name", m.name);
    one["response"] = m.response;
    one["value"] = m.value;
    one["uncertainty"] = m.uncertainty;
    one["unit"] = m.unit;
    one["source"] = m.source;
    put(one, "experiment", m.experiment);
    if (m.discrepancy > 0) one["discrepancy"] = m.discrepancy;
    return one;
  });
  put(j, "study", p.study);
  if (!p.program_version.empty()) {
    j["program"] = {
        {"version", p.program_version}, {"commit", p.program_commit}, {"identity", p.program}};
    if (p.contact_model > 1) j["program"]["contact_model"] = p.contact_model;
  }
  if (!p.seeds.empty()) j["seeds"] = p.seeds;
  put_all(j, "estimators", p.estimators, [](const UsedEstimator& e) {
    return Json{{"response", e.response}, {"method", e.method}, {"version", e.version}};
  });
  put(j, "command", p.command);
  put_all(j, "cases", p.cases, [](const SimulatedCase& c) {
    Json one = Json::object();
    put(one, "experiment", c.experiment);
    one["parameters"] = c.parameters;
    one["text"] = c.text;
    return one;
  });
  return j;
}

std::string float_text(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

bool scalars(const Json& array) {
  return std::ranges::none_of(array, [](const Json& item) { return item.is_structured(); });
}

// Compact with sorted keys, or, with an indent, on several lines in the order as it is.
void write(std::string& out, const Json& json, bool pretty, int depth) {
  const auto new_line = [&](int level) {
    if (pretty) out += '\n' + std::string(static_cast<std::size_t>(2 * level), ' ');
  };
  if (json.is_object()) {
    std::vector<std::string> keys;
    for (const auto& [key, value] : json.items()) keys.push_back(key);
    if (!pretty) std::ranges::sort(keys);
    out += '{';
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (i > 0) out += ',';
      new_line(depth + 1);
      out += Json(keys[i]).dump() + (pretty ? ": " : ":");
      write(out, json[keys[i]], pretty, depth + 1);
    }
    if (!keys.empty()) new_line(depth);
    out += '}';
  } else if (json.is_array()) {
    const bool one_line = scalars(json);
    out += '[';
    for (std::size_t i = 0; i < json.size(); ++i) {
      if (i > 0) out += pretty && one_line ? ", " : ",";
      if (!one_line) new_line(depth + 1);
      write(out, json[i], pretty, depth + 1);
    }
    if (!one_line) new_line(depth);
    out += ']';
  } else {
    out += json.is_number_float() ? float_text(json.get<double>()) : json.dump();
  }
}

// ---- Reading ----

std::optional<Interval> read_interval(const JsonReader& j, std::string_view key) {
  if (!j.has(key)) return std::nullopt;
  const std::vector<double> ends = j.numbers(key);
  if (ends.size() != 2)
    j.at(key).fail(fmt::format("has {} numbers; expected two ends", ends.size()));
  return Interval{ends[0], ends[1]};
}

std::uint64_t read_seed(const JsonReader& j) { return j.whole_number(); }

MaterialParameter read_parameter(const JsonReader& j) {
  j.allow({"name", "keys", "value", "unit", "uncertainty", "interval_95", "note"});
  return {j.string("name"),
          j.strings("keys"),
          j.number("value"),
          j.string("unit"),
          j.optional_number("uncertainty"),
          read_interval(j, "interval_95"),
          j.string_or_empty("note")};
}

MaterialProperty read_property(const JsonReader& j) {
  j.allow({"name", "value", "uncertainty", "range", "unit", "conditions", "statement"});
  return {j.string("name"),
          j.optional_number("value"),
          j.optional_number("uncertainty"),
          read_interval(j, "range"),
          j.string_or_empty("unit"),
          j.string_or_empty("conditions"),
          j.string_or_empty("statement")};
}

template <class Read>
auto read_all(const JsonReader& j, std::string_view key, Read read) {
  std::vector<decltype(read(j))> all;
  for (const JsonReader& item : j.items(key)) all.push_back(read(item));
  return all;
}

MaterialResponse read_response(const JsonReader& j) {
  j.allow({"name", "value", "uncertainty", "unit"});
  return {j.string("name"), j.number("value"), j.optional_number("uncertainty"), j.string("unit")};
}

ReferenceSet read_reference_set(const JsonReader& j) {
  j.allow({"name", "values", "predicted", "runs"});
  return {j.string("name"), j.numbers("values"), read_all(j, "predicted", read_response),
          read_all(j, "runs", [](const JsonReader& run) {
            run.allow({"experiment", "seed", "responses"});
            return ReferenceRun{run.string_or_empty("experiment"), read_seed(run.at("seed")),
                                read_all(run, "responses", read_response)};
          })};
}

EnsembleAxis read_joint(const JsonReader& j) {
  j.allow({"parameter", "scale", "min", "max", "mean"});
  const std::string scale = j.string("scale");
  if (scale != "log" && scale != "linear")
    j.at("scale").fail(fmt::format("is \"{}\"; expected \"log\" or \"linear\"", scale));
  return {j.string("parameter"),
          scale == "log" ? Scale::logarithmic : Scale::linear,
          {j.number("min"), j.number("max")},
          j.number("mean")};
}

EnsembleCombination read_combination(const JsonReader& j) {
  j.allow({"coefficients", "identifiable", "value", "uncertainty"});
  EnsembleCombination c;
  c.coefficients = j.numbers("coefficients");
  c.identifiable = j.boolean("identifiable");
  if (c.identifiable) c.value = j.number("value");
  c.uncertainty = j.optional_number("uncertainty");
  return c;
}

PosteriorEnsemble read_ensemble(const JsonReader& j) {
  j.allow({"axes", "covariance", "combinations", "samples", "reference_sets"});
  PosteriorEnsemble f;
  f.axes = read_all(j, "axes", read_joint);
  f.covariance = read_all(j, "covariance", [](const JsonReader& row) { return row.numbers(); });
  f.combinations = read_all(j, "combinations", read_combination);
  f.samples = read_all(j, "samples", [](const JsonReader& p) {
    p.allow({"values", "weight"});
    return EnsembleSample{p.numbers("values"), p.number("weight")};
  });
  f.reference_sets = read_all(j, "reference_sets", read_reference_set);
  return f;
}

Provenance read_provenance(const JsonReader& j) {
  j.allow({"author", "date", "source", "raw_data", "measurements", "study", "program", "seeds",
           "estimators", "command", "cases"});
  Provenance p;
  p.author = j.string("author");
  p.date = j.string("date");
  p.source = j.string("source");
  p.raw_data = read_all(j, "raw_data", [](const JsonReader& d) {
    d.allow({"what", "file", "sha256"});
    return RawData{d.string("what"), d.string("file"), d.string("sha256")};
  });
  p.measurements = read_all(j, "measurements", [](const JsonReader& m) {
    m.allow({"name", "response", "value", "uncertainty", "unit", "source", "experiment",
             "discrepancy"});
    return UsedMeasurement{m.string_or_empty("name"),
                           m.string("response"),
                           m.number("value"),
                           m.number("uncertainty"),
                           m.string("unit"),
                           m.string("source"),
                           m.string_or_empty("experiment"),
                           m.optional_number("discrepancy").value_or(0)};
  });
  p.study = j.string_or_empty("study");
  if (j.has("program")) {
    const JsonReader program = j.at("program");
    program.allow({"version", "commit", "identity", "contact_model"});
    p.program = program.string("identity");
    p.program_version = program.string("version");
    p.program_commit = program.string("commit");
    if (program.has("contact_model"))
      p.contact_model = static_cast<int>(program.integer("contact_model", 1, 1000000));
  }
  p.seeds = read_all(j, "seeds", read_seed);
  p.estimators = read_all(j, "estimators", [](const JsonReader& e) {
    e.allow({"response", "method", "version"});
    return UsedEstimator{e.string("response"), e.string("method"),
                         static_cast<int>(e.integer("version", 1, 1000000))};
  });
  p.command = j.string_or_empty("command");
  p.cases = read_all(j, "cases", [](const JsonReader& c) {
    c.allow({"experiment", "parameters", "text"});
    return SimulatedCase{c.string_or_empty("experiment"), c.strings("parameters"),
                         c.string("text")};
  });
  return p;
}

RecordKind read_kind(const JsonReader& j) {
  const std::string kind = j.string("kind");
  std::vector<std::string> known;
  for (const RecordKind k :
       {RecordKind::published, RecordKind::measured, RecordKind::calibrated, RecordKind::assumed}) {
    if (kind == to_string(k)) return k;
    known.emplace_back(to_string(k));
  }
  j.at("kind").fail(fmt::format("is \"{}\"; expected one of {}", kind, comma_list(known)));
}

ReadRecord read_record(const JsonReader& j, const std::string& source) {
  j.allow({"name", "version", "supersedes", "title", "materials", "kind", "parameters",
           "properties", "posterior_ensemble", "scope", "provenance", "note", "sha256"});
  MaterialRecord r;
  r.name = j.string("name");
  if (j.has("version")) r.version = static_cast<int>(j.integer("version", 1, 1000000000));
  r.supersedes = j.string_or_empty("supersedes");
  r.title = j.string("title");
  r.materials = j.strings("materials");
  r.kind = read_kind(j);
  r.parameters = read_all(j, "parameters", read_parameter);
  r.properties = read_all(j, "properties", read_property);
  if (j.has("posterior_ensemble")) r.ensemble = read_ensemble(j.at("posterior_ensemble"));
  r.scope = read_all(j, "scope", [](const JsonReader& s) {
    s.allow({"name", "statement"});
    return ScopeLimit{s.string("name"), s.string("statement")};
  });
  j.at("provenance");
  r.provenance = read_provenance(j.at("provenance"));
  r.note = j.string_or_empty("note");
  try {
    check(r);
  } catch (const InputError& e) {
    throw InputError(
        fmt::format("{}: {}{}{}", source, j.path(), j.path().empty() ? "" : ".", e.what()));
  }
  return {r, j.string_or_empty("sha256")};
}

}  // namespace

Json to_json(const MaterialRecord& r) {
  Json j = {{"name", r.name}};
  if (r.version > 0) j["version"] = r.version;
  put(j, "supersedes", r.supersedes);
  j["title"] = r.title;
  j["materials"] = r.materials;
  j["kind"] = to_string(r.kind);
  put_all(j, "parameters", r.parameters, parameter_json);
  put_all(j, "properties", r.properties, property_json);
  if (r.ensemble) j["posterior_ensemble"] = ensemble_json(*r.ensemble);
  put_all(j, "scope", r.scope, [](const ScopeLimit& s) {
    return Json{{"name", s.name}, {"statement", s.statement}};
  });
  j["provenance"] = provenance_json(r.provenance);
  put(j, "note", r.note);
  return j;
}

std::string canonical_text(const MaterialRecord& record) {
  Json json = to_json(record);
  use_first_record_names(json);
  std::string text;
  write(text, json, false, 0);
  return text;
}

std::string record_hash(const MaterialRecord& record) { return sha256(canonical_text(record)); }

std::string pretty_json(const Json& json) {
  std::string text;
  write(text, json, true, 0);
  return text;
}

std::string export_text(const std::vector<MaterialRecord>& records) {
  Json document = {{"format", format_name}, {"format_version", format_version}};
  Json all = Json::array();
  for (const MaterialRecord& record : records) {
    Json j = to_json(record);
    j["sha256"] = record_hash(record);
    all.push_back(j);
  }
  document["records"] = all;
  return pretty_json(document) + "\n";
}

std::vector<ReadRecord> read_records_text(std::string_view text, const std::string& source) {
  nlohmann::json parsed = parse_json(text, source);
  if (parsed.is_object() && parsed.value("format_version", nlohmann::json()) == 1 &&
      parsed.contains("records"))
    for (nlohmann::json& record : parsed["records"]) use_current_record_names(record);
  const JsonReader document(parsed, source);
  document.allow({"format", "format_version", "records"});
  if (const std::string format = document.string("format"); format != format_name)
    document.at("format").fail(fmt::format("is \"{}\"; expected \"{}\"", format, format_name));
  if (const auto version = document.integer("format_version", 1, 1000000); version > format_version)
    document.at("format_version")
        .fail(fmt::format("is {}, of a newer Firn; this one reads up to {}; expected another Firn",
                          version, format_version));
  document.at("records");
  return read_all(document, "records", [&](const JsonReader& j) { return read_record(j, source); });
}

std::vector<ReadRecord> read_records_file(const std::string& file) {
  return read_records_text(
      read_input_file(file, "a file of material records", input_limits::json_bytes), file);
}

MaterialRecord read_canonical(std::string_view text, const std::string& source) {
  nlohmann::json parsed = parse_json(text, source);
  use_current_record_names(parsed);
  return read_record(JsonReader(parsed, source), source).record;
}

}  // namespace firn
