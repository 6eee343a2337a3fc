// Bonded bodies in motion: balances, frequencies, breaks, and what must not change a run.
#include "solver/step/bond_forces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "tests/support/dice.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

using std::numbers::pi;

const Vec3 kSize(20e-3, 16e-3, 12e-3);  // m
constexpr double kPitch = 25e-3, kLength = 4e-3;

BeamLaw bridge(double strength = 1e9, double damping_ratio = 0, double young_modulus = 1e7) {
  BeamLaw law;
  law.name = "bridge";
  law.section = rectangular_section(4e-3, 3e-3, 0.33);
  law.length = kLength;
  law.young_modulus = young_modulus;
  law.shear_modulus = law.young_modulus / 2.66;
  law.tensile_strength = law.shear_strength = strength;
  law.damping_ratio = damping_ratio;
  return law;
}

BodyInMotion stands(const Vec3& position, const Quat& orientation = Quat::Identity()) {
  return {position, Vec3::Zero(), Vec3::Zero(), orientation};
}
Vec3 place(int i) { return i * kPitch * Vec3::UnitX(); }

// A row of boxes along x, each joined to the next; weightless.
Model row(int count, const BeamLaw& law) {
  Model model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.3, 0.3));
  model.gravity = Vec3::Zero();
  ShapeOptions options = scenes::ice_options(0, 0, 1e-3);
  scenes::add_particles(model, scenes::add_shape(model, make_box(kSize, options)), count);
  model.beams = {law};
  for (int i = 0; i + 1 < count; ++i) {
    const Vec3 middle = 0.5 * (place(i) + place(i + 1)) + Vec3(0, 2e-3, 1e-3);
    model.bonds.push_back(make_bond(i, i + 1, 0, kLength, stands(place(i)), stands(place(i + 1)),
                                    middle, Vec3::UnitX(), Vec3::UnitZ()));
  }
  model.timestep = 1e-5;
  return model;
}

// Two boxes whose bridge lies between their centers.
Model straight_pair(const BeamLaw& law) {
  Model model = row(2, law);
  model.bonds[0] = make_bond(0, 1, 0, kLength, stands(place(0)), stands(place(1)), 0.5 * place(1),
                             Vec3::UnitX(), Vec3::UnitZ());
  return model;
}

void put(Solver& solver, int particle, const Vec3& position,
         const Quat& orientation = Quat::Identity(), const Vec3& velocity = Vec3::Zero(),
         const Vec3& angular_velocity = Vec3::Zero()) {
  solver.insert(particle, position, orientation, velocity, angular_velocity);
}

struct Momenta {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};
Momenta momenta(const Solver& solver) {
  Momenta m;
  const ParticleState& s = solver.particles();
  for (std::size_t i = 0; i < s.position.size(); ++i) {
    const Shape& shape = solver.model().shapes[0];
    const Vec3 p = shape.mass * s.velocity[i];
    const Mat3 axes = s.orientation[i].toRotationMatrix();
    m.linear += p;
    m.angular += s.position[i].cross(p) +
                 axes * shape.inertia.asDiagonal() * axes.transpose() * s.angular_velocity[i];
  }
  return m;
}

// Thrown with different velocities and spins, so that the bridge stretches, bends and twists.
void throw_pair(Solver& solver, const Quat& all = Quat::Identity()) {
  put(solver, 0, all * place(0), all, all * Vec3(0.3, 0.1, -0.2), all * Vec3(4, -6, 3));
  put(solver, 1, all * place(1), all, all * Vec3(0.28, 0.15, -0.1), all * Vec3(-5, -6, 1));
}

TEST(Bond, FreeFlightKeepsMomentaAndEnergy) {
  Model model = row(2, bridge());
  model.timestep = advise_timestep(model, 40).timestep;
  Solver solver(model);
  throw_pair(solver);
  const Momenta first = momenta(solver);
  const double energy = scenes::mechanical(solver.energy());
  double most = 0, bound = 0;
  for (int k = 0; k < 200000; ++k) {  // 0.35 s, hundreds of periods
    solver.step();
    if (k % 50 != 0) continue;
    most = std::max(most, std::abs(scenes::mechanical(solver.energy()) - energy));
    bound = std::max(bound, solver.energy().elastic);
  }
  const Momenta last = momenta(solver);
  EXPECT_GT(bound, 1e-3 * energy);
  EXPECT_LT((last.linear - first.linear).norm(), 1e-11 * first.linear.norm());
  EXPECT_LT((last.angular - first.angular).norm(), 1e-10 * first.angular.norm());
  EXPECT_LT(most, 2e-3 * bound);
  EXPECT_EQ(solver.energy().dissipated_bonds, 0);
}

// Seconds from one upward crossing of zero to the next, over ten of them.
template <class Value>
double period(Solver& solver, const Value& value) {
  double first = 0, before = value();
  int crossings = 0;
  while (true) {
    const double t = solver.time();
    solver.step();
    const double now = value();
    if (before < 0 && now >= 0) {
      const double crossed = t + solver.model().timestep * before / (before - now);
      if (crossings == 0) first = crossed;
      if (++crossings == 11) return (crossed - first) / 10;
    }
    before = now;
    if (solver.time() > 10) return 0;
  }
}

