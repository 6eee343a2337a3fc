#include "experiments/text/number_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "experiments/text/units.h"

namespace firn {
namespace {

constexpr double kSmallestPlain = 1e-4, kFirstLarge = 1e9;
constexpr double kMostExact = 1e5;  // value by standard deviation

// Of a finite number other than zero, after rounding to `digits` significant digits.
int power_of_ten(double value, int digits) {
  const std::string text = fmt::format("{:.{}e}", value, digits - 1);
  return std::stoi(text.substr(text.find('e') + 1));
}

bool plain(double value) {
  return std::abs(value) >= kSmallestPlain && std::abs(value) < kFirstLarge;
}

// No "-0.00".
std::string fixed(double value, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  return text.find_first_of("123456789") == std::string::npos && text[0] == '-' ? text.substr(1)
                                                                                : text;
}

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

// A floating point number of TOML as short as it can be; other text as it stands.
std::string shortest(std::string_view token) {
  if (token.find('.') == token.npos || token.find('_') != token.npos) return std::string(token);
  double value = 0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (error != std::errc() || end != token.data() + token.size()) return std::string(token);
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";  // a float stays one
  return text.size() < token.size() ? text : std::string(token);
}

}  // namespace

std::string number_text(double value, int digits) {
  if (!std::isfinite(value)) return "undefined";
  if (value == 0) return "0";
  const bool whole = value == std::floor(value) && std::abs(value) < kFirstLarge;
  if (whole) return fmt::format("{:.0f}", value);
  if (!plain(value)) return fmt::format("{:.{}g}", value, digits);
  const int decimals = std::max(0, digits - 1 - power_of_ten(value, digits));
  std::string text = fixed(value, decimals);
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

double resolved(double value, const std::string& unit) {
  return std::abs(value) < resolution(unit) ? 0 : value;
}

std::string measured_text(double value, double standard_deviation) {
  if (!(standard_deviation > 0) || !std::isfinite(standard_deviation) || !std::isfinite(value))
    return number_text(value);
  if (std::abs(value) > kMostExact * standard_deviation)  // more digits than are useful
    return fmt::format("{} ± {}", number_text(value, 6), number_text(standard_deviation, 2));
  const int last = power_of_ten(standard_deviation, 2) - 1;  // power of ten of the last digit
  const double larger = std::max(std::abs(value), standard_deviation);
  if (larger >= kFirstLarge || larger < kSmallestPlain) {
    const int power = power_of_ten(larger, 2);
    const double unit = std::pow(10.0, power);
    const int decimals = std::clamp(power - last, 0, 15);
    return fmt::format("({} ± {})e{:+03}", fixed(value / unit, decimals),
                       fixed(standard_deviation / unit, decimals), power);
  }
  if (last > 0) {
    const double step = std::pow(10.0, last);
    return fmt::format("{} ± {}", fixed(std::round(value / step) * step, 0),
                       fixed(std::round(standard_deviation / step) * step, 0));
  }
  return fmt::format("{} ± {}", fixed(value, -last), fixed(standard_deviation, -last));
}

std::string measured_text(double value, double standard_deviation, const std::string& unit) {
  return measured_text(resolved(value, unit), resolved(standard_deviation, unit)) +
         unit_suffix(unit);
}

double without_rounding_error(double value, double scale) {
  constexpr double kNegligible = 1e-6;
  return std::abs(value) < kNegligible * std::abs(scale) ? 0 : value;
}

std::string range_text(double low, double high, int digits) {
  return fmt::format("{} to {}", number_text(low, digits), number_text(high, digits));
}

std::string unit_text(const std::string& unit) { return unit == "1" ? "" : plain_unit(unit); }

std::string unit_suffix(const std::string& unit) {
  const std::string text = unit_text(unit);
  return text.empty() ? "" : " " + text;
}

std::string axis_label(const std::string& name, const std::string& unit) {
  const std::string text = unit_text(unit);
  return name + (text.empty() ? "" : " / " + text);
}

std::string words(std::string key) {
  std::ranges::replace(key, '_', ' ');
  const std::size_t dot = key.find('.');
  if (dot == std::string::npos || dot != key.rfind('.')) return key;
  return key.substr(dot + 1) + " (" + key.substr(0, dot) + ")";
}

std::string shortest_numbers(std::string_view toml) {
  std::string out;
  char quote = 0;
  for (std::size_t i = 0; i < toml.size();) {
    const char c = toml[i];
    if (quote != 0) {
      out += c;
      ++i;
      if (c == '\\' && quote == '"' && i < toml.size()) out += toml[i++];
      if (c == quote) quote = 0;
      continue;
    }
    if (c == '"' || c == '\'') quote = c;
    if (std::isdigit(static_cast<unsigned char>(c)) == 0 || (i > 0 && is_word(toml[i - 1]))) {
      out += c;
      ++i;
      continue;
    }
    std::size_t end = i;
    while (end < toml.size() && (is_word(toml[end]) || toml[end] == '.' ||
                                 ((toml[end] == '-' || toml[end] == '+') &&
                                  (toml[end - 1] == 'e' || toml[end - 1] == 'E'))))
      ++end;
    out += shortest(toml.substr(i, end - i));
    i = end;
  }
  return out;
}

}  // namespace firn
