// How people read numbers: one rule for terminals, pages and messages. Documents for programs hold
// all digits.
#pragma once

#include <string>
#include <string_view>

namespace firn {

// A number with so many significant digits, without trailing zeros: "0.0416", "12346", "1.2e-07".
// Digits before the point are all kept. Powers of ten below 1e-4 and from 1e9 on. "undefined"
// unless finite.
std::string number_text(double value, int digits = 4);

// A number to the second significant digit of its standard deviation: "11.4 ± 1.2",
// "(1.234 ± 0.056)e-07". Six digits of one that is more exact. Without a positive, finite deviation
// as number_text().
std::string measured_text(double value, double standard_deviation);

// The unit as people read it: "deg"; nothing of a bare number, whose unit is "1" or empty.
std::string unit_text(const std::string& unit);

// The same behind a number: " deg".
std::string unit_suffix(const std::string& unit);

// TOML for people: numbers outside strings with the fewest digits that read back to the same value
// ("0.29999999999999999" becomes "0.3").
std::string shortest_numbers(std::string_view toml);

}  // namespace firn
