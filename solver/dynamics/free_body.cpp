#include "solver/dynamics/free_body.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "solver/dynamics/mechanism_members.h"
#include "solver/dynamics/rotation_vector.h"

namespace firn {
namespace {

// A coordinate within this distance of a joint limit is at the limit; relative to 1 + |coordinate|.
constexpr double kAtStop = 1e-12;

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJoints, kMaxJoints>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;
using Columns = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxJoints>;

// An iteration of rates has converged when their relative change is below this.
constexpr double kSame = 1e-15;
constexpr int kMostRepetitions = 60;
constexpr int kMostSweeps = 200;  // over the bounded impulses of a body

// Velocities of the body at unit rates, and the mass matrix. The axes of free rotation are those of
// the parent.
struct Axes {
  Columns velocity, angular_velocity;  // m/s and rad/s for each rate
  Mat3 inertia = Mat3::Zero();         // kg m^2, world axes
  Vec3 arm = Vec3::Zero();             // m, from the body's origin to its center of mass
  Matrix mass;                         // kg, kg m, kg m^2

  Axes(const FreeBody& body, const Vec3& origin, const Mat3& parent, const Mat3& rotation)
      : inertia(rotation * body.inertia * rotation.transpose()),
        arm(rotation * (body.center - origin)) {
    const auto given = static_cast<Eigen::Index>(body.joints.size());
    const Eigen::Index n = given + (body.free_rotation ? 3 : 0);
    velocity.resize(3, n);
    angular_velocity.resize(3, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const bool turns =
          k >= given || body.joints[static_cast<std::size_t>(k)].kind == Joint::Kind::rotation;
      const Vec3 axis = k >= given
                            ? Vec3(parent.col(k - given))
                            : Vec3(parent * body.joints[static_cast<std::size_t>(k)].direction);
      velocity.col(k) = turns ? axis.cross(arm) : axis;
      angular_velocity.col(k) = turns ? axis : Vec3::Zero();
    }
    mass = body.mass * velocity.transpose() * velocity +
           angular_velocity.transpose() * inertia * angular_velocity;
    for (Eigen::Index k = 0; k < given; ++k)
      mass(k, k) += body.joints[static_cast<std::size_t>(k)].armature;
  }
};

Vector rates(const FreeBodyMotion& m, Eigen::Index n) {
  return Eigen::Map<const Vector>(m.rate, n);
}

// Equal within rounding.
bool is_at(double rate, double wanted) {
  return std::abs(rate - wanted) <= 1e-9 * std::abs(wanted) + 1e-12;
}

bool is_rotation(const Joint& axis) { return axis.kind == Joint::Kind::rotation; }

// True when the mass matrix in the axes of the parent does not depend on the coordinates.
bool has_constant_inertia(const FreeBody& body) {
  if (body.free_rotation) return false;
  const bool turns = std::ranges::any_of(body.joints, is_rotation);
  return !turns || body.joints.size() == 1;
}

// Change of the generalized velocities per impulse that acts evenly over `h` s, with damping.
Matrix response(const FreeBody& body, const Matrix& mass, double h) {
  const Eigen::Index n = mass.rows();
  Vector damping = Vector::Zero(n);
  for (std::size_t k = 0; k < body.joints.size(); ++k)
    damping[static_cast<Eigen::Index>(k)] = body.joints[k].damping;
  if (damping.isZero(0)) return mass.inverse();
  // In the axes of the damped modes, (1 - exp(-h c)) / (h c) for each.
  const Eigen::LLT<Matrix> llt(mass);
  const Matrix lower = llt.matrixL().solve(Matrix(Matrix::Identity(n, n)));
  const SymmetricEigen modes = symmetric_eigen(lower * damping.asDiagonal() * lower.transpose());
  Vector gain(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double z = h * std::max(0.0, modes.values[i]);
    gain[i] = z < 1e-8 ? 1 - 0.5 * z : -std::expm1(-z) / z;
  }
  const Matrix to_rates = lower.transpose() * modes.vectors;
  return to_rates * gain.asDiagonal() * to_rates.transpose();
}

// Generalized forces by contacts, gravity and inertia at these rates. Inertia forces are those at
// constant rates, or at constant momenta if the mass matrix depends on the coordinates.
Vector forces_at(const FreeBody& body, const Axes& axes, const FreeBodyState& at, const Vector& u) {
  // Angular velocities of the parent, of the body relative to it, and of the body, rad/s.
  const Vec3& parent_omega = at.parent_angular_velocity;
  const Vec3 relative_omega = axes.angular_velocity * u, omega = parent_omega + relative_omega;
  Vec3 sliding = Vec3::Zero();  // m/s, of the origin against the parent
  for (std::size_t k = 0; k < body.joints.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    if (!is_rotation(body.joints[k])) sliding += axes.velocity.col(i) * u[i];
  }
  const Vec3 turning = parent_omega.cross(relative_omega);
  const Vec3 acceleration = 2 * parent_omega.cross(sliding) +
                            parent_omega.cross(parent_omega.cross(at.offset)) +
                            turning.cross(axes.arm) + omega.cross(omega.cross(axes.arm));
  const Vec3 force = at.force + body.mass * (at.gravity - acceleration);
  const Vec3 torque = at.torque - axes.arm.cross(at.force) - axes.inertia * turning -
                      omega.cross(axes.inertia * omega);
  Vector out = axes.velocity.transpose() * force + axes.angular_velocity.transpose() * torque;
  if (has_constant_inertia(body)) return out;
  // Rate of change of the generalized momenta at constant rates, in the axes of the parent.
  const Vec3 velocity = axes.velocity * u, swing = relative_omega.cross(axes.arm);
  const Vec3 inward = body.mass * relative_omega.cross(swing);
  for (Eigen::Index k = 0; k < out.size(); ++k) {
    const Vec3 w = axes.angular_velocity.col(k);
    out[k] += body.mass * w.cross(swing).dot(velocity) + axes.velocity.col(k).dot(inward) +
              w.dot(relative_omega.cross(axes.inertia * relative_omega));
  }
  return out;
}

// True when the generalized forces depend on the rates.
bool is_coupled(const FreeBody& body, const FreeBodyState& at) {
  const std::size_t n = body.joints.size() + (body.free_rotation ? 3 : 0);
  if (n < 2) return false;
  const bool slides = !std::ranges::all_of(body.joints, is_rotation);
  const bool turns = body.free_rotation || std::ranges::any_of(body.joints, is_rotation);
  return (slides && turns) || !at.parent_angular_velocity.isZero(0);
}

bool is_same(const Vector& a, const Vector& b) { return (a - b).norm() <= kSame * b.norm(); }

// Constants of a half-kick.
struct HalfKickInput {
  const FreeBody& body;
  const std::vector<const Motor*>* motors;  // [joints]
  const FreeBodyState& at;
  const Axes& axes;
  double t, dt;  // s
  HalfKick half;
  const double* coordinate;     // [joints]
  double friction[kMaxJoints];  // N or N m, limit

