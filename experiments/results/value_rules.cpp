#include "experiments/results/value_rules.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "experiments/results/schema_paths.h"

namespace firn::results {
namespace {

using hdf5::Shape;
using R = Rule;

bool is_whole(double v) { return v == std::floor(v); }
bool is_finite(double v) { return std::abs(v) <= kLargestNumber; }

bool keeps(Rule rule, double v, const Limits& limits) {
  switch (rule) {
    case R::any:
      return true;
    case R::finite:
    case R::rotation:
      return is_finite(v);
    case R::positive:
      return v > 0 && is_finite(v);
    case R::non_negative:
    case R::ascending:
      return v >= 0 && is_finite(v);
    case R::finite_or_nan:
    case R::vector_or_nan:
    case R::rotation_or_nan:
      return std::isnan(v) || is_finite(v);
    case R::non_negative_or_nan:
      return std::isnan(v) || (v >= 0 && is_finite(v));
    case R::flag:
      return v == 0 || v == 1;
    case R::batch:
      return v >= -1;
    case R::index:
      return v >= 0 && v < limits.count && is_whole(v);
    case R::index_or_none:
      return v >= -1 && v < limits.count && is_whole(v);
    case R::body:
      return v >= -limits.boundaries && v < limits.count && is_whole(v);
    case R::body_or_nan:
      return std::isnan(v) || keeps(R::body, v, limits);
    case R::counting:
    case R::choice:
      return true;
  }
  return true;
}

std::string place_text(std::size_t at, const Shape& shape, std::size_t first_row) {
  if (shape.empty()) return "its value";
  std::vector<std::size_t> place(shape.size());
  for (std::size_t k = shape.size(); k-- > 0;) {
    const std::size_t n = k == 0 ? at + 1 : std::max<std::size_t>(shape[k], 1);
    place[k] = at % n + (k == 0 ? first_row : 0);
    at /= n;
  }
  return shape.size() == 1 ? fmt::format("entry {}", place[0])
                           : fmt::format("entry [{}]", fmt::join(place, ", "));
}

}  // namespace

Limits limits_of(Rule rule, std::size_t length, std::size_t particles) {
  const auto n = static_cast<double>(length);
  if (rule != R::body && rule != R::body_or_nan) return {n, 0};
  return {static_cast<double>(particles), n};
}

std::string range_text(Rule rule, const Limits& limits) {
  switch (rule) {
    case R::any:
      return "any";
    case R::finite:
      return "a finite number";
    case R::positive:
      return "a finite number above 0";
    case R::non_negative:
      return "a finite number, 0 or more";
    case R::ascending:
      return "finite numbers from 0 on, none below the one before";
    case R::finite_or_nan:
      return "a finite number, or NaN";
    case R::vector_or_nan:
      return "finite numbers, or NaN in all of a vector";
    case R::rotation:
      return "a unit quaternion";
    case R::rotation_or_nan:
      return "a unit quaternion, or NaN in all of it";
    case R::non_negative_or_nan:
      return "a finite number, 0 or more, or NaN";
    case R::flag:
      return "0 or 1";
    case R::batch:
      return "-1 or more";
    case R::index:
      return limits.count > 0 ? fmt::format("0 ... {}", limits.count - 1) : "none at all";
    case R::index_or_none:
      return fmt::format("-1 ... {}", limits.count - 1);
    case R::body:
      if (std::isinf(limits.boundaries)) return fmt::format("{} or less", limits.count - 1);
      return fmt::format("{} ... {}", -limits.boundaries, limits.count - 1);
    case R::body_or_nan:
      return range_text(R::body, limits) + ", or NaN";
    case R::counting:
      return "0, 1, 2, ...";
    case R::choice:
      break;
  }
  return "one of the known texts";
}

std::optional<std::size_t> first_wrong(Rule rule, std::span<const double> v, std::size_t width,
                                       const Limits& limits) {
  for (std::size_t i = 0; i < v.size(); ++i)
    if (!keeps(rule, v[i], limits)) return i;
  if (rule == R::counting) {
    for (std::size_t i = 0; i < v.size(); ++i)
      if (v[i] != static_cast<double>(i)) return i;
  }
  if (rule == R::ascending) {
    for (std::size_t i = 1; i < v.size(); ++i)
      if (v[i] < v[i - 1]) return i;
  }
  const bool is_rotation = rule == R::rotation || rule == R::rotation_or_nan;
  if (!is_rotation && rule != R::vector_or_nan) return std::nullopt;
  constexpr double kUnit = 1e-3;  // of the squared length
  for (std::size_t i = 0; i + width <= v.size(); i += width) {
    std::size_t absent = 0;
    double square = 0;
    for (std::size_t k = i; k < i + width; ++k) {
      absent += std::isnan(v[k]);
      square += v[k] * v[k];
    }
    if (absent == width) continue;
    if (absent > 0 || (is_rotation && std::abs(square - 1) > kUnit)) return i;
  }
  return std::nullopt;
}

void check_numbers(std::string_view path, Rule rule, std::span<const double> values,
                   const Shape& shape, const Limits& limits, std::size_t first_row) {
  const std::size_t width = shape.empty() ? 1 : shape.back();
  if (const auto wrong = first_wrong(rule, values, width, limits))
    throw hdf5::Error(fmt::format("{}: {} is {:.9g}; expected {}", path,
                                  place_text(*wrong, shape, first_row), values[*wrong],
                                  range_text(rule, limits)));
}

bool is_choice(std::string_view value, std::string_view choices) {
  return std::ranges::any_of(split_list(choices, '|'), [&](std::string_view one) {
    return value == one || (value.starts_with(one) && value.substr(one.size()).starts_with(": "));
  });
}

std::string choices_text(std::string_view choices) {
  return fmt::format("{}", fmt::join(split_list(choices, '|'), ", "));
}

}  // namespace firn::results
