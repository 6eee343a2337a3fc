#include "solver/step/free_body_energy.h"

#include "solver/dynamics/joint_loads.h"
#include "solver/state/workspace.h"
#include "solver/step/boundary_contacts.h"
#include "solver/step/frame_poses.h"

namespace firn {

namespace {

// Velocity of a frame's origin and angular velocity.
struct FrameVelocity {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();  // m/s, rad/s, world
};

// Adds what the joints of a free body do at their rates. `axes`: of the parent -> world.
void add_joint_rates(const FreeBody& body, const Mat3& axes, const FrameMotion& motion,
                     FrameVelocity& velocity) {
  for (std::size_t k = 0; k < body.joints.size(); ++k) {
    const Joint& joint = body.joints[k];
    const bool turns = joint.kind == Joint::Kind::rotation;
    (turns ? velocity.angular : velocity.linear) += axes * joint.direction * motion.rate[k];
  }
  if (body.free_rotation) velocity.angular += axes * Vec3(motion.rate + body.joints.size());
}

// Of all frames: those of free bodies at their rates, which are those at the end of a step; those
// with prescribed motions over the last step.
std::vector<FrameVelocity> frame_velocities(const Model& model,
                                            const std::vector<FrameMotion>& frames) {
  std::vector<FrameVelocity> out(frames.size());
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const MotionFrame& frame = model.frames[f];
    const FrameMotion& now = frames[f];
    FrameVelocity& velocity = out[f];
    if (free_frame(model.frames, static_cast<int>(f)) < 0) {
      velocity = {now.velocity, now.angular_velocity};
      continue;
    }
    Mat3 axes = Mat3::Identity();
    if (frame.parent >= 0) {
      const auto p = static_cast<std::size_t>(frame.parent);
      axes = RotationMap(frames[p].rotation);
      velocity.angular = out[p].angular;
      velocity.linear = out[p].linear + out[p].angular.cross(now.position - frames[p].position);
    }
    if (frame.free) add_joint_rates(*frame.free, axes, now, velocity);
  }
  return out;
}

// Power of the loads on a boundary at the velocities of its frame over the step, W. The motion of a
// boundary on its frame is prescribed and does not count.
double power_on_frame(const Model& model, const std::vector<FrameMotion>& before, const State& s,
                      std::size_t b) {
  const auto f = static_cast<std::size_t>(model.boundaries[b].frame);
  const FrameMotion &from = before[f], &to = s.frames[f];
  const Vec3 arm = s.boundary_position[b];
  const Vec3 way =
      to.position - from.position + (RotationMap(to.rotation) - RotationMap(from.rotation)) * arm;
  const BodyLoad& load = s.boundary_load[b];
  return load.force.dot(way) / model.timestep + load.torque.dot(to.angular_velocity);
}

void add_body(const MotionFrame& frame, const FrameMotion& motion, const FrameVelocity& velocity,
              const Vec3& gravity, FreeBodyEnergy& e) {
  const FreeBody& body = *frame.free;
  const Mat3 axes = RotationMap(motion.rotation);
  const Vec3 arm = axes * (body.center - frame.origin);
  const Vec3 spin = axes.transpose() * velocity.angular;  // rad/s, axes of the body
  e.kinetic += 0.5 * body.mass * (velocity.linear + velocity.angular.cross(arm)).squaredNorm() +
               0.5 * spin.dot(body.inertia * spin);
  e.gravitational -= body.mass * gravity.dot(motion.position + arm);
  for (std::size_t k = 0; k < body.joints.size(); ++k) {
    const Joint& joint = body.joints[k];
    const double stretch = motion.coordinate[k] - joint.spring_reference;
    e.kinetic += 0.5 * joint.armature * motion.rate[k] * motion.rate[k];
    e.elastic += 0.5 * joint.stiffness * stretch * stretch;
    e.dissipated_friction += motion.dissipated_friction[k];
  }
}

}  // namespace

void add_contact_work(const Model& model, const std::vector<FrameMotion>& before, State& s) {
  if (!has_free_body(model.frames)) return;
  double power = 0;
  for (std::size_t k = 0; k < model.boundary_contacts.size(); ++k)
    power -= boundary_contact_power(model, s, k);
  for (std::size_t b = 0; b < model.boundaries.size(); ++b) {
    if (free_frame(model.frames, model.boundaries[b].frame) >= 0)
      power += power_on_frame(model, before, s, b);
  }
  s.free_bodies.contacts += 0.5 * model.timestep * power;
}

void add_carrier_work(const std::vector<FrameMotion>& before, std::size_t f, int carrier,
                      const JointLoad& impulse, State& s) {
  if (carrier < 0) return;
  const auto c = static_cast<std::size_t>(carrier);
  const FrameMotion &from = before[c], &to = s.frames[c];
  const Vec3 angular_velocity = 0.5 * (from.angular_velocity + to.angular_velocity);
  const Vec3 velocity = 0.5 * (from.velocity + to.velocity) +
                        angular_velocity.cross(before[f].position - from.position);
  s.free_bodies.carriers += impulse.force.dot(velocity) + impulse.torque.dot(angular_velocity);
}

JointLoad starting_impulse(const Model& model, const std::vector<FrameMotion>& before,
                           std::size_t f, const JointReaction& joint) {
  const MotionFrame& frame = model.frames[f];
  const FreeBody& body = *frame.free;
  const FrameVelocity start = frame_velocities(model, before)[f];
  const Mat3 axes = RotationMap(before[f].rotation);
  const Vec3 arm = axes * (body.center - frame.origin);
  const Vec3 angular_momentum = axes * body.inertia * axes.transpose() * start.angular;
  JointLoad impulse;
  impulse.force = body.mass * (joint.center_velocity - start.linear - start.angular.cross(arm) -
                               0.5 * model.timestep * model.gravity);
  impulse.torque = joint.angular_momentum - angular_momentum + arm.cross(impulse.force);
  return impulse;
}

FreeBodyEnergy free_body_energy(const Model& model, const Workspace& w, const State& s) {
  FreeBodyEnergy e;
  if (!has_free_body(model.frames)) return e;
  const std::vector<FrameVelocity> velocities = frame_velocities(model, s.frames);
  for (std::size_t f = 0; f < s.frames.size(); ++f) {
    if (model.frames[f].free)
      add_body(model.frames[f], s.frames[f], velocities[f], model.gravity, e);
  }
  for (const CouplingReaction& coupling : s.couplings)
    e.dissipated_friction += coupling.dissipated_friction;
  for (std::size_t k = 0; k < s.boundary_contacts.size(); ++k) {
    const BoundaryContactState contact = boundary_contact_state(w, s, k);
    e.contacts_elastic += contact.elastic;
    e.dissipated_contacts += contact.dissipated_normal + contact.dissipated_friction;
  }
  e.dissipated_damping = s.free_bodies.dampers + s.free_bodies.limits;
  e.work = s.free_bodies.motors + s.free_bodies.contacts + s.free_bodies.carriers;
  return e;
}

}  // namespace firn
