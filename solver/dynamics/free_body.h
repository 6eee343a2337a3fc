// A rigid body with a few degrees of freedom, whose parent is a frame with prescribed motion.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "firn/motion.h"
#include "solver/dynamics/joint_loads.h"

namespace firn {

// Pose of a free body and loads on it, in world axes at one instant. The angular velocity of the
// parent is the mean over the step.
struct FreeBodyState {
  Mat3 parent = Mat3::Identity();               // axes of the parent frame -> world
  Mat3 rotation = Mat3::Identity();             // axes of the body -> world
  Vec3 offset = Vec3::Zero();                   // m, from the parent's origin to the body's own
  Vec3 parent_angular_velocity = Vec3::Zero();  // rad/s
  // Of the parent's origin since the last step: accelerations times the time step, jumps included.
  Vec3 parent_velocity_change = Vec3::Zero();          // m/s
  Vec3 parent_angular_velocity_change = Vec3::Zero();  // rad/s
  bool parent_moves = false;                           // either of them is not zero
  Vec3 force = Vec3::Zero();                           // N, by contacts
  Vec3 torque = Vec3::Zero();                          // N m, by contacts, about the body's origin
  Vec3 gravity = Vec3::Zero();                         // m/s^2
  JointLoad bearing;                                   // N, N m by the parent over the last step
};

// [kMaxJoints] each: m or rad; m/s or rad/s; N s or N m s; J. The last three rates of a body that
// turns freely are its angular velocity relative to the parent, in the parent's axes. Mechanisms
// alone use the last member.
struct FreeBodyMotion {
  double* coordinate;
  double* rate;
  double* motor_impulse;
  double* limit_impulse;
  double* dissipated_friction;
};

// Which joints are held by friction, a motor or a limit.
using HeldAxes = std::array<bool, kMaxJoints>;
struct KickResult {
  bool driven = false;  // a motor acted
  HeldAxes held = {};
  std::array<double, kMaxJoints> friction_impulse = {}, damping_impulse = {};  // N s or N m s
};

// An impulse of friction or a motor within bounds that drives the rate of a joint towards a target.
struct BoundedPush {
  std::size_t joint;
  double target;       // m/s or rad/s
  double least, most;  // N s or N m s
  double* account;     // the impulse is added to it
  double impulse = 0;  // N s or N m s
  bool holds = false;  // the rate is at the target
};

// Advances the rates by the forces of half a step of `dt` s. The body's origin at t = 0 is `origin`
// (m, world). D'Alembert's principle gives one equation for each axis k:
//   (F + m g - m a) . v_k + (M - I alpha - w x I w) . w_k + spring + damper = 0.
// v_k: velocity of the center of mass at a unit rate; w_k: angular velocity of the body at a unit
// rate. If the mass matrix M depends on the coordinates, the kick changes the generalized momenta
// sum_j M_kj u_j, and drift() conserves them. Damping is integrated exactly for constant other
// forces.
//
// Friction and motors are bounded impulses, solved together. Precondition: not
// has_several_bounded_joints(body); such a body is a mechanism. `motors`: [joints] those of the
// body and those that stages have added, which may act on any joint. `pushes`: working memory.
KickResult integrate_free_body(const FreeBody& body, const Vec3& origin,
                               const std::vector<const Motor*>* motors, const FreeBodyState& scene,
                               double t, double dt, HalfKick half, FreeBodyMotion motion,
                               std::vector<BoundedPush>& pushes);

// Applies joint limits: reduces each joint rate so that the coordinate reaches its limit at the end
// of `dt`, or reverses it with the restitution of the limit. Call it after a kick, before the
// coordinates move; and after the second kick with a dt of 0, for coordinates at their limits.
// Marks stopped joints as held. The same precondition.
void apply_joint_limits(const FreeBody& body, const Vec3& origin, const FreeBodyState& scene,
                        double dt, FreeBodyMotion motion, HeldAxes& held);

// Advances the coordinates and `orientation` (body axes -> parent axes) by dt. The first half uses
// the rates at the start and the second half those at the end, which give the same momenta. Rates
// of held axes do not change. Returns the rotation vector, rad, parent axes.
Vec3 drift(const FreeBody& body, const Vec3& origin, double dt, const HeldAxes& held,
           FreeBodyMotion motion, Quat& orientation);

// Largest angular frequency of its springs at t = 0, rad/s; 0: no springs.
double highest_frequency(const FreeBody& body, const Vec3& origin);

// Minimum effective mass for a force at a point `arm` (m from the body's origin, world at t = 0)
// over all directions, at t = 0, kg. For the time step.
double min_effective_mass(const FreeBody& body, const Vec3& origin, const Vec3& arm);

}  // namespace firn
