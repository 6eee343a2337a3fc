#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "firn/bond.h"

namespace firn {

namespace {

double cube(double x) { return x * x * x; }

Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// Of the turn between the ends, whose quaternion (w, v) holds half its angle: that half over its
// sine; and what is left of 1 for what lies along the axis, over |v|^2.
struct TurnFactors {
  double across = 1, along = 0;
};
TurnFactors turn_factors(double w, const Vec3& v) {
  const double s2 = v.squaredNorm();
  if (s2 < 1e-8) return {1 + s2 / 6, -1.0 / 6};  // further terms are below rounding
  const double s = std::sqrt(s2), across = std::atan2(s, w) / s;
  return {across, (1 - across) / s2};
}

// From moments that do work on the deformations to moments on the ends; symmetric, so that the same
// takes relative angular velocities to rates of the deformations.
Vec3 to_ends(const BeamPose& pose, const Vec3& m) {
  // quarter_tangent = v / (1 + w) of the quaternion, which has |v|^2 + w^2 = 1.
  const double h2 = pose.quarter_tangent.squaredNorm(), w = (1 - h2) / (1 + h2);
  const Vec3 v = (1 + w) * pose.quarter_tangent;
  const TurnFactors f = turn_factors(w, v);
  return f.across * m + (f.along * v.dot(m)) * v;
}

// mobility_of(), each body with a part of its mass and inertia.
Mat6 mobility(const BeamLaw& law, const Bond& bond, const Shape& a, double mass_fraction_a,
              const Shape& b, double mass_fraction_b) {
  Mat6 sum = Mat6::Zero();
  const auto add = [&](const Shape& body, double fraction, const Quat& axes, const Vec3& end,
                       double side) {
    const Mat3 to_beam = axes.conjugate().toRotationMatrix();
    const Vec3 arm = to_beam * end + side * 0.5 * law.length * Vec3::UnitX();
    // From velocity and angular velocity to rates of the deformations.
    Mat6 rates = Mat6::Identity();
    rates.topRightCorner<3, 3>() = -cross_matrix(arm);
    Mat6 inverse_mass = Mat6::Zero();
    inverse_mass.topLeftCorner<3, 3>() = Mat3::Identity() / (fraction * body.mass);
    inverse_mass.bottomRightCorner<3, 3>() =
        to_beam * (fraction * body.inertia).cwiseInverse().asDiagonal() * to_beam.transpose();
    sum += rates * inverse_mass * rates.transpose();
  };
  add(a, mass_fraction_a, bond.axes_a, bond.end_a, 1);
  add(b, mass_fraction_b, bond.axes_b, bond.end_b, -1);
  return sum;
}

}  // namespace

BeamSection rectangular_section(double width, double height, double poisson_ratio) {
  BeamSection s;
  s.area = width * height;
  s.shear_coefficient = 10 * (1 + poisson_ratio) / (12 + 11 * poisson_ratio);
  const double a = 0.5 * std::max(width, height), b = 0.5 * std::min(width, height), r = b / a;
  s.inertia = {a * cube(b) * (16.0 / 3 - 3.36 * r * (1 - r * cube(r) / 12)),
               width * cube(height) / 12, height * cube(width) / 12};
  s.half_width = 0.5 * width;
  s.half_height = 0.5 * height;
  s.torsion_modulus =
      8 * a * b * b / (3 * (1 + r * (0.6095 + r * (0.8865 + r * (-1.8023 + r * 0.9100)))));
  return s;
}

BeamSection round_section(double radius, double poisson_ratio) {
  BeamSection s;
  s.area = std::numbers::pi * radius * radius;
  s.shear_coefficient = 6 * (1 + poisson_ratio) / (7 + 6 * poisson_ratio);
  const double second = 0.25 * s.area * radius * radius;
  s.inertia = {2 * second, second, second};
  s.half_width = s.half_height = radius;
  s.torsion_modulus = 2 * second / radius;
  return s;
}

Bond make_bond(int a, int b, int law, double length, const BodyInMotion& at_a,
               const BodyInMotion& at_b, const Vec3& middle, const Vec3& axis, const Vec3& up) {
  Mat3 axes;
  axes.col(0) = axis.normalized();
  axes.col(2) = (up - axes.col(0).dot(up) * axes.col(0)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  const Vec3 half = 0.5 * length * axes.col(0);
  Bond bond{a, b, law, {}, {}, {}, {}};
  const Quat to_a = at_a.orientation.conjugate(), to_b = at_b.orientation.conjugate();
  bond.end_a = to_a * Vec3(middle - half - at_a.position);
  bond.end_b = to_b * Vec3(middle + half - at_b.position);
  bond.axes_a = (to_a * Quat(axes)).normalized();
  bond.axes_b = (to_b * Quat(axes)).normalized();
  return bond;
}

const Shape& immovable_shape() {
  static const Shape shape = [] {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    Shape s;
    s.mass = kInfinite;
    s.inertia = Vec3::Constant(kInfinite);
    return s;
  }();
  return shape;
}

BeamSprings stiffness_of(const BeamLaw& law) {
  const BeamSection& s = law.section;
  const double e = law.young_modulus, l = law.length;
  const double sheared = s.shear_coefficient * law.shear_modulus * s.area;  // N
  // Deflection by bending and by shear in series.
  const auto across = [&](double inertia) {
    return 1 / (cube(l) / (12 * e * inertia) + l / sheared);
  };
  return {{e * s.area / l, across(s.inertia.z()), across(s.inertia.y())},
          Vec3(law.shear_modulus * s.inertia.x(), e * s.inertia.y(), e * s.inertia.z()) / l};
}

BeamSprings damping_of(const BeamLaw& law, const Bond& bond, const Shape& a, const Shape& b) {
  const BeamSprings k = stiffness_of(law);
  const Mat6 give = mobility(law, bond, a, 1, b, 1);
  BeamSprings c;
  for (int i = 0; i < 3; ++i) {
    c.linear[i] = 2 * law.damping_ratio * std::sqrt(k.linear[i] / give(i, i));
    c.angular[i] = 2 * law.damping_ratio * std::sqrt(k.angular[i] / give(3 + i, 3 + i));
  }
  return c;
}

Mat6 mobility_of(const BeamLaw& law, const Bond& bond, const Shape& a, const Shape& b) {
  return mobility(law, bond, a, 1, b, 1);
}

double highest_frequency(const BeamLaw& law, const Bond& bond, const Shape& a,
                         double mass_fraction_a, const Shape& b, double mass_fraction_b) {
  const BeamSprings k = stiffness_of(law);
  Eigen::Matrix<double, 6, 1> root;
  root << k.linear.cwiseSqrt(), k.angular.cwiseSqrt();
  const Mat6 m = root.asDiagonal() * mobility(law, bond, a, mass_fraction_a, b, mass_fraction_b) *
                 root.asDiagonal();
  return std::sqrt(symmetric_eigenvalues(m).maxCoeff());
}

BeamPose pose_of(const BeamLaw& law, const Bond& bond, const BodyInMotion& a,
                 const BodyInMotion& b) {
  const Quat at_a = a.orientation * bond.axes_a, at_b = b.orientation * bond.axes_b;
  Quat between = at_a.conjugate() * at_b;
  Quat other = at_b;
  if (between.w() < 0) {
    between.coeffs() = -between.coeffs();
    other.coeffs() = -other.coeffs();
  }
  BeamPose p;
  // The mean of two quaternions lies midway. Relative to it either end is turned by half the angle,
  // whose quaternion is the square root of `between`.
  p.axes = Quat(at_a.coeffs() + other.coeffs()).normalized().toRotationMatrix();
  const double w = std::min(1.0, between.w());
  const TurnFactors f = turn_factors(w, between.vec());
  p.rotation = 2 * f.across * between.vec();
  p.quarter_tangent = between.vec() / (1 + w);
  p.arm_a = a.orientation * bond.end_a;
  p.arm_b = b.orientation * bond.end_b;
  p.end_offset = (b.position - a.position) + (p.arm_b - p.arm_a);
  p.displacement = p.axes.transpose() * p.end_offset - law.length * Vec3::UnitX();
  return p;
}

BeamForces elastic_forces(const BeamSprings& k, const BeamPose& pose) {
  return {k.linear.cwiseProduct(pose.displacement), k.angular.cwiseProduct(pose.rotation)};
}

double elastic_energy(const BeamSprings& k, const BeamPose& pose) {
  return 0.5 *
         (k.linear.dot(pose.displacement.cwiseAbs2()) + k.angular.dot(pose.rotation.cwiseAbs2()));
}

Vec6 rates_of(const BeamPose& pose, const BodyInMotion& a, const BodyInMotion& b) {
  // Angular velocities, rad/s: of b relative to a, and of the axes in the middle.
  const Vec3 omega = b.angular_velocity - a.angular_velocity;
  const Vec3 middle_omega = 0.5 * (a.angular_velocity + b.angular_velocity) -
                            0.5 * (pose.axes * pose.quarter_tangent).cross(omega);
  const Vec3 velocity = (b.velocity + b.angular_velocity.cross(pose.arm_b)) -
                        (a.velocity + a.angular_velocity.cross(pose.arm_a)) -
                        middle_omega.cross(pose.end_offset);
  Vec6 rates;
  rates << pose.axes.transpose() * velocity, to_ends(pose, pose.axes.transpose() * omega);
  return rates;
}

// The gradient of the elastic energy. With f the force in the beam, d from end to end, h
// `quarter_tangent` and m the moments as the ends have them: on a (d x f + (d x f) x h) / 2 + m, on
// b (d x f - (d x f) x h) / 2 - m, together d x f, which the pair of forces takes away.
BeamLoad load_of(const BeamPose& pose, const BeamForces& forces) {
  BeamLoad load;
  load.force = pose.axes * forces.force;
  const Vec3 torque = 0.5 * pose.end_offset.cross(load.force);
  const Vec3 moment =
      torque.cross(pose.axes * pose.quarter_tangent) + pose.axes * to_ends(pose, forces.moment);
  load.moment_a = torque + moment + pose.arm_a.cross(load.force);
  load.moment_b = torque - moment - pose.arm_b.cross(load.force);
  return load;
}

BeamStress stress_of(const BeamLaw& law, const BeamForces& forces) {
  const BeamSection& s = law.section;
  const Vec3& f = forces.force;
  const Vec3& m = forces.moment;
  BeamStress out;
  out.tension = f.x() / s.area;
  out.shear = std::hypot(f.y(), f.z()) / s.area;
  out.torsion = std::abs(m.x()) / s.torsion_modulus;
  // The shear force bends the beam one way at one end and the other way at the other.
  for (const double end : {-0.5, 0.5}) {
    const double about_y = m.y() + end * law.length * f.z(),
                 about_z = m.z() - end * law.length * f.y();
    out.bending = std::max(out.bending, std::abs(about_y) * s.half_height / s.inertia.y() +
                                            std::abs(about_z) * s.half_width / s.inertia.z());
  }
  return out;
}

BondMode failure_mode(const BeamLaw& law, const BeamStress& stress, double strength) {
  if (stress.tension + stress.bending > strength * law.tensile_strength)
    return stress.tension > stress.bending ? BondMode::tension : BondMode::bending;
  if (stress.shear + stress.torsion > strength * law.shear_strength)
    return stress.shear > stress.torsion ? BondMode::shear : BondMode::torsion;
  return BondMode::intact;
}

const char* to_string(BondMode mode) {
  switch (mode) {
    case BondMode::intact:
      return "intact";
    case BondMode::tension:
      return "tension";
    case BondMode::bending:
      return "bending";
    case BondMode::shear:
      return "shear";
    case BondMode::torsion:
      return "torsion";
    case BondMode::removed:
      return "removed";
    case BondMode::lifetime:
      return "lifetime";
  }
  return "unknown";
}

}  // namespace firn