TEST(Bond, StretchAndTwistRingAtTheirNaturalFrequencies) {
  Model model = straight_pair(bridge());
  model.timestep = advise_timestep(model, 200).timestep;
  const Shape& box = model.shapes[0];
  const BeamSprings k = stiffness_of(model.beams[0]);
  {
    Solver solver(model);
    put(solver, 0, place(0));
    put(solver, 1, place(1) + Vec3(1e-5, 0, 0));
    const double found = period(solver, [&] { return solver.bond(0).forces.force.x(); });
    EXPECT_NEAR(found, 2 * pi * std::sqrt(0.5 * box.mass / k.linear.x()), 2e-4 * found);
  }
  Solver solver(model);
  put(solver, 0, place(0));
  put(solver, 1, place(1), Quat(Eigen::AngleAxisd(1e-2, Vec3::UnitX())));
  const double found = period(solver, [&] { return solver.bond(0).forces.moment.x(); });
  EXPECT_NEAR(found, 2 * pi * std::sqrt(0.5 * box.inertia.x() / k.angular.x()), 2e-4 * found);
}

TEST(Bond, DampingTakesItsRatioAndIsBooked) {
  const double ratio = 0.05;
  Model model = straight_pair(bridge(1e9, ratio));
  model.timestep = advise_timestep(model, 200).timestep;
  Solver solver(model);
  put(solver, 0, place(0));
  put(solver, 1, place(1) + Vec3(1e-5, 0, 0));
  const double start = scenes::mechanical(solver.energy());
  const double ring = period(solver, [&] { return solver.bond(0).forces.force.x(); });
  const double free =
      2 * pi * std::sqrt(0.5 * model.shapes[0].mass / stiffness_of(model.beams[0]).linear.x());
  EXPECT_NEAR(ring, free / std::sqrt(1 - ratio * ratio), 5e-4 * ring);
  const Energy e = solver.energy();
  EXPECT_NEAR(scenes::mechanical(e) + e.dissipated_bonds, start, 2e-3 * start);
  // The envelope falls by exp(-2 pi ratio) a period; energy by its square.
  const double decay =
      std::exp(-4 * pi * ratio / std::sqrt(1 - ratio * ratio) * solver.time() / ring);
  EXPECT_NEAR(scenes::mechanical(e) / start, decay, 0.15 * decay);
}

// One deformation of a pair: its number (stretch, two shears, torsion, two bendings), what b is
// moved by and what it is turned by about the middle of the bridge, for a unit of it.
struct DampedMode {
  int number;
  Vec3 shift, turn;
};
const DampedMode kDampedModes[] = {
    {0, Vec3::UnitX(), Vec3::Zero()}, {1, Vec3::UnitY(), Vec3::Zero()},
    {2, Vec3::UnitZ(), Vec3::Zero()}, {3, Vec3::Zero(), Vec3::UnitX()},
    {4, Vec3::Zero(), Vec3::UnitY()}, {5, Vec3::Zero(), Vec3::UnitZ()}};

struct Deformation {
  double way, rate;
};
Deformation deformation(const Solver& solver, int number) {
  const ParticleState& p = solver.particles();
  const auto body = [&](std::size_t i) {
    return BodyInMotion{p.position[i], p.velocity[i], p.angular_velocity[i], p.orientation[i]};
  };
  const Model& model = solver.model();
  const BeamPose pose = pose_of(model.beams[0], model.bonds[0], body(0), body(1));
  Vec6 ways;
  ways << pose.displacement, pose.rotation;
  return {ways[number], rates_of(pose, body(0), body(1))[number]};
}

// x'' + 2 ratio w x' + w^2 x = 0.
Deformation damped(const Deformation& start, double ratio, double w, double t) {
  const std::complex<double> root = std::sqrt(std::complex<double>(ratio * ratio - 1, 0)) * w;
  const double x0 = start.way, mixed = start.rate + ratio * w * x0,
               decay = std::exp(-ratio * w * t);
  const std::complex<double> sine =
      std::abs(root) * t < 1e-9 ? std::complex<double>(t) : std::sinh(root * t) / root;
  const double x = decay * (x0 * std::cosh(root * t) + mixed * sine).real();
  const double slope = decay * (x0 * root * root * sine + mixed * std::cosh(root * t)).real();
  return {x, slope - ratio * w * x};
}

