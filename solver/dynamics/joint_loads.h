// Loads of springs, motors and friction along the axis of a joint.
#pragma once

#include "firn/motion.h"

namespace firn {

// The half kicks of a step mirror each other: the first one takes forces that depend on the rates
// as they are at its end, and the whole change of the parent's motion; the second one as they are
// at its start.
enum class HalfKick { first, second };

struct JointLoad {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  // N and N m, or N s and N m s
};

// N or N m: the most that friction resists. `axis`: of the joint, unit. `bearing`: what the parent
// does to the body through the joint, N, and N m about the frame's origin, in the axes of `axis`.
double friction_limit(const Joint& joint, const Vec3& axis, const JointLoad& bearing);

// N or N m, at this coordinate.
double spring_load(const Joint& joint, double coordinate);
// Target speed of a motor. In the first half of a step: the speed that reaches, at the end of the
// step, the position that the approach to a target requires.
double motor_target_rate(const Motor& motor, double coordinate, double dt, HalfKick half);
// N or N m: limit of the motor load in a direction in which the axis moves at `rate`.
double motor_load_limit(const Motor& motor, double rate);

}  // namespace firn
