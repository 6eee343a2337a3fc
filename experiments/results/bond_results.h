// Bonds in a results file.
#pragma once

#include <string>
#include <vector>

#include "experiments/results/results_file.h"

namespace firn {

struct BondOutcome {
  std::string name;  // of the table [[bonds]] in the case
  int a = 0;         // particle
  int b = 0;         // particle, or -1 - the index of a boundary
  // "intact", "removed" (a body was removed), "lifetime" (it has ended), or the failure mode:
  // "tension", ...
  std::string mode;
  double time = 0;               // s, when it broke or its lifetime ended; NaN: neither
  double stress = 0;             // Pa, at breakage; NaN: not broken
  Vec3 position = Vec3::Zero();  // m, of its middle at `time`

  bool is_broken() const;
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
// m, world: end b of a bond to a boundary.
Vec3 end_on_boundary(const Model& model, const Bond& bond);
// "particle 3 and boundary \"mold\"", "particles 3 and 4".
std::string bodies_text(const Model& model, const BondOutcome& outcome);
// The bonds that are intact at `time` (s), the time of `frame`.
std::vector<BondBox> intact_bonds_at(const Case& c, const std::vector<BondOutcome>& outcomes,
                                     double time, const Frame& frame);

// Responses: numbers of bonds and of broken bonds, times and modes of breakage (docs/responses.md).
// Bonds whose lifetime has ended are not broken.
std::vector<Response> bond_responses(const Recording& recording, const Case& c);

}  // namespace firn
