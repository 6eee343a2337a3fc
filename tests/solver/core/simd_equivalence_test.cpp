// The wide paths against the plain ones: the same bits.
#include <gtest/gtest.h>

#include "solver/contact/contact_law_batch.h"
#include "solver/contact_detection/relative_poses.h"
#include "solver/dynamics/rigid_body.h"
#include "solver/state/workspace.h"
#include "solver/step/integrate_particles.h"
#include "tests/support/dice.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

TEST(Simd8d, RotateEachBodyAsOnItsOwn) {
  Dice dice(11);
  for (const double dt : {1e-5, 1e-2, 1.0}) {  // polynomials, both, library functions
    FreeRotations many;
    Quat q[Simd8d::size];
    Vec3 momentum[Simd8d::size], inverse[Simd8d::size];
    for (int k = 0; k < Simd8d::size; ++k) {
      q[k] = Quat(dice(-1, 1), dice(-1, 1), dice(-1, 1), dice(-1, 1)).normalized();
      momentum[k] = dice.vector(2);
      inverse[k] = Vec3(dice(1, 3), dice(1, 3), dice(1, 3));
      for (int c = 0; c < 4; ++c) many.q[c].set(k, q[k].coeffs()[c]);
      for (int c = 0; c < 3; ++c) {
        many.momentum[c].set(k, momentum[k][c]);
        many.inverse_inertia[c].set(k, inverse[k][c]);
      }
    }
    rotate_torque_free(many, dt);
    for (int k = 0; k < Simd8d::size; ++k) {
      rotate_torque_free(inverse[k], dt, q[k], momentum[k]);
      for (int c = 0; c < 4; ++c) EXPECT_EQ(many.q[c][k], q[k].coeffs()[c]);
      for (int c = 0; c < 3; ++c) EXPECT_EQ(many.momentum[c][k], momentum[k][c]);
    }
  }
}

