// The law of a bond against closed forms of beams, and against its own energy.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "firn/bond.h"

namespace firn {
namespace {

using std::numbers::pi;

constexpr double kWidth = 4e-3, kHeight = 3e-3, kLength = 5e-3;  // m
constexpr double kYoung = 1e7, kPoisson = 0.33;

BeamLaw bridge() {
  BeamLaw law;
  law.section = rectangular_section(kWidth, kHeight, kPoisson);
  law.length = kLength;
  law.young_modulus = kYoung;
  law.shear_modulus = kYoung / (2 * (1 + kPoisson));
  law.tensile_strength = law.shear_strength = 1e6;
  return law;
}

BodyInMotion at(const Vec3& position, const Quat& orientation = Quat::Identity()) {
  return {position, Vec3::Zero(), Vec3::Zero(), orientation};
}

// Ends off the centers by different arms, axes of beam and bodies all different.
const Quat kTurnA(Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()));
const Quat kTurnB(Eigen::AngleAxisd(-1.9, Vec3(0.3, -1, 2).normalized()));
const Vec3 kCenterA(1e-3, 2e-3, -3e-3), kCenterB(25e-3, 4e-3, 2e-3);
Bond skew_bond() {
  return make_bond(0, 1, 0, kLength, at(kCenterA, kTurnA), at(kCenterB, kTurnB),
                   Vec3(12e-3, 1e-3, 1e-3), Vec3(1, 0.2, -0.1), Vec3::UnitZ());
}

// Two bodies whose centers are the ends of a beam along x; b's end is displaced and turned.
BeamPose moved_end(const Vec3& by, const Vec3& turn) {
  const Vec3 end = kLength * Vec3::UnitX();
  const Bond bond = make_bond(0, 1, 0, kLength, at(Vec3::Zero()), at(end), 0.5 * end, Vec3::UnitX(),
                              Vec3::UnitZ());
  const Quat turned(Eigen::AngleAxisd(
      turn.norm(), turn.norm() > 0 ? Vec3(turn.normalized()) : Vec3(Vec3::UnitX())));
  return pose_of(bridge(), bond, at(Vec3::Zero()), at(end + by, turned));
}

double second_moment(double across, double along) { return along * across * across * across / 12; }

TEST(Beam, StiffnessesAreThoseOfTheTextbook) {
  const BeamSprings k = stiffness_of(bridge());
  const double area = kWidth * kHeight, g = kYoung / (2 * (1 + kPoisson));
  const double iy = second_moment(kHeight, kWidth), iz = second_moment(kWidth, kHeight);
  const double kappa = 10 * (1 + kPoisson) / (12 + 11 * kPoisson);
  const auto sheared = [&](double inertia) {
    const double phi = 12 * kYoung * inertia / (kappa * g * area * kLength * kLength);
    return 12 * kYoung * inertia / (kLength * kLength * kLength * (1 + phi));
  };
  EXPECT_NEAR(k.linear.x(), kYoung * area / kLength, 1e-9 * k.linear.x());
  EXPECT_NEAR(k.linear.y(), sheared(iz), 1e-9 * k.linear.y());
  EXPECT_NEAR(k.linear.z(), sheared(iy), 1e-9 * k.linear.z());
  EXPECT_NEAR(k.angular.y(), kYoung * iy / kLength, 1e-9 * k.angular.y());
  EXPECT_NEAR(k.angular.z(), kYoung * iz / kLength, 1e-9 * k.angular.z());
}

// Saint-Venant's series for the rectangle (Timoshenko and Goodier, section 109).
TEST(Beam, TorsionOfRectanglesFollowsTheSeries) {
  for (const double ratio : {1.0, 1.5, 2.0, 5.0, 20.0}) {
    const double b = 2e-3, a = ratio * b;
    double stiff = 0, stress = 0;
    for (int n = 1; n < 40; n += 2) {
      stiff += std::tanh(n * pi * a / (2 * b)) / std::pow(n, 5);
      stress += 1 / (n * n * std::cosh(n * pi * a / (2 * b)));
    }
    const double constant = a * b * b * b / 3 * (1 - 192 / std::pow(pi, 5) * b / a * stiff);
    const double modulus = constant / (b * (1 - 8 / (pi * pi) * stress));
    for (const bool upright : {false, true}) {
      const BeamSection s =
          upright ? rectangular_section(b, a, 0.3) : rectangular_section(a, b, 0.3);
      EXPECT_NEAR(s.inertia.x(), constant, 0.005 * constant) << ratio;
      EXPECT_NEAR(s.torsion_modulus, modulus, 0.005 * modulus) << ratio;
    }
  }
}

TEST(Beam, RoundSectionsTwistByTheirPolarMoment) {
  const double r = 3e-3;
  const BeamSection s = round_section(r, 0.3);
  EXPECT_NEAR(s.inertia.x(), pi * std::pow(r, 4) / 2, 1e-9 * s.inertia.x());
  EXPECT_NEAR(s.torsion_modulus, pi * std::pow(r, 3) / 2, 1e-9 * s.torsion_modulus);
}

// The end of a cantilever under a force P across it sinks by P L^3 / (3 E I) + P L / (kappa G A)
// and turns by P L^2 / (2 E I); so placed, it must give back P, and no moment there.
TEST(Beam, CantileverBendsAsTimoshenkosDoes) {
  const BeamLaw law = bridge();
  const BeamSprings k = stiffness_of(law);
  const double p = 1e-6, kga = law.section.shear_coefficient * law.shear_modulus * law.section.area;
  for (const int across : {1, 2}) {
    const double ei = kYoung * law.section.inertia[across == 1 ? 2 : 1];
    const double sinks = p * std::pow(kLength, 3) / (3 * ei) + p * kLength / kga;
    const double turns = p * kLength * kLength / (2 * ei);
    // Down along -y turns about -z, down along -z about +y.
    const Vec3 axis = across == 1 ? Vec3(-Vec3::UnitZ()) : Vec3(Vec3::UnitY());
    const BeamPose pose = moved_end(-sinks * Vec3::Unit(across), turns * axis);
    const BeamForces forces = elastic_forces(k, pose);
    const BeamLoad load = load_of(pose, forces);
    EXPECT_NEAR(-load.force[across], p, 1e-5 * p);  // on b: up
    EXPECT_NEAR(load.moment_b.norm(), 0, 1e-5 * p * kLength);
    EXPECT_NEAR(load.moment_a.norm(), p * kLength, 1e-5 * p * kLength);
    // And the stress at the root is that of the whole moment.
    const double fibre = across == 1 ? 0.5 * kWidth : 0.5 * kHeight;
    EXPECT_NEAR(stress_of(law, forces).bending, p * kLength * fibre * kYoung / ei,
                1e-5 * p * kLength * fibre * kYoung / ei);
    EXPECT_NEAR(stress_of(law, forces).shear, p / law.section.area, 1e-5 * p / law.section.area);
  }
}

TEST(Beam, TwistAndStretchGiveTheirMomentAndForce) {
  const BeamLaw law = bridge();
  const BeamSprings k = stiffness_of(law);
  const BeamPose pose = moved_end(2e-5 * Vec3::UnitX(), 1.2 * Vec3::UnitX());
  const BeamForces forces = elastic_forces(k, pose);
  EXPECT_NEAR(forces.force.x(), kYoung * kWidth * kHeight * 2e-5 / kLength, 1e-9);
  EXPECT_NEAR(forces.moment.x(), law.shear_modulus * law.section.inertia.x() * 1.2 / kLength,
              1e-12);
  EXPECT_NEAR(stress_of(law, forces).tension, kYoung * 2e-5 / kLength, 1e-3);
  EXPECT_NEAR(stress_of(law, forces).torsion, forces.moment.x() / law.section.torsion_modulus,
              1e-6);
}

// Loads are the slope of the elastic energy, at strains and turns of any size.
TEST(Beam, LoadsAreTheGradientOfTheEnergy) {
  const BeamLaw law = bridge();
  const BeamSprings k = stiffness_of(law);
  const Bond bond = skew_bond();
  const Quat extra(Eigen::AngleAxisd(1.1, Vec3(-1, 0.4, 2).normalized()));
  const BodyInMotion a = at(kCenterA + Vec3(1e-3, -2e-3, 1e-3), kTurnA),
                     b = at(kCenterB, extra * kTurnB);
  const auto energy = [&](const BodyInMotion& p, const BodyInMotion& q) {
    return elastic_energy(k, pose_of(law, bond, p, q));
  };
  const auto nudged = [](BodyInMotion body, int way, double by) {
    if (way < 3)
      body.position[way] += by;
    else
      body.orientation = Quat(Eigen::AngleAxisd(by, Vec3::Unit(way - 3))) * body.orientation;
    return body;
  };
  const BeamPose pose = pose_of(law, bond, a, b);
  const BeamLoad load = load_of(pose, elastic_forces(k, pose));
  for (int way = 0; way < 6; ++way) {
    const double by = way < 3 ? 1e-8 : 1e-6;
    const double slope_a =
                     (energy(nudged(a, way, by), b) - energy(nudged(a, way, -by), b)) / (2 * by),
                 slope_b =
                     (energy(a, nudged(b, way, by)) - energy(a, nudged(b, way, -by))) / (2 * by);
    const double on_a = way < 3 ? load.force[way] : load.moment_a[way - 3],
                 on_b = way < 3 ? -load.force[way] : load.moment_b[way - 3];
    const double scale = way < 3 ? load.force.norm() : load.moment_a.norm();
    EXPECT_NEAR(on_a, -slope_a, 1e-6 * scale) << way;
    EXPECT_NEAR(on_b, -slope_b, 1e-6 * scale) << way;
  }
  // Force and moments of the pair turn nothing.
  const Vec3 about_a = load.moment_a + load.moment_b - (b.position - a.position).cross(load.force);
  EXPECT_NEAR(about_a.norm(), 0, 1e-14 * load.moment_a.norm() + 1e-15);
}

TEST(Beam, TurningBothBodiesTogetherChangesNothing) {
  const BeamLaw law = bridge();
  const Bond bond = skew_bond();
  const Quat extra(Eigen::AngleAxisd(0.4, Vec3(1, 1, 0).normalized()));
  const BodyInMotion a = at(kCenterA, kTurnA), b = at(kCenterB, extra * kTurnB);
  const BeamPose before = pose_of(law, bond, a, b);
  for (const double angle : {0.3, 2.0, 3.1, 5.0}) {
    const Quat all(Eigen::AngleAxisd(angle, Vec3(1, -2, 0.5).normalized()));
    const Vec3 shift(0.1, -0.2, 0.3);
    const BeamPose after = pose_of(law, bond, at(all * a.position + shift, all * a.orientation),
                                   at(all * b.position + shift, all * b.orientation));
    EXPECT_NEAR((after.displacement - before.displacement).norm(), 0, 1e-15) << angle;
    EXPECT_NEAR((after.rotation - before.rotation).norm(), 0, 1e-13) << angle;
  }
}

TEST(Beam, BothEndsSeeTheSame) {
  const BeamLaw law = bridge();
  const BeamSprings k = stiffness_of(law);
  const Quat extra(Eigen::AngleAxisd(0.9, Vec3(2, 1, -0.3).normalized()));
  const BodyInMotion a = at(kCenterA, kTurnA), b = at(kCenterB, kTurnB),
                     c = at(kCenterB, extra * kTurnB);
  const Vec3 middle(12e-3, 1e-3, 1e-3), axis(1, 0.2, -0.1);
  const Bond there = make_bond(0, 1, 0, kLength, a, b, middle, axis, Vec3::UnitZ()),
             back = make_bond(1, 0, 0, kLength, b, a, middle, -axis, Vec3::UnitZ());
  const BeamPose one = pose_of(law, there, a, c), other = pose_of(law, back, c, a);
  const BeamLoad load = load_of(one, elastic_forces(k, one)),
                 turned = load_of(other, elastic_forces(k, other));
  EXPECT_NEAR((load.force + turned.force).norm(), 0, 1e-12 * load.force.norm());
  EXPECT_NEAR((load.moment_a - turned.moment_b).norm(), 0, 1e-12 * load.moment_a.norm());
  EXPECT_NEAR((load.moment_b - turned.moment_a).norm(), 0, 1e-12 * load.moment_b.norm());
}

}  // namespace
}  // namespace firn
