// Which free frames and couplings form a mechanism.
#pragma once

#include <vector>

#include "firn/motion.h"

namespace firn {

// Free frames of a mechanism in order of their numbers, and its couplings.
struct MechanismMembers {
  std::vector<int> frames;
  std::vector<int> couplings;
  int ground = -1;  // prescribed frame to which all of them are attached; -1: the world
};

// Members of all mechanisms. A single free frame is one if several of its joints have friction,
// motors or limits, else it belongs to none. Throws InputError, naming frame or coupling, when
// parts of a mechanism stand on different grounds, or a coupling ties no two bodies.
std::vector<MechanismMembers> find_mechanisms(const std::vector<MotionFrame>& frames,
                                              const std::vector<Coupling>& couplings);

}  // namespace firn
