#include "tests/calibration_proof/formula.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "firn/math.h"

namespace firn::proof {
namespace {

using Values = std::vector<double>;

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Recursive descent; each level binds more tightly than the one before.
class FormulaReader {
 public:
  FormulaReader(const std::string& text, const std::vector<std::string>& names)
      : text_(text), names_(names) {}

  Formula read() {
    Formula f = comparison();
    if (next() != '\0') fail();
    return f;
  }

 private:
  [[noreturn]] void fail() const {
    throw InputError(fmt::format("\"{}\" is no formula: unexpected \"{}\"", text_,
                                 at_ < text_.size() ? text_.substr(at_) : "end"));
  }
  char next() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  bool take(char c) {
    if (next() != c) return false;
    ++at_;
    return true;
  }
  Formula comparison() {
    const Formula left = sum();
    if (take('<'))
      return [left, right = sum()](const Values& v) { return double(left(v) < right(v)); };
    if (take('>'))
      return [left, right = sum()](const Values& v) { return double(left(v) > right(v)); };
    return left;
  }
  Formula sum() {
    Formula f = product();
    while (true) {
      if (take('+'))
        f = [f, g = product()](const Values& v) { return f(v) + g(v); };
      else if (take('-'))
        f = [f, g = product()](const Values& v) { return f(v) - g(v); };
      else
        return f;
    }
  }
  Formula product() {
    Formula f = signed_power();
    while (true) {
      if (take('*'))
        f = [f, g = signed_power()](const Values& v) { return f(v) * g(v); };
      else if (take('/'))
        f = [f, g = signed_power()](const Values& v) { return f(v) / g(v); };
      else
        return f;
    }
  }
  Formula signed_power() {
    if (take('-')) return [f = signed_power()](const Values& v) { return -f(v); };
    const Formula base = atom();
    if (!take('^')) return base;
    return [base, exponent = signed_power()](const Values& v) {
      return std::pow(base(v), exponent(v));
    };
  }
  Formula atom() {
    if (++depth_ > 200) fail();
    if (take('(')) {
      Formula f = comparison();
      if (!take(')')) fail();
      return f;
    }
    if (is_letter(next())) return name();
    double value = 0;
    const auto [end, error] =
        std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error != std::errc()) fail();
    at_ = static_cast<std::size_t>(end - text_.data());
    return [value](const Values&) { return value; };
  }
  Formula name() {
    std::size_t end = at_;
    while (end < text_.size() && (is_letter(text_[end]) || is_digit(text_[end]))) ++end;
    const std::string word = text_.substr(at_, end - at_);
    if (const auto found = std::find(names_.begin(), names_.end(), word); found != names_.end()) {
      at_ = end;
      return
          [i = static_cast<std::size_t>(found - names_.begin())](const Values& v) { return v[i]; };
    }
    static const std::map<std::string, double (*)(double)> functions = {
        {"exp", std::exp}, {"log", std::log},   {"sqrt", std::sqrt}, {"sin", std::sin},
        {"cos", std::cos}, {"tanh", std::tanh}, {"abs", std::abs}};
    if (const auto f = functions.find(word); f != functions.end()) {
      at_ = end;
      return [f = f->second, x = arguments(1)[0]](const Values& v) { return f(x(v)); };
    }
    if (word != "min" && word != "max") fail();
    at_ = end;
    const std::vector<Formula> two = arguments(2);
    if (word == "min") return [two](const Values& v) { return std::min(two[0](v), two[1](v)); };
    return [two](const Values& v) { return std::max(two[0](v), two[1](v)); };
  }
  std::vector<Formula> arguments(std::size_t count) {
    std::vector<Formula> all;
    if (!take('(')) fail();
    do all.push_back(comparison());
    while (take(','));
    if (!take(')') || all.size() != count) fail();
    return all;
  }

  const std::string& text_;
  const std::vector<std::string>& names_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

Formula parse_formula(const std::string& text, const std::vector<std::string>& names) {
  return FormulaReader(text, names).read();
}

}  // namespace firn::proof
