#include "experiments/text/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "experiments/system/input_file.h"

namespace firn {
namespace {

struct Symbol {
  std::string_view text;
  Unit unit;
  bool prefixes = false;  // takes SI prefixes
};

constexpr double kInch = 0.0254;                // m, exact
constexpr double kPound = 0.45359237;           // kg, exact
constexpr double kGravity = 9.80665;            // m/s^2, standard, exact
constexpr double kTurn = 2 * std::numbers::pi;  // rad

constexpr std::array kSymbols = {
    Symbol{"m", {1, dimension::length}, true},
    Symbol{"in", {kInch, dimension::length}},
    Symbol{"inch", {kInch, dimension::length}},
    Symbol{"ft", {12 * kInch, dimension::length}},
    Symbol{"yd", {36 * kInch, dimension::length}},
    Symbol{"mil", {kInch / 1000, dimension::length}},
    Symbol{"g", {1e-3, dimension::mass}, true},
    Symbol{"t", {1000, dimension::mass}},
    Symbol{"lb", {kPound, dimension::mass}},
    Symbol{"oz", {kPound / 16, dimension::mass}},
    Symbol{"s", {1, dimension::time}, true},
    Symbol{"min", {60, dimension::time}},
    Symbol{"h", {3600, dimension::time}},
    Symbol{"d", {86400, dimension::time}},
    Symbol{"Hz", {1, {0, 0, -1, 0}}, true},
    Symbol{"rad", {1, dimension::angle}, true},
    Symbol{"deg", {kTurn / 360, dimension::angle}},
    Symbol{"°", {kTurn / 360, dimension::angle}},
    Symbol{"rev", {kTurn, dimension::angle}},
    Symbol{"rpm", {kTurn / 60, dimension::angular_velocity}},
    Symbol{"L", {1e-3, dimension::volume}, true},
    Symbol{"mph", {63360 * kInch / 3600, dimension::velocity}},
    Symbol{"N", {1, dimension::force}, true},
    Symbol{"lbf", {kPound * kGravity, dimension::force}},
    Symbol{"ozf", {kPound * kGravity / 16, dimension::force}},
    Symbol{"kgf", {kGravity, dimension::force}},
    Symbol{"Pa", {1, dimension::pressure}, true},
    Symbol{"bar", {1e5, dimension::pressure}, true},
    Symbol{"psi", {kPound * kGravity / (kInch * kInch), dimension::pressure}},
    Symbol{"ksi", {1000 * kPound * kGravity / (kInch * kInch), dimension::pressure}},
    Symbol{"J", {1, dimension::energy}, true},
    Symbol{"W", {1, {2, 1, -3, 0}}, true},
    Symbol{"K", {1, dimension::temperature}},
};

// Temperatures with another zero than the kelvin: K = factor * value + offset. They are no part of
// a compound unit.
struct TemperatureScale {
  std::string_view text;
  double factor, offset;
};
constexpr std::array kTemperatureScales = {
    TemperatureScale{"degC", 1, kIcePoint},
    TemperatureScale{"°C", 1, kIcePoint},
    TemperatureScale{"degF", 5.0 / 9, kIcePoint - 32 * 5.0 / 9},
    TemperatureScale{"°F", 5.0 / 9, kIcePoint - 32 * 5.0 / 9},
};

constexpr std::array<std::pair<std::string_view, double>, 15> kPrefixes = {{
    {"T", 1e12},
    {"G", 1e9},
    {"M", 1e6},
    {"k", 1e3},
    {"h", 1e2},
    {"da", 1e1},
    {"d", 1e-1},
    {"c", 1e-2},
    {"m", 1e-3},
    {"u", 1e-6},
    {"\u00b5", 1e-6},
    {"\u03bc", 1e-6},  // the micro sign and the Greek letter
    {"n", 1e-9},
    {"p", 1e-12},
    {"f", 1e-15},
}};

// What messages call a dimension, and an example of it.
struct Name {
  Dimension dimension;
  std::string_view name, number, vector;
};
constexpr std::array kNames = {
    Name{dimension::none, "a dimensionless number", "0.3", "1 0 0"},
    Name{dimension::length, "a length", "2.4 in", "0 0 0.2 m"},
    Name{dimension::mass, "a mass", "13.7 g", "1 1 1 kg"},
    Name{dimension::time, "a time", "1 ms", "1 1 1 s"},
    Name{dimension::angle, "an angle", "10 deg", "0 0 90 deg"},
    Name{dimension::temperature, "a temperature", "-10 degC", "0 0 0 degC"},
    Name{dimension::volume, "a volume", "105 mL", "1 1 1 mL"},
    Name{dimension::velocity, "a velocity", "50.8 mm/min", "0 0 -1 m/s"},
    Name{dimension::acceleration, "an acceleration", "9.81 m/s^2", "0 0 -9.81 m/s^2"},
    Name{dimension::angular_velocity, "an angular velocity", "4 rad/s", "0 0 4 rad/s"},
    Name{dimension::density, "a density", "916.7 kg/m^3", "1 1 1 kg/m^3"},
    Name{dimension::force, "a force", "10 N", "0 0 1 N"},
    Name{dimension::stiffness, "a stiffness", "1e6 N/m", "1 1 1 N/m"},
    Name{dimension::pressure, "a pressure", "0.01 GPa", "1 1 1 Pa"},
    Name{dimension::energy, "an energy", "1e-6 J", "1 1 1 J"},
    Name{{0, 0, -1, 0}, "a frequency", "500 Hz", "1 1 1 Hz"},
};

const Name* find_name(const Dimension& d) {
  const auto it = std::ranges::find(kNames, d, &Name::dimension);
  return it == kNames.end() ? nullptr : &*it;
}

std::string base_units(const Dimension& d) {
  std::string text;
  const auto append = [&](const char* symbol, int exponent) {
    if (exponent == 0) return;
    if (!text.empty()) text += ' ';
    text += exponent == 1 ? symbol : fmt::format("{}^{}", symbol, exponent);
  };
  append("kg", d.mass);
  append("m", d.length);
  append("s", d.time);
  append("rad", d.angle);
  append("K", d.temperature);
  return text;
}

bool is_symbol_character(char c) {
  // Bytes of 0x80 and above belong to letters such as the micro sign.
  return std::isalpha(static_cast<unsigned char>(c)) || static_cast<unsigned char>(c) >= 0x80;
}

// Units that refusals suggest.
std::vector<std::string> symbols_to_suggest() {
  std::vector<std::string> all;
  for (const Symbol& s : kSymbols) {
    all.emplace_back(s.text);
    if (!s.prefixes) continue;
    for (const auto& [prefix, factor] : kPrefixes) {
      // Rare prefixes would crowd out the units that people mean.
      if (std::string_view("GMkcmu").find(prefix) == std::string_view::npos) continue;
      all.push_back(std::string(prefix) + std::string(s.text));
    }
  }
  return all;
}

std::string nearest_symbols(std::string_view text) {
  static const std::vector<std::string> symbols = symbols_to_suggest();
  struct Candidate {
    int distance = std::numeric_limits<int>::max();
    std::string_view symbol;
  };
  std::array<Candidate, 3> best;  // nearest first; of equal ones that of the table's order
  for (const std::string& symbol : symbols) {
    Candidate candidate{edit_distance(text, symbol), symbol};
    for (Candidate& b : best)
      if (candidate.distance < b.distance) std::swap(candidate, b);
  }
  return fmt::format("{}, {}, {}", best[0].symbol, best[1].symbol, best[2].symbol);
}

Unit find_symbol(std::string_view text) {
  for (const Symbol& s : kSymbols) {
    if (s.text == text) return s.unit;
  }
  for (const auto& [prefix, factor] : kPrefixes) {
    if (!text.starts_with(prefix)) continue;
    for (const Symbol& s : kSymbols) {
      if (s.prefixes && s.text == text.substr(prefix.size())) {
        return {factor * s.unit.factor, s.unit.dimension};
      }
    }
  }
  constexpr std::size_t kLongestTypo = 16;  // bytes; no unit is like a longer one
  if (text.size() > kLongestTypo)
    throw InputError(fmt::format("unknown unit \"{}\"", shortened(text)));
  throw InputError(fmt::format("unknown unit \"{}\" (nearest: {})", text, nearest_symbols(text)));
}

// Recursive descent over  product := factor { [*|/] factor },  factor := atom [[^] integer],
// atom := symbol | 1 | ( product ).
class UnitParser {
 public:
  explicit UnitParser(std::string_view text) : text_(text) {}