// Largest error over one and a half periods, over the largest deformation. The first steps are left
// out: a body that is placed feels its bonds from the end of its first step on.
double damping_error(const DampedMode& mode, double ratio, double steps) {
  Model model = straight_pair(bridge(1e9, ratio, 1e8));
  const BeamSprings k = stiffness_of(model.beams[0]);
  const Mat6 give = mobility_of(model.beams[0], model.bonds[0], model.shapes[0], model.shapes[0]);
  Vec6 stiffness;
  stiffness << k.linear, k.angular;
  const double w = std::sqrt(stiffness[mode.number] * give(mode.number, mode.number));
  model.timestep = 0.5 * pi / w / steps;
  Solver solver(model);
  const double size = mode.number < 3 ? 1e-7 : 1e-5;
  const Quat turn(Eigen::AngleAxisd(mode.turn.norm() * size, mode.turn.normalized()));
  put(solver, 0, place(0));
  put(solver, 1, 0.5 * place(1) + turn * (0.5 * place(1)) + size * mode.shift, turn);
  for (int i = 0; i < 2; ++i) solver.step();
  const Deformation start = deformation(solver, mode.number);
  const double begin = solver.time();
  double worst = 0;
  while (solver.time() < begin + 3 * pi / w) {
    solver.step();
    const Deformation now = deformation(solver, mode.number),
                      exact = damped(start, ratio, w, solver.time() - begin);
    worst = std::max({worst, std::abs(now.way - exact.way), std::abs(now.rate - exact.rate) / w});
  }
  return worst / std::hypot(start.way, start.rate / w);
}

TEST(Bond, DampedModesFollowTheDampedOscillator) {
  for (const DampedMode& mode : kDampedModes) {
    for (const double ratio : {0.01, 0.05, 0.2, 0.5, 0.9, 1.0, 1.1, 1.5, 2.0}) {
      // The default step. Without damping leapfrog's period is (w dt)^2 / 24 = 0.1 % off.
      const double error = damping_error(mode, ratio, 10);
      EXPECT_LT(error, 0.011) << "mode " << mode.number << ", ratio " << ratio;
      const double fine = damping_error(mode, ratio, 60), finer = damping_error(mode, ratio, 240);
      EXPECT_NEAR(fine / finer, 16, 3) << "mode " << mode.number << ", ratio " << ratio;
    }
  }
}

// A row that spins as one from the start and is stretched and bent by that: each bond must know the
// forces of its neighbors at the same time, too. Nothing is strained at the start.
TEST(Bond, DampedRowConvergesToSecondOrder) {
  for (const double ratio : {0.0, 0.1, 1.0, 2.0}) {
    Model model = row(6, bridge(1e12, ratio, 1e8));
    const double quarter = advise_timestep(model, 1).timestep;
    const Vec3 angular_velocity = 0.02 / quarter * Vec3(0.3, 0.5, 0.8), center = 2.5 * place(1);
    const auto end_of = [&](int steps) {
      model.timestep = 12 * quarter / steps;
      Solver solver(model);
      for (int i = 0; i < 6; ++i)
        put(solver, i, place(i), Quat::Identity(), angular_velocity.cross(place(i) - center),
            angular_velocity);
      for (int k = 0; k < steps; ++k) solver.step();
      Vec6 length;
      for (int i = 0; i < 5; ++i) length[i] = solver.bond(i).forces.force.norm();
      length[5] = solver.bond(2).forces.moment.norm();
      return length;
    };
    const Vec6 a = end_of(240), b = end_of(480), c = end_of(960);
    EXPECT_NEAR((a - b).norm() / (b - c).norm(), 4, 0.8) << "ratio " << ratio;
    EXPECT_LT((a - c).norm(), 0.02 * c.norm()) << "ratio " << ratio;
  }
}

// The automatic step is a statement on stability: a pair is stable up to 2 / omega and no further.
TEST(Bond, AutomaticStepKnowsTheFastestMotion) {
  Model model = row(2, bridge(1e9, 0, 1e9));  // stiffer than contacts
  model.timestep = 1;
  const double quarter = advise_timestep(model, 1).timestep;  // pi / 2 / omega
  EXPECT_NE(advise_timestep(model, 1).reason.find("bond \"bridge\""), std::string::npos);
  const auto largest = [&](double timestep) {
    model.timestep = timestep;
    Solver solver(model);
    put(solver, 0, place(0));
    put(solver, 1, place(1) + Vec3(1e-9, 2e-9, 3e-9),
        Quat(Eigen::AngleAxisd(1e-7, Vec3(1, -1, 1).normalized())));
    double most = 0;
    for (int k = 0; k < 400; ++k) {
      solver.step();
      most = std::max(most, solver.bond(0).stress.bending + solver.bond(0).stress.shear);
    }
    return most;
  };
  const double calm = largest(0.1 * quarter);
  EXPECT_LT(largest(4 / pi * 0.98 * quarter), 20 * calm);
  EXPECT_GT(largest(4 / pi * 1.02 * quarter), 1000 * calm);
}

// A row rings faster than a pair; each body's mass is shared between its bonds for that.
TEST(Bond, AutomaticStepHoldsForRows) {
  Model model = row(6, bridge(1e9, 0, 1e9));
  model.timestep = 1;
  const double quarter = advise_timestep(model, 1).timestep;
  const auto largest = [&](double timestep) {
    model.timestep = timestep;
    Solver solver(model);
    for (int i = 0; i < 6; ++i) put(solver, i, place(i) + 1e-9 * Vec3(i % 2, i % 3, i % 5));
    double most = 0;
    for (int k = 0; k < 450; ++k) {  // before the first look at the energy
      solver.step();
      for (int b = 0; b < 5; ++b) most = std::max(most, solver.bond(b).stress.bending);
    }
    return most;
  };
  EXPECT_LT(largest(4 / pi * 0.98 * quarter), 10 * largest(0.1 * quarter));
}

