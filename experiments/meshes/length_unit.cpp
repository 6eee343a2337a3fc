#include "experiments/meshes/length_unit.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "experiments/text/number_text.h"
#include "experiments/text/units.h"
#include "firn/math.h"

namespace firn {
namespace {

struct UsualSize {
  double smallest, largest;                // m; beyond, the unit is in question
  double likely_smallest, likely_largest;  // m; within, another unit is proposed
};
constexpr UsualSize kIceCube{4e-3, 0.2, 8e-3, 0.12};
constexpr UsualSize kMachinePart{10e-3, 5, 30e-3, 2};

std::string in_millimeters(double length) { return number_text(1e3 * length, 3) + " mm"; }

}  // namespace

std::string length_unit_warning(double longest_edge, double length_unit, MeshUse use) {
  const UsualSize& usual = use == MeshUse::particle ? kIceCube : kMachinePart;
  if (longest_edge >= usual.smallest && longest_edge <= usual.largest) return {};
  std::string others;
  for (const char* name : std::array{"mm", "cm", "in", "m"}) {
    const double unit = parse_length_unit(name);
    const double edge = longest_edge / length_unit * unit;
    if (std::abs(unit - length_unit) < 1e-9 * unit || edge < usual.likely_smallest ||
        edge > usual.likely_largest)
      continue;
    others += fmt::format(", {} in \"{}\"", in_millimeters(edge), name);
  }
  if (others.empty()) return {};
  return fmt::format("the longest edge is {} in this unit{}: check the unit",
                     in_millimeters(longest_edge), others);
}

double parse_length_unit(const std::string& name) {
  try {
    return parse_quantity("1 " + name, dimension::length);
  } catch (const InputError&) {
    throw InputError(fmt::format(
        "\"{}\" is not a unit of length; expected one such as \"mm\", \"cm\", \"m\" or \"in\"",
        name));
  }
}

}  // namespace firn
