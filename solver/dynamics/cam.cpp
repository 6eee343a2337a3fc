#include "solver/dynamics/cam.h"

// Before Boost 1.82 pchip.hpp uses the isnan of the global namespace.
#include <math.h>  // NOLINT(modernize-deprecated-headers)

#include <boost/math/interpolators/pchip.hpp>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

namespace firn {

struct Cam::Impl {
  static constexpr double kTurn = 2 * std::numbers::pi;
  boost::math::interpolators::pchip<std::vector<double>> curve;

  static double within_a_turn(double angle) { return angle - kTurn * std::floor(angle / kTurn); }
};

Cam::Cam(const std::vector<double>& angles, const std::vector<double>& lifts) {
  // Three turns, so that the ends do not affect the middle one.
  std::vector<double> x, y;
  for (const double turn : {-Impl::kTurn, 0.0, Impl::kTurn}) {
    for (std::size_t i = 0; i < angles.size(); ++i) {
      x.push_back(angles[i] + turn);
      y.push_back(lifts[i]);
    }
  }
  impl_ = std::make_unique<Impl>(Impl{{std::move(x), std::move(y)}});
}
Cam::~Cam() = default;
Cam::Cam(Cam&&) noexcept = default;
Cam& Cam::operator=(Cam&&) noexcept = default;

double Cam::lift(double angle) const { return impl_->curve(Impl::within_a_turn(angle)); }
double Cam::slope(double angle) const { return impl_->curve.prime(Impl::within_a_turn(angle)); }

}  // namespace firn
