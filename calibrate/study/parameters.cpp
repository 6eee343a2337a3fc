#include "calibrate/study/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace firn {
namespace {

// Significant digits that distinguish this value from neighboring values in the range.
int digits_of(const Parameter& p, double value) {
  constexpr int usual = 4, most = 15;
  constexpr double fine = 5e-4;  // of the range
  const double size = std::abs(value);
  const double step = fine * p.width() * (p.logarithmic ? size : 1);
  if (!(size > 0) || !(step > 0)) return usual;
  const double last = std::floor(std::log10(size)) - std::floor(std::log10(step)) + 1;
  const double coarse = std::pow(10, std::floor(std::log10(size)) - usual + 1);
  return coarse <= step ? usual : std::clamp(static_cast<int>(last), usual, most);
}

}  // namespace

double Parameter::scaled(double value) const { return logarithmic ? std::log(value) : value; }

double Parameter::width() const { return scaled(max) - scaled(min); }

double Parameter::to_unit(double value) const { return (scaled(value) - scaled(min)) / width(); }

double Parameter::from_unit(double u) const {
  const double s = scaled(min) + u * width();
  return logarithmic ? std::exp(s) : s;
}

double Parameter::rounded(double u) const {
  if (integer) return std::clamp(std::round(from_unit(u)), min, max);
  return std::clamp(std::strtod(text(from_unit(u)).c_str(), nullptr), min, max);
}

std::string Parameter::text(double value) const {
  return fmt::format("{:.{}g}", value, digits_of(*this, value));
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

std::vector<double> rounded_values(const std::vector<Parameter>& parameters,
                                   const Eigen::VectorXd& u) {
  std::vector<double> values(parameters.size());
  for (std::size_t i = 0; i < parameters.size(); ++i)
    values[i] = parameters[i].rounded(u[static_cast<Eigen::Index>(i)]);
  return values;
}

}  // namespace firn
