#include "calibrate/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace firn {
namespace {

double scaled(const Parameter& p, double value) { return p.logarithmic ? std::log(value) : value; }

}  // namespace

double Parameter::width() const { return scaled(*this, max) - scaled(*this, min); }

double Parameter::to_unit(double value) const {
  return (scaled(*this, value) - scaled(*this, min)) / width();
}

double Parameter::from_unit(double u) const {
  const double s = scaled(*this, min) + u * width();
  return logarithmic ? std::exp(s) : s;
}

double Parameter::tidy(double u) const {
  const std::string digits = fmt::format("{:.4g}", from_unit(u));
  return std::clamp(std::strtod(digits.c_str(), nullptr), min, max);
}

double Parameter::prior_mean_unit() const { return prior_mean ? to_unit(*prior_mean) : 0.5; }

std::optional<double> Parameter::prior_sd_unit() const {
  if (!prior_sd) return std::nullopt;
  // In logarithms a small sd becomes sd / mean.
  return (logarithmic ? *prior_sd / *prior_mean : *prior_sd) / width();
}

Eigen::VectorXd to_unit(const std::vector<Parameter>& parameters,
                        const std::vector<double>& values) {
  Eigen::VectorXd u(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i)
    u[static_cast<Eigen::Index>(i)] = parameters[i].to_unit(values[i]);
  return u;
}

std::vector<double> tidy_values(const std::vector<Parameter>& parameters,
                                const Eigen::VectorXd& u) {
  std::vector<double> values(parameters.size());
  for (std::size_t i = 0; i < parameters.size(); ++i)
    values[i] = parameters[i].tidy(u[static_cast<Eigen::Index>(i)]);
  return values;
}

}  // namespace firn