  double h() const { return 0.5 * dt; }  // s, the duration of the half-kick
};

// Impulses of friction and motors against a jump of the parent, N s or N m s. They count towards
// the limits of this half step.
struct JumpImpulses {
  double friction[kMaxJoints] = {}, motor[kMaxJoints] = {};
};

// Changes the rates by the jump of the parent. Friction and motors hold joints against it.
JumpImpulses apply_jump(const HalfKickInput& in, Vector& u) {
  JumpImpulses out;
  const FreeBodyState& at = in.at;
  const Axes& axes = in.axes;
  const Vector before = u;
  const Vec3 jump =
      at.parent_velocity_change + at.parent_angular_velocity_change.cross(at.offset + axes.arm);
  u -= axes.mass.inverse() *
       (axes.velocity.transpose() * (in.body.mass * jump) +
        axes.angular_velocity.transpose() * (axes.inertia * at.parent_angular_velocity_change));
  const Matrix mobility = axes.mass.inverse();
  const auto hold = [&](std::size_t k, double most) {
    const auto i = static_cast<Eigen::Index>(k);
    const double given = std::clamp((before[i] - u[i]) / mobility(i, i), -most, most);
    u += mobility.col(i) * given;
    return given;
  };
  for (std::size_t k = 0; k < in.body.joints.size(); ++k) {
    const double rate = before[static_cast<Eigen::Index>(k)];
    if (is_at(rate, 0) && in.friction[k] > 0) out.friction[k] = hold(k, in.h() * in.friction[k]);
    for (const Motor* motor : in.motors[k]) {
      const bool holds =
          motor->acts(in.t) &&
          is_at(rate, motor_target_rate(*motor, in.coordinate[k], in.dt, HalfKick::second));
      if (holds) out.motor[k] += hold(k, in.h() * motor->max_load);
    }
  }
  return out;
}

// Finds the bounded impulses that drive the rates `now` towards their targets, one after the other,
// until no rate changes (projected Gauss-Seidel), and adds their effect to `now`. A single one
// needs one sweep. Marks joints whose rate one of them holds. Returns [rates] the impulses, N s or
// N m s.
Vector apply_pushes(std::vector<BoundedPush>& pushes, const Matrix& inverse, Vector& now,
                    HeldAxes& held) {
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double change = 0, effect = 0;  // largest in this sweep, m/s or rad/s
    for (BoundedPush& push : pushes) {
      const auto i = static_cast<Eigen::Index>(push.joint);
      const double needed = push.impulse + (push.target - now[i]) / inverse(i, i),
                   impulse = std::clamp(needed, push.least, push.most),
                   more = impulse - push.impulse;
      now += inverse.col(i) * more;
      push.impulse = impulse;
      push.holds = impulse == needed;
      change = std::max(change, std::abs(inverse(i, i) * more));
      effect = std::max(effect, std::abs(inverse(i, i) * impulse));
    }
    if (pushes.size() < 2 || change <= kSame * effect) break;
  }
  Vector sum = Vector::Zero(now.size());
  for (const BoundedPush& push : pushes) {
    sum[static_cast<Eigen::Index>(push.joint)] += push.impulse;
    held[push.joint] = held[push.joint] || push.holds;
    *push.account += push.impulse;
  }
  return sum;
}

// Rates after the half-kick from `start`, by the forces at the rates `u`. `inverse`: see
// response(). `motor_impulse`: [joints] N s or N m s. `pushes`: working memory.
Vector kicked(const HalfKickInput& in, const Vector& start, const Matrix& inverse,
              const JumpImpulses& given_before, const Vector& u, KickResult& result,
              double* motor_impulse, std::vector<BoundedPush>& pushes) {
  const double h = in.h();
  Vector impulse = h * forces_at(in.body, in.axes, in.at, u);
  for (std::size_t k = 0; k < in.body.joints.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const Joint& axis = in.body.joints[k];
    impulse[i] += h * (spring_load(axis, in.coordinate[k]) - axis.damping * start[i]);
  }
  Vector now = start + inverse * impulse;
  result = {};
  pushes.clear();
  for (std::size_t k = 0; k < in.body.joints.size(); ++k) {
    double spent = given_before.motor[k];
    motor_impulse[k] = spent;
    const double friction = h * in.friction[k], rubbed = given_before.friction[k];
    result.friction_impulse[k] = rubbed;
    if (in.friction[k] > 0)
      pushes.push_back({k, 0, -friction - rubbed, friction - rubbed, &result.friction_impulse[k]});
    for (const Motor* motor : in.motors[k]) {
      if (!motor->acts(in.t)) continue;
      result.driven = true;
      const double rate = start[static_cast<Eigen::Index>(k)], given = std::exchange(spent, 0);
      pushes.push_back({k, motor_target_rate(*motor, in.coordinate[k], in.dt, in.half),
                        -h * motor_load_limit(*motor, -rate) - given,
                        h * motor_load_limit(*motor, rate) - given, &motor_impulse[k]});
    }
  }
  const Vector pushed = apply_pushes(pushes, inverse, now, result.held);
  // The rest of the change of the momenta. `impulse` contains the dampers at the rates `start`.
  for (std::size_t k = 0; k < in.body.joints.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const double damping = in.body.joints[k].damping;
    if (damping > 0)
      result.damping_impulse[k] =
          in.axes.mass.row(i).dot(now - start) - pushed[i] - (impulse[i] + h * damping * start[i]);
  }
  return now;
}

}  // namespace

