// Motion frames and the boundaries that they carry.
#include "solver/step/moving_boundaries.h"

#include <algorithm>
#include <vector>

#include "firn/rigid_motion.h"
#include "solver/dynamics/free_body.h"
#include "solver/dynamics/rotation_vector.h"
#include "solver/state/workspace.h"
#include "solver/step/frame_poses.h"
#include "solver/step/free_body_energy.h"
#include "solver/step/joint_reactions.h"

namespace firn {

namespace {

struct Place {
  Vec3 position = Vec3::Zero();
  Quat orientation = Quat::Identity();
  Vec3 turned = Vec3::Zero();  // rad, rotation vector of the step
};

// Applies one step of a motion. `by`: displacement of its directions and center by the motions
// before it; null: no displacement.
void apply(const Motion& m, const RigidMotion* by, const Vec3& origin, double t, double dt,
           Place& place) {
  const double displacement = m.displacement(t, dt);
  if (displacement == 0) return;
  const auto direction = [&](const Vec3& v) { return by ? Vec3(by->rotation * v) : v; };
  if (m.kind == Motion::Kind::translation) {
    place.position +=
        direction(m.profile == Motion::Profile::constant ? m.velocity : m.axis) * displacement;
    return;
  }
  const Vec3 axis = direction(m.axis);
  const Quat turn(Eigen::AngleAxisd(displacement, axis));
  Vec3 center = m.center - origin;
  if (by) center = by->rotation * center + by->translation;
  place.position = center + turn * (place.position - center);
  place.orientation = turn * place.orientation;
  if (place.turned.isZero(0)) {
    place.turned = axis * displacement;
  } else {
    const Quat so_far(Eigen::AngleAxisd(place.turned.norm(), place.turned.normalized()));
    const Eigen::AngleAxisd both(turn * so_far);
    place.turned = both.angle() * both.axis();
  }
}

// Applies a step of all motions of a boundary or frame (`mover` as in State::stage_motion_mover).
// The motions before a motion carry its axes and center, as if each of them moved a frame. In a
// step from t, motion j rotates about the position of its center at t. The steps are applied in
// reverse order. They give exactly the change of the combined motion, because a step of a motion
// commutes with the total displacement of the same motion.
void apply_all(const std::vector<Motion>& motions, std::size_t mover, const Vec3& origin,
               const State& s, double dt, BoundaryMotionScratch& scratch, Place& place) {
  std::vector<const Motion*>& all = scratch.motions;
  all.clear();
  for (const Motion& m : motions) all.push_back(&m);
  for (std::size_t k = 0; k < s.stage_motions.size(); ++k) {
    if (s.stage_motion_mover[k] == static_cast<int>(mover)) all.push_back(&s.stage_motions[k]);
  }
  std::vector<RigidMotion>& carried = scratch.carried;
  carried.assign(all.size(), {});
  std::size_t still = 1;  // number of motions at the front that have no displacement before them
  for (std::size_t j = 1; j < all.size(); ++j) {
    const double displacement = all[j - 1]->total_displacement(s.time);
    carried[j] = carried[j - 1];
    carried[j].append(*all[j - 1], origin, displacement);
    if (displacement == 0 && still == j) ++still;
  }
  for (std::size_t j = all.size(); j-- > 0;)
    apply(*all[j], j < still ? nullptr : &carried[j], origin, s.time, dt, place);
  if (!place.turned.isZero(0)) place.orientation.normalize();
}

// Rotation vector from one orientation to the next, rad.
Vec3 rotation_vector(const Mat3& from, const Mat3& to) {
  const Eigen::AngleAxisd turn(Quat(Mat3(to * from.transpose())));
  return turn.angle() * turn.axis();
}

// Mean angular velocity (rad/s, world) over a step of a body that rotated by `turned` (rad) in the
// axes of its carrier, which rotates as well. `from` and `to`: rotations of the body before and
// after the step.
Vec3 mean_angular_velocity(const Vec3& carrier_angular_velocity, const Mat3& carrier,
                           const Vec3& turned, const Mat3& from, const Mat3& to, double dt) {
  if (carrier_angular_velocity.isZero(0) || turned.isZero(0))
    return carrier_angular_velocity + carrier * turned / dt;
  return rotation_vector(from, to) / dt;
}

// `parents`: poses of the frames when the loads act. Velocities of the frames come from the state.
FreeBodyState free_body_state(const Model& model, const State& s,
                              const std::vector<FrameMotion>& parents, std::size_t f,
                              const BodyLoad& load) {
  const MotionFrame& frame = model.frames[f];
  const FrameMotion& motion = s.frames[f];
  FreeBodyState scene;
  scene.rotation = RotationMap(motion.rotation);
  scene.force = load.force;
  scene.torque = load.torque;
  scene.gravity = model.gravity;
  scene.bearing = {s.joint_reactions[f].force, s.joint_reactions[f].torque};
  if (frame.parent >= 0) {
    const FrameMotion& parent = s.frames[static_cast<std::size_t>(frame.parent)];
    const FrameMotion& place = parents[static_cast<std::size_t>(frame.parent)];
    scene.parent = RotationMap(place.rotation);
    scene.offset = motion.position - place.position;
    scene.parent_angular_velocity = parent.angular_velocity;
    scene.parent_velocity_change = parent.velocity_change;
    scene.parent_angular_velocity_change = parent.angular_velocity_change;
    scene.parent_moves =
        !parent.velocity_change.isZero(0) || !parent.angular_velocity_change.isZero(0);
  }
  return scene;
}

FreeBodyMotion coordinates(FrameMotion& m) {
  return {m.coordinate, m.rate, m.motor_impulse, m.limit_impulse, m.dissipated_friction};
}

void add_joint_work(const JointWork& work, FreeBodyAccount& account) {
  account.motors += work.motors;
  account.dampers -= work.dampers;
  account.limits -= work.limits;
}

// Collects the motors of a joint, from the model and from stages.
void gather_motors(const Model& model, const State& s, std::size_t f, std::size_t joint,
                   std::vector<const Motor*>& motors) {
  motors.clear();
  for (const Motor& d : model.frames[f].free->joints[joint].motors) motors.push_back(&d);
  for (std::size_t e = 0; e < s.stage_motors.size(); ++e) {
    if (s.stage_motor_joint[e] == static_cast<int>(f * kMaxJoints + joint))
      motors.push_back(&s.stage_motors[e]);
  }
}

// Adds the work in the joints of a body in a half-kick that changed its motion from `before`.
void add_kick_work(const FreeBody& body, const FrameMotion& before, const KickResult& result,
                   FrameMotion& motion, FreeBodyAccount& account) {
  JointWork work;
  for (std::size_t k = 0; k < body.joints.size(); ++k) {
    const double mean = 0.5 * (before.rate[k] + motion.rate[k]);
    motion.dissipated_friction[k] -= result.friction_impulse[k] * mean;
    work.motors += (motion.motor_impulse[k] - before.motor_impulse[k]) * mean;
    work.dampers += result.damping_impulse[k] * mean;
    work.limits += (motion.limit_impulse[k] - before.limit_impulse[k]) * mean;
  }
  add_joint_work(work, account);
}

HeldAxes kick(const Model& model, State& s, const std::vector<FrameMotion>& parents, std::size_t f,
              const BodyLoad& load, HalfKick half, BoundaryMotionScratch& scratch) {
  const MotionFrame& frame = model.frames[f];
  auto& motors = scratch.motors;
  for (std::size_t k = 0; k < frame.free->joints.size(); ++k)
    gather_motors(model, s, f, k, motors[k]);
  FrameMotion& motion = s.frames[f];
  const FrameMotion before = motion;
  const FreeBodyState scene = free_body_state(model, s, parents, f, load);
  KickResult result =
      integrate_free_body(*frame.free, frame.origin, motors.data(), scene, s.time, model.timestep,
                          half, coordinates(motion), scratch.pushes);
  motion.driven = result.driven ? 1 : 0;
  apply_joint_limits(*frame.free, frame.origin, scene, half == HalfKick::first ? model.timestep : 0,
                     coordinates(motion), result.held);
  add_kick_work(*frame.free, before, result, motion, s.free_bodies);
  return result.held;
}

// Force and torque (about the origin of `frame`) of contacts on the boundaries for whose frame
// holds(frame) is true.
template <class Predicate>
BodyLoad sum_loads(const Model& model, const State& s, int frame, Predicate&& holds) {
  BodyLoad sum;
  const Vec3& origin = s.frames[static_cast<std::size_t>(frame)].position;
  for (std::size_t b = 0; b < model.boundaries.size(); ++b) {
    if (!holds(model.boundaries[b].frame)) continue;
    const BodyLoad& load = s.boundary_load[b];
    const Vec3 arm = s.motion[model.particles.size() + b].position - origin;
    sum.force += load.force;
    sum.torque += load.torque + arm.cross(load.force);
  }
  return sum;
}

// Stores the contact loads on the bodies of a mechanism at the indices of their frames in `loads`.
void gather_loads(const Model& model, const State& s, const MechanismMembers& members,
                  std::vector<BodyLoad>& loads) {
  loads.resize(model.frames.size());
  for (const int f : members.frames)
    loads[static_cast<std::size_t>(f)] =
        sum_loads(model, s, f, [&](int carrier) { return free_frame(model.frames, carrier) == f; });
}

// `grounds`: poses of the frames when the loads act. Velocities of the frames come from the state.
MechanismState mechanism_state(const Model& model, State& s,
                               const std::vector<FrameMotion>& grounds,
                               const std::vector<BodyLoad>& loads,
                               const MechanismMembers& members) {
  MechanismState at;
  if (members.ground >= 0) {
    const auto g = static_cast<std::size_t>(members.ground);
    at.ground = RotationMap(grounds[g].rotation);
    at.ground_origin = model.frames[g].origin;
    at.ground_angular_velocity = s.frames[g].angular_velocity;
    at.ground_velocity_change = s.frames[g].velocity_change;
    at.ground_angular_velocity_change = s.frames[g].angular_velocity_change;
  }
  at.gravity = model.gravity;
  at.time = s.time;
  at.dt = model.timestep;
  for (const int f : members.frames) {
    const BodyLoad& load = loads[static_cast<std::size_t>(f)];
    at.loads.push_back({load.force, load.torque});
    const JointReaction& bearing = s.joint_reactions[static_cast<std::size_t>(f)];
    at.bearings.push_back({bearing.force, bearing.torque});
    at.orientations.push_back(s.frame_orientation[static_cast<std::size_t>(f)]);
    at.motion.push_back(coordinates(s.frames[static_cast<std::size_t>(f)]));
    auto& motors = at.motors.emplace_back();
    const std::size_t joints = model.frames[static_cast<std::size_t>(f)].free->joints.size();
    motors.resize(joints);
    for (std::size_t k = 0; k < joints; ++k)
      gather_motors(model, s, static_cast<std::size_t>(f), k, motors[k]);
  }
  for (const int c : members.couplings) {
    const CouplingReaction& memory = s.couplings[static_cast<std::size_t>(c)];
    at.couplings.push_back({memory.force, memory.torque});
  }
  return at;
}

// Sets the loads of the couplings for the friction of the first step.
void start_coupling_loads(Mechanism& mechanism, MechanismState& at, State& s) {
  at.couplings = mechanism.starting_coupling_loads(at);
  for (std::size_t c = 0; c < at.couplings.size(); ++c) {
    CouplingReaction& memory =
        s.couplings[static_cast<std::size_t>(mechanism.members().couplings[c])];
    memory.force = at.couplings[c].force;
    memory.torque = at.couplings[c].torque;
  }
}

// Adds the impulses of a half-kick on the body b of a coupling.
void add_coupling_impulse(const JointLoad& impulse, HalfKick half, CouplingReaction& memory) {
  memory.impulse += impulse.force;
  memory.angular_impulse += impulse.torque;
  if (half == HalfKick::first) {  // both halves act between the last two velocities
    memory.half_impulse += impulse.force;
    memory.half_angular_impulse += impulse.torque;
  } else {
    memory.half_impulse = impulse.force;
    memory.half_angular_impulse = impulse.torque;
  }
}

// Makes a half-kick of a mechanism, and after the first one also the drift of its coordinates.
// Stores the loads on its bodies in `scratch`, and whether it has converged.
void kick_mechanism(const Model& model, State& s, const std::vector<FrameMotion>& grounds,
                    Mechanism& mechanism, HalfKick half, BoundaryMotionScratch& scratch) {
  const MechanismMembers& members = mechanism.members();
  gather_loads(model, s, members, scratch.loads);
  const bool is_first = half == HalfKick::first;
  MechanismState at = mechanism_state(model, s, grounds, scratch.loads, members);
  if (is_first && s.steps == 0 && mechanism.has_coupling_friction())
    start_coupling_loads(mechanism, at, s);
  const MechanismKick result =
      is_first ? mechanism.integrate_positions(at) : mechanism.second_kick(at);
  scratch.unconverged = scratch.unconverged || !result.converged;
  add_joint_work(result.work, s.free_bodies);
  for (std::size_t f = 0; f < members.frames.size(); ++f) {
    const auto acts = [&](const Motor* motor) { return motor->acts(s.time); };
    const auto any = [&](const auto& motors) { return std::ranges::any_of(motors, acts); };
    s.frames[static_cast<std::size_t>(members.frames[f])].driven =
        std::ranges::any_of(at.motors[f], any) ? 1 : 0;
  }
  const Vec3 ground = members.ground < 0
                          ? Vec3(Vec3::Zero())
                          : grounds[static_cast<std::size_t>(members.ground)].position;
  for (std::size_t c = 0; c < members.couplings.size(); ++c) {
    CouplingReaction& memory = s.couplings[static_cast<std::size_t>(members.couplings[c])];
    memory.position = ground + mechanism.coupling_point(c, at);
    memory.dissipated_friction += result.dissipated_friction[c];
    add_coupling_impulse(result.couplings[c], half, memory);
    if (!is_first || s.steps == 0) continue;
    memory.force = memory.half_impulse / model.timestep;
    memory.torque = memory.half_angular_impulse / model.timestep;
  }
}

// Sets the orientation of a member of a mechanism, and its rotation since `before`. Sets the
// rotation vector of a body that turns freely to 0; see MechanismState::motion.
void turn_member(const FreeBody& body, const FrameMotion& before, FrameMotion& now, Place& place) {
  for (std::size_t k = 0; k < body.joints.size(); ++k) {
    const Joint& joint = body.joints[k];
    if (joint.kind != Joint::Kind::rotation) continue;
    place.orientation = Quat(Eigen::AngleAxisd(now.coordinate[k], joint.direction));
    place.turned = joint.direction * (now.coordinate[k] - before.coordinate[k]);
  }
  if (!body.free_rotation) return;
  Eigen::Map<Vec3> turned(now.coordinate + body.joints.size());
  place.orientation = (rotation_by(turned) * place.orientation).normalized();
  place.turned = turned;
  turned.setZero();
}

// The coordinates of a member of a mechanism have been advanced before.
void advance_frame(const Model& model, State& s, std::size_t f, bool is_member,
                   BoundaryMotionScratch& scratch) {
  const std::vector<FrameMotion>& before = scratch.frames;
  const MotionFrame& frame = model.frames[f];
  FrameMotion& motion = s.frames[f];
  const FrameMotion world;
  const FrameMotion& parent =
      frame.parent < 0 ? world : s.frames[static_cast<std::size_t>(frame.parent)];
  const Mat3 axes = RotationMap(parent.rotation);
  const double dt = model.timestep;
  const Vec3 parent_origin = origin_of(model, frame.parent);
  Place place{s.frame_position[f], s.frame_orientation[f]};
  BodyLoad load;
  if (is_member) {
    turn_member(*frame.free, before[f], motion, place);
    place.position = position_of(*frame.free, frame.origin - parent_origin, motion);
  } else if (frame.free) {
    load = load_on_frame(model, s, static_cast<int>(f));
    const HeldAxes held = kick(model, s, before, f, load, HalfKick::first, scratch);
    place.turned =
        drift(*frame.free, frame.origin, dt, held, coordinates(motion), place.orientation);
    place.position = position_of(*frame.free, frame.origin - parent_origin, motion);
  } else {
    apply_all(frame.motions, model.boundaries.size() + f, parent_origin, s, dt, scratch, place);
  }
  s.frame_position[f] = place.position;
  s.frame_orientation[f] = place.orientation;
  const Vec3 position = parent.position + axes * place.position;
  const Vec3 velocity = (position - motion.position) / dt;
  const Mat3 rotation = axes * place.orientation.toRotationMatrix();
  const Vec3 angular_velocity = mean_angular_velocity(parent.angular_velocity, axes, place.turned,
                                                      RotationMap(motion.rotation), rotation, dt);
  motion.velocity_change = velocity - motion.velocity;
  motion.angular_velocity_change = angular_velocity - motion.angular_velocity;
  motion.velocity = velocity;
  motion.angular_velocity = angular_velocity;
  motion.position = position;
  Eigen::Map<Mat3>(motion.rotation) = rotation;
  if (!frame.free || is_member) return;
  const bool is_known = s.joint_reactions[f].known > 0;
  const JointLoad other = other_impulse(model, *frame.free, frame.origin, load, before[f], motion,
                                        s.joint_reactions[f]);
  if (is_known) record_reaction(other, dt, s.joint_reactions[f]);
  add_carrier_work(before, f, frame.parent,
                   is_known ? other : starting_impulse(model, before, f, s.joint_reactions[f]), s);
}

void advance_boundary(const Model& model, State& s, std::size_t b, BoundaryMotionScratch& scratch) {
  const Boundary& boundary = model.boundaries[b];
  const std::size_t body = model.particles.size() + b;
  const double dt = model.timestep;
  BodyMotion& motion = s.motion[body];
  if (boundary.frame < 0) {
    Place place{motion.position, s.orientation[body]};
    apply_all(boundary.motions, b, Vec3::Zero(), s, dt, scratch, place);
    motion.velocity = (place.position - motion.position) / dt;
    motion.angular_velocity = place.turned / dt;
    motion.position = place.position;
    s.orientation[body] = place.orientation;
    return;
  }
  Place place{s.boundary_position[b], s.boundary_orientation[b]};
  apply_all(boundary.motions, b, origin_of(model, boundary.frame), s, dt, scratch, place);
  s.boundary_position[b] = place.position;
  s.boundary_orientation[b] = place.orientation;
  const FrameMotion& frame = s.frames[static_cast<std::size_t>(boundary.frame)];
  const Mat3 axes = RotationMap(frame.rotation);
  const Vec3 position = frame.position + axes * place.position;
  motion.velocity = (position - motion.position) / dt;
  const Quat orientation = (Quat(axes) * place.orientation).normalized();
  motion.angular_velocity = mean_angular_velocity(frame.angular_velocity, axes, place.turned,
                                                  s.orientation[body].toRotationMatrix(),
                                                  orientation.toRotationMatrix(), dt);
  motion.position = position;
  if (!motion.angular_velocity.isZero(0)) s.orientation[body] = orientation;
}

}  // namespace

void advance_boundaries(const Model& model, Workspace& w, State& s) {
  BoundaryMotionScratch& scratch = w.boundary_motion;
  scratch.frames = s.frames;
  scratch.unconverged = false;
  for (std::size_t f = 0; f < model.frames.size(); ++f) {
    const int of = w.mechanism_of[f];
    if (of >= 0) {
      Mechanism& mechanism = w.mechanisms[static_cast<std::size_t>(of)];
      if (mechanism.members().frames.front() == static_cast<int>(f))
        kick_mechanism(model, s, scratch.frames, mechanism, HalfKick::first, scratch);
    }
    advance_frame(model, s, f, of >= 0, scratch);
  }
  for (const Mechanism& mechanism : w.mechanisms)
    record_reactions(model, s, scratch.frames, scratch.loads, mechanism);
  for (std::size_t b = 0; b < model.boundaries.size(); ++b) advance_boundary(model, s, b, scratch);
  add_contact_work(model, scratch.frames, s);
}

BodyLoad load_on_frame(const Model& model, const State& s, int frame) {
  return sum_loads(model, s, frame,
                   [&](int carrier) { return descends_from(model.frames, carrier, frame); });
}

void finish_frames(const Model& model, Workspace& w, State& s) {
  add_contact_work(model, w.boundary_motion.frames, s);
  for (std::size_t f = 0; f < model.frames.size(); ++f) {
    const BodyLoad load = load_on_frame(model, s, static_cast<int>(f));
    if (const int of = w.mechanism_of[f]; of >= 0) {
      Mechanism& mechanism = w.mechanisms[static_cast<std::size_t>(of)];
      if (mechanism.members().frames.front() == static_cast<int>(f))
        kick_mechanism(model, s, s.frames, mechanism, HalfKick::second, w.boundary_motion);
    } else if (model.frames[f].free) {
      kick(model, s, s.frames, f, load, HalfKick::second, w.boundary_motion);
    }
    s.frames[f].impulse += load.force * model.timestep;
    s.frames[f].angular_impulse += load.torque * model.timestep;
  }
  if (w.boundary_motion.unconverged) ++s.diagnostics.unconverged_steps;
}

}  // namespace firn