// Bodies of two shapes, some of them not there, more than one range has and as many as do not fill
// the last lanes.
TEST(Simd8d, KickAndDriftEachBodyAsOnItsOwn) {
  constexpr int kBodies = 149;
  Dice dice(11);
  Model model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.1, 0.3));
  scenes::add_shape(model, make_box({0.02, 0.03, 0.01}, scenes::ice_options(0.02, 1e5, 1e-3)));
  scenes::add_shape(model, make_box({0.01, 0.01, 0.04}, scenes::ice_options(0.01, 1e5, 1e-3)));
  for (int i = 0; i < kBodies; ++i) scenes::add_particles(model, i % 2);
  model.timestep = 1e-4;
  Workspace w(model);
  State s;
  s.motion.resize(kBodies);
  s.load.resize(kBodies);
  s.translation_bound.resize(kBodies, 0);
  s.rotation_bound.resize(kBodies, 0);
  s.rebuild_distance.resize(kBodies, 1);
  for (int i = 0; i < kBodies; ++i) {
    s.presence.push_back(i % 5 == 3 ? Presence::removed : Presence::present);
    s.motion[i].position = dice.vector(1);
    s.motion[i].velocity = dice.vector(1);
    s.load[i].force = dice.vector(1);
    s.load[i].torque = dice.vector(1e-2);
    s.angular_momentum.push_back(dice.vector(1e-5));
    s.orientation.push_back(Quat(dice(-1, 1), dice(-1, 1), dice(-1, 1), dice(-1, 1)).normalized());
  }
  const State before = s;
  integrate_positions(model, w, s, false);
  const State drifted = s;
  // Two ranges of pairs push each body; the first one presses harder.
  w.loads.resize(2 * kBodies);
  w.load_index.first = {0};
  for (int i = 0; i < kBodies; ++i) {
    for (const int range : {0, 1}) {
      BlockLoad& load = w.loads[2 * i + range];
      const Vec3 force = dice.vector(1), torque = dice.vector(1e-2);
      load.force = {force.x(), force.y(), force.z(), 2.0 - range};
      load.torque = {torque.x(), torque.y(), torque.z(), 0};
      w.load_index.loads.push_back(2 * i + range);
    }
    w.load_index.first.push_back(2 * i + 2);
  }
  s.peak_normal_force.resize(kBodies, 1.5);
  State at_once = s;
  finish_velocities(model, w, s);
  for (int i = 0; i < kBodies; ++i) {
    SCOPED_TRACE(i);
    Vec3 velocity = before.motion[i].velocity, momentum = before.angular_momentum[i];
    Quat q = before.orientation[i];
    if (before.presence[i] != Presence::present) {
      EXPECT_EQ(s.motion[i].position, before.motion[i].position);
      EXPECT_EQ(s.motion[i].velocity, velocity);
      EXPECT_EQ(s.translation_bound[i], 0);
      continue;
    }
    const RigidBody& body = w.rigid[model.particles[i].shape];
    const auto kick_once = [&](const BodyLoad& load) {
      half_kick(body, load.force, load.torque, model.gravity, model.timestep, q.toRotationMatrix(),
                velocity, momentum);
    };
    kick_once(before.load[i]);
    rotate_torque_free(body.inverse_inertia, model.timestep, q, momentum);
    const Vec3 angular_velocity =
        q.toRotationMatrix() * momentum.cwiseProduct(body.inverse_inertia);
    const double turned = angular_velocity.norm() * model.timestep;
    EXPECT_EQ(drifted.motion[i].velocity, velocity);
    EXPECT_EQ(drifted.motion[i].position, before.motion[i].position + model.timestep * velocity);
    EXPECT_EQ(drifted.orientation[i].coeffs(), q.coeffs());
    EXPECT_EQ(drifted.angular_momentum[i], momentum);
    EXPECT_EQ(drifted.motion[i].angular_velocity, angular_velocity);
    EXPECT_EQ(drifted.rotation_bound[i], turned);
    EXPECT_EQ(drifted.translation_bound[i],
              velocity.norm() * model.timestep + turned * w.reach[model.particles[i].shape]);
    const BlockLoad &first = w.loads[2 * i], &second = w.loads[2 * i + 1];
    EXPECT_EQ(s.load[i].force, to_eigen(to_vec(first.force) + to_vec(second.force)));
    EXPECT_EQ(s.load[i].torque, to_eigen(to_vec(first.torque) + to_vec(second.torque)));
    EXPECT_EQ(s.peak_normal_force[i], 2);
    kick_once(s.load[i]);
    EXPECT_EQ(s.motion[i].velocity, velocity);
    EXPECT_EQ(s.angular_momentum[i], momentum);
    EXPECT_EQ(s.motion[i].angular_velocity,
              q.toRotationMatrix() * momentum.cwiseProduct(body.inverse_inertia));
  }
  // Both kicks in one pass.
  integrate_positions(model, w, s, false);
  integrate_positions(model, w, at_once, true);
  for (int i = 0; i < kBodies; ++i) {
    SCOPED_TRACE(i);
    EXPECT_EQ(at_once.motion[i].position, s.motion[i].position);
    EXPECT_EQ(at_once.motion[i].velocity, s.motion[i].velocity);
    EXPECT_EQ(at_once.motion[i].angular_velocity, s.motion[i].angular_velocity);
    EXPECT_EQ(at_once.orientation[i].coeffs(), s.orientation[i].coeffs());
    EXPECT_EQ(at_once.angular_momentum[i], s.angular_momentum[i]);
    EXPECT_EQ(at_once.translation_bound[i], s.translation_bound[i]);
    EXPECT_EQ(at_once.rotation_bound[i], s.rotation_bound[i]);
    EXPECT_EQ(at_once.peak_normal_force[i], s.peak_normal_force[i]);
  }
}

