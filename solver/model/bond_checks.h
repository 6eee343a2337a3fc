// Checks of the bonds of a model.
#pragma once

#include <string>

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
// For messages: "particles 1 and 2", "particle 1 and boundary \"mold\"".
std::string ends_text(const Model& model, const Bond& bond);

}  // namespace firn
