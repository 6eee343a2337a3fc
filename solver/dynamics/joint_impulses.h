// Impulses within bounds on the coordinates of a mechanism: friction, motors and limits of joints,
// friction of couplings.
#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <vector>

namespace firn {

// An impulse that drives the rate of one coordinate towards `at`. It is `below` if the rate is
// still less than `at`, and `above` if the rate is still greater. In between, it is the value that
// makes the rate equal to `at`.
struct BoundedImpulse {
  double at = 0;                // m/s or rad/s
  double below = 0, above = 0;  // N s or N m s, above <= below
  double* given = nullptr;      // share() adds the impulse to it; null: not recorded
};

// A bounded impulse along a direction in the space of the coordinates: of a coupling, whose rate is
// a linear function of all rates. It drives that rate towards `bound.at`.
struct DirectedImpulse {
  Eigen::VectorXd direction;  // [n] rate of the coupling for a unit rate of each coordinate
  BoundedImpulse bound;
};

// Solves for the bounded impulses of all coordinates and directions by projected Gauss-Seidel: one
// after the other, until no impulse changes. Impulses that grow alike in successive sweeps are
// extrapolated.
class JointImpulses {
 public:
  // `bounds`: [n] impulses on each coordinate, in ascending order of `at`. `mobility`: [n x n]
  // change of the rates per impulse along the coordinates, with couplings; it must outlive this
  // object. `free_mobility`: the same matrix without couplings.
  JointImpulses(std::vector<std::vector<BoundedImpulse>> bounds,
                const std::vector<DirectedImpulse>& directed, const Eigen::MatrixXd& mobility,
                const Eigen::MatrixXd& free_mobility);

  // Adds the effect of the impulses to `rates`. Stops when no rate changes by more than `small`, or
  // after 200 sweeps over all impulses. Returns false when the impulses have not converged: the
  // last sweep still changed a rate by more than 1e-9 of the largest effect of an impulse.
  bool apply(Eigen::VectorXd& rates, double small);

  // [n] along the coordinates, of all bounded impulses.
  Eigen::VectorXd impulses() const;
  // Divides the impulse of each coordinate and direction among its bounded impulses; see
  // BoundedImpulse::given.
  void share() const;

 private:
  struct Solution {
    double rate = 0, impulse = 0;
    bool held = false;  // at one of the rates that the impulses hold
  };
  struct Direction {
    Eigen::VectorXd direction, response;  // [n]; change of the rates per impulse
    double mobility = 0;                  // change of that rate per impulse
    std::vector<BoundedImpulse> bounds;   // one
    Solution solution;
  };
  // Adds so many times `growth` [active coordinates, then directions] to the impulses that the
  // first one reaches its bound, and the effect to `rates`.
  void extrapolate(const Eigen::VectorXd& growth, Eigen::VectorXd& rates);
  static Solution balance(double u0, double w, const std::vector<BoundedImpulse>& impulses);
  static void share_impulse(const Solution& solution, double total,
                            const std::vector<BoundedImpulse>& impulses);

  std::vector<std::vector<BoundedImpulse>> bounds_;
  const Eigen::MatrixXd& mobility_;
  std::vector<std::size_t> active_;  // coordinates
  std::vector<Solution> solutions_;
  Eigen::VectorXd impulses_;           // [n] of the coordinates
  std::vector<Direction> directions_;  // active
};

}  // namespace firn
