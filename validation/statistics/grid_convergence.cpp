#include "validation/statistics/grid_convergence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace firn {

Convergence converge(const Levels& l) {
  constexpr double least_order = 0.5, most_order = 2.5, sure = 2, k = 2;
  const double first = l.medium - l.coarse, second = l.fine - l.medium;
  const bool stands_out = std::abs(first) > sure * l.error && std::abs(second) > sure * l.error;
  if (!stands_out || first * second <= 0 || std::abs(second) >= std::abs(first)) {
    const double largest =
        std::max({std::abs(first), std::abs(second), std::abs(l.fine - l.coarse)});
    return {std::nullopt, std::max(largest, sure * l.error) / k,
            fmt::format("no order of convergence ({}): bounded by {:.3g}",
                        stands_out ? "the differences do not fall" : "the seeds hide it",
                        std::max(largest, sure * l.error))};
  }
  const double order = std::log(first / second) / std::log(l.ratio);
  const double used = std::clamp(order, least_order, most_order);
  const double safety = used == order ? 1.25 : 3;
  const double index = safety * std::abs(l.fine - l.coarse) / (1 - std::pow(l.ratio, -2 * used));
  return {order, index / k,
          fmt::format("observed order {:.2g} over three levels, grid convergence index {:.3g}",
                      order, index)};
}

}  // namespace firn
