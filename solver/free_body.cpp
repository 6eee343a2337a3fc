#include "solver/free_body.h"

#include <algorithm>
#include <cmath>

namespace firn {
namespace {

// A drive that has a target approaches it with this time constant, at most at its speed.
constexpr double kApproach = 5e-3;  // s
// So near to a stop a coordinate is on it.
constexpr double kAtStop = 1e-12;

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostAxes, kMostAxes>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostAxes, 1>;
using Columns = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMostAxes>;

// What unit rates do to the centre of mass, and the inertia against them.
struct Axes {
  Columns velocity, spin;  // m/s and rad/s for each rate
  Mat3 inertia;            // kg m^2, world axes
  Vec3 arm;                // m, from the body's origin to its centre of mass
  Matrix mass;             // kg, kg m, kg m^2

  Axes(const FreeBody& body, const Vec3& origin, const Mat3& parent, const Mat3& rotation)
      : inertia(rotation * body.inertia * rotation.transpose()),
        arm(rotation * (body.center - origin)) {
    const auto given = static_cast<Eigen::Index>(body.axes.size());
    const Eigen::Index n = given + (body.turns_freely ? 3 : 0);
    velocity.resize(3, n);
    spin.resize(3, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const bool turns =
          k >= given || body.axes[static_cast<std::size_t>(k)].kind == FreeAxis::Kind::rotation;
      const Vec3 axis = k >= given
                            ? Vec3(Vec3::Unit(k - given))
                            : Vec3(parent * body.axes[static_cast<std::size_t>(k)].direction);
      velocity.col(k) = turns ? axis.cross(arm) : axis;
      spin.col(k) = turns ? axis : Vec3::Zero();
    }
    mass = body.mass * velocity.transpose() * velocity + spin.transpose() * inertia * spin;
  }
};

Vector rates(const FreeBodyMotion& m, Eigen::Index n) {
  return Eigen::Map<const Vector>(m.rate, n);
}

// Of springs alone: dampers are taken implicitly.
double spring_force(const FreeAxis& axis, double coordinate) {
  return -axis.stiffness * (coordinate - axis.rest);
}

double wanted_rate(const Drive& drive, double coordinate) {
  if (!drive.target) return drive.speed;
  const double most = std::abs(drive.speed);
  return std::clamp((*drive.target - coordinate) / kApproach, -most, most);
}

}  // namespace

bool kick_free_body(const FreeBody& body, const Vec3& origin,
                    const std::vector<const Drive*>* drives, const FreeBodyScene& at, double t,
                    double h, bool with_parent, FreeBodyMotion motion) {
  const Axes axes(body, origin, at.parent, at.rotation);
  const Eigen::Index n = axes.velocity.cols();
  Vector u = rates(motion, n);
  if (with_parent) {
    const Vec3 jump = at.parent_velocity_change + at.parent_spin_change.cross(at.offset + axes.arm);
    u -= axes.mass.inverse() * (axes.velocity.transpose() * (body.mass * jump) +
                                axes.spin.transpose() * (axes.inertia * at.parent_spin_change));
  }
  const Vec3 relative_spin = axes.spin * u, spin = at.parent_spin + relative_spin;
  Vec3 sliding = Vec3::Zero();  // m/s, of the origin against the parent
  for (std::size_t k = 0; k < body.axes.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    if (body.axes[k].kind == FreeAxis::Kind::translation) sliding += axes.velocity.col(i) * u[i];
  }
  // Accelerations at constant rates. The rates of a body that turns freely count along world axes,
  // those of a hinge along an axis that turns with the parent.
  const Vec3 turning =
      body.turns_freely ? Vec3(Vec3::Zero()) : Vec3(at.parent_spin.cross(relative_spin));
  const Vec3 acceleration = 2 * at.parent_spin.cross(sliding) +
                            at.parent_spin.cross(at.parent_spin.cross(at.offset)) +
                            turning.cross(axes.arm) + spin.cross(spin.cross(axes.arm));
  const Vec3 force = at.force + body.mass * (at.gravity - acceleration);
  const Vec3 torque = at.torque - axes.arm.cross(at.force) - axes.inertia * turning -
                      spin.cross(axes.inertia * spin);
  Vector impulse = h * (axes.velocity.transpose() * force + axes.spin.transpose() * torque);
  Matrix mass = axes.mass;
  for (std::size_t k = 0; k < body.axes.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const FreeAxis& axis = body.axes[k];
    impulse[i] += h * (spring_force(axis, motion.coordinate[k]) - axis.damping * u[i]);
    mass(i, i) += h * axis.damping;
  }
  const Matrix inverse = mass.inverse();
  u += inverse * impulse;
  bool driven = false;
  const auto push = [&](Eigen::Index i, double wanted, double most) {
    const double given = std::clamp((wanted - u[i]) / inverse(i, i), -most, most);
    u += inverse.col(i) * given;
    return given;
  };
  for (std::size_t k = 0; k < body.axes.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    if (body.axes[k].friction > 0) push(i, 0, h * body.axes[k].friction);
    for (const Drive* drive : drives[k]) {
      if (!drive->acts(t)) continue;
      driven = true;
      motion.drive_impulse[k] +=
          push(i, wanted_rate(*drive, motion.coordinate[k]), h * drive->limit);
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) motion.rate[i] = u[i];
  return driven;
}

void meet_stops(const FreeBody& body, const Vec3& origin, const FreeBodyScene& at, double dt,
                FreeBodyMotion motion) {
  const auto leaves = [&](std::size_t k) {
    const FreeAxis& axis = body.axes[k];
    const double rate = motion.rate[k], next = motion.coordinate[k] + rate * dt,
                 near = dt > 0 ? 0 : kAtStop * (1 + std::abs(next));
    if (rate < 0 && next < axis.lower + near) return -1;
    if (rate > 0 && next > axis.upper - near) return 1;
    return 0;
  };
  for (std::size_t k = 0; k < body.axes.size(); ++k) {
    const int side = leaves(k);
    if (side == 0) continue;
    const FreeAxis& axis = body.axes[k];
    const Axes axes(body, origin, at.parent, at.rotation);
    const Matrix inverse = axes.mass.inverse();
    const auto i = static_cast<Eigen::Index>(k);
    const double limit = side < 0 ? axis.lower : axis.upper;
    const double wanted = axis.stop_restitution > 0 ? -axis.stop_restitution * motion.rate[k]
                          : dt > 0                  ? (limit - motion.coordinate[k]) / dt
                                                    : 0;
    const double given = (wanted - motion.rate[k]) / inverse(i, i);
    for (Eigen::Index j = 0; j < inverse.rows(); ++j) motion.rate[j] += inverse(j, i) * given;
    motion.stop_impulse[k] += given;
  }
}

double least_apparent_mass(const FreeBody& body, const Vec3& origin, const Vec3& arm) {
  const Axes axes(body, origin, Mat3::Identity(), Mat3::Identity());
  Columns point = axes.velocity;
  for (Eigen::Index k = 0; k < point.cols(); ++k)
    point.col(k) += axes.spin.col(k).cross(arm - axes.arm);
  const Mat3 mobility = point * axes.mass.inverse() * point.transpose();  // 1/kg
  return 1 / Eigen::SelfAdjointEigenSolver<Mat3>(mobility).eigenvalues().maxCoeff();
}

}  // namespace firn