// Pairs among particles and a boundary, as many as do not fill the last lanes.
TEST(Simd8d, FindThePoseOfEachPairAsOnItsOwn) {
  constexpr int kBodies = 9;
  Dice dice(11);
  State s;
  for (int i = 0; i < kBodies; ++i) {
    s.motion.emplace_back().position = dice.vector(1);
    s.orientation.push_back(Quat(dice(-1, 1), dice(-1, 1), dice(-1, 1), dice(-1, 1)).normalized());
  }
  for (int a = 0; a < kBodies; ++a) {
    for (int b = a + 1; b < kBodies; ++b) {
      Pair& pair = s.pairs.emplace_back();
      pair.a = a;
      pair.b = b;
      PairMotionBound& motion_bound = s.motion_bound.emplace_back();
      for (double& x : motion_bound.reference_rotation) x = dice(-1, 1);
      for (double& x : motion_bound.reference_translation) x = dice(-1, 1);
      motion_bound.reference_translation_bound = dice(-1, 1);  // must not get in
    }
  }
  for (int trial = 0; trial < 40; ++trial) {
    const int count = 1 + trial % PairPoses::capacity;
    std::vector<std::uint32_t> numbers;
    for (int k = 0; k < count; ++k)
      numbers.push_back(static_cast<std::uint32_t>(dice(0, static_cast<double>(s.pairs.size()))));
    PairPoses poses;
    poses.find(s, numbers.data(), count);
    for (int k = 0; k < count; ++k) {
      const Pair& pair = s.pairs[numbers[k]];
      const PairMotionBound& motion_bound = s.motion_bound[numbers[k]];
      const Pose plain_one = relative_pose(s, pair.a, pair.b);
      Pose pose;
      poses.get_pose(k, pose);
      EXPECT_EQ(pose.rotation, plain_one.rotation);
      EXPECT_EQ(pose.translation, plain_one.translation);
      const Mat3 then = Eigen::Map<const Mat3>(motion_bound.reference_rotation);
      const Vec3 there = Eigen::Map<const Vec3>(motion_bound.reference_translation);
      EXPECT_EQ(poses.shift(k), (plain_one.translation - there).norm());
      EXPECT_NEAR(poses.turn(k), std::sqrt(0.5) * (plain_one.rotation - then).norm(), 1e-15);
    }
  }
}

struct Contact {
  ContactPatch patch;
  std::vector<ContactPoint> points;
  PairMotion motion;
  PairCoefficients law;
};

// Patches of all kinds: touching, near, sliding, sticking, fresh, turning, with rolling resistance.
Contact any_contact(Dice& dice) {
  Contact c;
  c.law.stiffness = 2e5;
  c.law.unloading_stiffness_ratio = dice(1, 10);
  c.law.minimum_unloading_ratio = 0.001;
  c.law.tangential_stiffness = dice(0.3, 1) * 2e5;
  c.law.static_friction = dice(0, 0.5);
  c.law.dynamic_friction = dice(0, 1) * c.law.static_friction;
  c.law.restick_velocity = 1e-3;
  c.law.rolling_limit = dice(-1, 1) > 0 ? 1e-3 : 0;
  ContactPatch& p = c.patch;
  p.normal = dice.vector(1).normalized();
  p.arm = dice.vector(0.02);
  p.gap_is_current = dice(-1, 1) > 0.5;
  p.sliding = dice(-1, 1) > 0;
  p.torsion_radius = dice(-1, 1) > 0 ? dice(0, 0.005) : 0;
  const double e = dice(0, 1), angle = dice(0, M_PI);
  p.elongation = {static_cast<float>(e * std::cos(2 * angle)),
                  static_cast<float>(e * std::sin(2 * angle))};
  // Friction from far below its limit to beyond it.
  const double load = std::pow(10, dice(-3, 0)), speed = std::pow(10, dice(-3, 0));
  p.torsion = p.torsion_radius > 0 ? load * dice(-1e-3, 1e-3) : 0;
  const Vec3 t = load * dice.vector(1);
  p.tangential = t - p.normal * p.normal.dot(t);
  p.point_count = static_cast<std::uint16_t>(dice(1, 7));
  for (std::uint32_t i = 0; i < p.point_count; ++i) {
    ContactPoint point;
    point.offset = dice.vector(0.005);
    point.gap = dice(-2e-5, 1e-5);
    point.stiffness_fraction = 1.0 / p.point_count;
    point.force = dice(-1, 1) > 0 && point.gap < 0 ? dice(0, 1) : 0;
    c.points.push_back(point);
  }
  const auto quad = [&](double size) {
    const Vec3 v = dice.vector(size);
    return Vec4{v.x(), v.y(), v.z(), 0};
  };
  c.motion = {quad(0.3 * speed), quad(5 * speed), quad(0.03)};
  return c;
}

