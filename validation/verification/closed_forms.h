// What several groups of cases compare with, and the reduction of a sweep to its worst value.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "validation/verification/check.h"
#include "validation/verification/scenes.h"

namespace firn::verification {

// Restitution of the hysteretic spring with its unloading floor lambda. Unloading from s_max along
// K / e^2 meets the floor lambda K s at r s_max, r = (1 - e^2) / (1 - lambda e^2); the work
// returned over the work put in is e'^2 = (1 + lambda r)(1 - r) + lambda r^2 = 1 - r (1 - lambda).
inline double restitution_with_floor(double e, double lambda = 0.001) {
  const double r = (1 - e * e) / (1 - lambda * e * e);
  return std::sqrt(1 - r * (1 - lambda));
}

// s, from first touch to the largest overlap.
inline double quarter_period(double mass, double stiffness) {
  return 0.5 * std::numbers::pi * std::sqrt(mass / stiffness);
}

// A sphere or cube of given mass (kg) and stiffness (N/m).
inline Shape sphere(double radius, double mass, double stiffness) {
  return make_sphere(radius, scenes::ice_options(mass, stiffness, radius));
}
inline Shape cube(double edge, double mass, double stiffness, double rounding) {
  return make_box(Vec3::Constant(edge), scenes::ice_options(mass, stiffness, rounding));
}

// Of a solid box, about its centre, per axis, kg m^2.
inline Vec3 box_inertia(double mass, const Vec3& size) {
  const Vec3 s = size.cwiseAbs2();
  return mass / 12 * Vec3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
}

inline Quat about(const Vec3& axis, double degrees) {
  return Quat(Eigen::AngleAxisd(degrees * scenes::kDegree, axis.normalized()));
}

// Of many ratios that should all be one, the one that is furthest off, as a check of its own.
class Worst {
 public:
  Worst(std::string what, double tolerance) : what_(std::move(what)), tolerance_(tolerance) {}

  void add(double measured, double expected, const std::string& where) {
    ++count_;
    const double ratio = measured / expected;
    if (count_ > 1 && std::abs(ratio - 1) <= std::abs(worst_ - 1)) return;
    worst_ = ratio;
    where_ = where;
  }

  Check check() const {
    return {.what = fmt::format("{}, worst of {} ({})", what_, count_, where_),
            .measured = worst_,
            .expected = 1,
            .tolerance = tolerance_,
            .bound = Bound::absolute};
  }

 private:
  std::string what_, where_;
  double tolerance_ = 0, worst_ = 1;
  int count_ = 0;
};

}  // namespace firn::verification
