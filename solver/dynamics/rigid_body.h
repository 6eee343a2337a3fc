// Rigid-body motion: equations (1) and (2) in full.
#pragma once

#include "solver/core/simd.h"

namespace firn {

struct RigidBody {
  double mass = 0;                      // kg
  double inverse_mass = 0;              // 1/kg
  Vec3 inverse_inertia = Vec3::Zero();  // 1/(kg m^2), principal
};

// Kicks one body by half a step: velocity by F / m, angular momentum (body axes) by torque.
void half_kick(const RigidBody& body, const Vec3& force, const Vec3& torque, const Vec3& gravity,
               double dt, const Mat3& rotation, Vec3& velocity, Vec3& angular_momentum);

// Rotations of several bodies side by side; bit for bit what rotate_torque_free() gives for each.
struct FreeRotations {
  Simd8d q[4];         // x y z w of the orientations
  Simd8d momentum[3];  // kg m^2/s, body axes
  Simd8d inverse_inertia[3];
};
void rotate_torque_free(FreeRotations& bodies, double dt);

// Drifts a rotation by dt: the symmetric splitting of the free rigid body into turns about its
// principal axes (Dullweber, Leimkuhler and McLachlan 1997): second order, time reversible, the
// magnitude of the angular momentum is conserved to rounding.
void rotate_torque_free(const Vec3& inverse_inertia, double dt, Quat& orientation,
                        Vec3& angular_momentum);

}  // namespace firn
