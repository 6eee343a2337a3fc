#include "solver/dynamics/joint_loads.h"

#include <algorithm>
#include <cmath>

namespace firn {
namespace {

// A motor that has a target approaches it with this time constant, at most at its speed.
constexpr double kApproach = 5e-3;  // s

}  // namespace

double friction_limit(const Joint& joint, const Vec3& axis, const JointLoad& bearing) {
  if (joint.friction_coefficient == 0) return joint.friction;
  const double along = axis.dot(bearing.force);
  const Vec3 across = bearing.force - along * axis;
  double borne = across.norm();
  if (joint.bearing_length > 0) {
    // Ends at +-L/2: their forces sum to `across`, and their moments to the torque across the axis.
    const Vec3 couple = bearing.torque.cross(axis) / joint.bearing_length;
    borne = (0.5 * across + couple).norm() + (0.5 * across - couple).norm();
  }
  if (joint.kind == Joint::Kind::rotation) borne = joint.bearing_radius * (borne + std::abs(along));
  return joint.friction + joint.friction_coefficient * borne;
}

double spring_load(const Joint& joint, double coordinate) {
  return -joint.stiffness * (coordinate - joint.spring_reference);
}

double motor_target_rate(const Motor& motor, double coordinate, double dt, HalfKick half) {
  if (!motor.target) return motor.speed;
  const double most = std::abs(motor.speed);
  const double rate = half == HalfKick::first ? -std::expm1(-dt / kApproach) / dt : 1 / kApproach;
  return std::clamp((*motor.target - coordinate) * rate, -most, most);
}

double motor_load_limit(const Motor& motor, double rate) {
  if (motor.no_load_speed == kUnbounded) return motor.max_load;
  return motor.max_load * std::clamp(1 - rate / motor.no_load_speed, 0.0, 1.0);
}

}  // namespace firn
