// Numbers as text in terminal output, reports and messages. Files for other programs have all
// digits instead.
#pragma once

#include <string>
#include <string_view>

namespace firn {

// A number with `digits` significant digits, without trailing zeros: "0.0416", "12346", "1.2e-07".
// All digits before the decimal point are kept. Exponential notation below 1e-4 and from 1e9 on.
// "undefined" for a number that is not finite.
std::string number_text(double value, int digits = 4);

// The value for display: 0 below the resolution() of the unit, so that a mechanism at rest has the
// angle "0" and not "-3.6e-25". Not for files and JSON, which have all digits.
double resolved(double value, const std::string& unit);

// A number, rounded to the second significant digit of its standard deviation, and that deviation:
// "11.4 ± 1.2", "(1.234 ± 0.056)e-07". At most six significant digits of the number. number_text()
// if the deviation is not positive and finite.
std::string measured_text(double value, double standard_deviation);

// The same of resolved() numbers, with the unit: "11.4 ± 1.2 deg".
std::string measured_text(double value, double standard_deviation, const std::string& unit);

// `value`, or 0 where it is below a millionth of `scale`, a number that it is compared with: what
// rounding errors leave of a zero.
double without_rounding_error(double value, double scale);

// "9.1 to 10.9".
std::string range_text(double low, double high, int digits = 3);

// The unit for display, as plain_unit() spells it: "deg", "cm^3". Empty for a bare number, whose
// unit is "1" or empty.
std::string unit_text(const std::string& unit);

// The same as a suffix of a number: " deg".
std::string unit_suffix(const std::string& unit);

// The label of an axis: "friction force / N"; the name alone of a bare number.
std::string axis_label(const std::string& name, const std::string& unit);

// A key as words: "discharge_time" becomes "discharge time", and "tilt.slide_angle", a response of
// an experiment, "slide angle (tilt)".
std::string words(std::string key);

// TOML text with numbers outside of strings in the fewest digits that read back to the same value:
// "0.29999999999999999" becomes "0.3".
std::string shortest_numbers(std::string_view toml);

}  // namespace firn
