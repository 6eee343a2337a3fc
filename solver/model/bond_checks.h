// What a model must meet for its bonds.
#pragma once

#include "firn/model.h"

namespace firn {

// Throws InputError for bonds that are none.
void check_bonds(const Model& model);
// The bond that swings fastest, for time steps; none: -1.
struct FastestBond {
  int bond = -1;
  double frequency = 0;  // rad/s
};
FastestBond fastest_bond(const Model& model);

}  // namespace firn
