// Rigid motion composed of a list of prescribed motions.
#pragma once

#include <vector>

#include "firn/motion.h"

namespace firn {

// Rigid motion from t = 0: x -> turn x + shift.
struct RigidMotion {
  Quat turn = Quat::Identity();
  Vec3 shift = Vec3::Zero();  // m

  Vec3 operator()(const Vec3& x) const { return turn * x + shift; }
  // First `other`, then this one.
  RigidMotion operator*(const RigidMotion& other) const {
    return {turn * other.turn, turn * other.shift + shift};
  }

  // Appends a prescribed motion relative to this one, with the displacement `way` (m or rad; s for
  // a steady translation). Centers of rotation are relative to `origin` (m).
  void carry(const Motion& m, const Vec3& origin, double way) {
    if (way == 0) return;
    if (m.kind == Motion::Kind::translation) {
      shift += turn * (m.profile == Motion::Profile::constant ? m.velocity : m.axis) * way;
      return;
    }
    const Quat one(Eigen::AngleAxisd(way, m.axis));
    const Vec3 center = m.center - origin;
    shift += turn * Vec3(center - one * center);
    turn = (turn * one).normalized();
  }
};

}  // namespace firn
