// Bonds in a results file.
#pragma once

#include <string>
#include <vector>

#include "experiments/results/results_file.h"

namespace firn {

struct BondOutcome {
  std::string name;  // of the table [[bonds]] in the case
  int a = 0, b = 0;  // particles
  std::string
      mode;  // "intact", "removed" (a body was removed), or the failure mode: "tension", ...
  // At breakage; NaN: not broken.
  double time = 0;               // s
  double stress = 0;             // Pa
  Vec3 position = Vec3::Zero();  // m
};
// [bonds] in the order of the case.
std::vector<BondOutcome> bond_outcomes(const Recording& recording);

// An intact bond as a box for display, in the axes of the beam.
struct BondBox {
  int bond = 0;
  Vec3 position = Vec3::Zero();         // m, center, world
  Quat orientation = Quat::Identity();  // beam axes -> world
  Vec3 size = Vec3::Zero();             // m, edge lengths
};
// The bonds that are intact at `time` (s), the time of `frame`.
std::vector<BondBox> intact_bonds_at(const Case& c, const std::vector<BondOutcome>& outcomes,
                                     double time, const Frame& frame);

// Responses: numbers of bonds and of broken bonds, times and modes of breakage (docs/responses.md).
std::vector<Response> bond_responses(const Recording& recording, const Case& c);

}  // namespace firn
