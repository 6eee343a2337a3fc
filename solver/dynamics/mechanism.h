// Mechanisms: free frames that are attached to each other, or connected by couplings.
//
// The coordinates q of all joints and their rates u follow M(q) u' = f(q, u, t) + G(q)^T l with the
// constraints c(q) = 0 of the couplings, G = dc/dq. A step is symmetric in time, and so of second
// order (RATTLE: Andersen, J. Comput. Phys. 52 (1983) 24,
// https://doi.org/10.1016/0021-9991(83)90014-1):
//   M(q0) (u - u0) = dt/2 f(q0, u) + G(q0)^T l0,   q1 = q0 + dt u,   c(q1) = 0,
//   M(q1) (u1 - u) = dt/2 f(q1, u) + G(q1)^T l1,   G(q1) u1 = 0.
// Friction, motors and limits of the joints are impulses within their bounds in both halves, such
// that sticking joints do not move and driven joints have exactly their target speed. The friction
// of a coupling is such an impulse, too, along the rate of its pin or slot, which is a linear
// function of all rates; a sticking pin is at rest to rounding.
//
// A body that turns freely has an orientation R against its parent instead of three coordinates.
// Its rates are the angular velocity w, and R1 = exp(dt w) R0, which is symmetric in time, too.
#pragma once

#include <memory>
#include <vector>

#include "firn/motion.h"
#include "solver/dynamics/free_body.h"
#include "solver/dynamics/mechanism_members.h"

namespace firn {

// One instant of a mechanism, in world axes.
struct MechanismState {
  Mat3 ground = Mat3::Identity();               // axes of the ground -> world
  Vec3 ground_origin = Vec3::Zero();            // m, of the ground as drawn
  Vec3 ground_angular_velocity = Vec3::Zero();  // rad/s
  // Of the ground since the last step: accelerations times the time step, jumps included.
  Vec3 ground_velocity_change = Vec3::Zero(), ground_angular_velocity_change = Vec3::Zero();
  Vec3 gravity = Vec3::Zero();      // m/s^2
  double time = 0, dt = 0;          // s
  std::vector<JointLoad> loads;     // [frames] N, N m by contacts, about the frame's origin
  std::vector<JointLoad> bearings;  // [frames] N, N m by the parent over the last step
  // [couplings] N, N m about the coupling's point, on its body b over the last step.
  std::vector<JointLoad> couplings;
  // [frames] body axes -> axes of the parent; read of bodies that turn freely.
  std::vector<Quat> orientations;
  // [frames] The coordinates after the joints of a body that turns freely are the rotation vector
  // (rad, axes of the parent) of a step: 0 before both half-kicks. After the first one, the caller
  // turns the orientation by it and sets it to 0.
  std::vector<FreeBodyMotion> motion;
  std::vector<std::vector<std::vector<const Motor*>>> motors;  // [frames][joints]
};

// What the couplings and joints of a mechanism have done in a half-kick.
struct MechanismKick {
  // [couplings] on body b: N s, and N m s about the coupling's point; of a gear or cam, along
  // joint_b. Friction is included.
  std::vector<JointLoad> couplings;
  std::vector<double> dissipated_friction;  // [couplings] J
  JointWork work;
  bool converged = true;  // false: rates, friction, motors and limits are inexact
};

class Mechanism {
 public:
  // Stores pointers into both. Throws InputError, naming a coupling, when it does not hold as
  // drawn.
  Mechanism(const std::vector<MotionFrame>& frames, const std::vector<Coupling>& couplings,
            MechanismMembers members);
  ~Mechanism();
  Mechanism(Mechanism&&) noexcept;
  Mechanism& operator=(Mechanism&&) noexcept;

  const MechanismMembers& members() const;

  // The first half kick and the drift; the second half-kick at the new pose. They change
  // coordinates, rates, impulses and dissipated energies of state.motion. Throw RunError when the
  // couplings cannot be met any more.
  MechanismKick integrate_positions(const MechanismState& state);
  MechanismKick second_kick(const MechanismState& state);
  // True when a coupling has friction.
  bool has_coupling_friction() const;
  // [couplings] N, N m: loads of the couplings on their bodies b for the friction of the first
  // step, at the coordinates of `state`. They are those under gravity, springs, contacts and the
  // turning of the ground, as the bodies start from rest without friction, motors and limits.
  std::vector<JointLoad> starting_coupling_loads(const MechanismState& state);
  // m, world: the point of a coupling as its body b carries it, against the ground's origin, at the
  // start of the last kick.
  Vec3 coupling_point(std::size_t coupling, const MechanismState& state) const;

  // Of its springs alone, as drawn, without couplings, rad/s; 0: it has none.
  double highest_frequency() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
