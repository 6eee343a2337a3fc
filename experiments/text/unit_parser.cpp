// Symbols of units, and their products.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "experiments/system/input_file.h"
#include "experiments/text/suggestions.h"
#include "experiments/text/units.h"

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

// Superscripts and dots of typeset units, and their plain spellings.
constexpr std::array<std::pair<std::string_view, std::string_view>, 14> kTypeset = {{
    {"\u2070", "0"},
    {"\u00b9", "1"},
    {"\u00b2", "2"},
    {"\u00b3", "3"},
    {"\u2074", "4"},
    {"\u2075", "5"},
    {"\u2076", "6"},
    {"\u2077", "7"},
    {"\u2078", "8"},
    {"\u2079", "9"},
    {"\u207b", "-"},
    {"\u00b7", " "},  // the middle dot and the dot operator
    {"\u22c5", " "},
    {"\u2212", "-"},  // the minus sign
}};
constexpr std::size_t kSuperscripts = 11;  // of them, in front

// Recursive descent over  product := factor { [*|/] factor },  factor := atom [[^] integer],
// atom := symbol | 1 | ( product ).
class UnitParser {
 public:
  explicit UnitParser(std::string_view text) : given_(text), plain_(plain_unit(text)) {}

  Unit parse() {
    const Unit unit = product(0);
    if (at_ < text_.size()) fail();
    return unit;
  }

 private:
  static constexpr int kDeepest = 16;
  static constexpr int kLargestExponent = 99;

  [[noreturn]] void fail() const {
    throw InputError(fmt::format("cannot read \"{}\" as a unit", shortened(given_)));
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

  std::string_view given_;
  const std::string plain_;
  const std::string_view text_ = plain_;
  std::size_t at_ = 0;
};

}  // namespace

std::string plain_unit(std::string_view text) {
  std::string plain;
  bool raised = false;  // the last sign was a superscript
  while (!text.empty()) {
    const auto sign = std::ranges::find_if(
        kTypeset, [&](const auto& typeset) { return text.starts_with(typeset.first); });
    const bool typeset = sign != kTypeset.end();
    const bool superscript =
        typeset && static_cast<std::size_t>(sign - kTypeset.begin()) < kSuperscripts;
    if (superscript && !raised) plain += '^';
    plain += typeset ? sign->second : text.substr(0, 1);
    text.remove_prefix(typeset ? sign->first.size() : 1);
    raised = superscript;
  }
  return plain;
}

Unit parse_unit(std::string_view text) { return UnitParser(text).parse(); }

std::optional<double> conversion_factor(std::string_view from, std::string_view to) {
  const Unit a = parse_unit(from), b = parse_unit(to);
  if (a.dimension != b.dimension) return std::nullopt;
  return a.factor / b.factor;
}

}  // namespace firn
