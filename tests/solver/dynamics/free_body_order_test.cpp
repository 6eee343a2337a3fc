// Free bodies converge with the square of the time step, and keep what they must keep.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/dice.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

using scenes::Random;
using std::numbers::pi;

Vec3 random_direction(Random& random) { return random.orientation() * Vec3::UnitX(); }

Mat3 random_inertia(Random& random, double mass) {
  // Of a solid box, turned.
  const Vec3 s(random.uniform(0.02, 0.05), random.uniform(0.05, 0.1), random.uniform(0.1, 0.2));
  const Vec3 principal = mass / 12 *
                         Vec3(s.y() * s.y() + s.z() * s.z(), s.x() * s.x() + s.z() * s.z(),
                              s.x() * s.x() + s.y() * s.y());
  const Mat3 r = random.orientation().toRotationMatrix();
  return r * principal.asDiagonal() * r.transpose();
}

// Frames, of which the last one is free, and what it starts with.
struct Case {
  std::vector<MotionFrame> frames;
  Vec3 angular_velocity = Vec3::Zero();  // rad/s, of one that turns freely
  std::vector<double> rates;
  std::string name;
};

Solver start(const Case& in, double timestep) {
  Model model = scenes::empty(scenes::law(0.3, 0.3), scenes::law(0.3, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, scenes::crescent()));
  model.frames = in.frames;
  model.timestep = timestep;
  Solver solver(model);
  FrameStart go;
  go.frame = static_cast<int>(in.frames.size()) - 1;
  go.position = in.frames.back().origin;
  go.coordinates.assign(in.rates.size(), 0);
  go.rates = in.rates;
  go.relative_angular_velocity = in.angular_velocity;
  solver.start_frame(go);
  return solver;
}

// Place, axes and coordinates at the end.
Eigen::VectorXd end_of(const Case& in, double time, int steps) {
  Solver solver = start(in, time / steps);
  for (int k = 0; k < steps; ++k) solver.step();
  const FrameState f = solver.frames().back();
  const Mat3 axes = f.orientation.toRotationMatrix();
  Eigen::VectorXd out(12 + static_cast<Eigen::Index>(f.joints.size()));
  out.head<3>() = f.position / 0.1;
  out.segment<9>(3) = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(axes.data());
  for (std::size_t k = 0; k < f.joints.size(); ++k)
    out[12 + static_cast<Eigen::Index>(k)] = f.joints[k].coordinate / 0.1;
  return out;
}

void expect_second_order(const Case& in, double time, int steps) {
  const Eigen::VectorXd a = end_of(in, time, steps), b = end_of(in, time, 2 * steps),
                        c = end_of(in, time, 4 * steps);
  const double coarse = (a - b).norm(), fine = (b - c).norm();
  if (coarse < 1e-9) return;  // exact but for rounding
  EXPECT_NEAR(coarse / fine, 4, 0.6) << in.name << ": " << coarse << " and " << fine;
  EXPECT_LT(fine, 0.02) << in.name;
}

MotionFrame free_frame(Random& random, double arm, bool free_rotation, std::vector<Joint> axes) {
  MotionFrame frame;
  frame.name = "free";
  frame.origin = random_vector(random, 0.1);
  const double mass = random.uniform(0.1, 1);
  frame.free = FreeBody{mass, frame.origin + arm * random_direction(random),
                        random_inertia(random, mass), std::move(axes), free_rotation};
  return frame;
}

Joint axis(Joint::Kind kind, const Vec3& direction) {
  Joint out;
  out.kind = kind;
  out.direction = direction;
  return out;
}

Mat3 inertia_now(const FreeBody& body, const Quat& q) {
  const Mat3 r = q.toRotationMatrix();
  return r * body.inertia * r.transpose();
}

