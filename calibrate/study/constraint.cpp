#include "calibrate/study/constraint.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "calibrate/numerics/experimental_design.h"
#include "firn/math.h"

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::uint64_t candidates = 4096;
constexpr double tolerance = 1e-3;  // unit cube

bool word_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

// Reads `[+-] [NUMBER] [*] [NAME]` terms into coefficients and a constant.
class RuleReader {
 public:
  RuleReader(const std::string& rule, const std::vector<Parameter>& parameters)
      : rule_(rule), parameters_(parameters) {}

  Constraint read() {
    Constraint c{rule_, std::vector<double>(parameters_.size(), 0), 0};
    read_side(1, c);
    skip_blanks();
    const std::string comparison = rule_.substr(at_, 2);
    if (comparison != "<=" && comparison != ">=") fail("expected <= or >= after the left side");
    at_ += 2;
    read_side(-1, c);
    if (at_ != rule_.size()) fail(fmt::format("expected its end before \"{}\"", rule_.substr(at_)));
    if (comparison == ">=") {
      for (double& x : c.coefficients) x = -x;
      c.bound = -c.bound;
    }
    if (std::all_of(c.coefficients.begin(), c.coefficients.end(), [](double x) { return x == 0; }))
      fail("expected a parameter in it");
    return c;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("\"{}\" is not an inequality: {}, as in \"dynamic <= 0.9 static\"",
                                 rule_, what));
  }
  void skip_blanks() {
    while (at_ < rule_.size() && rule_[at_] == ' ') ++at_;
  }
  char next() {
    skip_blanks();
    return at_ < rule_.size() ? rule_[at_] : '\0';
  }
  void read_side(double side, Constraint& c) {
    bool first = true;
    while (first || next() == '+' || next() == '-') {
      double factor = side;
      if (next() == '+' || next() == '-') factor *= rule_[at_++] == '-' ? -1 : 1;
      read_term(factor, c);
      first = false;
    }
  }
  void read_term(double factor, Constraint& c) {
    std::optional<double> number;
    if (const char n = next(); (n >= '0' && n <= '9') || n == '.') {
      double value = 0;
      const auto [end, error] =
          std::from_chars(rule_.data() + at_, rule_.data() + rule_.size(), value);
      if (error != std::errc() || !std::isfinite(value)) fail("expected finite numbers");
      number = value;
      at_ = static_cast<std::size_t>(end - rule_.data());
      if (next() == '*') ++at_;
    }
    skip_blanks();
    std::size_t end = at_;
    while (end < rule_.size() && word_character(rule_[end])) ++end;
    const std::string name = rule_.substr(at_, end - at_);
    at_ = end;
    if (name.empty() && !number) fail("expected a number or the name of a parameter");
    if (name.empty()) {
      c.bound -= factor * *number;
      return;
    }
    const auto found = std::find_if(parameters_.begin(), parameters_.end(),
                                    [&](const Parameter& p) { return p.name == name; });
    if (found == parameters_.end())
      fail(fmt::format("\"{}\" is not a parameter of the study", name));
    c.coefficients[static_cast<std::size_t>(found - parameters_.begin())] +=
        factor * number.value_or(1);
  }

  const std::string& rule_;
  const std::vector<Parameter>& parameters_;
  std::size_t at_ = 0;
};

// Left side less the bound, and the size of its terms.
double excess(const Constraint& c, const std::vector<double>& values, double* size = nullptr) {
  double sum = -c.bound, terms = std::abs(c.bound);
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum += c.coefficients[i] * values[i];
    terms += std::abs(c.coefficients[i] * values[i]);
  }
  if (size != nullptr) *size = terms;
  return sum;
}

bool allowed_at(const Constraints& constraints, const std::vector<double>& values) {
  constexpr double rounding = 1e-12;
  return std::all_of(constraints.all.begin(), constraints.all.end(), [&](const Constraint& c) {
    double size = 0;
    const double sum = excess(c, values, &size);
    return sum <= rounding * size;
  });
}

