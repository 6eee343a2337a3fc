// Checks of the bonds of a model.
#pragma once

#include "firn/model.h"

namespace firn {

// Throws InputError for invalid bonds.
void check_bonds(const Model& model);
// The bond with the highest frequency, for the time step; -1: none.
struct FastestBond {
  int bond = -1;
  double frequency = 0;  // rad/s
};
FastestBond fastest_bond(const Model& model);

}  // namespace firn
