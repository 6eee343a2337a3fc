// Scalars, vectors and handles shared by the whole solver. SI units throughout; right-handed axes.
#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace firn {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;  // unit; coefficients named w x y z

inline constexpr double kDegToRad = std::numbers::pi / 180, kRadToDeg = 180 / std::numbers::pi;

// A number of a body, shape or part as the index of a standard container.
constexpr std::size_t index(int i) { return static_cast<std::size_t>(i); }

// A rigid pose: p_outer = rotation * p_inner + translation.
struct Pose {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();  // m

  Vec3 operator*(const Vec3& p) const { return rotation * p + translation; }
};

// The shortest rotation that takes the direction `from` to the direction `to`; neither is zero.
// Eigen's FromTwoVectors compiles a singular value decomposition in each source that calls it.
Quat shortest_rotation(const Vec3& from, const Vec3& to);

struct SymmetricEigen {
  Eigen::VectorXd values;   // ascending
  Eigen::MatrixXd vectors;  // orthonormal columns, in the order of the values
};

// Of the lower triangle of a square matrix of finite numbers. Eigen's solver for matrices of a size
// that is known at run time takes seconds to compile in each source that calls it.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix);
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& matrix);

// Replaces control characters by spaces. Messages quote the content of files, which may have any
// characters.
inline std::string one_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ' || c == 0x7f) c = ' ';
  }
  return text;
}

// Wrong input of the user (exit status 2). The message is one line and states what is expected.
// Readers of files prefix it with FILE:LINE: KEY.
struct InputError : std::runtime_error {
  explicit InputError(std::string message) : std::runtime_error(one_line(std::move(message))) {}
};

// Failure of a simulation (exit status 1): non-finite value, runaway energy, ...
struct RunError : std::runtime_error {
  explicit RunError(std::string message) : std::runtime_error(one_line(std::move(message))) {}
};

}  // namespace firn
