// Tables and scratch memory of the bonds, made once from the model.
#pragma once

#include <cstdint>
#include <vector>

#include "firn/model.h"

namespace firn {

// The six dampers of a bond.
struct BeamDampers {
  Vec6 constants;  // N s/m and N m s/rad
  Mat6 implicit;   // (1 + dt/2 mobility constants)^-1
};

struct BondWorkspace {
  explicit BondWorkspace(const Model& model);

  std::vector<BeamSprings> stiffness;  // [bonds]
  std::vector<BeamDampers> dampers;    // [bonds]
  // The bonds of body i are ends[first[i]] ... ends[first[i + 1] - 1], ascending: twice the number
  // of the bond, and 1 more for its end b.
  std::vector<std::uint32_t> first;  // [particles + boundaries + 1]
  std::vector<std::uint32_t> ends;   // [2 * bonds]
  std::vector<double> lost;          // [bonds] J, in the present step
};

}  // namespace firn
