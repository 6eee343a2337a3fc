#include "experiments/material_records/material_record.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string_view>

#include "experiments/material_records/material_names.h"
#include "experiments/text/toml_aliases.h"
#include "firn/contact_model.h"
#include "firn/math.h"

namespace firn {
namespace {

struct KnownKey {
  std::string_view table, key;
  Dimension dimension;
  MaterialKey::Range range;
};
constexpr double infinity = std::numeric_limits<double>::infinity();
// As the case reader has them (experiments/case_reader/model/materials.cpp).
constexpr MaterialKey::Range positive{0, false, infinity, false, "a number above 0"};
constexpr MaterialKey::Range not_negative{0, true, infinity, false, "a number of at least 0"};
constexpr MaterialKey::Range below_one{0, true, 1, false, "a number from 0 to below 1"};
constexpr KnownKey known_keys[] = {
    {"materials", "density", dimension::density, positive},
    {"materials", "young_modulus", dimension::pressure, positive},
    {"materials",
     "poisson_ratio",
     dimension::none,
     {-1, false, 0.5, true, "a number above -1 and up to 0.5"}},
    {"interactions", "static_friction", dimension::none, not_negative},
    {"interactions", "dynamic_friction", dimension::none, not_negative},
    {"interactions",
     "restitution",
     dimension::none,
     {0, false, 1, true, "a number above 0 and up to 1"}},
    {"interactions", "tangential_stiffness_ratio", dimension::none, positive},
    {"interactions", "minimum_unloading_ratio", dimension::none, below_one},
    {"interactions", "rolling_resistance", dimension::none, not_negative},
    {"interactions", "restick_velocity", dimension::velocity, not_negative},
    {"interactions", "adhesion_force", dimension::force, not_negative},
    {"interactions", "adhesion_stiffness_fraction", dimension::none, below_one},
};

constexpr std::uint64_t largest_sample = 1'000'000'000'000;

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

std::vector<double> draw_point(const PosteriorEnsemble& f, std::uint64_t k) {
  // k times the golden ratio modulo 1, in 64-bit fixed point: exact for every k.
  const double place = static_cast<double>((k * 0x9e3779b97f4a7c15u) >> 11) * 0x1p-53;
  double sum = 0;
  for (const EnsembleSample& p : f.samples)
    if ((sum += p.weight) > place) return p.values;
  return f.samples.back().values;
}

std::vector<double> draw_gaussian(const MaterialRecord& record, std::uint64_t k) {
  const PosteriorEnsemble& f = *record.ensemble;
  const auto n = static_cast<Eigen::Index>(f.axes.size());
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      covariance(i, j) = f.covariance[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  const SymmetricEigen eigen = symmetric_eigen(covariance);
  const Eigen::VectorXd spread = eigen.values.cwiseMax(0).cwiseSqrt();
  constexpr int tries = 10000;
  std::uint64_t counter = mix(k);
  for (int t = 0; t < tries; ++t) {
    Eigen::VectorXd z(n);
    for (Eigen::Index i = 0; i < n; ++i) z[i] = normal_pair(counter++).first * spread[i];
    const Eigen::VectorXd departure = eigen.vectors * z;
    std::vector<double> values;
    bool inside = true;
    for (std::size_t i = 0; i < f.axes.size(); ++i) {
      const EnsembleAxis& axis = f.axes[i];
      const double scaled = axis.mean + departure[static_cast<Eigen::Index>(i)];
      values.push_back(axis.scale == Scale::logarithmic ? std::exp(scaled) : scaled);
      inside = inside && values[i] >= axis.bounds.low && values[i] <= axis.bounds.high;
    }
    if (inside) return values;
  }
  throw InputError(
      fmt::format("material {}: its Gaussian hardly reaches into the bounds of its ensemble; "
                  "expected stored samples",
                  record.reference()));
}

std::vector<double> ensemble_values(const MaterialRecord& record, const MaterialChoice& choice) {
  const PosteriorEnsemble& f = *record.ensemble;
  if (choice.sample)
    return f.samples.empty() ? draw_gaussian(record, *choice.sample)
                             : draw_point(f, *choice.sample);
  std::vector<std::string> names;
  for (const ReferenceSet& a : f.reference_sets) {
    if (a.name == choice.reference_set) return a.values;
    names.push_back(fmt::format("\"{}\"", a.name));
  }
  throw InputError(fmt::format("material {}: has no reference set \"{}\"; expected {}",
                               record.reference(), choice.reference_set,
                               names.empty() ? "a sample" : "one of " + comma_list(names)));
}

}  // namespace

const char* to_string(RecordKind kind) {
  switch (kind) {
    case RecordKind::published:
      return "published";
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

bool MaterialKey::Range::contains(double value) const {
  return (value > low || (low_included && value == low)) &&
         (value < high || (high_included && value == high));
}

MaterialKey parse_material_key(const std::string& text) {
  const std::string path = current_case_path(text);
  const std::size_t first = path.find('.'), last = path.rfind('.');
  if (first != path.npos && first < last) {
    const std::string table = path.substr(0, first), key = path.substr(last + 1);
    const std::string who = path.substr(first + 1, last - first - 1);
    for (const KnownKey& known : known_keys) {
      if (known.table != table || known.key != key) continue;
      if (table == "materials" && has_name_characters(who, "_"))
        return {table, {who}, key, known.dimension, known.range};
      const std::size_t dash = who.find('-');
      if (table == "interactions" && dash != who.npos &&
          has_name_characters(who.substr(0, dash), "_") &&
          has_name_characters(who.substr(dash + 1), "_"))
        return {
            table, {who.substr(0, dash), who.substr(dash + 1)}, key, known.dimension, known.range};
    }
  }
  throw InputError(
      fmt::format("\"{}\" is not a key of a material; expected materials.NAME.KEY or "
                  "interactions.NAME-NAME.KEY with a key of docs/case-files.md, names of letters, "
                  "digits and _",
                  path));
}

std::string toml_value(double value, const std::string& unit) {
  return unit == "1" ? fmt::format("{}", value) : fmt::format("\"{} {}\"", value, unit);
}

std::string MaterialChoice::selection() const {
  if (sample) return fmt::format("sample {}", *sample);
  return reference_set.empty() ? "" : fmt::format("reference set \"{}\"", reference_set);
}

MaterialChoice parse_material_choice(const std::string& text) {
  const auto bad = [&] {
    return InputError(fmt::format(
        "material \"{}\": is not a record; expected NAME, NAME@VERSION, or either with #SAMPLE",
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
      choice.reference_set = rest;
  }
  const std::size_t at = record.find('@');
  choice.name = record.substr(0, at);
  if (!has_name_characters(choice.name, "_-.")) throw bad();
  if (at != record.npos && !whole(record.substr(at + 1), choice.version)) throw bad();
  return choice;
}

std::vector<double> chosen_values(const MaterialRecord& record, const MaterialChoice& choice) {
  std::vector<double> values;
  for (const MaterialParameter& p : record.parameters) values.push_back(p.value);
  if (!choice.sample && choice.reference_set.empty()) return values;
  if (!record.ensemble)
    throw InputError(
        fmt::format("material {}: holds single values and no posterior ensemble, so that nothing "
                    "can be sampled from it; "
                    "expected it without #",
                    record.reference()));
  const std::vector<double> drawn = ensemble_values(record, choice);
  for (std::size_t i = 0; i < drawn.size(); ++i)
    values[record.index(record.ensemble->axes[i].parameter)] = drawn[i];
  return values;
}

std::string contact_model_warning(const std::string& reference, int contact_model) {
  if (contact_model == kContactModel) return "";
  return fmt::format(
      "material {} was calibrated with contact model {}, and this build has {}: its values may not "
      "fit; calibrate them again",
      reference, contact_model, kContactModel);
}

}  // namespace firn
