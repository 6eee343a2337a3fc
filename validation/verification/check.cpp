#include "validation/verification/check.h"

#include <cmath>
#include <iterator>
#include <limits>

namespace firn::verification {

double tolerance_fraction(const Check& c) {
  if (!std::isfinite(c.measured)) return std::numeric_limits<double>::infinity();
  const double off = std::abs(c.measured - c.expected);
  switch (c.bound) {
    case Bound::relative:
      return off == 0 ? 0 : off / (c.tolerance * std::abs(c.expected));
    case Bound::absolute:
      return off == 0 ? 0 : off / c.tolerance;
    case Bound::at_most:
      return c.measured <= 0 ? 0 : c.measured / c.expected;
    case Bound::at_least:
      return c.expected <= 0 ? 0 : c.expected / c.measured;
  }
  return std::numeric_limits<double>::infinity();
}

bool passed(const Check& c) {
  if (!std::isfinite(c.measured)) return false;
  switch (c.bound) {
    case Bound::relative:
      return std::abs(c.measured - c.expected) <= c.tolerance * std::abs(c.expected);
    case Bound::absolute:
      return std::abs(c.measured - c.expected) <= c.tolerance;
    case Bound::at_most:
      return c.measured <= c.expected;
    case Bound::at_least:
      return c.measured >= c.expected;
  }
  return false;
}

std::string group(const VerificationCase& c) { return c.name.substr(0, c.name.find('.')); }

std::vector<VerificationCase> all_cases() {
  std::vector<VerificationCase> all;
  for (auto* cases :
       {impact_cases, energy_cases, body_cases, structure_cases, bulk_cases, machine_cases,
        invariance_cases, mesh_cases, tessellation_cases, curved_wall_cases, robustness_cases}) {
    std::vector<VerificationCase> some = cases();
    all.insert(all.end(), std::make_move_iterator(some.begin()),
               std::make_move_iterator(some.end()));
  }
  return all;
}

}  // namespace firn::verification