TEST(Simd8d, AdvanceEachPatchAsOnItsOwn) {
  Dice dice(11);
  const double dt = 2e-5;
  int sliding = 0, sticking = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const int count = 1 + trial % PatchBlock::capacity;
    std::vector<Contact> wide;
    for (int k = 0; k < count; ++k) wide.push_back(any_contact(dice));
    std::vector<Contact> plain_ones = wide;
    std::vector<ContactPatch> patches;
    for (const Contact& c : wide) patches.push_back(c.patch);
    std::vector<PatchDetail> details(patches.size());
    std::vector<ActivePair> pairs(wide.size());
    for (int k = 0; k < count; ++k) {
      pairs[k].a = 2 * k;
      pairs[k].b = 2 * k + 1;
    }
    PatchBlock block(patches.data(), details.data(), 2 * count - 1);  // the last b is a boundary
    for (int k = 0; k < count; ++k) {
      Contact& c = wide[k];
      block.add(pairs[k], c.law, patches[k], c.points.data(), c.motion);
    }
    block.advance(dt);
    ASSERT_EQ(block.at_boundary().size(), 1u);
    EXPECT_EQ(block.at_boundary()[0], count - 1);
    for (int k = 0; k < count; ++k) {
      Contact& c = plain_ones[k];
      const Vec n = to_vec(c.patch.normal), arm = to_vec(c.patch.arm);
      const Vec angular_velocity = to_vec(c.motion.angular_velocity);
      const PatchMotion motion = patch_motion(
          n, to_vec(c.motion.velocity) + cross(angular_velocity, arm), angular_velocity, dt);
      const NormalLoad pressed = advance_points(c.law, c.patch, c.points.data(), motion);
      const FrictionStep rubbed = advance_friction(
          {c.law.tangential_stiffness, c.law.static_friction, c.law.dynamic_friction,
           c.law.restick_velocity},
          {to_vec(c.patch.tangential), c.patch.torsion, c.patch.sliding ? 1.0 : 0.0}, pressed.force,
          friction_region(c.patch), motion, dt);
      const Wrench on_a = wrench(n, pressed.force, pressed.offset_force, rubbed.state);
      const PatchLoad load = block.load(k);
      EXPECT_EQ(load.a, 2 * k);
      EXPECT_EQ(load.force.x, on_a.force.x);
      EXPECT_EQ(load.force.y, on_a.force.y);
      EXPECT_EQ(load.force.z, on_a.force.z);
      EXPECT_EQ(load.normal, pressed.force);
      EXPECT_EQ(block.overlap(k), pressed.overlap);
      EXPECT_GE(block.deepest(), pressed.overlap);
      EXPECT_EQ(load.work_normal, pressed.work);
      EXPECT_EQ(patches[k].torsion, rubbed.state.torsion);
      EXPECT_EQ(patches[k].sliding, rubbed.state.sliding > 0 ? 1u : 0u);
      (rubbed.state.sliding > 0 ? sliding : sticking) += pressed.force > 0 ? 1 : 0;
      for (std::size_t i = 0; i < c.points.size(); ++i) {
        EXPECT_EQ(wide[k].points[i].force, c.points[i].force);
        EXPECT_EQ(wide[k].points[i].gap, c.points[i].gap);
      }
      // Newton's third law, moments about one point: that of a and that of b.
      const Vec moment = to_vec(load.moment_a);
      const Vec sum =
          moment + to_vec(load.moment_b) + cross(to_vec(c.motion.apart), to_vec(load.force));
      EXPECT_NEAR(std::sqrt(square(sum)), 0, 1e-15 + 1e-12 * std::sqrt(square(moment)));
      if (c.law.rolling_limit == 0) {
        EXPECT_EQ(load.work_friction, rubbed.work);
        EXPECT_EQ(load.moment_a.x, (on_a.moment + cross(arm, on_a.force)).x);
      }
    }
  }
  EXPECT_GT(sliding, 100);
  EXPECT_GT(sticking, 100);
}

}  // namespace
}  // namespace firn