// Strained to just below and just above the limit, by one kind of strain each.
TEST(Bond, BreaksAtItsStrengthAndSaysByWhat) {
  struct Trial {
    BondMode mode;
    Vec3 shift, turn;  // of b about the end of the bridge: of a unit stress, found below
  };
  const Trial trials[] = {{BondMode::tension, Vec3(1e-5, 0, 0), Vec3::Zero()},
                          {BondMode::bending, Vec3::Zero(), Vec3(0, 1e-3, 0)},
                          {BondMode::bending, Vec3::Zero(), Vec3(0, 0, 1e-3)},
                          {BondMode::shear, Vec3(0, 1e-6, 0), Vec3::Zero()},
                          {BondMode::torsion, Vec3::Zero(), Vec3(1e-3, 0, 0)}};
  for (const Trial& trial : trials) {
    BeamLaw law = bridge();
    const bool pulled = trial.mode == BondMode::tension || trial.mode == BondMode::bending;
    for (const double share : {0.999, 1.001}) {
      const auto placed = [&](const BeamLaw& with) {
        Model model = straight_pair(with);
        model.timestep = 1e-10;
        Solver solver(model);
        const Quat turn = trial.turn.norm() > 0
                              ? Quat(Eigen::AngleAxisd(trial.turn.norm(), trial.turn.normalized()))
                              : Quat::Identity();
        // b turned about the middle of the bridge, which bends it by a moment alone.
        const Vec3 arm = 0.5 * place(1);
        put(solver, 0, place(0));
        put(solver, 1, 0.5 * place(1) + turn * arm + trial.shift, turn);
        return solver;
      };
      const BeamStress stress = placed(law).bond(0).stress;
      const double reached =
          pulled ? stress.tension + stress.bending : stress.shear + stress.torsion;
      BeamLaw limited = law;
      (pulled ? limited.tensile_strength : limited.shear_strength) = reached / share;
      Solver solver = placed(limited);
      const double elastic = solver.energy().elastic;
      solver.step();
      const BondRecord& record = solver.bonds()[0];
      if (share < 1) {
        EXPECT_EQ(record.mode, BondMode::intact) << to_string(trial.mode);
        continue;
      }
      EXPECT_STREQ(to_string(record.mode), to_string(trial.mode));
      EXPECT_DOUBLE_EQ(record.time, solver.time());
      EXPECT_NEAR(record.stress, reached, 1e-6 * reached);
      EXPECT_NEAR((record.position - 0.5 * place(1)).norm(), 0, 1e-4);
      EXPECT_EQ(solver.energy().elastic, 0);
      EXPECT_NEAR(solver.energy().dissipated_bonds, elastic, 1e-6 * elastic);
      EXPECT_EQ(solver.load(0).force.norm(), 0);
      // For good.
      scenes::run(solver, 100 * solver.model().timestep);
      EXPECT_STREQ(to_string(solver.bonds()[0].mode), to_string(trial.mode));
      EXPECT_EQ(solver.load(1).moment.norm(), 0);
    }
  }
}

TEST(Bond, CompressionBreaksNothing) {
  Model model = straight_pair(bridge(1e3));
  model.timestep = 1e-10;
  Solver solver(model);
  put(solver, 0, place(0));
  put(solver, 1, place(1) - Vec3(1e-4, 0, 0));
  solver.step();
  EXPECT_EQ(solver.bonds()[0].mode, BondMode::intact);
}

TEST(Bond, TurningTheWholeSceneChangesNothing) {
  scenes::Random random(5);
  const Quat all = random.orientation();
  Model model = row(2, bridge(1e9, 0.05)), turned = model;
  turned.timestep = model.timestep = advise_timestep(model, 20).timestep;
  const BodyInMotion a = stands(all * place(0), all), b = stands(all * place(1), all);
  turned.bonds[0] =
      make_bond(0, 1, 0, kLength, a, b, all * Vec3(0.5 * place(1) + Vec3(0, 2e-3, 1e-3)),
                all * Vec3::UnitX(), all * Vec3::UnitZ());
  Solver one(model), other(turned);
  throw_pair(one);
  throw_pair(other, all);
  scenes::run(one, 0.05);
  scenes::run(other, 0.05);
  for (int i = 0; i < 2; ++i) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_NEAR((all * one.particles().position[k] - other.particles().position[k]).norm(), 0,
                1e-12);
    EXPECT_NEAR(
        (all * one.particles().angular_velocity[k] - other.particles().angular_velocity[k]).norm(),
        0, 1e-9);
  }
}