TEST(FreeBodyOrder, FreeTopKeepsMomentumAndEnergy) {
  Random random(7);
  for (int member = 0; member < 12; ++member) {
    Case in;
    in.name = "top " + std::to_string(member);
    in.frames = {free_frame(random, 0, true, {})};
    in.angular_velocity = 20 * random_direction(random);
    expect_second_order(in, 1, 2000);
    Solver solver = start(in, 5e-4);
    const FreeBody& body = *in.frames[0].free;
    const auto momentum = [&] {
      const FrameState f = solver.frames()[0];
      return Vec3(inertia_now(body, f.orientation) * f.relative_angular_velocity);
    };
    const auto energy = [&] {
      return 0.5 * momentum().dot(solver.frames()[0].relative_angular_velocity);
    };
    const Vec3 l = momentum();
    const double e = energy();
    double worst_l = 0, worst_e = 0, late_e = 0;
    for (int k = 0; k < 40000; ++k) {  // 20 s, some 60 turns
      solver.step();
      worst_l = std::max(worst_l, (momentum() - l).norm() / l.norm());
      (k < 20000 ? worst_e : late_e) =
          std::max(k < 20000 ? worst_e : late_e, std::abs(energy() / e - 1));
    }
    EXPECT_LT(worst_l, 1e-10) << in.name;
    EXPECT_LT(worst_e, 1e-3) << in.name;
    EXPECT_LT(late_e, 1.05 * worst_e) << in.name;  // no drift
  }
}

TEST(FreeBodyOrder, HeavyTop) {
  Random random(8);
  for (int member = 0; member < 12; ++member) {
    Case in;
    in.name = "heavy top " + std::to_string(member);
    in.frames = {free_frame(random, random.uniform(0.01, 0.05), true, {})};
    in.angular_velocity = random.uniform(5, 40) * random_direction(random);
    expect_second_order(in, 0.5, 1000);
    Solver solver = start(in, 5e-4);
    const FreeBody& body = *in.frames[0].free;
    const auto energy = [&] {
      const FrameState f = solver.frames()[0];
      const Vec3 arm = f.orientation * (body.center - in.frames[0].origin);
      const Vec3 v = f.relative_angular_velocity.cross(arm);
      return 0.5 * body.mass * v.squaredNorm() +
             0.5 * f.relative_angular_velocity.dot(inertia_now(body, f.orientation) *
                                                   f.relative_angular_velocity) +
             body.mass * scenes::kGravity * arm.z();
    };
    const double first = energy();
    double worst = 0;
    for (int k = 0; k < 20000; ++k) {
      solver.step();
      worst = std::max(worst, std::abs(energy() - first));
    }
    EXPECT_LT(worst, 2e-3 * std::abs(first)) << in.name;
  }
}

// Loose in space, with an origin anywhere: both momenta of the whole are kept.
TEST(FreeBodyOrder, LooseBodyKeepsMomenta) {
  Random random(9);
  for (int member = 0; member < 8; ++member) {
    Case in;
    in.name = "loose " + std::to_string(member);
    in.frames = {free_frame(random, 0.03, true,
                            {axis(Joint::Kind::translation, Vec3::UnitX()),
                             axis(Joint::Kind::translation, Vec3::UnitY()),
                             axis(Joint::Kind::translation, Vec3::UnitZ())})};
    in.rates = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    in.angular_velocity = 15 * random_direction(random);
    expect_second_order(in, 0.5, 1000);
    Model model = start(in, 2e-4).model();
    model.gravity.setZero();
    Solver solver(model);
    FrameStart go;
    go.coordinates = {0, 0, 0};
    go.rates = in.rates;
    go.relative_angular_velocity = in.angular_velocity;
    solver.start_frame(go);
    const FreeBody& body = *in.frames[0].free;
    const auto momenta = [&](Vec3& p, Vec3& l) {
      const FrameState f = solver.frames()[0];
      const Vec3 arm = f.orientation * (body.center - in.frames[0].origin);
      const Vec3 origin(f.joints[0].rate, f.joints[1].rate, f.joints[2].rate);
      p = body.mass * (origin + f.relative_angular_velocity.cross(arm));
      l = (f.position + arm).cross(p) +
          inertia_now(body, f.orientation) * f.relative_angular_velocity;
    };
    Vec3 p0, l0, p, l;
    momenta(p0, l0);
    for (int k = 0; k < 10000; ++k) solver.step();
    momenta(p, l);
    EXPECT_LT((p - p0).norm(), 1e-9 * p0.norm()) << in.name;
    EXPECT_LT((l - l0).norm(), 1e-9 * (l0.norm() + p0.norm() * 0.1)) << in.name;
  }
}

