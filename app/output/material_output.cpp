#include "app/output/material_output.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/material_records/material_json.h"
#include "experiments/text/number_text.h"

namespace firn {
namespace {

constexpr std::size_t long_text = 60;  // longer texts: their lengths are compared

std::string value_text(double value, const std::optional<double>& uncertainty,
                       const std::string& unit) {
  return (uncertainty ? measured_text(value, *uncertainty) : number_text(value, 6)) +
         unit_suffix(unit);
}

std::string range_text(const Interval& i, const std::string& unit) {
  return fmt::format("{:.4g} to {:.4g}{}", i.low, i.high, unit_suffix(unit));
}

template <class... Args>
void line(std::string& out, fmt::format_string<Args...> format, Args&&... args) {
  out += fmt::format(format, std::forward<Args>(args)...) + "\n";
}

void append_values(std::string& out, const MaterialRecord& r) {
  if (!r.parameters.empty()) out += "\nvalues for cases\n";
  for (const MaterialParameter& p : r.parameters) {
    std::string known;
    if (p.interval_95) known += fmt::format(" (95 %: {})", range_text(*p.interval_95, p.unit));
    line(out, "  {:<26} {}{}", p.name, value_text(p.value, p.uncertainty, p.unit), known);
    for (const std::string& key : p.keys) line(out, "  {:<26} -> {}", "", key);
    if (!p.note.empty()) line(out, "  {:<26} {}", "", p.note);
  }
  if (!r.properties.empty()) out += "\nother properties (not used by cases)\n";
  for (const MaterialProperty& p : r.properties) {
    std::string text;
    if (p.value) text += value_text(*p.value, p.uncertainty, p.unit);
    if (p.range) text += (text.empty() ? "" : ", ") + range_text(*p.range, p.unit);
    if (!p.statement.empty()) text += (text.empty() ? "" : "; ") + p.statement;
    line(out, "  {:<26} {}{}", p.name, text, p.conditions.empty() ? "" : " (" + p.conditions + ")");
  }
}

// Mean over the runs of a reference set, response by response.
std::string simulated_text(const ReferenceSet& a) {
  std::map<std::string, std::pair<std::string, std::vector<double>>> all;  // unit and values
  for (const ReferenceRun& run : a.runs) {
    for (const MaterialResponse& r : run.responses) {
      auto& [unit, values] = all[run.experiment.empty() ? r.name : run.experiment + ": " + r.name];
      unit = r.unit;
      values.push_back(r.value);
    }
  }
  std::string text;
  for (const auto& [name, response] : all) {
    const auto& [unit, values] = response;
    text += fmt::format(
        "{}{} {:.4g}{}{}", text.empty() ? "" : ", ", name, mean(values),
        values.size() > 1 ? fmt::format(" (sd {:.2g})", standard_deviation(values)) : "",
        unit_suffix(unit));
  }
  return text;
}

void append_combinations(std::string& out, const PosteriorEnsemble& f) {
  for (const EnsembleCombination& c : f.combinations) {
    std::string sum;
    for (std::size_t i = 0; i < f.axes.size(); ++i) {
      const EnsembleAxis& a = f.axes[i];
      const double factor = c.coefficients[i];
      sum += fmt::format("{}{:.2f} {}",
                         sum.empty()  ? factor < 0 ? "-" : ""
                         : factor < 0 ? " - "
                                      : " + ",
                         std::abs(factor),
                         a.scale == Scale::logarithmic ? "ln(" + a.parameter + ")" : a.parameter);
    }
    if (!c.identifiable) {
      line(out, "  {:<26} {}", "not identifiable", sum);
      continue;
    }
    line(out, "  {:<26} {} = {}", "identifiable", sum,
         c.uncertainty ? measured_text(c.value, *c.uncertainty) : number_text(c.value, 3));
  }
}

void append_ensemble(std::string& out, const MaterialRecord& r) {
  if (!r.ensemble) return;
  const PosteriorEnsemble& f = *r.ensemble;
  line(out, "\nposterior ensemble: {}; sample with #1, #2, ...",
       f.samples.empty() ? "Gaussian, cut at the bounds"
                         : fmt::format("{} samples of the posterior", f.samples.size()));
  for (std::size_t i = 0; i < f.axes.size(); ++i) {
    const EnsembleAxis& a = f.axes[i];
    line(out, "  {:<26} from {} to {}; {} {}", a.parameter, a.bounds.low, a.bounds.high,
         a.scale == Scale::logarithmic ? "logarithm" : "value",
         measured_text(a.mean, std::sqrt(f.covariance[i][i])));
  }
  append_combinations(out, f);
  for (const ReferenceSet& a : f.reference_sets) {
    std::string values;
    for (std::size_t i = 0; i < f.axes.size(); ++i)
      values += fmt::format("{}{} {:.4g}", i == 0 ? "" : ", ", f.axes[i].parameter, a.values[i]);
    line(out, "  {:<26} {}", "#" + a.name, values);
    if (!a.runs.empty())
      line(out, "  {:<26} simulated {} times: {}", "", a.runs.size(), simulated_text(a));
    for (const MaterialResponse& p : a.predicted)
      line(out, "  {:<26} the study's model predicts {} {}", "", p.name,
           value_text(p.value, p.uncertainty, p.unit));
  }
}

void append_provenance(std::string& out, const StoredRecord& s) {
  const MaterialRecord& r = s.record;
  const Provenance& p = r.provenance;
  out += "\nwhere it comes from\n";
  line(out, "  {:<14} {}", "source", p.source);
  line(out, "  {:<14} {}, {}", "author, date", p.author, p.date);
  for (const UsedMeasurement& m : p.measurements)
    line(out, "  {:<14} {} = {}{}; {}", "measurement", m.response,
         value_text(m.value, m.uncertainty, m.unit),
         m.discrepancy > 0 ? ", discrepancy of the simulation ± " + number_text(m.discrepancy, 2) +
                                 unit_suffix(m.unit)
                           : "",
         m.source);
  if (!p.program_version.empty())
    line(out, "  {:<14} firn {}, commit {}, identity {}, contact model {}", "program",
         p.program_version, p.program_commit, p.program, p.contact_model);
  for (const UsedEstimator& e : p.estimators)
    line(out, "  {:<14} {}: {}, version {}", "estimator", e.response, e.method, e.version);
  if (!p.seeds.empty()) {
    std::vector<std::string> seeds;
    for (const std::uint64_t seed : p.seeds) seeds.push_back(std::to_string(seed));
    line(out, "  {:<14} {}", "seeds", comma_list(seeds));
  }
  for (const RawData& d : p.raw_data)
    line(out, "  {:<14} {} ({}), sha256 {}", "raw data", d.file, d.what, d.sha256);
  if (!p.command.empty()) line(out, "  {:<14} {}", "made by", p.command);
  if (!r.supersedes.empty()) line(out, "  {:<14} sha256 {}", "supersedes", r.supersedes);
  line(out, "  {:<14} {}", "sha256", s.sha256);
}

// Arrays of named things as objects, so that one more of them is one difference.
Json by_name(const Json& json) {
  if (json.is_object()) {
    Json object = Json::object();
    for (const auto& [key, value] : json.items()) object[key] = by_name(value);
    return object;
  }
  if (!json.is_array() || json.empty()) return json;
  Json object = Json::object();
  for (const Json& item : json) {
    std::string name;
    for (const char* key : {"name", "parameter", "response", "file"})
      if (name.empty() && item.is_object() && item.contains(key)) name = item[key];
    if (name.empty()) return json;  // compared as a whole
    std::string unique = name;
    for (int k = 2; object.contains(unique); ++k) unique = fmt::format("{} {}", name, k);
    object[unique] = by_name(item);
  }
  return object;
}

void compare(const std::string& path, const Json& from, const Json& to,
             std::vector<RecordChange>& all) {
  if (from == to) return;
  if (!from.is_object() || !to.is_object()) {
    all.push_back({path, from, to});
    return;
  }
  std::vector<std::string> keys;
  for (const auto& [key, value] : from.items()) keys.push_back(key);
  for (const auto& [key, value] : to.items())
    if (!from.contains(key)) keys.push_back(key);
  for (const std::string& key : keys)
    compare(path.empty() ? key : path + "." + key, from.contains(key) ? from[key] : Json(),
            to.contains(key) ? to[key] : Json(), all);
}

std::string short_text(const Json& json) {
  if (json.is_null()) return "none";
  const std::string text = json.is_string() ? json.get<std::string>() : json.dump();
  if (text.size() <= long_text && text.find('\n') == text.npos) return text;
  return json.is_string() ? fmt::format("(text of {} characters)", text.size())
                          : fmt::format("({} entries)", json.size());
}

}  // namespace

std::string records_table(const std::vector<StoredRecord>& records) {
  std::size_t width = 0, materials = 0;
  for (const StoredRecord& s : records) {
    width = std::max(width, s.record.reference().size());
    materials = std::max(materials, comma_list(s.record.materials).size());
  }
  std::string out;
  for (const StoredRecord& s : records) {
    const MaterialRecord& r = s.record;
    line(out, "{:<{}}  {:<{}}  {:<10}  {:<7}  {:<6}  {}", r.reference(), width,
         comma_list(r.materials), materials, to_string(r.kind), s.shipped ? "shipped" : "own",
         r.ensemble             ? "ensemble"
         : r.parameters.empty() ? "facts"
                                : "values",
         r.title);
  }
  return out;
}

Json records_json(const std::vector<StoredRecord>& records) {
  Json all = Json::array();
  for (const StoredRecord& s : records) {
    const MaterialRecord& r = s.record;
    all.push_back({{"name", r.name},
                   {"version", r.version},
                   {"title", r.title},
                   {"materials", r.materials},
                   {"kind", to_string(r.kind)},
                   {"parameters", r.parameters.size()},
                   {"properties", r.properties.size()},
                   {"posterior_ensemble", r.ensemble.has_value()},
                   {"author", r.provenance.author},
                   {"date", r.provenance.date},
                   {"note", r.note},
                   {"shipped", s.shipped},
                   {"sha256", s.sha256}});
  }
  return all;
}

std::string record_text(const StoredRecord& stored) {
  const MaterialRecord& r = stored.record;
  std::string out;
  line(out, "{}: {}", r.reference(), r.title);
  line(out, "{}{}; about {}", to_string(r.kind), stored.shipped ? ", ships with Firn" : "",
       comma_list(r.materials));
  append_values(out, r);
  append_ensemble(out, r);
  out += "\nholds for\n";
  for (const ScopeLimit& s : r.scope) line(out, "  {:<26} {}", s.name, s.statement);
  append_provenance(out, stored);
  if (!r.note.empty()) line(out, "\nnote\n  {}", r.note);
  return out;
}

Json record_json(const StoredRecord& stored) {
  Json json = to_json(stored.record);
  json["sha256"] = stored.sha256;
  json["shipped"] = stored.shipped;
  return json;
}

std::vector<RecordChange> changes(const MaterialRecord& from, const MaterialRecord& to) {
  std::vector<RecordChange> all;
  Json a = by_name(to_json(from)), b = by_name(to_json(to));
  for (const char* identity : {"name", "version", "supersedes"}) {
    a.erase(identity);
    b.erase(identity);
  }
  compare("", a, b, all);
  return all;
}

std::string changes_table(const std::vector<RecordChange>& all) {
  std::size_t width = 0;
  for (const RecordChange& c : all) width = std::max(width, c.path.size());
  std::string out;
  for (const RecordChange& c : all) {
    std::string factor;
    if (c.from.is_number() && c.to.is_number() && c.from.get<double>() != 0)
      factor = fmt::format("  (x {:.4g})", c.to.get<double>() / c.from.get<double>());
    line(out, "{:<{}}  {} -> {}{}", c.path, width, short_text(c.from), short_text(c.to), factor);
  }
  return out;
}

Json changes_json(const std::vector<RecordChange>& all) {
  Json json = Json::array();
  for (const RecordChange& c : all)
    json.push_back({{"path", c.path}, {"from", c.from}, {"to", c.to}});
  return json;
}

}  // namespace firn