  Unit parse() {
    const Unit unit = product(0);
    if (at_ < text_.size()) fail();
    return unit;
  }

 private:
  static constexpr int kDeepest = 16;
  static constexpr int kLargestExponent = 99;

  [[noreturn]] void fail() const {
    throw InputError(fmt::format("cannot read \"{}\" as a unit", shortened(text_)));
  }

  char next() {  // past spaces; 0 at the end
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }

  Unit product(int depth) {
    if (depth > kDeepest) fail();
    Unit unit = factor(depth);
    for (char c = next(); c != '\0' && c != ')'; c = next()) {
      if (c == '*' || c == '/') ++at_;
      const Unit f = factor(depth);
      const int sign = c == '/' ? -1 : 1;
      unit.factor = sign > 0 ? unit.factor * f.factor : unit.factor / f.factor;
      unit.dimension = unit.dimension * f.dimension.power(sign);
    }
    return unit;
  }

  Unit factor(int depth) {
    const Unit base = atom(depth);
    int exponent = 1;
    const bool caret = at_ < text_.size() && text_[at_] == '^';
    if (caret) ++at_;
    const auto [end, error] =
        std::from_chars(text_.data() + at_, text_.data() + text_.size(), exponent);
    if (error != std::errc() ? caret : std::abs(exponent) > kLargestExponent) fail();
    if (error == std::errc()) at_ = static_cast<std::size_t>(end - text_.data());
    const Dimension d = base.dimension.power(exponent);
    for (const int e : {d.length, d.mass, d.time, d.angle, d.temperature}) {
      if (std::abs(e) > kLargestExponent) fail();
    }
    return {std::pow(base.factor, exponent), d};
  }

