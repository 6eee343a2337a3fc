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

// The program of a calibration, an object within the provenance.
struct ProgramOf {
  Provenance& provenance;
};

}  // namespace

// ---- Keys: found by argument-dependent lookup ----

static Json json_of(Interval& interval) { return {interval.low, interval.high}; }

static void read_key(const JsonReader& j, const char* key, Interval& interval) {
  const std::vector<double> ends = j.numbers(key);
  if (ends.size() != 2)
    j.at(key).fail(fmt::format("has {} numbers; expected two ends", ends.size()));
  interval = {ends[0], ends[1]};
}

static Json json_of(Scale& scale) { return scale == Scale::logarithmic ? "log" : "linear"; }

static void read_key(const JsonReader& j, const char* key, Scale& value) {
  const std::string scale = j.string(key);
  if (scale != "log" && scale != "linear")
    j.at(key).fail(fmt::format("is \"{}\"; expected \"log\" or \"linear\"", scale));
  value = scale == "log" ? Scale::logarithmic : Scale::linear;
}

static Json json_of(RecordKind& kind) { return to_string(kind); }

static void read_key(const JsonReader& j, const char* key, RecordKind& value) {
  const std::string kind = j.string(key);
  std::vector<std::string> known;
  for (const RecordKind k :
       {RecordKind::published, RecordKind::measured, RecordKind::calibrated, RecordKind::assumed}) {
    value = k;
    if (kind == to_string(k)) return;
    known.emplace_back(to_string(k));
  }
  j.at(key).fail(fmt::format("is \"{}\"; expected one of {}", kind, comma_list(known)));
}

static void fields(StrictFields& f, MaterialParameter& p) {
  f.required("name", p.name);
  f.required("keys", p.keys);
  f.required("value", p.value);
  f.required("unit", p.unit);
  f.optional("uncertainty", p.uncertainty);
  f.optional("interval_95", p.interval_95);
  f.optional("note", p.note);
}

static void fields(StrictFields& f, MaterialProperty& p) {
  f.required("name", p.name);
  f.optional("value", p.value);
  f.optional("uncertainty", p.uncertainty);
  f.optional("range", p.range);
  f.optional("unit", p.unit);
  f.optional("conditions", p.conditions);
  f.optional("statement", p.statement);
}

static void fields(StrictFields& f, MaterialResponse& r) {
  f.required("name", r.name);
  f.required("value", r.value);
  f.optional("uncertainty", r.uncertainty);
  f.required("unit", r.unit);
}

static void fields(StrictFields& f, ReferenceRun& r) {
  f.optional("experiment", r.experiment);
  f.required("seed", r.seed);
  f.optional("responses", r.responses);
}

static void fields(StrictFields& f, ReferenceSet& s) {
  f.required("name", s.name);
  f.required("values", s.values);
  f.optional("predicted", s.predicted);
  f.optional("runs", s.runs);
}

static void fields(StrictFields& f, EnsembleAxis& a) {
  f.required("parameter", a.parameter);
  f.required("scale", a.scale);
  f.required("min", a.bounds.low);
  f.required("max", a.bounds.high);
  f.required("mean", a.mean);
}

static void fields(StrictFields& f, EnsembleCombination& c) {
  f.required("coefficients", c.coefficients);
  f.required("identifiable", c.identifiable);
  if (f.lists_keys() || c.identifiable) f.required("value", c.value);
  f.optional("uncertainty", c.uncertainty);
}

static void fields(StrictFields& f, EnsembleSample& s) {
  f.required("values", s.values);
  f.required("weight", s.weight);
}

static void fields(StrictFields& f, PosteriorEnsemble& e) {
  f.optional("axes", e.axes);
  f.required("covariance", e.covariance);
  f.optional("combinations", e.combinations);
  f.optional("samples", e.samples);
  f.optional("reference_sets", e.reference_sets);
}

static void fields(StrictFields& f, ScopeLimit& s) {
  f.required("name", s.name);
  f.required("statement", s.statement);
}

static void fields(StrictFields& f, RawData& d) {
  f.required("what", d.what);
  f.required("file", d.file);
  f.required("sha256", d.sha256);
}

static void fields(StrictFields& f, UsedMeasurement& m) {
  f.optional("name", m.name);
  f.required("response", m.response);
  f.required("value", m.value);
  f.required("uncertainty", m.uncertainty);
  f.required("unit", m.unit);
  f.required("source", m.source);
  f.optional("experiment", m.experiment);
  f.written_if(m.discrepancy > 0, "discrepancy", m.discrepancy);
}

static void fields(StrictFields& f, ProgramOf& p) {
  f.required("version", p.provenance.program_version);
  f.required("commit", p.provenance.program_commit);
  f.required("identity", p.provenance.program);
  f.written_if(p.provenance.contact_model > 1, "contact_model",
               WholeNumber{p.provenance.contact_model});
}

static void fields(StrictFields& f, UsedEstimator& e) {
  f.required("response", e.response);
  f.required("method", e.method);
  f.required("version", WholeNumber{e.version});
}

static void fields(StrictFields& f, SimulatedCase& c) {
  f.optional("experiment", c.experiment);
  f.required("parameters", c.parameters);
  f.required("text", c.text);
}

static void fields(StrictFields& f, Provenance& p) {
  f.required("author", p.author);
  f.required("date", p.date);
  f.required("source", p.source);
  f.optional("raw_data", p.raw_data);
  f.optional("measurements", p.measurements);
  f.optional("study", p.study);
  f.written_if(!p.program_version.empty(), "program", ProgramOf{p});
  f.optional("seeds", p.seeds);
  f.optional("estimators", p.estimators);
  f.optional("command", p.command);
  f.optional("cases", p.cases);
}

static void fields(StrictFields& f, MaterialRecord& r) {
  f.required("name", r.name);
  f.written_if(r.version > 0, "version", WholeNumber{r.version, 1000000000});
  f.optional("supersedes", r.supersedes);
  f.required("title", r.title);
  f.required("materials", r.materials);
  f.required("kind", r.kind);
  f.optional("parameters", r.parameters);
  f.optional("properties", r.properties);
  f.optional("posterior_ensemble", r.ensemble);
  f.optional("scope", r.scope);
  f.required("provenance", r.provenance);
  f.optional("note", r.note);
}

namespace {

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

ReadRecord read_record(const JsonReader& j, const std::string& source) {
  MaterialRecord r;
  read_object(j, r, "sha256");
  try {
    check(r);
  } catch (const InputError& e) {
    throw InputError(
        fmt::format("{}: {}{}{}", source, j.path(), j.path().empty() ? "" : ".", e.what()));
  }
  return {r, j.string_or_empty("sha256")};
}

}  // namespace

Json to_json(const MaterialRecord& record) {
  MaterialRecord r = record;  // fields() takes what can be changed
  return json_of(r);
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
  std::vector<ReadRecord> records;
  for (const JsonReader& j : document.items("records")) records.push_back(read_record(j, source));
  return records;
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
