#include "experiments/text/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "experiments/system/input_file.h"

namespace firn {
namespace {

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

// Resolutions in SI. Lengths: a hundredth of an atom, above the rounding of coordinates of some
// meters. Angles: what the rounding of a coordinate turns a body of some millimeters by. Speeds: a
// micrometer in ten days. Forces: a tenth of the weight of a grain of a micrometer, above the
// rounding of forces of some newtons that cancel; moments: the same with an arm of 0.1 m. Numbers:
// a few times the rounding of 1.
constexpr std::array kResolutions = {
    std::pair{dimension::none, 1e-15},         std::pair{dimension::length, 1e-12},
    std::pair{dimension::time, 1e-12},         std::pair{dimension::mass, 1e-20},
    std::pair{dimension::angle, 1e-9},         std::pair{dimension::velocity, 1e-12},
    std::pair{dimension::acceleration, 1e-12}, std::pair{dimension::angular_velocity, 1e-9},
    std::pair{dimension::force, 1e-15},        std::pair{dimension::energy, 1e-20},
    std::pair{dimension::pressure, 1e-9},
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

double resolution(const std::string& unit) {
  if (unit.empty()) return resolution("1");
  constexpr double kMoment = 1e-16;  // N m
  if (plain_unit(unit) == "N m") return kMoment;
  Unit parsed;
  try {
    parsed = parse_unit(unit);
  } catch (const InputError&) {
    return 0;
  }
  for (const auto& [dimension, least] : kResolutions)
    if (dimension == parsed.dimension) return least / parsed.factor;
  return 0;
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
