// Lists of prescribed motions against closed-form poses, and against frames that carry each other.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/dice.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

using scenes::Random;
using Affine = Eigen::Isometry3d;

// Any course, with a start, a stop and repetitions. `smooth`: of continuous speed for all times.
Motion random_motion(Random& random, bool smooth) {
  Motion m;
  m.kind = random.uniform(0, 1) < 0.6 ? Motion::Kind::rotation : Motion::Kind::translation;
  m.axis = random.orientation() * Vec3::UnitX();
  m.center = random_vector(random, 0.3);
  const bool turns = m.kind == Motion::Kind::rotation;
  const double size = turns ? 1 : 0.1;
  switch (static_cast<int>(random.uniform(0, smooth ? 3 : 4))) {
    case 0:
      m.velocity = random_vector(random, 0.5);
      m.angular_speed = random.uniform(-5, 5);
      break;
    case 1:
      m.profile = Motion::Profile::ramp;
      m.rate = size * random.uniform(-3, 3);
      m.end_rate = size * random.uniform(-3, 3);
      m.ramp_time = smooth ? 10 : random.uniform(0.1, 1);
      break;
    case 2:
      m.profile = Motion::Profile::sinusoidal;
      m.amplitude = size * random.uniform(0.1, 1);
      m.frequency = random.uniform(0.5, 5);
      m.phase = random.uniform(0, 6);
      break;
    default:
      m.profile = Motion::Profile::table;
      for (int i = 0; i < 5; ++i) {
        m.times.push_back(0.1 * i);
        m.positions.push_back(size * random.uniform(-0.2, 0.2));
      }
  }
  if (smooth) return m;
  if (random.uniform(0, 1) < 0.5) m.start = random.uniform(0, 0.3);
  if (random.uniform(0, 1) < 0.5) m.stop = m.start + random.uniform(0.1, 0.3);
  if (m.stop < kUnbounded && random.uniform(0, 1) < 0.5) {
    m.period = (m.stop - m.start) * random.uniform(1, 2);
    if (random.uniform(0, 1) < 0.5) m.end = random.uniform(0.3, 1);
  }
  return m;
}

Affine transform(const Motion& m, double way) {
  if (m.kind == Motion::Kind::translation)
    return Affine(
        Eigen::Translation3d((m.profile == Motion::Profile::constant ? m.velocity : m.axis) * way));
  return Affine(Eigen::Translation3d(m.center) * Eigen::AngleAxisd(way, m.axis) *
                Eigen::Translation3d(-m.center));
}

// Way from 0 to t, written out once more: integrated speeds, piece by piece.
double way_by_speed(const Motion& m, double t) {
  const auto in_period = [&](double tau) {
    switch (m.profile) {
      case Motion::Profile::constant:
        return m.kind == Motion::Kind::translation ? tau : m.angular_speed * tau;
      case Motion::Profile::ramp: {
        const double r = std::min(tau, m.ramp_time);
        return m.rate * r + (m.end_rate - m.rate) * r * r / (2 * m.ramp_time) +
               m.end_rate * (tau - r);
      }
      case Motion::Profile::sinusoidal:
        return m.amplitude *
               (std::sin(2 * std::numbers::pi * m.frequency * tau + m.phase) - std::sin(m.phase));
      default: {
        double way = 0;
        for (std::size_t i = 0; i + 1 < m.times.size(); ++i) {
          const double part =
              std::clamp((tau - m.times[i]) / (m.times[i + 1] - m.times[i]), 0.0, 1.0);
          way += part * (m.positions[i + 1] - m.positions[i]);
        }
        return way;
      }
    }
  };
  double way = 0;
  for (int k = 0; k < 1000; ++k) {
    const double begin = m.start + k * m.period;
    const double to = std::min({t, m.end, begin + (m.stop - m.start)});
    if (to > begin) way += in_period(to - begin);
    if (m.period == 0) break;
  }
  return way;
}

Affine closed_form(const std::vector<Motion>& motions, double t) {
  Affine pose = Affine::Identity();
  for (const Motion& m : motions) pose = pose * transform(m, way_by_speed(m, t));
  return pose;
}

TriangleMesh small_triangle(const Vec3&) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

// One boundary that all motions move in one list, one frame with the same list that carries another
// boundary, and a chain of frames with one motion each.
struct Scene {
  Model model;
  int listed = 0, carried = 1, chained = 2;
};
Scene scene(Random& random, const std::vector<Motion>& motions, double timestep) {
  Scene out;
  Model& model = out.model;
  model = scenes::empty(scenes::law(0.3, 0.3), scenes::law(0.3, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, scenes::crescent()));
  Boundary b;
  b.name = "plate";
  b.material = scenes::kPlastic;
  b.origin = random_vector(random, 0.2);
  b.orientation = random.orientation();
  b.mesh = small_triangle(b.origin);
  b.motions = motions;
  model.boundaries = {b, b, b};
  model.boundaries[1].motions.clear();
  model.boundaries[1].frame = 0;
  MotionFrame frame;
  frame.name = "list";
  frame.origin = random_vector(random, 0.2);
  frame.motions = motions;
  model.frames = {frame};
  for (std::size_t i = 0; i < motions.size(); ++i) {
    MotionFrame link;
    link.name = "link " + std::to_string(i);
    link.origin = random_vector(random, 0.2);
    link.parent = i == 0 ? -1 : static_cast<int>(i);
    link.motions = {motions[i]};
    model.frames.push_back(link);
  }
  model.boundaries[2].motions.clear();
  model.boundaries[2].frame = static_cast<int>(model.frames.size()) - 1;
  model.timestep = timestep;
  return out;
}

