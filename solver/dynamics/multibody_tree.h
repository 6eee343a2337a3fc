// Mass matrix, forces and constraints of rigid bodies on joints, in joint coordinates, by the
// multibody library Simbody. Simbody's headers do not compile as C++20, so that multibody_tree.cpp
// is C++17 and this header includes none of Firn's.
//
// All vectors are in the axes of the ground, on which the tree stands; its origin is that of the
// world at t = 0. A joint coordinate is 0 as drawn. A free rotation has three coordinates and three
// rates: the rotation vector (rad) from an orientation that is set, and the angular velocity
// (rad/s), both against the parent and in its axes.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <vector>

namespace firn {

struct TreeJoint {
  bool turns = false;  // about the body's origin, once all slides of the body have moved it
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  // unit
};

struct TreeBody {
  int parent = -1;                                    // an earlier body; -1: the ground
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();   // m, as drawn
  double mass = 0;                                    // kg
  Eigen::Vector3d center = Eigen::Vector3d::Zero();   // m, center of mass, as drawn
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // kg m^2 about it
  std::vector<TreeJoint> joints;                      // at most one turns
  // About all axes through the body's origin, once all slides have moved it; then no joint turns.
  bool free_rotation = false;
};

// Ties two bodies in addition to the joints; numbers of bodies, -1: the ground.
struct TreeLoop {
  enum class Kind { ball, hinge, weld, slot };
  Kind kind = Kind::ball;
  int a = -1, b = -1;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    // m, as drawn
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  // unit: the hinge, or the slot in a
};

// Of a body, at one instant.
struct TreePose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();            // m
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          // m/s, of the origin
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // rad/s
};
struct TreeLoad {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   // N
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // N m, about the origin of the body
};

class MultibodyTree {
 public:
  MultibodyTree(const std::vector<TreeBody>& bodies, const std::vector<TreeLoop>& loops);
  ~MultibodyTree();
  MultibodyTree(MultibodyTree&&) noexcept;
  MultibodyTree& operator=(MultibodyTree&&) noexcept;

  int coordinates() const;  // n
  // Place of a coordinate among them. Those of a free rotation follow the joints of the body.
  int coordinate(int body, int joint) const;

  // [bodies] orientations (body axes -> axes of the parent) at which the coordinates of free
  // rotations are 0; the identity before the first call. Those of other bodies are not read. Has an
  // effect from the next place() on.
  void set_orientations(const std::vector<Eigen::Quaterniond>& orientations);
  // Poses for these coordinates [n] and rates [n]: what the functions below refer to.
  void place(const Eigen::VectorXd& coordinates, const Eigen::VectorXd& rates);

  Eigen::MatrixXd mass_matrix() const;  // [n x n]
  // [m x n]: rates of the errors of all loops. Rows may depend on each other.
  Eigen::MatrixXd constraint_matrix() const;
  Eigen::VectorXd constraint_errors() const;  // [m] m or 1
  TreePose pose(int body) const;
  // [n]: generalized forces of loads [bodies] and of the velocities of the bodies.
  Eigen::VectorXd generalized_forces(const std::vector<TreeLoad>& loads) const;
  // [n], generalized impulses of impulses on the bodies.
  Eigen::VectorXd generalized_impulses(const std::vector<TreeLoad>& impulses) const;
  // [bodies]: loads by one loop, whose constraint rows act with `multipliers` [m], as
  // constraint_matrix().transpose() * multipliers along the coordinates.
  std::vector<TreeLoad> loop_loads(int loop, const Eigen::VectorXd& multipliers) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
