// Quantities with units in the form of input files: "2.4 in", "0.01 GPa", "50.8 mm/min",
// "0 0 -1 m/s".
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "firn/math.h"

namespace firn {

// Exponents of the base dimensions. The angle is a base dimension, so that "4 1/s" is not an
// angular velocity.
struct Dimension {
  int length = 0, mass = 0, time = 0, angle = 0, temperature = 0;

  friend bool operator==(const Dimension&, const Dimension&) = default;
  friend Dimension operator*(const Dimension& a, const Dimension& b);
  Dimension power(int exponent) const;
};

namespace dimension {
inline constexpr Dimension none{};
inline constexpr Dimension length{1, 0, 0, 0};
inline constexpr Dimension mass{0, 1, 0, 0};
inline constexpr Dimension time{0, 0, 1, 0};
inline constexpr Dimension angle{0, 0, 0, 1};
inline constexpr Dimension temperature{0, 0, 0, 0, 1};
inline constexpr Dimension volume{3, 0, 0, 0};
inline constexpr Dimension velocity{1, 0, -1, 0};
inline constexpr Dimension acceleration{1, 0, -2, 0};
inline constexpr Dimension angular_velocity{0, 0, -1, 1};
inline constexpr Dimension density{-3, 1, 0, 0};
inline constexpr Dimension force{1, 1, -2, 0};
inline constexpr Dimension stiffness{0, 1, -2, 0};
inline constexpr Dimension pressure{-1, 1, -2, 0};
inline constexpr Dimension energy{2, 1, -2, 0};
inline constexpr Dimension torque = energy;
inline constexpr Dimension frequency{0, 0, -1, 0};
inline constexpr Dimension moment_of_inertia{2, 1, 0, 0};
}  // namespace dimension

inline constexpr double kIcePoint = 273.15;  // K: 0 degC, exact

// Accepted magnitudes of values other than zero, in SI. The range exceeds that of any simulation.
// Sums and products of several values within it neither overflow nor underflow.
struct UsableRange {
  double smallest, largest;
};
UsableRange usable_range(const Dimension& dimension);

struct Unit {
  double factor = 1;  // value in SI = factor * value in this unit
  Dimension dimension;
};

// Parses a unit: "kg/m^3", "mm/min", "N m". Symbols are joined by spaces, * and /, with ^ and whole
// exponents. A division applies to the next symbol or parenthesis only. Takes the signs that
// plain_unit() replaces. Throws InputError.
Unit parse_unit(std::string_view text);
// The one spelling of a unit in tables, pages and comparisons of units: "m³" becomes "m^3", "s⁻¹"
// "s^-1" and "N·m" "N m". Other text is not changed.
std::string plain_unit(std::string_view text);
// Factor that converts a number from the unit `from` to the unit `to`. Nothing for units of
// different dimensions. Throws InputError for a text that is not a unit.
std::optional<double> conversion_factor(std::string_view from, std::string_view to);

// Value of "2.4 in" in SI. A temperature may also be in "degC" or "degF". Throws InputError (one
// sentence) for a unit that is missing, unknown or of another dimension, and for a number that is
// not finite or above the usable range. Numbers below the range are accepted.
double parse_quantity(std::string_view text, const Dimension& expected);
// "x y z unit" in SI.
Vec3 parse_vector(std::string_view text, const Dimension& expected);

// Name of a dimension with its article, "a length"; in base units if it has no name.
std::string dimension_name(const Dimension& dimension);
// Name and example, "a length, such as \"2.4 in\"". `components`: 1 or 3.
std::string example(const Dimension& dimension, int components = 1);

// A value in SI as text that reads back to the same bits: "0.06096 m".
std::string si_text(double value, const Dimension& dimension);

// A duration (s) for display: "7.3 s", "48 s", "12 min 05 s", "3 h 20 min".
std::string duration_text(double seconds);
// Magnitude (in `unit`) below which a value of a simulation is rounding error: no input, body or
// instrument is as fine, e.g. 1e-12 m or 1e-9 rad. 0 for a text that is not a unit, and for units
// of dimensions without a known one.
double resolution(const std::string& unit);

// An estimated duration (s), not below 0: "48 s", "12 min", "3.3 h".
std::string estimated_duration_text(double seconds);

// The words, separated by commas: "a, b, c".
template <class Words>
std::string comma_list(const Words& words) {
  std::string text;
  for (const auto& word : words) {
    if (!text.empty()) text += ", ";
    text += word;
  }
  return text;
}

}  // namespace firn