std::vector<double> values_at(const std::vector<Parameter>& parameters, const VectorXd& u) {
  std::vector<double> values(parameters.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = parameters[i].from_unit(u[static_cast<Index>(i)]);
  return values;
}

}  // namespace

Constraint parse_constraint(const std::string& rule, const std::vector<Parameter>& parameters) {
  return RuleReader(rule, parameters).read();
}

Constraints make_constraints(std::vector<Constraint> all,
                             const std::vector<Parameter>& parameters) {
  Constraints c{std::move(all), {}, 1};
  const int d = static_cast<int>(parameters.size());
  c.middle = VectorXd::Constant(d, 0.5);
  if (c.all.empty()) return c;
  std::vector<VectorXd> inside;
  VectorXd mean = VectorXd::Zero(d);
  for (std::uint64_t i = 0; i < candidates; ++i) {
    const VectorXd u = quasi_random_point(i, d);
    if (!allowed(c, parameters, u)) continue;
    inside.push_back(u);
    mean += u;
  }
  c.share = static_cast<double>(inside.size()) / static_cast<double>(candidates);
  if (inside.empty()) return c;
  mean /= static_cast<double>(inside.size());
  c.middle = *std::min_element(inside.begin(), inside.end(), [&](const auto& a, const auto& b) {
    return (a - mean).squaredNorm() < (b - mean).squaredNorm();
  });
  return c;
}

bool allowed(const Constraints& constraints, const std::vector<Parameter>& parameters,
             const VectorXd& u) {
  return constraints.all.empty() || allowed_at(constraints, values_at(parameters, u));
}

VectorXd violations(const Constraints& constraints, const std::vector<Parameter>& parameters,
                    const VectorXd& u, MatrixXd* jacobian) {
  const auto count = static_cast<Index>(constraints.all.size());
  VectorXd r = VectorXd::Zero(count);
  if (jacobian != nullptr) *jacobian = MatrixXd::Zero(count, u.size());
  const std::vector<double> values = values_at(parameters, u);
  for (Index k = 0; k < count; ++k) {
    const Constraint& c = constraints.all[static_cast<std::size_t>(k)];
    const double sum = excess(c, values);
    if (!(sum > 0)) continue;
    VectorXd slope(u.size());
    for (Index i = 0; i < u.size(); ++i) {
      const auto p = static_cast<std::size_t>(i);
      slope[i] =
          c.coefficients[p] * parameters[p].width() * (parameters[p].logarithmic ? values[p] : 1);
    }
    const double steepness = slope.norm();
    r[k] = sum / (steepness * tolerance);
    if (jacobian != nullptr) jacobian->row(k) = slope.transpose() / (steepness * tolerance);
  }
  return r;
}

std::vector<double> allowed_values(const Constraints& constraints,
                                   const std::vector<Parameter>& parameters, const VectorXd& u) {
  std::vector<double> values = rounded_values(parameters, u);
  constexpr int steps = 1000;
  for (int s = 1; s <= steps && !allowed_at(constraints, values); ++s)
    values = rounded_values(parameters, u + double(s) / steps * (constraints.middle - u));
  return values;
}

std::vector<VectorXd> spread_points(const Constraints& constraints,
                                    const std::vector<Parameter>& parameters, int count,
                                    std::vector<VectorXd> taken) {
  const int d = static_cast<int>(parameters.size());
  std::vector<VectorXd> open, chosen;
  for (std::uint64_t i = 0; i < candidates; ++i)
    if (VectorXd u = quasi_random_point(i, d); allowed(constraints, parameters, u))
      open.push_back(std::move(u));
  while (static_cast<int>(chosen.size()) < count && !open.empty()) {
    std::size_t best = 0;
    double most = -1;
    for (std::size_t i = 0; i < open.size(); ++i) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const VectorXd& t : taken) nearest = std::min(nearest, (open[i] - t).squaredNorm());
      if (nearest > most) {
        most = nearest;
        best = i;
      }
    }
    chosen.push_back(open[best]);
    taken.push_back(open[best]);
    open.erase(open.begin() + static_cast<std::ptrdiff_t>(best));
  }
  return chosen;
}

}  // namespace firn