KickResult integrate_free_body(const FreeBody& body, const Vec3& origin,
                               const std::vector<const Motor*>* motors, const FreeBodyState& at,
                               double t, double dt, HalfKick half, FreeBodyMotion motion,
                               std::vector<BoundedPush>& pushes) {
  assert(!has_several_bounded_joints(body));
  const Axes axes(body, origin, at.parent, at.rotation);
  const Eigen::Index n = axes.velocity.cols();
  HalfKickInput in{body, motors, at, axes, t, dt, half, motion.coordinate, {}};
  for (std::size_t k = 0; k < body.joints.size(); ++k)
    in.friction[k] =
        friction_limit(body.joints[k], at.parent * body.joints[k].direction, at.bearing);
  Vector u = rates(motion, n);
  JumpImpulses given;
  if (half == HalfKick::first && at.parent_moves) given = apply_jump(in, u);
  const Vector start = u;
  const Matrix inverse = response(body, axes.mass, in.h());
  KickResult result;
  double motor_impulse[kMaxJoints] = {};
  u = kicked(in, start, inverse, given, start, result, motor_impulse, pushes);
  if (half == HalfKick::first && is_coupled(body, at)) {
    for (int r = 0; r < kMostRepetitions; ++r) {
      const Vector next = kicked(in, start, inverse, given, u, result, motor_impulse, pushes);
      const bool done = is_same(next, u);
      u = next;
      if (done) break;
    }
  }
  for (std::size_t k = 0; k < body.joints.size(); ++k) motion.motor_impulse[k] += motor_impulse[k];
  for (Eigen::Index i = 0; i < n; ++i) motion.rate[i] = u[i];
  return result;
}

