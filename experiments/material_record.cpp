#include "experiments/material_record.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>
#include <string_view>

namespace firn {
namespace {

struct KnownKey {
  std::string_view table, key;
  Dimension dimension;
};
constexpr KnownKey known_keys[] = {
    {"materials", "density", dimension::density},
    {"materials", "young_modulus", dimension::pressure},
    {"materials", "poisson_ratio", dimension::none},
    {"interactions", "static_friction", dimension::none},
    {"interactions", "dynamic_friction", dimension::none},
    {"interactions", "restitution", dimension::none},
    {"interactions", "tangential_stiffness_ratio", dimension::none},
    {"interactions", "unloading_floor", dimension::none},
    {"interactions", "rolling_resistance", dimension::none},
    {"interactions", "sliding_speed", dimension::velocity},
    {"interactions", "adhesion_force", dimension::force},
    {"interactions", "adhesion_stiffness_fraction", dimension::none},
};

constexpr std::uint64_t largest_sample = 1'000'000'000'000;

bool plain(std::string_view text, std::string_view also) {
  return !text.empty() && std::ranges::all_of(text, [&](unsigned char c) {
    return (c < 128 && std::isalnum(c)) || also.find(static_cast<char>(c)) != also.npos;
  });
}

[[noreturn]] void refuse(const std::string& field, const std::string& message) {
  throw InputError(fmt::format("{}: {}", field, message));
}

void require_text(const std::string& field, const std::string& text, const char* wanted) {
  if (text.empty()) refuse(field, fmt::format("missing; expected {}", wanted));
}

void require_finite(const std::string& field, double value) {
  if (!std::isfinite(value)) refuse(field, fmt::format("is {}; expected a finite number", value));
}

void require_interval(const std::string& field, const Interval& i) {
  require_finite(field, i.low);
  require_finite(field, i.high);
  if (i.low > i.high)
    refuse(field,
           fmt::format("runs from {} down to {}; expected the lower end first", i.low, i.high));
}

Dimension require_unit(const std::string& field, const std::string& unit) {
  if (unit == "1") return dimension::none;
  require_text(field, unit, "a unit, \"1\" for a bare number");
  try {
    return parse_unit(unit).dimension;
  } catch (const InputError& e) {
    refuse(field, e.what());
  }
}

void check_parameter(const std::string& field, const MaterialParameter& p,
                     const std::vector<std::string>& materials, std::set<std::string>& bound) {
  if (!plain(p.name, "_-"))
    refuse(field + ".name", fmt::format("is \"{}\"; expected letters, digits, _ and -", p.name));
  if (p.keys.empty()) refuse(field + ".keys", "are none; expected case keys that take the value");
  const Dimension dimension = require_unit(field + ".unit", p.unit);
  for (std::size_t i = 0; i < p.keys.size(); ++i) {
    const std::string place = fmt::format("{}.keys.{}", field, i);
    const MaterialKey key = [&] {
      try {
        return parse_material_key(p.keys[i]);
      } catch (const InputError& e) {
        refuse(place, e.what());
      }
    }();
    for (const std::string& m : key.materials)
      if (std::ranges::find(materials, m) == materials.end())
        refuse(place, fmt::format("is about \"{}\", which is none of the record's materials; "
                                  "expected one of {}",
                                  m, comma_list(materials)));
    if (!(key.dimension == dimension))
      refuse(field + ".unit", fmt::format("is \"{}\", but {} takes {}; expected a unit that fits",
                                          p.unit, key.key, dimension_name(key.dimension)));
    if (!bound.insert(p.keys[i]).second)
      refuse(place, fmt::format("\"{}\" is bound twice; expected one parameter a key", p.keys[i]));
  }
  require_finite(field + ".value", p.value);
  if (p.uncertainty && !(*p.uncertainty >= 0 && std::isfinite(*p.uncertainty)))
    refuse(field + ".uncertainty", fmt::format("is {}; expected at least 0", *p.uncertainty));
  if (p.interval_95) require_interval(field + ".interval_95", *p.interval_95);
}

void check_property(const std::string& field, const MaterialProperty& p) {
  require_text(field + ".name", p.name, "what the property is");
  if (!p.value && !p.range && p.statement.empty())
    refuse(field, "says nothing; expected a value, a range or a statement");
  if (p.value) require_finite(field + ".value", *p.value);
  if (p.uncertainty && !(p.value && *p.uncertainty >= 0 && std::isfinite(*p.uncertainty)))
    refuse(field + ".uncertainty", "is not that of a value; expected at least 0, beside a value");
  if (p.range) require_interval(field + ".range", *p.range);
  if (p.value || p.range) require_text(field + ".unit", p.unit, "a unit, \"1\" for a bare number");
}

// Symmetric, and no direction with a negative variance beyond rounding.
void check_covariance(const std::string& field, const std::vector<std::vector<double>>& rows,
                      std::size_t n) {
  if (rows.size() != n) refuse(field, fmt::format("has {} rows; expected {}", rows.size(), n));
  Eigen::MatrixXd m(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    if (rows[i].size() != n)
      refuse(fmt::format("{}.{}", field, i),
             fmt::format("has {} numbers; expected {}", rows[i].size(), n));
    for (std::size_t j = 0; j < n; ++j) {
      require_finite(fmt::format("{}.{}.{}", field, i, j), rows[i][j]);
      m(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j];
    }
  }
  if (m != m.transpose()) refuse(field, "is not symmetric; expected a covariance");
  const double largest = m.cwiseAbs().maxCoeff();
  if (Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m).eigenvalues().minCoeff() < -1e-9 * largest)
    refuse(field, "has a negative variance in some direction; expected a covariance");
}

void check_responses(const std::string& field, const std::vector<MaterialResponse>& all) {
  for (std::size_t i = 0; i < all.size(); ++i) {
    require_text(fmt::format("{}.{}.name", field, i), all[i].name, "a response");
    require_finite(fmt::format("{}.{}.value", field, i), all[i].value);
  }
}

void check_family(const MaterialRecord& r) {
  const MaterialFamily& f = *r.family;
  const std::size_t n = f.axes.size();
  if (n == 0) refuse("family.axes", "are none; expected the parameters that vary");
  std::set<std::string> names;
  for (std::size_t i = 0; i < n; ++i) {
    const FamilyAxis& axis = f.axes[i];
    const std::string field = fmt::format("family.axes.{}", i);
    if (std::ranges::find(r.parameters, axis.parameter, &MaterialParameter::name) ==
        r.parameters.end())
      refuse(field + ".parameter",
             fmt::format("\"{}\" is no parameter of the record; expected one", axis.parameter));
    if (!names.insert(axis.parameter).second)
      refuse(field + ".parameter", fmt::format("\"{}\" is there twice", axis.parameter));
    require_interval(field + ".bounds", axis.bounds);
    if (!(axis.bounds.low < axis.bounds.high))
      refuse(field + ".bounds", "are a point; expected a range");
    if (axis.scale == Scale::logarithmic && !(axis.bounds.low > 0))
      refuse(field + ".bounds", "reach zero; expected more for a logarithmic scale");
    require_finite(field + ".mean", axis.mean);
  }
  const auto check_values = [&](const std::string& field, const std::vector<double>& values) {
    if (values.size() != n)
      refuse(field, fmt::format("has {} numbers; expected {}", values.size(), n));
    for (std::size_t i = 0; i < n; ++i)
      if (!(values[i] >= f.axes[i].bounds.low && values[i] <= f.axes[i].bounds.high))
        refuse(fmt::format("{}.{}", field, i),
               fmt::format("is {}; expected a value within the bounds {} to {}", values[i],
                           f.axes[i].bounds.low, f.axes[i].bounds.high));
  };
  check_covariance("family.covariance", f.covariance, n);
  for (std::size_t i = 0; i < f.combinations.size(); ++i)
    if (f.combinations[i].coefficients.size() != n)
      refuse(fmt::format("family.combinations.{}.coefficients", i),
             fmt::format("are {}; expected {}", f.combinations[i].coefficients.size(), n));
  double sum = 0;
  for (std::size_t i = 0; i < f.points.size(); ++i) {
    const std::string field = fmt::format("family.points.{}", i);
    check_values(field + ".values", f.points[i].values);
    if (!(f.points[i].weight > 0))
      refuse(field + ".weight", fmt::format("is {}; expected more than 0", f.points[i].weight));
    sum += f.points[i].weight;
  }
  if (!f.points.empty() && std::abs(sum - 1) > 1e-6)
    refuse("family.points", fmt::format("weigh {} together; expected 1", sum));
  for (std::size_t i = 0; i < f.anchors.size(); ++i) {
    const Anchor& a = f.anchors[i];
    const std::string field = fmt::format("family.anchors.{}", i);
    require_text(field + ".name", a.name, "a name");
    if (std::ranges::all_of(a.name, [](unsigned char c) { return c < 128 && std::isdigit(c); }))
      refuse(field + ".name", "is a number, like a sample's; expected a word");
    check_values(field + ".values", a.values);
    check_responses(field + ".predicted", a.predicted);
    for (std::size_t k = 0; k < a.runs.size(); ++k)
      check_responses(fmt::format("{}.runs.{}.responses", field, k), a.runs[k].responses);
  }
}

bool is_hash(const std::string& text) {
  return text.size() == 64 && std::ranges::all_of(text, [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

// 2026-11-21, with or without T18:02:11Z.
bool is_date(const std::string& text) {
  constexpr std::string_view shape = "0000-00-00T00:00:00Z";
  if (text.size() != 10 && text.size() != shape.size()) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool digit = text[i] >= '0' && text[i] <= '9';
    if (shape[i] == '0' ? !digit : text[i] != shape[i]) return false;
  }
  const int month = std::stoi(text.substr(5, 2)), day = std::stoi(text.substr(8, 2));
  return month >= 1 && month <= 12 && day >= 1 && day <= 31;
}

void check_provenance(const MaterialRecord& r) {
  const Provenance& p = r.provenance;
  require_text("provenance.author", p.author, "who answers for the record");
  if (!is_date(p.date))
    refuse("provenance.date",
           fmt::format("is \"{}\"; expected a date such as 2026-11-21 or 2026-11-21T18:02:11Z",
                       p.date));
  require_text("provenance.source", p.source,
               "where the values come from: publication and table, notebook, study");
  for (std::size_t i = 0; i < p.raw_data.size(); ++i) {
    const std::string field = fmt::format("provenance.raw_data.{}", i);
    require_text(field + ".what", p.raw_data[i].what, "what the file is");
    require_text(field + ".file", p.raw_data[i].file, "a file");
    if (!is_hash(p.raw_data[i].sha256))
      refuse(field + ".sha256", "is no hash; expected 64 lower-case hexadecimal digits");
  }
  const bool needs_data = r.kind == RecordKind::measured || r.kind == RecordKind::calibrated;
  if (needs_data && p.raw_data.empty())
    refuse("provenance.raw_data", fmt::format("is missing; expected the files, with their hashes, "
                                              "that a {} record was made from",
                                              to_string(r.kind)));
  for (std::size_t i = 0; i < p.measurements.size(); ++i) {
    const UsedMeasurement& m = p.measurements[i];
    const std::string field = fmt::format("provenance.measurements.{}", i);
    require_text(field + ".response", m.response, "the response that was measured");
    require_text(field + ".source", m.source, "where the measurement comes from");
    require_finite(field + ".value", m.value);
    if (!(m.uncertainty >= 0 && std::isfinite(m.uncertainty)))
      refuse(field + ".uncertainty", fmt::format("is {}; expected at least 0", m.uncertainty));
  }
  if (r.kind != RecordKind::calibrated) return;
  require_text("provenance.program.version", p.program_version, "of the program that simulated");
  require_text("provenance.program.commit", p.program_commit, "of the program that simulated");
  require_text("provenance.study", p.study, "the study's name");
  require_text("provenance.program.identity", p.program, "of the program that simulated");
  if (p.cases.empty()) refuse("provenance.cases", "is missing; expected the complete cases");
  for (std::size_t i = 0; i < p.cases.size(); ++i) {
    require_text(fmt::format("provenance.cases.{}.text", i), p.cases[i].text, "a complete case");
    for (const std::string& name : p.cases[i].parameters)
      if (std::ranges::find(r.parameters, name, &MaterialParameter::name) == r.parameters.end())
        refuse(fmt::format("provenance.cases.{}.parameters", i),
               fmt::format("\"{}\" is no parameter of the record; expected one", name));
  }
  require_text("provenance.command", p.command, "what makes the values again");
  if (p.measurements.empty())
    refuse("provenance.measurements", "is missing; expected what the values were fitted to");
  if (p.seeds.empty()) refuse("provenance.seeds", "is missing; expected those of the runs");
  if (p.estimators.empty())
    refuse("provenance.estimators", "is missing; expected how each response was measured");
}

std::uint64_t mix(std::uint64_t x) {  // splitmix64
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

// Two independent standard normal numbers (Box and Muller), a pure function of the counter.
std::pair<double, double> normal_pair(std::uint64_t counter) {
  const auto uniform = [](std::uint64_t bits) {  // above 0, up to 1
    return (static_cast<double>(bits >> 11) + 1) * 0x1p-53;
  };
  const double r = std::sqrt(-2 * std::log(uniform(mix(2 * counter))));
  const double angle = 2 * std::numbers::pi * uniform(mix(2 * counter + 1));
  return {r * std::cos(angle), r * std::sin(angle)};
}

std::vector<double> draw_point(const MaterialFamily& f, std::uint64_t k) {
  // k times the golden ratio modulo 1, in 64-bit fixed point: exact for every k.
  const double place = static_cast<double>((k * 0x9e3779b97f4a7c15u) >> 11) * 0x1p-53;
  double sum = 0;
  for (const FamilyPoint& p : f.points)
    if ((sum += p.weight) > place) return p.values;
  return f.points.back().values;
}

std::vector<double> draw_gaussian(const MaterialRecord& record, std::uint64_t k) {
  const MaterialFamily& f = *record.family;
  const auto n = static_cast<Eigen::Index>(f.axes.size());
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      covariance(i, j) = f.covariance[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
  const Eigen::VectorXd spread = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();
  constexpr int tries = 10000;
  std::uint64_t counter = mix(k);
  for (int t = 0; t < tries; ++t) {
    Eigen::VectorXd z(n);
    for (Eigen::Index i = 0; i < n; ++i) z[i] = normal_pair(counter++).first * spread[i];
    const Eigen::VectorXd departure = eigen.eigenvectors() * z;
    std::vector<double> values;
    bool inside = true;
    for (std::size_t i = 0; i < f.axes.size(); ++i) {
      const FamilyAxis& axis = f.axes[i];
      const double scaled = axis.mean + departure[static_cast<Eigen::Index>(i)];
      values.push_back(axis.scale == Scale::logarithmic ? std::exp(scaled) : scaled);
      inside = inside && values[i] >= axis.bounds.low && values[i] <= axis.bounds.high;
    }
    if (inside) return values;
  }
  throw InputError(fmt::format(
      "material {}: its Gaussian hardly reaches into the bounds of its family; expected "
      "stored points",
      record.reference()));
}

std::vector<double> family_values(const MaterialRecord& record, const MaterialChoice& choice) {
  const MaterialFamily& f = *record.family;
  if (choice.sample)
    return f.points.empty() ? draw_gaussian(record, *choice.sample) : draw_point(f, *choice.sample);
  std::vector<std::string> names;
  for (const Anchor& a : f.anchors) {
    if (a.name == choice.anchor) return a.values;
    names.push_back(fmt::format("\"{}\"", a.name));
  }
  throw InputError(fmt::format("material {}: has no anchor \"{}\"; expected {}", record.reference(),
                               choice.anchor,
                               names.empty() ? "a sample" : "one of " + comma_list(names)));
}

}  // namespace

const char* to_string(RecordKind kind) {
  switch (kind) {
    case RecordKind::printed:
      return "printed";
    case RecordKind::measured:
      return "measured";
    case RecordKind::calibrated:
      return "calibrated";
    case RecordKind::assumed:
      return "assumed";
  }
  return "";
}

std::string MaterialRecord::reference() const {
  return version > 0 ? fmt::format("{}@{}", name, version) : name;
}

std::size_t MaterialRecord::index(const std::string& parameter) const {
  const auto it = std::ranges::find(parameters, parameter, &MaterialParameter::name);
  if (it == parameters.end()) throw std::logic_error("no parameter " + parameter);
  return static_cast<std::size_t>(it - parameters.begin());
}

MaterialKey parse_material_key(const std::string& path) {
  const std::size_t first = path.find('.'), last = path.rfind('.');
  if (first != path.npos && first < last) {
    const std::string table = path.substr(0, first), key = path.substr(last + 1);
    const std::string who = path.substr(first + 1, last - first - 1);
    for (const KnownKey& known : known_keys) {
      if (known.table != table || known.key != key) continue;
      if (table == "materials" && plain(who, "_")) return {table, {who}, key, known.dimension};
      const std::size_t dash = who.find('-');
      if (table == "interactions" && dash != who.npos && plain(who.substr(0, dash), "_") &&
          plain(who.substr(dash + 1), "_"))
        return {table, {who.substr(0, dash), who.substr(dash + 1)}, key, known.dimension};
    }
  }
  throw InputError(
      fmt::format("\"{}\" is no key of a material; expected materials.NAME.KEY or "
                  "interactions.NAME-NAME.KEY with a key of docs/case-files.md, names of letters, "
                  "digits and _",
                  path));
}

std::string toml_value(double value, const std::string& unit) {
  return unit == "1" ? fmt::format("{}", value) : fmt::format("\"{} {}\"", value, unit);
}

void check(const MaterialRecord& r) {
  if (!plain(r.name, "_-.") || r.name.front() == '.' || r.name.size() > 100)
    refuse("name",
           fmt::format("is \"{}\"; expected letters, digits, _, - and ., at most 100", r.name));
  require_text("title", r.title, "one line that says what the record is");
  if (r.materials.empty() || r.materials.size() > 2)
    refuse("materials", fmt::format("are {}; expected one, or a pair", r.materials.size()));
  for (std::size_t i = 0; i < r.materials.size(); ++i)
    if (!plain(r.materials[i], "_"))
      refuse(fmt::format("materials.{}", i),
             fmt::format("is \"{}\"; expected letters, digits and _", r.materials[i]));
  if (r.parameters.empty() && r.properties.empty())
    refuse("parameters", "are none, nor are there properties; expected something that is known");
  std::set<std::string> names, keys;
  for (std::size_t i = 0; i < r.parameters.size(); ++i) {
    const std::string field = fmt::format("parameters.{}", i);
    check_parameter(field, r.parameters[i], r.materials, keys);
    if (!names.insert(r.parameters[i].name).second)
      refuse(field + ".name", fmt::format("\"{}\" is taken already", r.parameters[i].name));
  }
  for (std::size_t i = 0; i < r.properties.size(); ++i)
    check_property(fmt::format("properties.{}", i), r.properties[i]);
  if (r.family) check_family(r);
  for (std::size_t i = 0; i < r.scope.size(); ++i) {
    require_text(fmt::format("scope.{}.name", i), r.scope[i].name, "what the limit is of");
    require_text(fmt::format("scope.{}.statement", i), r.scope[i].statement, "where it holds");
  }
  if (r.scope.empty()) refuse("scope", "is missing; expected where the values hold");
  check_provenance(r);
}

std::string MaterialChoice::selection() const {
  if (sample) return fmt::format("sample {}", *sample);
  return anchor.empty() ? "" : fmt::format("anchor \"{}\"", anchor);
}

MaterialChoice parse_material_choice(const std::string& text) {
  const auto bad = [&] {
    return InputError(fmt::format(
        "material \"{}\": is no record; expected NAME, NAME@VERSION, or either with #SAMPLE",
        text));
  };
  const auto whole = [&](std::string_view digits, auto& value) {
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return error == std::errc() && end == digits.data() + digits.size() && value >= 1;
  };
  MaterialChoice choice;
  const std::size_t hash = text.find('#');
  const std::string record = text.substr(0, hash);
  if (hash != text.npos) {
    const std::string rest = text.substr(hash + 1);
    std::uint64_t sample = 0;
    if (whole(rest, sample) && sample <= largest_sample)
      choice.sample = sample;
    else if (rest.empty() || rest.find_first_not_of("0123456789") == rest.npos)
      throw bad();
    else
      choice.anchor = rest;
  }
  const std::size_t at = record.find('@');
  choice.name = record.substr(0, at);
  if (!plain(choice.name, "_-.")) throw bad();
  if (at != record.npos && !whole(record.substr(at + 1), choice.version)) throw bad();
  return choice;
}

std::vector<double> chosen_values(const MaterialRecord& record, const MaterialChoice& choice) {
  std::vector<double> values;
  for (const MaterialParameter& p : record.parameters) values.push_back(p.value);
  if (!choice.sample && choice.anchor.empty()) return values;
  if (!record.family)
    throw InputError(fmt::format(
        "material {}: holds single values and no family, so that nothing can be sampled from it; "
        "expected it without #",
        record.reference()));
  const std::vector<double> drawn = family_values(record, choice);
  for (std::size_t i = 0; i < drawn.size(); ++i)
    values[record.index(record.family->axes[i].parameter)] = drawn[i];
  return values;
}

}  // namespace firn
