// Bodies and impacts for the tests of contact energies.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/solver/contact_energy/contact_energy.h"

namespace firn::contact_energy {

inline constexpr double kMass = 0.0137;      // kg
inline constexpr double kStiffness = 6.1e5;  // N/m
inline constexpr double kSpeed = 1.4;        // m/s
inline constexpr double kDegree = std::numbers::pi / 180;

struct Dice {
  std::mt19937_64 engine;
  explicit Dice(std::uint64_t seed) : engine(seed) {}
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  double normal() { return std::normal_distribution<double>()(engine); }
  Vec3 direction() { return Vec3(normal(), normal(), normal()).normalized(); }
  Quat turn() { return Quat(normal(), normal(), normal(), normal()).normalized(); }
  // A turn about an axis across z, of up to `most` (rad) about x and about y.
  Quat tilt(double most) {
    const Vec3 axis(between(-1, 1), between(-1, 1), 0);
    return Quat(Eigen::AngleAxisd(axis.norm() * most, axis.normalized()));
  }
};

inline std::vector<Vec3> box_corners(const Vec3& size) {
  std::vector<Vec3> out;
  out.reserve(8);
  for (int i = 0; i < 8; ++i)
    out.emplace_back(0.5 * size.cwiseProduct(Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  return out;
}

inline Solid box(const Vec3& size) { return make_solid(box_corners(size)); }

// A random convex polyhedron with corners on a sphere, its origin inside.
inline Solid random_solid(Dice& dice, int corners, double radius) {
  std::vector<Vec3> points;
  points.reserve(corners);
  for (int i = 0; i < 4; ++i)  // around the origin
    points.emplace_back(radius * (Vec3(i == 1 || i == 2 ? 1 : -1, i == 1 || i == 3 ? 1 : -1,
                                       i == 2 || i == 3 ? 1 : -1) +
                                  0.4 * dice.direction())
                                     .normalized());
  for (int i = 4; i < corners; ++i) points.emplace_back(radius * dice.direction());
  return make_solid(points);
}

// A crescent whose dish has `facets` facets: its hull below the plane of each facet.
inline Body crescent(int arcs, int facets, double dish) {
  constexpr double kChord = 0.061, kWidth = 0.0206, kDepth = 0.0137, kTip = 0.002;
  std::vector<Vec3> outline;
  for (const double y : {-kWidth / 2, kWidth / 2}) {
    for (int i = 0; i <= arcs; ++i) {
      const double u = -1 + 2.0 * i / arcs;
      outline.emplace_back(u * kChord / 2, y, -kTip - (kDepth - kTip) * (1 - u * u));
    }
    for (const double x : {-kChord / 2, kChord / 2}) outline.emplace_back(x, y, 0);
  }
  const Solid hull = make_solid(outline);
  Body body;
  for (int i = 0; i < facets; ++i) {
    const auto at = [&](int k) {
      const double u = -1 + 2.0 * k / facets;
      return Vec3(u * kChord / 2, 0, -dish * (1 - u * u));
    };
    const Vec3 normal = Vec3::UnitY().cross(at(i) - at(i + 1)).normalized();
    const double offset = normal.dot(at(i));
    std::vector<Vec3> points;
    for (const Vec3& v : hull.vertices) {
      if (normal.dot(v) <= offset) points.push_back(v);
    }
    for (const Solid::Edge& e : hull.edges) {
      const Vec3 &from = hull.vertices[e.vertex[0]], &to = hull.vertices[e.vertex[1]];
      const double first = normal.dot(from) - offset, last = normal.dot(to) - offset;
      if ((first < 0) != (last < 0))
        points.emplace_back(from + first / (first - last) * (to - from));
    }
    body.push_back(make_solid(points));
  }
  return body;
}

struct Rigid {
  Vec3 inertia = Vec3::Ones();  // kg m^2, principal
  Pose pose;
  Quat turn = Quat::Identity();
  Vec3 velocity = Vec3::Zero();
  Vec3 momentum = Vec3::Zero();  // kg m^2/s, angular, world

  void set(const Quat& q, const Vec3& at) {
    turn = q;
    pose = {q.toRotationMatrix(), at};
  }
  Vec3 spin(const Mat3& rotation) const {
    return rotation * (rotation.transpose() * momentum).cwiseQuotient(inertia);
  }
  Vec3 spin() const { return spin(pose.rotation); }
  double kinetic() const {
    return 0.5 * kMass * velocity.squaredNorm() + 0.5 * momentum.dot(spin());
  }
  void kick(const Vec3& force, const Vec3& moment, double dt) {
    velocity += dt / kMass * force;
    momentum += dt * moment;
  }
  static Quat turned(const Vec3& angle, const Quat& q) {
    const double size = angle.norm();
    return size > 0 ? Quat(Eigen::AngleAxisd(size, angle / size)) * q : q;
  }
  void drift(double dt) {  // midpoint rule for the rotation
    Vec3 w = spin();
    for (int i = 0; i < 2; ++i) w = spin(turned(0.5 * dt * w, turn).toRotationMatrix());
    set(turned(dt * w, turn).normalized(), pose.translation + dt * velocity);
  }
};

inline Vec3 box_inertia(const Vec3& size) {
  const Vec3 s = size.cwiseProduct(size);
  return kMass / 12 * Vec3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
}

// Below, `contact(pose_a, pose_b)` returns a structure with energy (J), deepest (m) and wrench.

// The least height of a above b along z at which they do not touch, below `top`; -1 if they miss.
template <class ContactOf>
double height_of_touch(const ContactOf& contact, const Rigid& ra, const Rigid& rb, double top) {
  const auto energy = [&](double z) {
    Pose pose = ra.pose;
    pose.translation.z() = z;
    return contact(pose, rb.pose).energy;
  };
  double z = top;
  while (z > -top && energy(z) <= 0) z -= 5e-4;
  if (z <= -top) return -1;
  double low = z, high = z + 5e-4;
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (low + high);
    (energy(middle) > 0 ? low : high) = middle;
  }
  return high;
}

// An elastic impact of two free bodies: kinetic energy after it over that before (0 if they miss),
// and the largest overlap (m).
struct Impact {
  double kept = 0, deepest = 0;
};
template <class ContactOf>
Impact impact(const ContactOf& contact, Rigid ra, Rigid rb, double dt, double phase) {
  const double z = height_of_touch(contact, ra, rb, 0.08);
  if (z < 0) return {};
  ra.pose.translation.z() = z + phase * kSpeed * dt;
  ra.velocity = {0, 0, -kSpeed};
  const double before = ra.kinetic() + rb.kinetic();
  Impact out;
  Wrench w;
  int apart = 0;
  for (int step = 0; step < 40000 && apart < 30; ++step) {
    ra.kick(w.force, w.moment_a, dt / 2);
    rb.kick(-w.force, w.moment_b, dt / 2);
    ra.drift(dt);
    rb.drift(dt);
    const auto c = contact(ra.pose, rb.pose);
    w = c.wrench;
    apart = c.energy > 0 ? 0 : apart + 1;
    out.deepest = std::max(out.deepest, c.deepest);
    ra.kick(w.force, w.moment_a, dt / 2);
    rb.kick(-w.force, w.moment_b, dt / 2);
  }
  out.kept = (ra.kinetic() + rb.kinetic()) / before;
  return out;
}

// Compares the wrench with differences of the energy where the bodies overlap by some 0.2 mm.
template <class ContactOf>
void expect_gradient(const ContactOf& contact, Rigid ra, const Rigid& rb, double tolerance) {
  const double z = height_of_touch(contact, ra, rb, 0.08);
  if (z < 0) return;
  ra.pose.translation.z() = z - 2e-4;
  const auto c = contact(ra.pose, rb.pose);
  ASSERT_GT(c.energy, 0);
  const double size = c.wrench.force.norm();
  for (int i = 0; i < 3; ++i) {
    const auto moved = [&](double h) {
      Pose p = ra.pose;
      p.translation[i] += h;
      return contact(p, rb.pose).energy;
    };
    const auto turned = [&](bool is_a, double h) {
      Pose p = is_a ? ra.pose : rb.pose;
      p.rotation = Eigen::AngleAxisd(h, Vec3::Unit(i)).toRotationMatrix() * p.rotation;
      return is_a ? contact(p, rb.pose).energy : contact(ra.pose, p).energy;
    };
    EXPECT_NEAR(-(moved(1e-8) - moved(-1e-8)) / 2e-8, c.wrench.force[i], 10 * tolerance * size);
    EXPECT_NEAR(-(turned(true, 1e-6) - turned(true, -1e-6)) / 2e-6, c.wrench.moment_a[i],
                tolerance * size);
    EXPECT_NEAR(-(turned(false, 1e-6) - turned(false, -1e-6)) / 2e-6, c.wrench.moment_b[i],
                tolerance * size);
  }
}

// Two crescents on their way to an impact: anywhere, or the back of a in the dish of b.
inline void place_crescents(Dice& dice, bool in_dish, Rigid& a, Rigid& b) {
  a.inertia = b.inertia = box_inertia({0.061, 0.0206, 0.0137});
  a.set(in_dish ? Quat(Eigen::AngleAxisd(dice.between(-20, 20) * kDegree, dice.direction()))
                : dice.turn(),
        {dice.between(-0.02, 0.02), dice.between(-8e-3, 8e-3), 0});
  b.set(in_dish ? Quat::Identity() : dice.turn(), Vec3::Zero());
}

}  // namespace firn::contact_energy