// 150 boxes in a row fall onto a plane; the bridges break here and there.
Model falling_row(int threads = 1) {
  BeamLaw law = bridge(2e4, 0.05);
  Model model = row(150, law);
  model.gravity = Vec3(0, 0, -9.81);
  scenes::add_plane(model, Vec3(0, 0, -20e-3), Vec3(0.02, 0, 1).normalized(), false);
  model.timestep = advise_timestep(model, 8).timestep;
  model.numerics.threads = threads;
  return model;
}
Solver dropped(const Model& model) {
  Solver solver(model);
  for (int i = 0; i < 150; ++i)
    put(solver, i, place(i) + Vec3(0, 0, 80e-3), Quat::Identity(), Vec3(0, 0, -1));
  return solver;
}
int broken(const Solver& solver) {
  int count = 0;
  for (const BondRecord& record : solver.bonds()) count += record.mode != BondMode::intact;
  return count;
}

TEST(Bond, ThreadsAndInterruptionsChangeNoBit) {
  Solver one = dropped(falling_row());
  scenes::run(one, 0.05);
  const std::vector<std::byte> half = one.save();
  EXPECT_LT(broken(one), 149);
  scenes::run(one, 0.04);
  EXPECT_GT(broken(one), 0);
  EXPECT_LT(broken(one), 149);
  Solver resumed(falling_row());
  resumed.restore(half);
  scenes::run(resumed, 0.04);
  EXPECT_TRUE(resumed.save() == one.save());
  for (const int threads : {2, 3, 4}) {
    Solver other = dropped(falling_row(threads));
    scenes::run(other, 0.09);
    EXPECT_TRUE(other.save() == one.save()) << threads << " threads";
  }
}

TEST(Bond, FirstLawHoldsThroughBreaks) {
  Solver solver = dropped(falling_row());
  const Energy first = solver.energy();
  scenes::run(solver, 0.12);
  const Energy e = solver.energy();
  const double lost = e.dissipated_normal + e.dissipated_friction + e.dissipated_bonds;
  EXPECT_GT(e.dissipated_bonds, 0);
  EXPECT_NEAR(scenes::mechanical(e) + lost, scenes::mechanical(first),
              0.01 * (first.kinetic - first.gravitational + lost));
}

// What a bond had stored when its force acted last is lost, to second order in the step.
TEST(Bond, BreaksAndEndsKeepTheAccount) {
  Dice dice(5);
  for (int trial = 0; trial < 30; ++trial) {
    const double strength = dice(2e4, 1e5);
    const Vec3 velocity(dice(0.2, 0.4), dice(-0.1, 0.1), dice(-0.1, 0.1)), spin = dice.vector(20);
    const bool ends = trial % 3 == 0;
    const auto error = [&](double step) {
      BeamLaw law = bridge(strength);
      if (ends) {
        law = bridge();
        law.lifetime = 2e-4;
      }
      Model model = row(2, law);
      model.timestep = step;
      Solver solver(model);
      put(solver, 0, place(0));
      put(solver, 1, place(1), Quat::Identity(), velocity, spin);
      const double first = scenes::mechanical(solver.energy());
      while (solver.bonds()[0].mode == BondMode::intact && solver.time() < 0.01) solver.step();
      EXPECT_NE(solver.bonds()[0].mode, BondMode::intact);
      const double lost = solver.energy().dissipated_bonds;
      EXPECT_GT(lost, 0);
      return std::abs(scenes::mechanical(solver.energy()) + lost - first) / lost;
    };
    EXPECT_LT(error(1e-5), 1e-3) << trial;
    EXPECT_LT(error(1e-6), 2e-5) << trial;
  }
}

TEST(Bond, BodiesThatLeaveKeepTheAccount) {
  const auto account = [](const Energy& e) {
    return scenes::mechanical(e) + e.dissipated_bonds + e.removed;
  };
  Dice dice(6);
  for (int trial = 0; trial < 30; ++trial) {
    const Vec3 velocity(dice(0.2, 0.4), dice(-0.1, 0.1), dice(-0.1, 0.1)), spin = dice.vector(20);
    const double leaves = dice(1e-4, 5e-4);  // s
    const int removed = trial % 2;
    const auto error = [&](double step) {
      Model model = row(2, bridge(1e9, trial % 3 == 0 ? 0.05 : 0));
      model.timestep = step;
      Solver solver(model);
      put(solver, 0, place(0));
      put(solver, 1, place(1), Quat::Identity(), velocity, spin);
      scenes::run(solver, leaves);
      const double first = account(solver.energy()), elastic = solver.energy().elastic;
      solver.remove_particle(removed);
      solver.step();
      solver.step();
      return std::abs(account(solver.energy()) - first) / elastic;
    };
    EXPECT_LT(error(1e-5), 2e-3) << trial;
    EXPECT_LT(error(1e-6), 2e-5) << trial;
  }
}

TEST(Bond, EndsWithABodyThatLeaves) {
  Model model = straight_pair(bridge());
  Solver solver(model);
  put(solver, 0, place(0));
  solver.step();
  EXPECT_FALSE(solver.bond(0).acts);  // not while it is alone
  put(solver, 1, place(1) + Vec3(1e-5, 0, 0));
  EXPECT_TRUE(solver.bond(0).acts);
  solver.step();
  EXPECT_GT(solver.load(0).force.x(), 0);
  const double elastic = solver.energy().elastic;
  EXPECT_GT(elastic, 0);
  solver.remove_particle(1);
  EXPECT_EQ(solver.bonds()[0].mode, BondMode::removed);
  EXPECT_EQ(solver.energy().elastic, 0);
  solver.step();
  EXPECT_EQ(solver.load(0).force.norm(), 0);
  EXPECT_EQ(solver.energy().dissipated_bonds, 0);
}