Motion rotation_ramp(Random& random) {
  Motion m;
  m.kind = Motion::Kind::rotation;
  m.profile = Motion::Profile::ramp;
  m.axis = random_direction(random);
  m.center = random_vector(random, 0.1);
  m.rate = random.uniform(-2, 2);
  m.end_rate = random.uniform(-6, 6);
  m.ramp_time = 10;
  return m;
}
Motion vibration(Random& random, Motion::Kind kind) {
  Motion m;
  m.kind = kind;
  m.profile = Motion::Profile::sinusoidal;
  m.axis = random_direction(random);
  m.center = random_vector(random, 0.1);
  m.amplitude = kind == Motion::Kind::rotation ? 0.3 : 0.02;
  m.frequency = random.uniform(1, 3);
  m.phase = random.uniform(0, 6);
  return m;
}

// Bodies with one to three sliders, with a hinge, turning freely or neither; on springs and
// dampers, with motors at a speed or at their limit, at rest or on carriers that shake and turn.
TEST(FreeBodyOrder, AnyBodyOnAnyCarrier) {
  Random random(10);
  for (int member = 0; member < 60; ++member) {
    Case in;
    in.name = "member " + std::to_string(member);
    const int carriers = member % 4;
    for (int c = 0; c < carriers; ++c) {
      MotionFrame frame;
      frame.name = "carrier " + std::to_string(c);
      frame.parent = c - 1;
      frame.origin = random_vector(random, 0.1);
      frame.motions = {c == 0   ? rotation_ramp(random)
                       : c == 1 ? vibration(random, Motion::Kind::translation)
                                : vibration(random, Motion::Kind::rotation)};
      in.frames.push_back(frame);
    }
    const int turning = member / 4 % 3;  // no, hinge, freely
    const int sliders = turning == 0 ? 1 + member / 12 % 3 : member / 12 % 4;
    std::vector<Joint> axes;
    const Quat turned = random.orientation();
    for (int k = 0; k < sliders; ++k)
      axes.push_back(axis(Joint::Kind::translation, turned * Vec3::Unit(k)));
    if (turning == 1) axes.push_back(axis(Joint::Kind::rotation, random_direction(random)));
    for (Joint& a : axes) {
      const bool is_slider = a.kind == Joint::Kind::translation;
      a.stiffness = random.uniform(5, 50) * (is_slider ? 1 : 0.01);
      a.damping = random.uniform(0, 2) * (is_slider ? 1 : 0.01);
      a.spring_reference = random.uniform(-0.05, 0.05);
      in.rates.push_back(random.uniform(-0.5, 0.5));
    }
    if (!axes.empty() && member % 5 == 1) {  // keeps its speed
      Motor motor;
      motor.speed = in.rates[0];
      axes[0].motors = {motor};
    }
    if (!axes.empty() && member % 5 == 2) {  // pushes with all that it has
      Motor motor;
      motor.speed = 100;
      motor.max_load = axes[0].kind == Joint::Kind::translation ? 2 : 0.02;
      axes[0].motors = {motor};
    }
    if (!axes.empty() && member % 5 == 3) {  // goes to a target
      Motor motor;
      motor.speed = 100;
      motor.target = 3e-3;
      axes[0].motors = {motor};
      in.rates[0] = *motor.target / 5e-3;  // the approach's own
    }
    in.frames.push_back(free_frame(random, random.uniform(0.01, 0.05), turning == 2, axes));
    in.frames.back().parent = carriers - 1;
    if (turning == 2) in.angular_velocity = random.uniform(2, 10) * random_direction(random);
    expect_second_order(in, 0.4, 800);
  }
}

}  // namespace
}  // namespace firn
