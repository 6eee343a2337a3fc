#include "solver/dynamics/joint_impulses.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace firn {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int kMostSweeps = 200;
// Largest change of a rate in the last sweep, as a fraction of the largest effect of an impulse, at
// which the impulses count as converged. Rounding errors are far below it.
constexpr double kSolved = 1e-9;
// Changes of the impulses in two sweeps are alike if they differ by less than this fraction.
constexpr double kAlike = 1e-3;
// Most sweeps that one extrapolation replaces: rounding errors of rates grow with it.
constexpr double kMostExtrapolated = 1e5;
// Couplings hold a coordinate or direction if its mobility is below this fraction of that without
// couplings. Impulses along it are zero.
constexpr double kHeldByCouplings = 1e-12;

}  // namespace

JointImpulses::JointImpulses(std::vector<std::vector<BoundedImpulse>> bounds,
                             const std::vector<DirectedImpulse>& directed, const MatrixXd& mobility,
                             const MatrixXd& free_mobility)
    : bounds_(std::move(bounds)),
      mobility_(mobility),
      solutions_(bounds_.size()),
      impulses_(VectorXd::Zero(mobility.rows())) {
  for (std::size_t i = 0; i < bounds_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (!bounds_[i].empty() && mobility(k, k) > kHeldByCouplings * free_mobility(k, k))
      active_.push_back(i);
  }
  for (const DirectedImpulse& one : directed) {
    const VectorXd response = mobility * one.direction;
    const double own = one.direction.dot(response),
                 free = one.direction.dot(VectorXd(free_mobility * one.direction));
    if (own > kHeldByCouplings * free)
      directions_.push_back({one.direction, response, own, {one.bound}, {}});
  }
}

bool JointImpulses::apply(VectorXd& rates, double small) {
  rates += mobility_ * impulses_;
  for (const Direction& one : directions_) rates += one.response * one.solution.impulse;
  double change = 0, effect = 0;  // largest of a sweep, m/s or rad/s
  // [active coordinates, then directions] changes of the impulses in a sweep.
  VectorXd growth(static_cast<Eigen::Index>(active_.size() + directions_.size())), last_growth;
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    change = effect = 0;
    Eigen::Index place = 0;
    for (const std::size_t i : active_) {
      const auto k = static_cast<Eigen::Index>(i);
      const double w = mobility_(k, k);
      solutions_[i] = balance(rates[k] - w * impulses_[k], w, bounds_[i]);
      const double more = solutions_[i].impulse - impulses_[k];
      impulses_[k] = solutions_[i].impulse;
      rates += mobility_.col(k) * more;
      growth[place++] = more;
      change = std::max(change, std::abs(w * more));
      effect = std::max(effect, std::abs(w * impulses_[k]));
    }
    for (Direction& one : directions_) {
      const double w = one.mobility, before = one.solution.impulse;
      one.solution = balance(one.direction.dot(rates) - w * before, w, one.bounds);
      const double more = one.solution.impulse - before;
      rates += one.response * more;
      growth[place++] = more;
      change = std::max(change, std::abs(w * more));
      effect = std::max(effect, std::abs(w * one.solution.impulse));
    }
    if (change <= small) break;
    const bool grows_alike =
        last_growth.size() > 0 && (growth - last_growth).lpNorm<Eigen::Infinity>() <
                                      kAlike * growth.lpNorm<Eigen::Infinity>();
    if (grows_alike) extrapolate(growth, rates);
    last_growth = grows_alike ? VectorXd() : growth;
  }
  for (const std::size_t i : active_)  // removes rounding errors
    if (solutions_[i].held) rates[static_cast<Eigen::Index>(i)] = solutions_[i].rate;
  return change <= std::max(small, kSolved * effect);
}

// Impulses that cannot bring all of their rates to where they hold, such as those of a motor and of
// friction elsewhere on rigid parts, grow by the same amount in each sweep until one is at its
// bound.
void JointImpulses::extrapolate(const VectorXd& growth, VectorXd& rates) {
  double sweeps = kMostExtrapolated;
  const auto limit = [&](const std::vector<BoundedImpulse>& bounds, double impulse, double more) {
    double bound = 0;
    for (const BoundedImpulse& one : bounds) bound += more > 0 ? one.below : one.above;
    if (more != 0) sweeps = std::min(sweeps, (bound - impulse) / more);
  };
  Eigen::Index k = 0;
  for (const std::size_t i : active_)
    limit(bounds_[i], impulses_[static_cast<Eigen::Index>(i)], growth[k++]);
  for (const Direction& one : directions_) limit(one.bounds, one.solution.impulse, growth[k++]);
  if (!(sweeps > 1)) return;
  k = 0;
  for (const std::size_t i : active_) {
    const double more = sweeps * growth[k++];
    impulses_[static_cast<Eigen::Index>(i)] += more;
    rates += mobility_.col(static_cast<Eigen::Index>(i)) * more;
  }
  for (Direction& one : directions_) {
    const double more = sweeps * growth[k++];
    one.solution.impulse += more;
    rates += one.response * more;
  }
}

VectorXd JointImpulses::impulses() const {
  VectorXd all = impulses_;
  for (const Direction& one : directions_) all += one.direction * one.solution.impulse;
  return all;
}

void JointImpulses::share() const {
  for (const std::size_t i : active_)
    share_impulse(solutions_[i], impulses_[static_cast<Eigen::Index>(i)], bounds_[i]);
  for (const Direction& one : directions_)
    share_impulse(one.solution, one.solution.impulse, one.bounds);
}

// Finds the rate u = u0 + w p of a coordinate whose impulse p is the sum of `impulses` at that
// rate. The solution is unique, because p does not increase with u. `impulses` are in order of
// `at`.
JointImpulses::Solution JointImpulses::balance(double u0, double w,
                                               const std::vector<BoundedImpulse>& impulses) {
  double sum = 0;
  for (const BoundedImpulse& i : impulses) sum += i.below;
  for (std::size_t k = 0; k < impulses.size();) {
    const double at = impulses[k].at;
    if (u0 + w * sum <= at) return {u0 + w * sum, sum, false};
    double after = 0;
    for (std::size_t j = 0; j < impulses.size(); ++j)
      after += impulses[j].at <= at ? impulses[j].above : impulses[j].below;
    const double needed = (at - u0) / w;
    if (needed >= after) return {at, needed, true};
    sum = after;
    while (k < impulses.size() && impulses[k].at == at) ++k;
  }
  return {u0 + w * sum, sum, false};
}

// Divides `total` among the impulses. Those that hold the rate take the remainder of the others, in
// the order of `impulses`.
void JointImpulses::share_impulse(const Solution& solution, double total,
                                  const std::vector<BoundedImpulse>& impulses) {
  double rest = total;
  const auto acts_here = [&](const BoundedImpulse& i) {
    return solution.held && i.at == solution.rate;
  };
  const auto outside = [&](const BoundedImpulse& i) {
    return solution.rate < i.at ? i.below : i.above;
  };
  for (const BoundedImpulse& i : impulses)
    if (!acts_here(i)) rest -= outside(i);
  for (const BoundedImpulse& i : impulses) {
    double given = outside(i);
    if (acts_here(i)) {
      given = std::clamp(rest, i.above, i.below);
      rest -= given;
    }
    if (i.given) *i.given += given;
  }
}

}  // namespace firn
