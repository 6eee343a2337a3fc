// Bonds in a results file.
#pragma once

#include <string>
#include <vector>

#include "experiments/results/results_file.h"

namespace firn {

struct BondOutcome {
  std::string name;  // of its table in the case
  int a = 0, b = 0;  // particles
  std::string mode;  // "intact", "removed" (a body has left), or what broke it: "tension", ...
  // Of the break; NaN: it is not broken.
  double time = 0;            // s
  double stress = 0;          // Pa
  Vec3 place = Vec3::Zero();  // m
};
// [bonds of the case]; empty for a case without.
std::vector<BondOutcome> bond_outcomes(const Recording& recording);

// A bond that holds at the instant of a frame, as a box about its middle, axes as the beam's.
struct Bridge {
  int bond = 0;
  Vec3 position = Vec3::Zero();  // m
  Quat orientation = Quat::Identity();
  Vec3 size = Vec3::Zero();  // m
};
std::vector<Bridge> bridges_at(const Case& c, const std::vector<BondOutcome>& outcomes, double time,
                               const Frame& frame);

// Responses: numbers of bonds and of broken bonds, times and modes of breakage.
std::vector<Response> bond_responses(const Recording& recording, const Case& c);

}  // namespace firn
