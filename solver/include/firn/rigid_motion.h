// Rigid motion composed of a list of prescribed motions.
#pragma once

#include <vector>

#include "firn/motion.h"

namespace firn {

// Rigid motion from t = 0, world axes: x -> rotation x + translation.
struct RigidMotion {
  Quat rotation = Quat::Identity();
  Vec3 translation = Vec3::Zero();  // m

  Vec3 operator()(const Vec3& x) const { return rotation * x + translation; }
  // First `other`, then this one.
  RigidMotion operator*(const RigidMotion& other) const {
    return {rotation * other.rotation, rotation * other.translation + translation};
  }

  // Appends a prescribed motion relative to this one, with the displacement of
  // Motion::displacement() (m or rad; s for a translation at constant velocity). Its center of
  // rotation is taken relative to `origin` (m).
  void append(const Motion& m, const Vec3& origin, double displacement) {
    if (displacement == 0) return;
    if (m.kind == Motion::Kind::translation) {
      translation +=
          rotation * (m.profile == Motion::Profile::constant ? m.velocity : m.axis) * displacement;
      return;
    }
    const Quat one(Eigen::AngleAxisd(displacement, m.axis));
    const Vec3 center = m.center - origin;
    translation += rotation * Vec3(center - one * center);
    rotation = (rotation * one).normalized();
  }
};

}  // namespace firn