TEST(Bond, ModelsWithWrongOnesAreRefused) {
  Model model = row(2, bridge());
  model.bonds[0].b = 2;
  EXPECT_THROW(Solver{model}, InputError);
  model.bonds[0].b = 0;
  EXPECT_THROW(Solver{model}, InputError);
  model = row(2, bridge());
  model.beams[0].tensile_strength = 0;
  EXPECT_THROW(Solver{model}, InputError);
}

// A body at the origin on a beam along `axis` to a wall that is out of reach of contacts. The beam
// begins at the distance `root` (m) from the center of the body.
Model body_on_wall(const Shape& shape, const BeamLaw& law, const Vec3& axis, double root) {
  Model model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.3, 0.3));
  model.gravity = Vec3::Zero();
  scenes::add_particles(model, scenes::add_shape(model, shape));
  scenes::add_plane(model, 30e-3 * axis, -axis);
  Boundary& wall = model.boundaries.front();
  wall.name = "wall";
  model.beams = {law};
  const Vec3 up = std::abs(axis.z()) > 0.5 ? Vec3::UnitY() : Vec3::UnitZ();
  model.bonds = {make_bond(0, 1, 0, law.length, stands(Vec3::Zero()),
                           stands(wall.origin, wall.orientation), (root + 0.5 * law.length) * axis,
                           axis, up)};
  model.timestep = 1e-5;
  return model;
}
Shape boxed() { return make_box(kSize, scenes::ice_options(0, 0, 1e-3)); }
constexpr double kHalfHeight = 6e-3;  // m, of that box

Vec3 weight_of_body(Model& model) {
  model.gravity = Vec3(0, 0, -scenes::kGravity);
  return model.shapes[0].mass * model.gravity;
}

TEST(BondToBoundary, ABodyHangsByItsWeight) {
  const BeamLaw law = bridge(1e9, 1);
  Model model = body_on_wall(boxed(), law, Vec3::UnitZ(), kHalfHeight);
  const double weight = weight_of_body(model).norm();
  model.timestep = advise_timestep(model, 20).timestep;
  Solver solver(model);
  put(solver, 0, Vec3::Zero());
  scenes::run(solver, 0.05);
  const double sinks = weight * law.length / (law.young_modulus * law.section.area);
  EXPECT_NEAR(solver.particles().position[0].z(), -sinks, 1e-4 * sinks);
  EXPECT_NEAR(solver.bond(0).forces.force.x(), weight, 1e-4 * weight);
  EXPECT_NEAR(solver.bond(0).stress.tension, weight / law.section.area,
              1e-4 * weight / law.section.area);
  EXPECT_NEAR(solver.load(0).force.z(), weight, 1e-4 * weight);
  // Loads of boundaries are those of contacts.
  EXPECT_EQ(solver.boundaries()[0].impulse.norm(), 0);
}

// Deflection and angle of a cantilever that bears a force at its free end.
struct Cantilever {
  double sinks, turns;
};
Cantilever cantilever(const BeamLaw& law, double force) {
  const double l = law.length, ei = law.young_modulus * law.section.inertia.y(),
               kga = law.section.shear_coefficient * law.shear_modulus * law.section.area;
  return {force * (l * l * l / (3 * ei) + l / kga), force * l * l / (2 * ei)};
}

TEST(BondToBoundary, ABodyBendsItsBeamAsACantilever) {
  const BeamLaw law = bridge(1e9, 1);
  Model model = body_on_wall(boxed(), law, Vec3::UnitX(), 0);
  const double weight = weight_of_body(model).norm();
  model.timestep = advise_timestep(model, 20).timestep;
  Solver solver(model);
  put(solver, 0, Vec3::Zero());
  const double start = scenes::mechanical(solver.energy());
  scenes::run(solver, 0.2);
  const Cantilever expected = cantilever(law, weight);
  const ParticleState& p = solver.particles();
  EXPECT_NEAR(p.position[0].z(), -expected.sinks, 1e-3 * expected.sinks);
  EXPECT_NEAR(Eigen::AngleAxisd(p.orientation[0]).angle(), expected.turns, 1e-3 * expected.turns);
  const double bending = weight * law.length * law.section.half_height / law.section.inertia.y();
  EXPECT_NEAR(solver.bond(0).stress.bending, bending, 1e-3 * bending);
  const Energy e = solver.energy();
  EXPECT_NEAR(scenes::mechanical(e) + e.dissipated_bonds, start, 5e-3 * weight * expected.sinks);
}

TEST(BondToBoundary, ASphereRingsOnItsBeam) {
  const BeamLaw law = bridge();
  Model model =
      body_on_wall(make_sphere(8e-3, scenes::ice_options(0, 0, -1)), law, Vec3::UnitX(), 8e-3);
  model.timestep = advise_timestep(model, 200).timestep;
  Solver solver(model);
  put(solver, 0, Vec3(1e-5, 0, 0));
  const double found = period(solver, [&] { return solver.bond(0).forces.force.x(); });
  const double stiffness = law.young_modulus * law.section.area / law.length;
  EXPECT_NEAR(found, 2 * pi * std::sqrt(model.shapes[0].mass / stiffness), 2e-4 * found);
}

