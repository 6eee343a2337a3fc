// One or two bodies against closed forms, through the public solver alone.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "validation/verification/scenes.h"

namespace firn {
namespace {

using scenes::kDegree;
using scenes::kGravity;

// Restitution of the hysteretic spring with its unloading floor lambda. Unloading from s_max along
// K / e^2 meets the floor lambda K s at r s_max, r = (1 - e^2) / (1 - lambda e^2); the work
// returned over the work put in is e'^2 = (1 + lambda r)(1 - r) + lambda r^2 = 1 - r (1 - lambda).
double restitution_with_floor(double e, double lambda = 0.001) {
  const double r = (1 - e * e) / (1 - lambda * e * e);
  return std::sqrt(1 - r * (1 - lambda));
}

double quarter_period(double mass, double stiffness) {
  return 0.5 * std::numbers::pi * std::sqrt(mass / stiffness);
}

Shape sphere(double radius, double mass, double stiffness) {
  return make_sphere(radius, scenes::ice_options(mass, stiffness, radius));
}

Shape cube(double edge, double mass, double stiffness, double rounding) {
  return make_box(Vec3::Constant(edge), scenes::ice_options(mass, stiffness, rounding));
}

TEST(NormalImpact, RestitutionWithFloorHasItsPublishedValues) {
  EXPECT_NEAR(restitution_with_floor(0.5), 0.500562, 1e-6);
  EXPECT_NEAR(restitution_with_floor(0.3), 0.301377, 1e-6);
  EXPECT_NEAR(restitution_with_floor(0.1), 0.104786, 1e-6);
}

struct Impact {
  double overlap = 0;       // m, largest
  double force = 0;         // N, largest
  double rebound = 0;       // m/s
  double contact_time = 0;  // s with more force than the floor can give
};

Impact drop_sphere(double mass, double speed, double stiffness, double e) {
  const double radius = 0.05;
  Model model = scenes::body_on_plane(sphere(radius, mass, stiffness), scenes::law(0, e));
  model.gravity.setZero();
  const double dt = model.timestep = quarter_period(mass, stiffness) * e / 200;
  Solver solver(model);
  solver.insert(0, {0, 0, radius + 0.4 * speed * dt}, Quat::Identity(), {0, 0, -speed},
                Vec3::Zero());
  const double floor_force = 0.002 * speed * std::sqrt(mass * stiffness);
  Impact out;
  for (double before = -speed; solver.steps() < 100000;) {
    solver.step();
    const ParticleState& p = solver.particles();
    const double now = p.velocity[0].z(), height = p.position[0].z();
    out.overlap = std::max(out.overlap, radius - height);
    if (mass * (now - before) / dt > floor_force) out.contact_time += dt;
    before = now;
    if (now > 0 && height > radius) break;
  }
  out.force = solver.particles().peak_normal_force[0];
  out.rebound = solver.particles().velocity[0].z();
  return out;
}

TEST(NormalImpact, SphereOnRigidWallFollowsClosedForm) {
  for (const double mass : {0.0137, 0.05, 1.0}) {
    for (const double stiffness : {2e4, 1e5, 1e6}) {
      for (const double speed : {0.1, 1.0, 2.0}) {
        for (const double e : {0.1, 0.3, 0.5, 0.8, 1.0}) {
          SCOPED_TRACE(::testing::Message()
                       << "m " << mass << " K " << stiffness << " v " << speed << " e " << e);
          const Impact got = drop_sphere(mass, speed, stiffness, e);
          const double overlap = speed * std::sqrt(mass / stiffness);
          const double force = speed * std::sqrt(mass * stiffness);
          const double time = (1 + e) * quarter_period(mass, stiffness);
          EXPECT_NEAR(got.overlap, overlap, 1e-4 * overlap);
          EXPECT_NEAR(got.force, force, 1e-4 * force);
          EXPECT_NEAR(got.contact_time, time, 4e-3 * time);
          EXPECT_NEAR(got.rebound, restitution_with_floor(e) * speed, 1e-3 * speed);
        }
      }
    }
  }
}

// v1' = V - (m2/M) e (v1 - v2) and so on; F_max = v_rel sqrt(m* K) with the stiffnesses in series.
TEST(NormalImpact, TwoSpheresFollowClosedForm) {
  const double radius = 0.05, m1 = 1, m2 = 3, v1 = 1.5, v2 = -0.5, stiffness = 1e5;
  const double e = restitution_with_floor(0.6), reduced = m1 * m2 / (m1 + m2);
  Model model = scenes::empty(scenes::law(0, 0.6), scenes::law(0, 0.6));
  scenes::add_particles(model, scenes::add_shape(model, sphere(radius, m1, 2 * stiffness)));
  scenes::add_particles(model, scenes::add_shape(model, sphere(radius, m2, 2 * stiffness)));
  model.gravity.setZero();
  model.timestep = quarter_period(reduced, stiffness) * 0.6 / 200;
  Solver solver(model);
  solver.insert(0, {-radius, 0, 0}, Quat::Identity(), {v1, 0, 0}, Vec3::Zero());
  solver.insert(1, {radius + 1e-6, 0, 0}, Quat::Identity(), {v2, 0, 0}, Vec3::Zero());
  scenes::run(solver, 0.04);
  const ParticleState& p = solver.particles();
  const double center = (m1 * v1 + m2 * v2) / (m1 + m2);
  EXPECT_NEAR(p.velocity[0].x(), center - m2 / (m1 + m2) * e * (v1 - v2), 2e-3);
  EXPECT_NEAR(p.velocity[1].x(), center + m1 / (m1 + m2) * e * (v1 - v2), 1e-3);
  EXPECT_NEAR(m1 * p.velocity[0].x() + m2 * p.velocity[1].x(), m1 * v1 + m2 * v2, 1e-12);
  EXPECT_NEAR(p.peak_normal_force[0], 547.7226, 0.06);
  EXPECT_EQ(p.peak_normal_force[0], p.peak_normal_force[1]);
}

// An apex of h gives the next one of e^2 h, and a little less: gravity also works along the dent
// s = v sqrt(m / K) and the sphere climbs out of it, e^2 (h + s) - s.
TEST(NormalImpact, BouncingSphereLosesHeightByRestitutionSquared) {
  const double radius = 0.05, height = 0.5, e = restitution_with_floor(0.5);
  Model model = scenes::body_on_plane(sphere(radius, 1, 1e7), scenes::law(0, 0.5));
  model.timestep = quarter_period(1, 1e7) * 0.5 / 50;
  Solver solver(model);
  solver.insert(0, {0, 0, radius + height}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  std::vector<double> apexes;
  double before = 0;
  while (apexes.size() < 3) {
    solver.step();
    const double now = solver.particles().velocity[0].z();
    if (before > 0 && now <= 0) apexes.push_back(solver.particles().position[0].z() - radius);
    before = now;
    ASSERT_LT(solver.time(), 2);
  }
  double expected = height;
  for (const double apex : apexes) {
    const double dent = std::sqrt(2 * kGravity * expected / 1e7);
    expected = e * e * (expected + dent) - dent;
    EXPECT_NEAR(apex, expected, 5e-3 * expected);
  }
}

struct Oblique {
  double tangential = 0;  // m/s after
  double spin = 0;        // rad/s after; slip = tangential + R spin
};

Oblique oblique_impact(double friction, double degrees, double stiffness) {
  const double radius = 0.05, speed = 2;
  Interaction law = scenes::law(friction, 0.5);
  law.tangential_stiffness_ratio = 0.5;
  Model model = scenes::body_on_plane(sphere(radius, 1, stiffness), law);
  model.gravity.setZero();
  model.timestep = quarter_period(1, stiffness) * 0.5 / 400;
  Solver solver(model);
  const double angle = degrees * kDegree;
  solver.insert(0, {0, 0, radius + 1e-9}, Quat::Identity(),
                {speed * std::sin(angle), 0, -speed * std::cos(angle)}, Vec3::Zero());
  scenes::run(solver, 12 * quarter_period(1, stiffness));
  const ParticleState& p = solver.particles();
  EXPECT_GT(p.position[0].z(), radius);
  EXPECT_NEAR(p.velocity[0].y(), 0, 1e-12);
  return {p.velocity[0].x(), -p.angular_velocity[0].y()};
}

// Elastic-frictional tangential spring, K_t / K = 0.5, e = 0.5, R = 0.05 m, 2 m/s; angles from the
// normal. The table does not depend on stiffness; a stiff contact keeps the lever arm at R.
TEST(ObliqueImpact, SphereFollowsTableOfTangentialVelocityAndSpin) {
  const std::array<double, 6> angles = {10, 20, 30, 45, 60, 75};
  const std::array<double, 3> frictions = {0.1, 0.3, 0.6};
  const double expected[3][6][2] = {{{.14890, -9.9201},
                                     {.40213, -14.0954},
                                     {.74019, -12.9904},
                                     {1.20208, -10.6066},
                                     {1.58205, -7.5000},
                                     {1.85421, -3.8823}},
                                    {{.14888, -9.9210},
                                     {.29325, -19.5398},
                                     {.42874, -28.5631},
                                     {.77811, -31.8053},
                                     {1.28205, -22.5000},
                                     {1.69891, -11.6469}},
                                    {{.14887, -9.9211},
                                     {.29323, -19.5405},
                                     {.42869, -28.5657},
                                     {.60630, -40.3956},
                                     {.85139, -44.0331},
                                     {1.46598, -23.2937}}};
  for (std::size_t i = 0; i < frictions.size(); ++i) {
    for (std::size_t j = 0; j < angles.size(); ++j) {
      SCOPED_TRACE(::testing::Message() << "mu " << frictions[i] << " angle " << angles[j]);
      // Gross slip throughout when tan(angle) > mu (1 + e) 7/2 or so: vt' = vt - mu (1 + e) vn.
      const bool slips = std::tan(angles[j] * kDegree) > 3.5 * 1.5 * frictions[i];
      const double tolerance = slips ? 3e-3 : 1e-2;
      const Oblique got = oblique_impact(frictions[i], angles[j], 1e8);
      EXPECT_NEAR(got.tangential, expected[i][j][0], tolerance * std::abs(expected[i][j][0]));
      EXPECT_NEAR(got.spin, expected[i][j][1], tolerance * std::abs(expected[i][j][1]));
    }
  }
}

// Two equal spheres meet head on; `second_spin` is the spin of the second about z.
Oblique spinning_pair(double spin, double second_spin, double refresh_fraction) {
  const double radius = 0.05;
  Model model = scenes::empty(scenes::law(0.4, 0.5), scenes::law(0.4, 0.5));
  scenes::add_particles(model, scenes::add_shape(model, sphere(radius, 1, 1e8)), 2);
  model.gravity.setZero();
  model.timestep = quarter_period(0.5, 0.5e8) * 0.5 / 400;
  model.numerics.refresh_fraction = refresh_fraction;
  Solver solver(model);
  solver.insert(0, {-radius, 0, 0}, Quat::Identity(), {1, 0, 0}, {0, 0, spin});
  solver.insert(1, {radius + 1e-9, 0, 0}, Quat::Identity(), {-1, 0, 0}, {0, 0, second_spin});
  scenes::run(solver, 12 * quarter_period(0.5, 0.5e8));
  const ParticleState& p = solver.particles();
  EXPECT_LT(p.velocity[0].x(), 0);
  return {p.velocity[0].y(), p.angular_velocity[0].z()};
}

TEST(ObliqueImpact, CounterSpinningSpheresKeepTheirSpins) {
  const Oblique exact = spinning_pair(20, -20, 0);
  EXPECT_NEAR(exact.spin, 20, 1e-10);
  EXPECT_NEAR(exact.tangential, 0, 1e-12);
  // Between two searches for contacts the contact point stays where it was found.
  const Oblique linearised = spinning_pair(20, -20, Model{}.numerics.refresh_fraction);
  EXPECT_NEAR(linearised.spin, 20, 5e-3);
  EXPECT_NEAR(linearised.tangential, 0, 2e-4);
}

// By symmetry the middle plane is a rigid wall, and half the pair's overlap is the wall's.
TEST(ObliqueImpact, EquallySpinningSpheresActLikeOneOnARigidWall) {
  const double radius = 0.05, stiffness = 1e8;
  const Oblique pair = spinning_pair(20, 20, 0);
  Model model = scenes::body_on_plane(sphere(radius, 1, stiffness), scenes::law(0.4, 0.5));
  model.gravity.setZero();
  model.timestep = quarter_period(1, stiffness) * 0.5 / 400;
  Solver solver(model);
  // The pair's x is the wall's -z; its y, with spin about z, is the wall's x with spin about y.
  solver.insert(0, {0, 0, radius + 0.5e-9}, Quat::Identity(), {0, 0, -1}, {0, 20, 0});
  scenes::run(solver, 12 * quarter_period(1, stiffness));
  EXPECT_NEAR(solver.particles().angular_velocity[0].y(), pair.spin, 2e-3 * 20);
  EXPECT_NEAR(std::abs(solver.particles().velocity[0].x()), std::abs(pair.tangential), 2e-3);
}

// A cube of 0.1 m on z = 0, gravity leaning by `degrees` towards +x, resting in its own dent.
Solver cube_on_incline(double degrees, double friction, double speed) {
  const double edge = 0.1, stiffness = 1e6, angle = degrees * kDegree;
  Model model = scenes::body_on_plane(cube(edge, 1, stiffness, 1e-3), scenes::law(friction, 0.5));
  model.gravity = kGravity * Vec3(std::sin(angle), 0, -std::cos(angle));
  model.timestep = 2e-5;
  Solver solver(model);
  const double dent = kGravity * std::cos(angle) / stiffness;
  solver.insert(0, {0, 0, edge / 2 - dent}, Quat::Identity(), {speed, 0, 0}, Vec3::Zero());
  return solver;
}

TEST(Incline, BlockSlidesWithCoulombAcceleration) {
  const double cases[3][2] = {{20, 0.3}, {30, 0.5}, {45, 0.6}};
  for (const auto& [degrees, friction] : cases) {
    SCOPED_TRACE(::testing::Message() << degrees << " deg, mu " << friction);
    Solver solver = cube_on_incline(degrees, friction, 0);
    scenes::run(solver, 0.2);
    const double before = solver.particles().velocity[0].x();
    scenes::run(solver, 0.5);
    const double expected =
        kGravity * (std::sin(degrees * kDegree) - friction * std::cos(degrees * kDegree));
    EXPECT_NEAR((solver.particles().velocity[0].x() - before) / 0.5, expected, 2e-3 * expected);
    EXPECT_NEAR(solver.particles().position[0].y(), 0, 1e-9);
  }
}

TEST(Incline, BlockBelowTheFrictionAngleStays) {
  Solver solver = cube_on_incline(15, 0.3, 0);
  scenes::run(solver, 0.5);
  const Vec3 before = solver.particles().position[0];
  scenes::run(solver, 1.0);
  EXPECT_LT((solver.particles().position[0] - before).norm(), 1e-6);
}

// v^2 / (2 mu g) = 0.509684 m in v / (mu g) = 0.509684 s.
TEST(Incline, SlidingBlockStopsAfterCoulombDistance) {
  Solver solver = cube_on_incline(0, 0.4, 2);
  scenes::run(solver, 0.505);
  EXPECT_GT(solver.particles().velocity[0].x(), 5e-3);
  scenes::run(solver, 0.1);
  const double stop = solver.particles().position[0].x();
  EXPECT_NEAR(stop, 0.509684, 5e-4);
  // What is left is the ring of the tangential spring, of amplitude mu m g / K = 3.9 um.
  scenes::run(solver, 0.3);
  EXPECT_NEAR(solver.particles().position[0].x(), stop, 1e-5);
}

// A box lands on a frictionless plane at 1 m/s without gravity. `lowest` is the middle of what
// touches first, a corner, an edge's or a face's middle, in units of half the core's edges.
void expect_rigid_body_rebound(const Vec3& size, const Quat& turn, const Vec3& lowest) {
  const double stiffness = 1e8, e = 0.5, rounding = 1e-5;
  const Shape shape = make_box(size, scenes::ice_options(1, stiffness, rounding));
  Model model = scenes::body_on_plane(shape, scenes::law(0, e));
  model.gravity.setZero();
  model.timestep = 1e-6;
  Solver solver(model);
  const Vec3 half = 0.5 * size - Vec3::Constant(rounding);
  const Vec3 arm = turn * lowest.cwiseProduct(half);
  solver.insert(0, {0, 0, rounding - arm.z() + 1e-9}, turn, {0, 0, -1}, Vec3::Zero());
  scenes::run(solver, 2e-3);

  // J = m_eff (1 + e) v, 1 / m_eff = 1/m + (r x n) . I^-1 (r x n).
  const Vec3 sides = size.cwiseAbs2();
  const Vec3 inertia =
      Vec3(sides.y() + sides.z(), sides.x() + sides.z(), sides.x() + sides.y()) / 12;
  const Mat3 r = turn.toRotationMatrix();
  const Mat3 inverse = r * inertia.cwiseInverse().asDiagonal() * r.transpose();
  const Vec3 lever = arm.cross(Vec3::UnitZ());
  const double effective = 1 / (1 + lever.dot(inverse * lever));
  const double impulse = effective * (1 + restitution_with_floor(e));
  const Vec3 spin = impulse * (inverse * lever);
  const ParticleState& p = solver.particles();
  EXPECT_NEAR(p.velocity[0].z(), -1 + impulse, 2e-3);
  EXPECT_LT((p.angular_velocity[0] - spin).norm(), 5e-3 * spin.norm() + 1e-6);
  // One patch has the whole stiffness, whether one, two or four vertices carry it.
  const double force = std::sqrt(effective * stiffness);
  EXPECT_NEAR(p.peak_normal_force[0], force, 3e-3 * force);
}

Quat about(const Vec3& axis, double degrees) {
  return Quat(Eigen::AngleAxisd(degrees * kDegree, axis.normalized()));
}

TEST(OffCentreImpact, CubeOnItsFace) {
  expect_rigid_body_rebound(Vec3::Constant(0.1), Quat::Identity(), {0, 0, -1});
}

TEST(OffCentreImpact, CubeOnItsEdge) {
  for (const double tilt : {10.0, 20.0, 45.0}) {
    SCOPED_TRACE(tilt);
    expect_rigid_body_rebound(Vec3::Constant(0.1), about(Vec3::UnitY(), tilt), {1, 0, -1});
  }
}

TEST(OffCentreImpact, BoxOnItsCorner) {
  const Quat turn = about(Vec3::UnitX(), -25) * about(Vec3::UnitY(), 20);
  const Vec3 lowest(1, 1, -1);
  expect_rigid_body_rebound(Vec3::Constant(0.1), turn, lowest);
  expect_rigid_body_rebound({0.3, 0.2, 0.1}, turn, lowest);
}

// Spin about the middle axis flips every 3.513899 s, first at 1.9861 s.
TEST(FreeBody, BoxFlipsInTimeAndKeepsEnergyAndMomentum) {
  const Shape box = make_box({0.3, 0.2, 0.1}, scenes::ice_options(1, 1e6, 1e-3));
  Model model = scenes::empty(scenes::law(0, 1), scenes::law(0, 1));
  scenes::add_particles(model, scenes::add_shape(model, box));
  model.gravity.setZero();
  model.timestep = 5e-5;
  Solver solver(model);
  const Vec3 spin(0.01, 10, 0.01), inertia = Vec3(0.05, 0.10, 0.13) / 12;
  solver.insert(0, Vec3::Zero(), Quat::Identity(), Vec3::Zero(), spin);
  const auto body_spin = [&] {
    return solver.shape_orientation(0).conjugate() * solver.particles().angular_velocity[0];
  };
  const Vec3 momentum = inertia.cwiseProduct(spin);
  const double energy = 0.5 * spin.dot(momentum);
  std::vector<double> flips;
  double before = spin.y();
  while (solver.time() < 10) {
    solver.step();
    const Vec3 now = body_spin();
    if (now.y() * before < 0) flips.push_back(solver.time());
    before = now.y();
  }
  ASSERT_GE(flips.size(), 2u);
  EXPECT_NEAR(flips[0], 1.9861, 2e-3);
  EXPECT_NEAR(flips[1] - flips[0], 3.513899, 2e-3);
  const Vec3 end = body_spin();
  EXPECT_NEAR(0.5 * end.dot(inertia.cwiseProduct(end)), energy, 1e-6 * energy);
  EXPECT_NEAR(solver.energy().kinetic, energy, 1e-6 * energy);
  const Vec3 world = solver.shape_orientation(0) * inertia.cwiseProduct(end);
  EXPECT_LT((world - momentum).norm(), 1e-6 * momentum.norm());
}

// The resultant leaves the support when tan(angle) > 1. The plane creeps up to the angle so that
// the load does not set the cube rocking; edges rounded by 10 um narrow the base by 0.01 deg.
bool cube_tips(double degrees) {
  const double edge = 0.1, stiffness = 1e6, start = 43.5, rate = 1;  // deg, deg/s
  Model model = scenes::empty(scenes::law(1.5, 0.5), scenes::law(1.5, 0.5));
  scenes::add_particles(model, scenes::add_shape(model, cube(edge, 1, stiffness, 1e-5)));
  const Vec3 normal(std::sin(start * kDegree), 0, std::cos(start * kDegree));
  const int plane = scenes::add_plane(model, Vec3::Zero(), normal);
  Motion tilt;
  tilt.kind = Motion::Kind::rotation;
  tilt.axis = Vec3::UnitY();
  tilt.angular_speed = rate * kDegree;
  tilt.start = 0.3;
  tilt.stop = tilt.start + (degrees - start) / rate;
  model.boundaries[plane].motions = {tilt};
  model.timestep = 2e-5;
  Solver solver(model);
  const Quat turn = about(Vec3::UnitY(), start);
  const double dent = kGravity * std::cos(start * kDegree) / stiffness;
  solver.insert(0, (edge / 2 - dent) * normal, turn, Vec3::Zero(), Vec3::Zero());
  while (solver.time() < tilt.stop + 0.8) {
    scenes::run(solver, 0.01);
    const Vec3 up = solver.shape_orientation(0) * Vec3::UnitZ();
    if (std::acos(up.z()) / kDegree > degrees + 5) return true;
  }
  return false;
}

TEST(Incline, CubeTipsAboveFortyFiveDegreesOnly) {
  EXPECT_FALSE(cube_tips(44.9));
  EXPECT_TRUE(cube_tips(45.1));
}

// Uniform pressure: moment mu m g a 0.382598, so alpha = 0.382598 mu m g a / (m a^2 / 6).
TEST(Incline, SpinningCubeIsBrakedByItsWholeFace) {
  const double edge = 0.1, friction = 0.3, stiffness = 1e6;
  Model model = scenes::body_on_plane(cube(edge, 1, stiffness, 1e-4), scenes::law(friction, 0.5));
  model.timestep = 2e-5;
  Solver solver(model);
  solver.insert(0, {0, 0, edge / 2 - kGravity / stiffness}, Quat::Identity(), Vec3::Zero(),
                {0, 0, 20});
  scenes::run(solver, 0.05);
  const double before = solver.particles().angular_velocity[0].z();
  scenes::run(solver, 0.15);
  const double expected = 0.382598 * friction * kGravity * edge / (edge * edge / 6);
  EXPECT_NEAR((before - solver.particles().angular_velocity[0].z()) / 0.15, expected,
              0.015 * expected);
}

// The weight of ten cubes stands on the floor, and the tower stands still.
TEST(Stack, TenCubesStandAndWeighTenCubes) {
  const double edge = 0.1;
  Model model = scenes::empty(scenes::law(0.3, 0.3), scenes::law(0.3, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, cube(edge, 1, 1e6, 1e-3)), 10);
  scenes::add_plane(model, Vec3::Zero(), Vec3::UnitZ());
  model.timestep = 2e-5;
  Solver solver(model);
  // Each cube starts in the dent that the load above it makes: a spring that never exceeds its
  // largest load again does not lose energy, and the tower would ring.
  double sunk = 0;
  for (int i = 0; i < 10; ++i) {
    const double load = (10 - i) * kGravity, stiffness = i == 0 ? 1e6 : 0.5e6;
    sunk += load / stiffness;
    solver.insert(i, {0, 0, (i + 0.5) * edge - sunk}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  }
  scenes::run(solver, 0.5);
  const std::vector<Vec3> before = solver.particles().position;
  solver.clear_boundary_loads();
  scenes::run(solver, 0.3);
  EXPECT_NEAR(solver.boundaries()[0].impulse.z(), -10 * kGravity * 0.3, 1e-3 * 10 * kGravity * 0.3);
  EXPECT_LT(solver.energy().kinetic, 1e-6);
  for (int i = 0; i < 10; ++i) {
    EXPECT_LT((solver.particles().position[i] - before[i]).norm(), 2e-6) << "cube " << i;
  }
}

}  // namespace
}  // namespace firn
