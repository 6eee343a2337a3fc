#include "solver/dynamics/mechanism_tree.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace firn {

namespace {

TreeLoop::Kind loop_kind(Coupling::Kind kind) {
  switch (kind) {
    case Coupling::Kind::hinge:
      return TreeLoop::Kind::hinge;
    case Coupling::Kind::weld:
      return TreeLoop::Kind::weld;
    case Coupling::Kind::slot:
      return TreeLoop::Kind::slot;
    default:
      return TreeLoop::Kind::ball;
  }
}

}  // namespace

int body_number(const MechanismMembers& members, int frame) {
  const auto at = std::ranges::find(members.frames, frame);
  return at == members.frames.end() ? -1 : static_cast<int>(at - members.frames.begin());
}

std::vector<TreeBody> tree_bodies(const std::vector<MotionFrame>& all,
                                  const MechanismMembers& members) {
  std::vector<TreeBody> bodies;
  for (const int f : members.frames) {
    const MotionFrame& frame = all[static_cast<std::size_t>(f)];
    TreeBody body;
    body.parent = body_number(members, free_frame(all, frame.parent));
    body.origin = frame.origin;
    body.mass = frame.free->mass;
    body.center = frame.free->center;
    body.inertia = frame.free->inertia;
    body.free_rotation = frame.free->free_rotation;
    for (const Joint& j : frame.free->joints)
      body.joints.push_back({j.kind == Joint::Kind::rotation, j.direction});
    bodies.push_back(std::move(body));
  }
  return bodies;
}

std::vector<TreeLoop> tree_loops(const std::vector<MotionFrame>& all,
                                 const std::vector<Coupling>& couplings,
                                 const MechanismMembers& members) {
  std::vector<TreeLoop> loops;
  for (const int c : members.couplings) {
    const Coupling& one = couplings[static_cast<std::size_t>(c)];
    if (one.ties_joints()) continue;
    loops.push_back({loop_kind(one.kind), body_number(members, free_frame(all, one.a)),
                     body_number(members, free_frame(all, one.b)), one.position, one.direction});
  }
  return loops;
}

}  // namespace firn