// A weight just below and just above what the section bears, in equilibrium from the start.
TEST(BondToBoundary, BreaksAtStrengthTimesArea) {
  for (const BondMode mode : {BondMode::tension, BondMode::shear}) {
    for (const double share : {0.98, 1.02}) {
      BeamLaw law = bridge();
      const bool hangs = mode == BondMode::tension;
      Model model = hangs ? body_on_wall(boxed(), law, Vec3::UnitZ(), kHalfHeight)
                          : body_on_wall(boxed(), law, Vec3::UnitX(), 0);
      const double weight = weight_of_body(model).norm(), stress = weight / law.section.area;
      (hangs ? model.beams[0].tensile_strength : model.beams[0].shear_strength) = stress / share;
      model.timestep = 1e-6;
      const Cantilever bent = cantilever(law, weight);
      const double sinks =
          hangs ? weight * law.length / (law.young_modulus * law.section.area) : bent.sinks;
      Solver solver(model);
      put(solver, 0, Vec3(0, 0, -sinks),
          hangs ? Quat::Identity() : Quat(Eigen::AngleAxisd(-bent.turns, Vec3::UnitY())));
      solver.step();
      const BondRecord first = solver.bonds()[0];
      scenes::run(solver, 5e-3 - solver.time());
      const double fallen = -sinks - solver.particles().position[0].z();
      if (share < 1) {
        EXPECT_EQ(solver.bonds()[0].mode, BondMode::intact) << to_string(mode);
        EXPECT_LT(std::abs(fallen), 0.01 * sinks);
        continue;
      }
      EXPECT_STREQ(to_string(first.mode), to_string(mode));
      EXPECT_NEAR(first.stress, stress, 1e-2 * stress);
      const double free = 0.5 * scenes::kGravity * solver.time() * solver.time();
      EXPECT_NEAR(fallen, free, 0.01 * free);
    }
  }
}

double ledger(const Solver& solver) {
  const Energy e = solver.energy();
  return scenes::mechanical(e) + e.dissipated_bonds + e.removed;
}

TEST(BondToBoundary, FallsFreelyFromTheEndOfTheLifetimeOn) {
  BeamLaw law = bridge();
  law.lifetime = 20e-3;
  Model model = body_on_wall(boxed(), law, Vec3::UnitZ(), kHalfHeight);
  const double weight = weight_of_body(model).norm();
  Solver solver(model);
  for (int k = 0; k < 100; ++k) solver.step();
  put(solver, 0, Vec3(0, 0, -weight * law.length / (law.young_modulus * law.section.area)));
  const double start = ledger(solver);
  for (int k = 0; k < 1999; ++k) solver.step();
  EXPECT_EQ(solver.bonds()[0].mode, BondMode::intact);
  const double elastic = solver.energy().elastic;
  EXPECT_GT(elastic, 0);
  solver.step();
  const BondRecord& record = solver.bonds()[0];
  EXPECT_STREQ(to_string(record.mode), "lifetime");
  EXPECT_DOUBLE_EQ(record.time, 2100 * model.timestep);
  EXPECT_DOUBLE_EQ(record.made, 100 * model.timestep);
  EXPECT_EQ(record.stress, 0);
  EXPECT_NEAR(record.position.z(), kHalfHeight + 0.5 * law.length, 1e-5);
  EXPECT_EQ(solver.energy().elastic, 0);
  EXPECT_NEAR(solver.energy().dissipated_bonds, elastic, 0.01 * elastic);
  const double z = solver.particles().position[0].z(), v = solver.particles().velocity[0].z(),
               begin = solver.time();
  scenes::run(solver, 0.05);
  const double t = solver.time() - begin;
  EXPECT_NEAR(solver.particles().position[0].z(), z + v * t - 0.5 * scenes::kGravity * t * t, 1e-9);
  EXPECT_NEAR(ledger(solver), start, 0.01 * elastic);
}

TEST(Bond, LifetimeCountsFromTheLaterBodyOn) {
  BeamLaw law = bridge();
  law.lifetime = 1e-3;
  Solver solver(straight_pair(law));
  put(solver, 0, place(0));
  for (int k = 0; k < 500; ++k) solver.step();
  put(solver, 1, place(1));
  for (int k = 0; k < 99; ++k) solver.step();
  EXPECT_EQ(solver.bonds()[0].mode, BondMode::intact);
  solver.step();
  EXPECT_EQ(solver.bonds()[0].mode, BondMode::lifetime);
}

