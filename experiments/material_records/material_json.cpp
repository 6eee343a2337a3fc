#include "experiments/material_records/material_json.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>

#include "experiments/storage/sha256.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/json_aliases.h"
#include "experiments/text/json_fields.h"
#include "experiments/text/json_parser.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* format_name = "firn material records";
constexpr int format_version = 2;  // 1: other names of keys (json_aliases.h)

// The program of a calibration, an object within the provenance.
struct ProgramOf {
  Provenance& provenance;
};

struct FileHeader {
  std::string format;
  int version = 0;
};

struct RecordFile {
  FileHeader header;
  std::vector<ReadRecord> records;
};

}  // namespace

// ---- Keys: found by argument-dependent lookup ----

static Json json_value(Interval& interval) { return {interval.low, interval.high}; }

static void read_json_value(const Json& json, const JsonPlace& place, Interval& interval) {
  std::pair<double, double> ends;
  JsonFieldReader::read(json, place, ends);
  interval = {ends.first, ends.second};
}

static Json json_value(Scale& scale) { return scale == Scale::logarithmic ? "log" : "linear"; }

static void read_json_value(const Json& json, const JsonPlace& place, Scale& scale) {
  if (json != "log" && json != "linear") place.refuse(json, "\"log\" or \"linear\"");
  scale = json == "log" ? Scale::logarithmic : Scale::linear;
}

static Json json_value(RecordKind& kind) { return to_string(kind); }

static void read_json_value(const Json& json, const JsonPlace& place, RecordKind& kind) {
  std::vector<std::string> known;
  for (const RecordKind k :
       {RecordKind::published, RecordKind::measured, RecordKind::calibrated, RecordKind::assumed}) {
    kind = k;
    if (json == to_string(k)) return;
    known.emplace_back(to_string(k));
  }
  place.refuse(json, "one of " + comma_list(known));
}

template <class Fields>
static void fields(Fields& f, MaterialParameter& p) {
  f.required("name", p.name);
  f.added("keys", p.keys);
  f.required("value", p.value);
  f.required("unit", p.unit);
  f.optional("uncertainty", p.uncertainty);
  f.optional("interval_95", p.interval_95);
  f.optional("note", p.note);
}

template <class Fields>
static void fields(Fields& f, MaterialProperty& p) {
  f.required("name", p.name);
  f.optional("value", p.value);
  f.optional("uncertainty", p.uncertainty);
  f.optional("range", p.range);
  f.optional("unit", p.unit);
  f.optional("conditions", p.conditions);
  f.optional("statement", p.statement);
}

template <class Fields>
static void fields(Fields& f, MaterialResponse& r) {
  f.required("name", r.name);
  f.required("value", r.value);
  f.optional("uncertainty", r.uncertainty);
  f.required("unit", r.unit);
}

template <class Fields>
static void fields(Fields& f, ReferenceRun& r) {
  f.optional("experiment", r.experiment);
  f.required("seed", r.seed);
  f.optional("responses", r.responses);
}

template <class Fields>
static void fields(Fields& f, ReferenceSet& s) {
  f.required("name", s.name);
  f.required("values", s.values);
  f.optional("predicted", s.predicted);
  f.optional("runs", s.runs);
}

template <class Fields>
static void fields(Fields& f, EnsembleAxis& a) {
  f.required("parameter", a.parameter);
  f.required("scale", a.scale);
  f.required("min", a.bounds.low);
  f.required("max", a.bounds.high);
  f.required("mean", a.mean);
}

template <class Fields>
static void fields(Fields& f, EnsembleCombination& c) {
  f.required("coefficients", c.coefficients);
  f.required("identifiable", c.identifiable);
  f.required_if(c.identifiable, "value", c.value);
  f.optional("uncertainty", c.uncertainty);
}

template <class Fields>
static void fields(Fields& f, EnsembleSample& s) {
  f.required("values", s.values);
  f.required("weight", s.weight);
}

template <class Fields>
static void fields(Fields& f, PosteriorEnsemble& e) {
  f.optional("axes", e.axes);
  f.added("covariance", e.covariance);
  f.optional("combinations", e.combinations);
  f.optional("samples", e.samples);
  f.optional("reference_sets", e.reference_sets);
}

template <class Fields>
static void fields(Fields& f, ScopeLimit& s) {
  f.required("name", s.name);
  f.required("statement", s.statement);
}

template <class Fields>
static void fields(Fields& f, RawData& d) {
  f.required("what", d.what);
  f.required("file", d.file);
  f.required("sha256", d.sha256);
}