Vec3 drift(const FreeBody& body, const Vec3& origin, double dt, const HeldAxes& held,
           FreeBodyMotion motion, Quat& orientation) {
  const std::size_t given = body.joints.size();
  const auto n = static_cast<Eigen::Index>(given + (body.free_rotation ? 3 : 0));
  if (has_constant_inertia(body)) {
    Vec3 turned = Vec3::Zero();
    for (std::size_t k = 0; k < given; ++k) {
      const Joint& axis = body.joints[k];
      motion.coordinate[k] += motion.rate[k] * dt;
      if (!is_rotation(axis)) continue;
      orientation = Quat(Eigen::AngleAxisd(motion.coordinate[k], axis.direction));
      turned += axis.direction * (motion.rate[k] * dt);
    }
    return turned;
  }
  const Vector first = rates(motion, n);
  const auto angular_velocity_of = [&](const Vector& u) {
    Vec3 omega = Vec3::Zero();
    if (body.free_rotation) omega = u.tail<3>();
    for (std::size_t k = 0; k < given; ++k) {
      if (is_rotation(body.joints[k]))
        omega += body.joints[k].direction * u[static_cast<Eigen::Index>(k)];
    }
    return omega;
  };
  const auto turn = [&](const Vector& u) { return rotation_by(0.5 * dt * angular_velocity_of(u)); };
  const Mat3 parent = Mat3::Identity();
  const Vector momenta = Axes(body, origin, parent, orientation.toRotationMatrix()).mass * first;
  const Quat half_way = turn(first) * orientation;
  Vector last = first;
  Quat end;
  for (int r = 0; r < kMostRepetitions; ++r) {
    end = (turn(last) * half_way).normalized();
    Matrix mass = Axes(body, origin, parent, end.toRotationMatrix()).mass;
    Vector known = momenta;
    for (std::size_t k = 0; k < given; ++k) {
      if (!held[k]) continue;
      const auto i = static_cast<Eigen::Index>(k);
      mass.row(i).setZero();
      mass(i, i) = 1;
      known[i] = first[i];
    }
    const Vector next = mass.partialPivLu().solve(known);
    const bool done = is_same(next, last);
    last = next;
    if (done) break;
  }
  end = (turn(last) * half_way).normalized();
  for (std::size_t k = 0; k < given; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const Joint& axis = body.joints[k];
    const double before = motion.coordinate[k], next = before + 0.5 * dt * (first[i] + last[i]);
    const bool is_within = before >= axis.lower && before <= axis.upper;
    motion.coordinate[k] = is_within ? std::clamp(next, axis.lower, axis.upper) : next;
    if (is_rotation(axis)) end = Quat(Eigen::AngleAxisd(motion.coordinate[k], axis.direction));
  }
  for (Eigen::Index i = 0; i < n; ++i) motion.rate[i] = last[i];
  orientation = end;
  return 0.5 * dt * (angular_velocity_of(first) + angular_velocity_of(last));
}

