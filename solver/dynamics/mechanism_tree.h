// The bodies, joints and loops of a mechanism, for the multibody library.
#pragma once

#include <vector>

#include "firn/motion.h"
#include "solver/dynamics/mechanism_members.h"
#include "solver/dynamics/multibody_tree.h"

namespace firn {

// Number of the body of a frame in the tree; -1: not a member, so a part of the ground.
int body_number(const MechanismMembers& members, int frame);

// [frames of the members]
std::vector<TreeBody> tree_bodies(const std::vector<MotionFrame>& all,
                                  const MechanismMembers& members);

// One for each coupling of the members that does not tie joints, in their order.
std::vector<TreeLoop> tree_loops(const std::vector<MotionFrame>& all,
                                 const std::vector<Coupling>& couplings,
                                 const MechanismMembers& members);

}  // namespace firn