template <class Fields>
static void fields(Fields& f, UsedMeasurement& m) {
  f.optional("name", m.name);
  f.required("response", m.response);
  f.required("value", m.value);
  f.required("uncertainty", m.uncertainty);
  f.required("unit", m.unit);
  f.required("source", m.source);
  f.optional("experiment", m.experiment);
  f.written_if(m.discrepancy > 0, "discrepancy", m.discrepancy);
}

template <class Fields>
static void fields(Fields& f, ProgramOf& p) {
  f.required("version", p.provenance.program_version);
  f.required("commit", p.provenance.program_commit);
  f.required("identity", p.provenance.program);
  f.written_if(p.provenance.contact_model > 1, "contact_model",
               PositiveInt{p.provenance.contact_model});
}

template <class Fields>
static void fields(Fields& f, UsedEstimator& e) {
  f.required("response", e.response);
  f.required("method", e.method);
  f.required("version", PositiveInt{e.version});
}

template <class Fields>
static void fields(Fields& f, SimulatedCase& c) {
  f.optional("experiment", c.experiment);
  f.required("parameters", c.parameters);
  f.required("text", c.text);
}

template <class Fields>
static void fields(Fields& f, Provenance& p) {
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

template <class Fields>
static void fields(Fields& f, MaterialRecord& r) {
  f.required("name", r.name);
  f.written_if(r.version > 0, "version", PositiveInt{r.version, 1000000000});
  f.optional("supersedes", r.supersedes);
  f.required("title", r.title);
  f.added("materials", r.materials);
  f.required("kind", r.kind);
  f.optional("parameters", r.parameters);
  f.optional("properties", r.properties);
  f.optional("posterior_ensemble", r.ensemble);
  f.optional("scope", r.scope);
  f.required("provenance", r.provenance);
  f.optional("note", r.note);
}

template <class Fields>
static void fields(Fields& f, ReadRecord& r) {
  fields(f, r.record);
  f.optional("sha256", r.sha256);
}

template <class Fields>
static void fields(Fields& f, FileHeader& header) {
  f.required("format", header.format);
  f.required("format_version", PositiveInt{header.version});
}

template <class Fields>
static void fields(Fields& f, RecordFile& file) {
  fields(f, file.header);
  f.required("records", file.records);
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

// Throws InputError for a record whose values contradict each other. `path`: of the record in the
// text; empty for a record alone.
void check_read(const MaterialRecord& record, const std::string& source, std::string_view text,
                const std::vector<std::string>& path) {
  try {
    check(record);
  } catch (const InputError& e) {
    const std::string problem = e.what();  // FIELD: FAULT
    std::vector<std::string> whole = path;
    std::istringstream field(problem.substr(0, problem.find(':')));
    for (std::string key; std::getline(field, key, '.');) whole.push_back(key);
    throw InputError(fmt::format("{}: {}{}{}", json_place(source, text, whole),
                                 fmt::join(path, "."), path.empty() ? "" : ".", problem));
  }
}

}  // namespace

Json to_json(const MaterialRecord& record) {
  MaterialRecord r = record;  // fields() takes what can be changed
  return JsonFieldWriter::json_of(r);
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
  RecordFile file{{format_name, format_version}, {}};
  for (const MaterialRecord& record : records)
    file.records.push_back({record, record_hash(record)});
  return pretty_json(JsonFieldWriter::json_of(file)) + "\n";
}

std::vector<ReadRecord> read_records_text(std::string_view text, const std::string& source) {
  Json document = parse_json(text, source);
  const auto header = document_from_json<FileHeader>(document, source, JsonReading::tolerant, text);
  if (header.format != format_name)
    throw InputError(fmt::format("{}: format: is \"{}\"; expected \"{}\"",
                                 json_place(source, text, {"format"}), shortened(header.format),
                                 format_name));
  if (header.version > format_version)
    throw InputError(
        fmt::format("{}: format_version: is {}, of a newer Firn; this one reads up to {}; expected "
                    "another Firn",
                    json_place(source, text, {"format_version"}), header.version, format_version));
  if (header.version == 1 && document.contains("records"))
    for (Json& record : document["records"]) use_current_record_names(record);
  auto file = document_from_json<RecordFile>(document, source, JsonReading::strict, text);
  for (std::size_t i = 0; i < file.records.size(); ++i)
    check_read(file.records[i].record, source, text, {"records", std::to_string(i)});
  return std::move(file.records);
}

std::vector<ReadRecord> read_records_file(const std::string& file) {
  return read_records_text(
      read_input_file(file, "a file of material records", input_limits::json_bytes), file);
}

MaterialRecord read_canonical(std::string_view text, const std::string& source) {
  Json document = parse_json(text, source);
  use_current_record_names(document);
  auto record = document_from_json<ReadRecord>(document, source, JsonReading::strict).record;
  check_read(record, source, {}, {});
  return record;
}

}  // namespace firn