void apply_joint_limits(const FreeBody& body, const Vec3& origin, const FreeBodyState& at,
                        double dt, FreeBodyMotion motion, HeldAxes& held) {
  assert(!has_several_bounded_joints(body));
  const auto leaves = [&](std::size_t k) {
    const Joint& axis = body.joints[k];
    const double rate = motion.rate[k], next = motion.coordinate[k] + rate * dt,
                 near = dt > 0 ? 0 : kAtStop * (1 + std::abs(next));
    if (rate < 0 && next < axis.lower + near) return -1;
    if (rate > 0 && next > axis.upper - near) return 1;
    return 0;
  };
  for (std::size_t k = 0; k < body.joints.size(); ++k) {
    const int side = leaves(k);
    if (side == 0) continue;
    const Joint& axis = body.joints[k];
    const Axes axes(body, origin, at.parent, at.rotation);
    const Matrix inverse = axes.mass.inverse();
    const auto i = static_cast<Eigen::Index>(k);
    const double limit = side < 0 ? axis.lower : axis.upper;
    const double wanted = axis.limit_restitution > 0 ? -axis.limit_restitution * motion.rate[k]
                          : dt > 0                   ? (limit - motion.coordinate[k]) / dt
                                                     : 0;
    const double given = (wanted - motion.rate[k]) / inverse(i, i);
    for (Eigen::Index j = 0; j < inverse.rows(); ++j) motion.rate[j] += inverse(j, i) * given;
    motion.limit_impulse[k] += given;
    held[k] = true;
  }
}

double highest_frequency(const FreeBody& body, const Vec3& origin) {
  const Matrix mass = Axes(body, origin, Mat3::Identity(), Mat3::Identity()).mass;
  Vector root = Vector::Zero(mass.rows());
  for (std::size_t k = 0; k < body.joints.size(); ++k)
    root[static_cast<Eigen::Index>(k)] = std::sqrt(body.joints[k].stiffness);
  if (root.isZero(0)) return 0;
  const Eigen::MatrixXd squares = root.asDiagonal() * mass.inverse() * root.asDiagonal();
  return std::sqrt(std::max(0.0, symmetric_eigenvalues(squares).maxCoeff()));
}

double min_effective_mass(const FreeBody& body, const Vec3& origin, const Vec3& arm) {
  const Axes axes(body, origin, Mat3::Identity(), Mat3::Identity());
  Columns point = axes.velocity;
  for (Eigen::Index k = 0; k < point.cols(); ++k)
    point.col(k) += axes.angular_velocity.col(k).cross(arm - axes.arm);
  const Mat3 mobility = point * axes.mass.inverse() * point.transpose();  // 1/kg
  return 1 / Eigen::SelfAdjointEigenSolver<Mat3>(mobility).eigenvalues().maxCoeff();
}

}  // namespace firn
