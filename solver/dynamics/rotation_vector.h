// Rotation vectors. C++17 code uses this header, too, so that it includes none of Firn's.
#pragma once

#include <Eigen/Dense>

namespace firn {

// Unit quaternion of the rotation by |vector| rad about the direction of `vector`.
inline Eigen::Quaterniond rotation_by(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  return angle > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, vector / angle))
                   : Eigen::Quaterniond::Identity();
}

}  // namespace firn