TEST(MotionLists, ComposeToClosedFormPoses) {
  Random random(31);
  for (int member = 0; member < 200; ++member) {
    std::vector<Motion> motions;
    for (int k = 0; k < 1 + member % 5; ++k) motions.push_back(random_motion(random, false));
    const double timestep = member % 2 ? 1e-2 : 7e-4;
    Scene in = scene(random, motions, timestep);
    Solver solver(in.model);
    while (solver.time() < 1.2) {
      solver.step();
      if (solver.steps() % 10 != 0) continue;
      const Affine pose = closed_form(motions, solver.time());
      for (const int which : {in.listed, in.carried, in.chained}) {
        const Boundary& drawn = in.model.boundaries[static_cast<std::size_t>(which)];
        const BoundaryState& now = solver.boundaries()[static_cast<std::size_t>(which)];
        ASSERT_LT((now.position - pose * drawn.origin).norm(), 1e-11)
            << member << ", boundary " << which << " at " << solver.time();
        const Quat turned(pose.linear() * drawn.orientation.toRotationMatrix());
        ASSERT_LT(now.orientation.angularDistance(turned), 1e-7)
            << member << ", boundary " << which << " at " << solver.time();
      }
    }
  }
}

// A step's velocity and angular velocity are those of the pose in its middle, to second order.
TEST(MotionLists, VelocitiesAreThoseOfThePose) {
  Random random(32);
  for (int member = 0; member < 60; ++member) {
    std::vector<Motion> motions;
    for (int k = 0; k < 2 + member % 3; ++k) motions.push_back(random_motion(random, true));
    const auto error_of = [&](double timestep, int which) {
      Random same(static_cast<std::uint64_t>(member));
      Scene in = scene(same, motions, timestep);
      Solver solver(in.model);
      double worst = 0;
      while (solver.time() < 0.2) {
        const double middle = solver.time() + 0.5 * timestep, h = 1e-5;
        solver.step();
        const BoundaryState& now = solver.boundaries()[static_cast<std::size_t>(which)];
        const Affine a = closed_form(motions, middle - h), b = closed_form(motions, middle + h);
        const Vec3 origin = in.model.boundaries[static_cast<std::size_t>(which)].origin;
        const Vec3 velocity = (b * origin - a * origin) / (2 * h);
        const Eigen::AngleAxisd turn(Mat3(b.linear() * a.linear().transpose()));
        const Vec3 angular_velocity = turn.angle() * turn.axis() / (2 * h);
        worst = std::max({worst, (now.velocity - velocity).norm(),
                          (now.angular_velocity - angular_velocity).norm()});
      }
      return worst;
    };
    for (const int which : {0, 1, 2}) {
      const double coarse = error_of(4e-3, which), fine = error_of(1e-3, which);
      EXPECT_LT(fine, coarse / 10 + 1e-6) << member << ", boundary " << which;
      EXPECT_LT(fine, 0.01) << member << ", boundary " << which;
    }
  }
}

TEST(MotionLists, WayCoveredIsTheSumOfItsSteps) {
  Random random(33);
  for (int member = 0; member < 500; ++member) {
    const Motion m = random_motion(random, false);
    double sum = 0;
    const double dt = random.uniform(1e-3, 1e-2);
    for (int k = 0; k < 150; ++k) {
      sum += m.displacement(k * dt, dt);
      ASSERT_NEAR(sum, m.total_displacement((k + 1) * dt), 1e-11) << member;
      ASSERT_NEAR(sum, way_by_speed(m, (k + 1) * dt), 1e-11) << member;
    }
  }
}

// The center of a later motion goes along: a disk that slides and turns stays a disk about its
// axle.
TEST(MotionLists, SlidingDiskTurnsAboutItsMovedCenter) {
  Motion slide, turn;
  slide.velocity = Vec3(0.1, 0, 0);
  turn.kind = Motion::Kind::rotation;
  turn.axis = Vec3::UnitZ();
  turn.center = Vec3(0, 0.2, 0);
  turn.angular_speed = 3;
  Random random(1);
  Scene in = scene(random, {slide, turn}, 1e-3);
  in.model.boundaries[0].origin = turn.center;
  Solver solver(in.model);
  scenes::run(solver, 1);
  EXPECT_NEAR((solver.boundaries()[0].position - Vec3(0.1, 0.2, 0)).norm(), 0, 1e-12);
  in = scene(random, {turn, slide}, 1e-3);  // carried around
  in.model.boundaries[0].origin = turn.center;
  Solver other(in.model);
  scenes::run(other, 1);
  const Vec3 expected = turn.center + 0.1 * Vec3(std::cos(3), std::sin(3), 0);
  EXPECT_NEAR((other.boundaries()[0].position - expected).norm(), 0, 1e-12);
}

}  // namespace
}  // namespace firn