  Unit atom(int depth) {
    const char c = next();
    if (c == '(') {
      ++at_;
      const Unit unit = product(depth + 1);
      if (next() != ')') fail();
      ++at_;
      return unit;
    }
    if (c == '1') {
      ++at_;
      return {};
    }
    const std::size_t first = at_;
    while (at_ < text_.size() && is_symbol_character(text_[at_])) ++at_;
    if (at_ == first) fail();
    return find_symbol(text_.substr(first, at_ - first));
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

std::string_view trim(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

// What is expected, made into text for refusals only.
struct Wanted {
  Dimension dimension;
  int components = 1;

  std::string text() const { return example(dimension, components); }
};

// Takes a number off the front of `text`.
double take_number(std::string_view& text, std::string_view whole, const Wanted& wanted) {
  text = trim(text);
  std::string_view digits = text;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error == std::errc::result_out_of_range || (error == std::errc() && !std::isfinite(value))) {
    throw InputError(
        fmt::format("\"{}\" is not finite; expected {}", shortened(whole), wanted.text()));
  }
  if (error != std::errc()) {
    throw InputError(
        fmt::format("cannot read \"{}\"; expected {}", shortened(whole), wanted.text()));
  }
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

// Value in SI = factor * number + offset.
struct Conversion {
  double factor = 1, offset = 0;
};

// What is left behind the numbers must be a unit of the dimension.
Conversion take_unit(std::string_view text, std::string_view whole, const Wanted& wanted) {
  text = trim(text);
  if (text.empty()) {
    if (wanted.dimension == dimension::none) return {};
    throw InputError(
        fmt::format("\"{}\" has no unit; expected {}", shortened(whole), wanted.text()));
  }
  if (std::string_view("+-.0123456789").find(text.front()) != std::string_view::npos &&
      !text.starts_with("1/")) {
    throw InputError(
        fmt::format("\"{}\" has too many numbers; expected {}", shortened(whole), wanted.text()));
  }
  if (wanted.dimension == dimension::temperature) {
    const auto scale = std::ranges::find(kTemperatureScales, text, &TemperatureScale::text);
    if (scale != kTemperatureScales.end()) return {scale->factor, scale->offset};
  }
  Unit unit;
  try {
    unit = parse_unit(text);
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("\"{}\": {}; expected {}", shortened(whole), error.what(), wanted.text()));
  }
  if (unit.dimension != wanted.dimension) {
    throw InputError(fmt::format("\"{}\" is {}; expected {}", shortened(whole),
                                 dimension_name(unit.dimension), wanted.text()));
  }
  return {unit.factor, 0};
}

double checked(double value, std::string_view whole, const Wanted& wanted) {
  if (!std::isfinite(value))
    throw InputError(
        fmt::format("\"{}\" is not finite; expected {}", shortened(whole), wanted.text()));
  const Dimension& d = wanted.dimension;
  if (const double largest = usable_range(d).largest; std::abs(value) > largest)
    throw InputError(fmt::format("\"{}\" is beyond {}; expected {} up to it", shortened(whole),
                                 si_text(largest, d), dimension_name(d)));
  return value;
}

struct DimensionRange {
  Dimension dimension;
  UsableRange range;
};
const std::array kRanges = {
    DimensionRange{dimension::length, {1e-9, 1e6}},
    DimensionRange{dimension::mass, {1e-20, 1e9}},
    DimensionRange{dimension::time, {1e-12, 1e9}},
    DimensionRange{dimension::angle, {1e-9, 1e6}},
    DimensionRange{dimension::temperature, {1e-6, 1e6}},
    DimensionRange{dimension::velocity, {1e-12, 1e6}},
    DimensionRange{dimension::acceleration, {1e-12, 1e9}},
    DimensionRange{dimension::angular_velocity, {1e-12, 1e7}},
    DimensionRange{dimension::density, {1e-6, 1e6}},
    DimensionRange{dimension::force, {1e-20, 1e12}},
    DimensionRange{dimension::stiffness, {1e-12, 1e15}},
    DimensionRange{dimension::pressure, {1e-3, 1e15}},
    DimensionRange{dimension::energy, {1e-30, 1e15}},
    DimensionRange{dimension::frequency, {1e-9, 1e12}},
};

}  // namespace

Dimension operator*(const Dimension& a, const Dimension& b) {
  return {a.length + b.length, a.mass + b.mass, a.time + b.time, a.angle + b.angle,
          a.temperature + b.temperature};
}

Dimension Dimension::power(int exponent) const {
  return {length * exponent, mass * exponent, time * exponent, angle * exponent,
          temperature * exponent};
}

Unit parse_unit(std::string_view text) { return UnitParser(text).parse(); }

std::optional<double> conversion_factor(std::string_view from, std::string_view to) {
  const Unit a = parse_unit(from), b = parse_unit(to);
  if (a.dimension != b.dimension) return std::nullopt;
  return a.factor / b.factor;
}

double parse_quantity(std::string_view text, const Dimension& expected) {
  const Wanted wanted{expected};
  std::string_view rest = text;
  const double number = take_number(rest, text, wanted);
  const Conversion unit = take_unit(rest, text, wanted);
  return checked(number * unit.factor + unit.offset, text, wanted);
}

Vec3 parse_vector(std::string_view text, const Dimension& expected) {
  const Wanted wanted{expected, 3};
  std::string_view rest = text;
  Vec3 v;
  for (int i = 0; i < 3; ++i) v[i] = take_number(rest, text, wanted);
  const Conversion unit = take_unit(rest, text, wanted);
  for (int i = 0; i < 3; ++i) v[i] = checked(v[i] * unit.factor + unit.offset, text, wanted);
  return v;
}

UsableRange usable_range(const Dimension& d) {
  const auto known = std::ranges::find(kRanges, d, &DimensionRange::dimension);
  return known == kRanges.end() ? UsableRange{1e-60, 1e60} : known->range;
}

std::string dimension_name(const Dimension& d) {
  const Name* name = find_name(d);
  return name ? std::string(name->name) : fmt::format("in units of {}", base_units(d));
}

std::string example(const Dimension& d, int components) {
  const Name* name = find_name(d);
  if (!name) return fmt::format("a value {}", dimension_name(d));
  if (components == 1) return fmt::format("{}, such as \"{}\"", name->name, name->number);
  return fmt::format("three numbers and the unit of {}, such as \"{}\"", name->name, name->vector);
}

std::string si_text(double value, const Dimension& d) {
  const std::string units = base_units(d);
  return units.empty() ? fmt::format("{}", value) : fmt::format("{} {}", value, units);
}

int edit_distance(std::string_view a, std::string_view b) {
  constexpr int kStep = 2;
  const auto substitution = [](char x, char y) {
    if (x == y) return 0;
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c; };
    return lower(x) == lower(y) ? kStep / 2 : kStep;
  };
  std::vector<int> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = kStep * static_cast<int>(j);
  for (const char letter : a) {
    int diagonal = row[0];
    row[0] += kStep;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const int replaced = diagonal + substitution(letter, b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + kStep, row[j + 1] + kStep});
    }
  }
  return row[b.size()];
}

constexpr double kLongestDuration = 1e12;  // s; beyond, a file is wrong

std::string duration_text(double seconds) {
  if (!(seconds <= kLongestDuration)) return "undefined";
  if (seconds < 10) return fmt::format("{:.1f} s", seconds);
  const auto total = static_cast<long>(std::ceil(seconds));
  if (total < 60) return fmt::format("{} s", total);
  if (total < 3600) return fmt::format("{} min {:02} s", total / 60, total % 60);
  return fmt::format("{} h {:02} min", total / 3600, total % 3600 / 60);
}

std::string estimated_duration_text(double seconds) {
  if (!(seconds <= kLongestDuration)) return "undefined";
  if (seconds < 90) return fmt::format("{:.0f} s", std::ceil(seconds));
  if (seconds < 5400) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

}  // namespace firn