// 150 boxes on beams to a ceiling, of which the fast ones break.
Model hung_row(int threads = 1) {
  BeamLaw law = bridge(2e4, 0.05);
  law.lifetime = 0.03;
  Model model = row(150, law);
  model.gravity = Vec3(0, 0, -scenes::kGravity);
  const int number = scenes::add_plane(model, Vec3(0, 0, 30e-3), -Vec3::UnitZ(), false);
  const Boundary& ceiling = model.boundaries[index(number)];
  model.bonds.clear();
  for (int i = 0; i < 150; ++i)
    model.bonds.push_back(make_bond(
        i, 150 + number, 0, kLength, stands(place(i)), stands(ceiling.origin, ceiling.orientation),
        place(i) + Vec3(0, 0, kHalfHeight + 0.5 * kLength), Vec3::UnitZ(), Vec3::UnitY()));
  // A whole number of steps in the times of the test.
  model.timestep = 0.02 / std::ceil(0.02 / advise_timestep(model, 8).timestep);
  model.numerics.threads = threads;
  return model;
}
Solver hanging(const Model& model) {
  Solver solver(model);
  for (int i = 0; i < 150; ++i)
    put(solver, i, place(i), Quat::Identity(), Vec3(0, 0, -0.04 * i / 150));
  return solver;
}
std::ptrdiff_t count_of_mode(const Solver& solver, BondMode mode) {
  return std::ranges::count(solver.bonds(), mode, &BondRecord::mode);
}

TEST(BondToBoundary, ThreadsAndInterruptionsChangeNoBit) {
  Solver one = hanging(hung_row());
  scenes::run(one, 0.02);
  const std::vector<std::byte> half = one.save();
  EXPECT_GT(count_of_mode(one, BondMode::tension), 0);
  EXPECT_GT(count_of_mode(one, BondMode::intact), 0);
  scenes::run(one, 0.04);
  EXPECT_GT(count_of_mode(one, BondMode::lifetime), 0);
  EXPECT_EQ(count_of_mode(one, BondMode::intact), 0);
  Solver resumed(hung_row());
  resumed.restore(half);
  scenes::run(resumed, 0.04);
  EXPECT_TRUE(resumed.save() == one.save());
  for (const int threads : {2, 3}) {
    Solver other = hanging(hung_row(threads));
    scenes::run(other, 0.06);
    EXPECT_TRUE(other.save() == one.save()) << threads << " threads";
  }
}

TEST(BondToBoundary, AutomaticStepKnowsTheFastestMotion) {
  Model model = body_on_wall(boxed(), bridge(1e9, 0, 1e9), Vec3::UnitX(), 10e-3);
  model.timestep = 1;
  const TimestepAdvice advice = advise_timestep(model, 1);  // pi / 2 / omega
  EXPECT_NE(advice.reason.find("bond \"bridge\" between particle 0 and boundary \"wall\""),
            std::string::npos)
      << advice.reason;
  const auto largest = [&](double timestep) {
    model.timestep = timestep;
    Solver solver(model);
    put(solver, 0, Vec3(1e-9, 2e-9, 3e-9),
        Quat(Eigen::AngleAxisd(1e-7, Vec3(1, -1, 1).normalized())));
    double most = 0;
    for (int k = 0; k < 400 && most < 1e8; ++k) {  // before it breaks
      solver.step();
      const BeamStress stress = solver.bond(0).stress;
      most =
          std::max(most, std::abs(stress.tension) + stress.bending + stress.shear + stress.torsion);
    }
    return most;
  };
  const double calm = largest(0.1 * advice.timestep);
  EXPECT_LT(largest(4 / pi * 0.98 * advice.timestep), 20 * calm);
  EXPECT_GT(largest(4 / pi * 1.02 * advice.timestep), 1000 * calm);
}

TEST(BondToBoundary, EndsWithABoundaryThatIsRemoved) {
  Solver solver(body_on_wall(boxed(), bridge(), Vec3::UnitX(), 10e-3));
  put(solver, 0, Vec3(-1e-5, 0, 0));
  const double start = ledger(solver);
  solver.step();
  EXPECT_GT(solver.load(0).force.x(), 0);
  const double elastic = solver.energy().elastic;
  EXPECT_GT(elastic, 0);
  solver.remove_boundary(0);
  EXPECT_EQ(solver.bonds()[0].mode, BondMode::removed);
  EXPECT_EQ(solver.energy().elastic, 0);
  EXPECT_NEAR(ledger(solver), start, 1e-3 * elastic);
  solver.step();
  EXPECT_EQ(solver.load(0).force.norm(), 0);
}

TEST(BondToBoundary, BoundariesThatMoveAreRefused) {
  const Model fixed = body_on_wall(boxed(), bridge(), Vec3::UnitX(), 10e-3);
  const auto refusal = [](const Model& model) {
    try {
      Solver solver(model);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refusal(fixed), "");
  Model moving = fixed, carried = fixed, absent = fixed;
  moving.boundaries[0].motions.emplace_back();
  carried.frames.emplace_back().name = "carrier";
  carried.boundaries[0].frame = 0;
  absent.bonds[0].b = 2;
  for (const Model& model : {moving, carried}) {
    const std::string line = refusal(model);
    EXPECT_NE(line.find("boundary \"wall\" moves; expected"), std::string::npos) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
  EXPECT_NE(refusal(absent), "");
}

}  // namespace
}  // namespace firn
