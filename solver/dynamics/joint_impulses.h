// Impulses within bounds on the coordinates of a mechanism: friction, motors and limits of joints.
#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <vector>

namespace firn {

// An impulse on one coordinate: at most `below` while its rate is less than `at`, at least `above`
// while it is more, and whatever holds it there in between.
struct BoundedImpulse {
  double at = 0;                // m/s or rad/s
  double below = 0, above = 0;  // N s or N m s, above <= below
  double* given = nullptr;      // receives its part; null: not recorded
};

// The bounded impulses of all coordinates at once, coordinate by coordinate until none changes
// (projected Gauss-Seidel).
class JointImpulses {
 public:
  // `bounds`: [n] of each coordinate, in order of `at`. `mobility`: [n x n] change of the rates by
  // impulses along the coordinates, with couplings; it must outlive this object. `free_mobility`:
  // the same without couplings.
  JointImpulses(std::vector<std::vector<BoundedImpulse>> bounds, const Eigen::MatrixXd& mobility,
                const Eigen::MatrixXd& free_mobility);

  // `rates`: those without these impulses, which are added; changes below `small` are none.
  void apply(Eigen::VectorXd& rates, double small);

  const Eigen::VectorXd& impulses() const { return impulses_; }
  // Gives each of the bounded impulses its part.
  void share() const;

 private:
  struct Solution {
    double rate = 0, impulse = 0;
    bool held = false;  // at one of the rates that the impulses hold
  };
  static Solution balance(double u0, double w, const std::vector<BoundedImpulse>& impulses);
  static void share_impulse(const Solution& solution, double total,
                            const std::vector<BoundedImpulse>& impulses);

  std::vector<std::vector<BoundedImpulse>> bounds_;
  const Eigen::MatrixXd& mobility_;
  std::vector<std::size_t> active_;  // coordinates
  std::vector<Solution> solutions_;
  Eigen::VectorXd impulses_;
};

}  // namespace firn
