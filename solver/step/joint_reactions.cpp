#include "solver/step/joint_reactions.h"

#include "solver/step/frame_poses.h"
#include "solver/step/free_body_energy.h"

namespace firn {

JointLoad other_impulse(const Model& model, const FreeBody& body, const Vec3& origin,
                        const BodyLoad& load, const FrameMotion& before, const FrameMotion& now,
                        JointReaction& joint) {
  JointLoad other;
  const double dt = model.timestep;
  const RotationMap from(before.rotation), to(now.rotation);
  const Vec3 arm = from * (body.center - origin);
  const Vec3 velocity = now.velocity + (to * (body.center - origin) - arm) / dt;
  const Mat3 inertia =
      0.5 * (from * body.inertia * from.transpose() + to * body.inertia * to.transpose());
  const Vec3 angular_momentum = inertia * now.angular_velocity;
  if (joint.known > 0) {
    const Vec3 momentum =
        body.mass * (velocity - joint.center_velocity) - body.mass * model.gravity * dt;
    other.force = momentum - load.force * dt;
    other.torque =
        angular_momentum - joint.angular_momentum + arm.cross(momentum) - load.torque * dt;
  }
  joint.center_velocity = velocity;
  joint.angular_momentum = angular_momentum;
  joint.known = 1;
  return other;
}

void record_reaction(const JointLoad& parent, double dt, JointReaction& joint) {
  joint.force = parent.force / dt;
  joint.torque = parent.torque / dt;
  joint.impulse += parent.force;
  joint.angular_impulse += parent.torque;
}

void record_reactions(const Model& model, State& s, const std::vector<FrameMotion>& before,
                      const std::vector<BodyLoad>& loads, const Mechanism& mechanism) {
  const MechanismMembers& members = mechanism.members();
  std::vector<JointLoad> borne(model.frames.size());
  const auto add = [&](int frame, const Vec3& at, const Vec3& force, const Vec3& torque) {
    const int f = free_frame(model.frames, frame);
    if (f < 0) return;
    JointLoad& load = borne[static_cast<std::size_t>(f)];
    load.force += force;
    load.torque += torque + (at - before[static_cast<std::size_t>(f)].position).cross(force);
  };
  for (const int c : members.couplings) {
    const Coupling& coupling = model.couplings[static_cast<std::size_t>(c)];
    if (coupling.ties_joints()) continue;  // through the bearings
    const CouplingReaction& memory = s.couplings[static_cast<std::size_t>(c)];
    add(coupling.b, memory.position, -memory.half_impulse, -memory.half_angular_impulse);
    add(coupling.a, memory.position, memory.half_impulse, memory.half_angular_impulse);
  }
  for (std::size_t k = members.frames.size(); k-- > 0;) {
    const auto f = static_cast<std::size_t>(members.frames[k]);
    const MotionFrame& frame = model.frames[f];
    const bool is_known = s.joint_reactions[f].known > 0;
    const JointLoad own = other_impulse(model, *frame.free, frame.origin, loads[f], before[f],
                                        s.frames[f], s.joint_reactions[f]);
    add_carrier_work(before, f, members.ground,
                     is_known ? own : starting_impulse(model, before, f, s.joint_reactions[f]), s);
    if (!is_known) continue;
    borne[f].force += own.force;
    borne[f].torque += own.torque;
    record_reaction(borne[f], model.timestep, s.joint_reactions[f]);
    add(frame.parent, before[f].position, borne[f].force, borne[f].torque);
  }
}

void estimate_reactions(const Model& model, State& s) {
  for (std::size_t f = model.frames.size(); f-- > 0;) {
    const MotionFrame& frame = model.frames[f];
    if (!frame.free) continue;
    JointReaction& joint = s.joint_reactions[f];
    const Vec3 support = -frame.free->mass * model.gravity;
    joint.force += support;
    joint.torque += (frame.free->center - frame.origin).cross(support);
    const int below = free_frame(model.frames, frame.parent);
    if (below < 0) continue;
    JointReaction& carrier = s.joint_reactions[static_cast<std::size_t>(below)];
    const Vec3 arm = frame.origin - model.frames[static_cast<std::size_t>(below)].origin;
    carrier.force += joint.force;
    carrier.torque += joint.torque + arm.cross(joint.force);
  }
}

}  // namespace firn
