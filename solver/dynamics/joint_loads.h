// Loads of springs, motors and friction along the axis of a joint.
#pragma once

#include "firn/motion.h"

namespace firn {

// The half-kicks of a step are symmetric in time. In the first one, forces that depend on the rates
// use the rates at its end. It also contains the whole velocity change of the parent. In the second
// one, these forces use the rates at its start.
enum class HalfKick { first, second };

struct JointLoad {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  // N and N m, or N s and N m s
};

// Work in joints over a half-kick, J, on the bodies that they join. It is the impulse along a
// coordinate times the mean of its rates before and after the half-kick. With constant masses, the
// sum over all impulses is exactly the change of the kinetic energy, and a sticking joint has none.
struct JointWork {
  double motors = 0, dampers = 0, limits = 0;
};

// Friction limit, N or N m. `axis`: of the joint, unit. `bearing`: load of the parent on the body
// through the joint, N, and N m about the frame's origin, in the axes of `axis`.
double friction_limit(const Joint& joint, const Vec3& axis, const JointLoad& bearing);

// Load of the spring at this coordinate, N or N m.
double spring_load(const Joint& joint, double coordinate);
// Target speed of a motor. In the first half of a step: the speed that reaches, at the end of the
// step, the position that the approach to a target requires.
double motor_target_rate(const Motor& motor, double coordinate, double dt, HalfKick half);
// N or N m: limit of the motor load in a direction in which the axis moves at `rate`.
double motor_load_limit(const Motor& motor, double rate);

}  // namespace firn
