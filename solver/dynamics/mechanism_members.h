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

// True when more than one joint has friction, motors or limits. Impulses within bounds on one joint
// change the rates of the others where the inertia of the body couples them, so that those of
// several joints are solved together.
bool has_several_bounded_joints(const FreeBody& body);

// Members of all mechanisms. A single free frame is one if it has_several_bounded_joints(), else it
// belongs to none. Throws InputError, naming frame or coupling, when parts of a mechanism stand on
// different grounds, or a coupling ties no two bodies.
std::vector<MechanismMembers> find_mechanisms(const std::vector<MotionFrame>& frames,
                                              const std::vector<Coupling>& couplings);

}  // namespace firn
