// Scalars, vectors and handles shared by the whole solver. SI units throughout; right-handed axes.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace firn {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;  // unit; coefficients named w x y z

// A rigid placement: p_outer = rotation * p_inner + translation.
struct Pose {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();  // m

  Vec3 operator*(const Vec3& p) const { return rotation * p + translation; }
};

// The user's mistake (exit status 2). The message is one line and says what is expected;
// readers of files prefix it with FILE:LINE: KEY.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A simulation that went wrong (exit status 1): non-finite value, runaway energy, ...
struct RunError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace firn
