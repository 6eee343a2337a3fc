#include "solver/dynamics/mechanism.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "solver/dynamics/cam.h"
#include "solver/dynamics/constraint_solver.h"
#include "solver/dynamics/joint_impulses.h"
#include "solver/dynamics/mechanism_tree.h"
#include "solver/dynamics/multibody_tree.h"

namespace firn {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// An iteration of rates has converged when they change by less than this fraction of the sum of the
// magnitudes of their terms.
constexpr double kSameRates = 1e-14;
constexpr int kMostRepetitions = 200;
// A step counts as converged up to this fraction, as rounding errors of some linkages exceed
// kSameRates.
constexpr double kSolvedRates = 1e-9;
// Errors of couplings, m or 1: those below kMet count as zero, and those from kUnmet on as a
// failure.
constexpr double kMet = 1e-13, kUnmet = 1e-7;
// Rates of the errors of couplings at unit rates of the coordinates, m or 1, that are rounding
// errors up to this size.
constexpr double kNoMotion = 1e-13;

// The pin or slot of a coupling as a joint with friction.
Joint bearing_of(const Coupling& coupling) {
  Joint joint;
  joint.kind =
      coupling.kind == Coupling::Kind::slot ? Joint::Kind::translation : Joint::Kind::rotation;
  joint.direction = coupling.direction;
  joint.friction = coupling.friction;
  joint.friction_coefficient = coupling.friction_coefficient;
  joint.bearing_radius = coupling.bearing_radius;
  return joint;
}

}  // namespace

struct Mechanism::Impl {
  MechanismMembers members;
  std::string name;                        // of the first frame
  std::vector<const MotionFrame*> frames;  // [frames of the members]
  std::vector<int> parent_body;            // [frames] number in the tree; -1: the ground
  std::vector<const Coupling*> couplings;  // [couplings of the members]
  // Of each coupling: its loop in the tree, or the coordinates that it ties.
  struct Tie {
    int loop = -1;
    int coordinate_a = -1, coordinate_b = -1;
    int body_a = -1, body_b = -1;  // numbers in the tree
    std::optional<Cam> cam;
    std::optional<Joint> bearing;  // of its pin or slot, with the friction
  };
  std::vector<Tie> ties;
  // [coordinates] frame and joint; the axes of a free rotation count after the joints.
  std::vector<std::pair<std::size_t, std::size_t>> joint;
  VectorXd damping, armature, stiffness;  // [coordinates]
  MultibodyTree tree;

  Impl(const std::vector<MotionFrame>& all, const std::vector<Coupling>& given,
       MechanismMembers with)
      : members(std::move(with)), tree(tree_bodies(all, members), tree_loops(all, given, members)) {
    for (const int f : members.frames) {
      const MotionFrame& frame = all[static_cast<std::size_t>(f)];
      frames.push_back(&frame);
      parent_body.push_back(body_number(members, free_frame(all, frame.parent)));
    }
    name = frames.front()->name;
    const int n = tree.coordinates();
    joint.resize(static_cast<std::size_t>(n));
    damping = armature = stiffness = VectorXd::Zero(n);
    for (std::size_t f = 0; f < frames.size(); ++f) {
      const FreeBody& body = *frames[f]->free;
      for (std::size_t k = 0; k < body.joints.size() + (body.free_rotation ? 3 : 0); ++k) {
        const int i = tree.coordinate(static_cast<int>(f), static_cast<int>(k));
        joint[static_cast<std::size_t>(i)] = {f, k};
        if (k >= body.joints.size()) continue;
        damping[i] = body.joints[k].damping;
        armature[i] = body.joints[k].armature;
        stiffness[i] = body.joints[k].stiffness;
      }
    }
    int loops = 0;
    for (const int c : members.couplings) {
      const Coupling& one = given[static_cast<std::size_t>(c)];
      couplings.push_back(&one);
      Tie tie;
      tie.body_a = body_number(members, free_frame(all, one.a));
      tie.body_b = body_number(members, free_frame(all, one.b));
      if (one.has_friction()) tie.bearing = bearing_of(one);
      if (one.ties_joints()) {
        tie.coordinate_a = tree.coordinate(tie.body_a, one.joint_a);
        tie.coordinate_b = tree.coordinate(tie.body_b, one.joint_b);
        if (one.kind == Coupling::Kind::cam) tie.cam.emplace(one.angles, one.lifts);
      } else {
        tie.loop = loops++;
      }
      ties.push_back(std::move(tie));
    }
    check_cams();
  }

  void check_cams() const {
    for (std::size_t c = 0; c < ties.size(); ++c) {
      if (!ties[c].cam) continue;
      const double lift = ties[c].cam->lift(0);
      if (std::abs(lift) > 1e-12)
        throw InputError(
            fmt::format("couplings.{}: the cam lifts by {:.6g} at the angle 0, where "
                        "both parts are drawn; expected 0",
                        couplings[c]->name, lift));
    }
  }

  MatrixXd mass_matrix() const {
    MatrixXd mass = tree.mass_matrix();
    mass.diagonal() += armature;
    return mass;
  }

  // Of the tree where it is placed, at the coordinates q.
  MatrixXd constraint_matrix(const VectorXd& q) const {
    const MatrixXd loops = tree.constraint_matrix();
    MatrixXd g = MatrixXd::Zero(loops.rows() + tied_joints(), q.size());
    g.topRows(loops.rows()) = loops;
    Eigen::Index row = loops.rows();
    for (std::size_t c = 0; c < ties.size(); ++c) {
      const Tie& tie = ties[c];
      if (tie.loop >= 0) continue;
      g(row, tie.coordinate_a) -=
          tie.cam ? tie.cam->slope(q[tie.coordinate_a]) : couplings[c]->ratio;
      g(row++, tie.coordinate_b) += 1;
    }
    return g;
  }
  VectorXd constraint_errors(const VectorXd& q) const {
    const VectorXd loops = tree.constraint_errors();
    VectorXd errors(loops.size() + tied_joints());
    errors.head(loops.size()) = loops;
    Eigen::Index row = loops.size();
    for (std::size_t c = 0; c < ties.size(); ++c) {
      const Tie& tie = ties[c];
      if (tie.loop >= 0) continue;
      const double a = q[tie.coordinate_a];
      errors[row++] = q[tie.coordinate_b] - (tie.cam ? tie.cam->lift(a) : couplings[c]->ratio * a);
    }
    return errors;
  }
  Eigen::Index tied_joints() const {
    return std::ranges::count_if(ties, [](const Tie& t) { return t.loop < 0; });
  }

  VectorXd gather(const MechanismState& s, double* FreeBodyMotion::*what) const {
    VectorXd out(static_cast<Eigen::Index>(joint.size()));
    for (std::size_t i = 0; i < joint.size(); ++i)
      out[static_cast<Eigen::Index>(i)] = (s.motion[joint[i].first].*what)[joint[i].second];
    return out;
  }
  void scatter(const MechanismState& s, double* FreeBodyMotion::*what, const VectorXd& from) const {
    for (std::size_t i = 0; i < joint.size(); ++i)
      (s.motion[joint[i].first].*what)[joint[i].second] = from[static_cast<Eigen::Index>(i)];
  }

  struct Arm {
    Vec3 center, from_ground;  // m, of the center of mass from the body's and the ground's origin
    Mat3 inertia;              // kg m^2
  };
  Arm arm_of(std::size_t f, const TreePose& pose, const MechanismState& s) const {
    const FreeBody& body = *frames[f]->free;
    const Vec3 center = pose.rotation * (body.center - frames[f]->origin);
    return {center, pose.origin + center - s.ground_origin,
            pose.rotation * body.inertia * pose.rotation.transpose()};
  }

  // Along the coordinates, by contacts, gravity, the ground's turning, springs and the motion
  // itself, at the place and the rates of the tree.
  VectorXd forces(const MechanismState& s, const VectorXd& q) const {
    const Mat3 to_ground = s.ground.transpose();
    const Vec3 omega = to_ground * s.ground_angular_velocity;  // rad/s, axes of the ground
    const Vec3 gravity = to_ground * s.gravity;
    std::vector<TreeLoad> loads(frames.size());
    for (std::size_t f = 0; f < frames.size(); ++f) {
      const TreePose pose = tree.pose(static_cast<int>(f));
      const Arm arm = arm_of(f, pose, s);
      const Vec3 velocity = pose.velocity + pose.angular_velocity.cross(arm.center);
      const Vec3 acceleration =
          omega.cross(omega.cross(arm.from_ground)) + 2 * omega.cross(velocity);
      const Vec3 own = frames[f]->free->mass * (gravity - acceleration);
      const Vec3 momentum = arm.inertia * omega;
      const Vec3 turning = pose.angular_velocity.cross(momentum) -
                           arm.inertia * pose.angular_velocity.cross(omega) +
                           omega.cross(arm.inertia * (omega + pose.angular_velocity));
      loads[f].force = to_ground * s.loads[f].force + own;
      loads[f].torque = to_ground * s.loads[f].torque + arm.center.cross(own) - turning;
    }
    VectorXd out = tree.generalized_forces(loads);
    for (std::size_t i = 0; i < joint.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      if (const Joint* one = joint_at(i)) out[k] += spring_load(*one, q[k]);
    }
    return out;
  }
  // Joint of a coordinate; null: an axis of a free rotation, which has no spring, friction, motor
  // or limit.
  const Joint* joint_at(std::size_t i) const {
    const auto [f, k] = joint[i];
    const std::vector<Joint>& joints = frames[f]->free->joints;
    return k < joints.size() ? &joints[k] : nullptr;
  }

  // Generalized impulses due to the velocity change of the ground.
  VectorXd jump(const MechanismState& s) const {
    const Vec3 velocity = s.ground.transpose() * s.ground_velocity_change,
               omega = s.ground.transpose() * s.ground_angular_velocity_change;  // m/s, rad/s
    if (velocity.isZero(0) && omega.isZero(0)) return VectorXd::Zero(tree.coordinates());
    std::vector<TreeLoad> impulses(frames.size());
    for (std::size_t f = 0; f < frames.size(); ++f) {
      const Arm arm = arm_of(f, tree.pose(static_cast<int>(f)), s);
      impulses[f].force = -frames[f]->free->mass * (velocity + omega.cross(arm.from_ground));
      impulses[f].torque = arm.center.cross(impulses[f].force) - arm.inertia * omega;
    }
    return tree.generalized_impulses(impulses);
  }

  // Impulses of friction, motors and limits on each coordinate. Those of friction are added to
  // `friction_impulse` [coordinates] when they are known.
  std::vector<std::vector<BoundedImpulse>> bounded_impulses(const MechanismState& s, HalfKick half,
                                                            const VectorXd& q, const VectorXd& u,
                                                            VectorXd& friction_impulse) const {
    std::vector<std::vector<BoundedImpulse>> all(joint.size());
    const double h = 0.5 * s.dt;
    for (std::size_t i = 0; i < joint.size(); ++i) {
      const Joint* const found = joint_at(i);
      if (found == nullptr) continue;
      const Joint& one = *found;
      const auto [f, k] = joint[i];
      const auto at = static_cast<Eigen::Index>(i);
      std::vector<BoundedImpulse>& impulses = all[i];
      const double friction = friction_limit(one, world_axis(s, f, one), s.bearings[f]);
      if (friction > 0) impulses.push_back({0, h * friction, -h * friction, &friction_impulse[at]});
      for (const Motor* motor : s.motors[f][k]) {
        if (!motor->acts(s.time)) continue;
        impulses.push_back({motor_target_rate(*motor, q[at], s.dt, half),
                            h * motor_load_limit(*motor, u[at]),
                            -h * motor_load_limit(*motor, -u[at]), s.motion[f].motor_impulse + k});
      }
      add_limits(one, q[at], u[at], half == HalfKick::first ? s.dt : 0,
                 s.motion[f].limit_impulse + k, impulses);
      std::ranges::stable_sort(impulses, {}, &BoundedImpulse::at);
    }
    return all;
  }
  // A coordinate within this distance of a limit is at the limit; relative to 1 + |coordinate|.
  static constexpr double kOnLimit = 1e-12;
  static void add_limits(const Joint& one, double q, double u, double dt, double* given,
                         std::vector<BoundedImpulse>& impulses) {
    const double near = dt > 0 ? 0 : kOnLimit * (1 + std::abs(q));
    const auto arrives = [&](double limit) { return dt > 0 ? (limit - q) / dt : 0; };
    const double e = one.limit_restitution;
    if (one.lower > -kUnbounded && (dt > 0 || q < one.lower + near)) {
      const double rate =
          u * dt + q < one.lower + near && u < 0 && e > 0 ? -e * u : arrives(one.lower);
      impulses.push_back({rate, kUnbounded, 0, given});
    }
    if (one.upper < kUnbounded && (dt > 0 || q > one.upper - near)) {
      const double rate =
          u * dt + q > one.upper - near && u > 0 && e > 0 ? -e * u : arrives(one.upper);
      impulses.push_back({rate, 0, -kUnbounded, given});
    }
  }

  // Friction of the pin or slot of a coupling in a half-kick.
  struct PinFriction {
    std::size_t coupling = 0;
    Vec3 axis = Vec3::UnitX();  // unit, axes of the ground
    VectorXd direction;         // [coordinates] rate of the pin for a unit rate of each
    double limit = 0;           // N or N m
    double impulse = 0;         // N s or N m s, on body b
  };
  std::vector<PinFriction> pin_friction(const MechanismState& s) const {
    std::vector<PinFriction> pins;
    for (std::size_t c = 0; c < ties.size(); ++c) {
      if (!ties[c].bearing) continue;
      const Joint& bearing = *ties[c].bearing;
      PinFriction pin;
      pin.coupling = c;
      pin.axis = bearing.direction;
      if (ties[c].body_a >= 0) pin.axis = tree.pose(ties[c].body_a).rotation * bearing.direction;
      pin.limit = friction_limit(bearing, s.ground * pin.axis, s.couplings[c]);
      if (!(pin.limit > 0)) continue;
      pin.direction = tree.generalized_impulses(pin_loads(c, pin.axis));
      pins.push_back(std::move(pin));
    }
    return pins;
  }
  // [bodies] a unit torque about the axis of a pin, or a unit force along a slot, between the
  // bodies of its coupling.
  std::vector<TreeLoad> pin_loads(std::size_t coupling, const Vec3& axis) const {
    const Tie& tie = ties[coupling];
    const Vec3 at = point(coupling);
    std::vector<TreeLoad> loads(frames.size());
    const auto act = [&](int body, double sign) {
      if (body < 0) return;
      TreeLoad& load = loads[static_cast<std::size_t>(body)];
      if (tie.bearing->kind == Joint::Kind::rotation) {
        load.torque = sign * axis;
        return;
      }
      load.force = sign * axis;
      load.torque = (at - tree.pose(body).origin).cross(load.force);
    };
    act(tie.body_b, 1);
    act(tie.body_a, -1);
    return loads;
  }
  // They refer to `pins`, which must outlive them.
  static std::vector<DirectedImpulse> directed_impulses(std::vector<PinFriction>& pins, double h) {
    std::vector<DirectedImpulse> out;
    for (PinFriction& pin : pins)
      out.push_back({pin.direction, {0, h * pin.limit, -h * pin.limit, &pin.impulse}});
    return out;
  }

  // Largest mobility of a constraint that no coordinate changes but for rounding errors.
  static double rounding_mobility(const MatrixXd& mass) {
    return kNoMotion * kNoMotion / mass.diagonal().minCoeff();
  }

  // Equations of a half-kick: resists u = known + h f(q, u) + g^T l, with the bounded impulses.
  struct KickEquations {
    VectorXd q, start;  // coordinates; rates before
    MatrixXd resists;   // mass, and damping as far as it is implicit
    MatrixXd mobility;  // inverse of `resists`
    MatrixXd g, along;  // of the constraints; mobility g^T
    ConstraintSolver constraint;
    VectorXd known;  // impulses that do not depend on the new rates
  };
  KickEquations kick_equations(const MechanismState& s, HalfKick half) {
    const bool first = half == HalfKick::first;
    const double h = 0.5 * s.dt;
    VectorXd q = gather(s, &FreeBodyMotion::coordinate), start = gather(s, &FreeBodyMotion::rate);
    tree.set_orientations(s.orientations);
    tree.place(q, start);
    const MatrixXd mass = mass_matrix();
    MatrixXd resists = mass;
    if (first) resists.diagonal() += h * damping;
    MatrixXd mobility = resists.llt().solve(MatrixXd::Identity(mass.rows(), mass.cols()));
    MatrixXd g = constraint_matrix(q);
    MatrixXd along = mobility * g.transpose();
    ConstraintSolver constraint(g * along, rounding_mobility(mass));
    VectorXd known = mass * start;
    if (first) {
      known += jump(s);
    } else {
      known -= h * damping.cwiseProduct(start);
    }
    return {std::move(q), std::move(start), std::move(resists),    std::move(mobility),
            std::move(g), std::move(along), std::move(constraint), std::move(known)};
  }

  struct KickSolution {
    VectorXd u;              // rates
    VectorXd applied;        // impulses without constraints and bounded impulses
    VectorXd end;            // coordinates at the end of the step
    bool converged = false;  // rates and bounded impulses
  };
  // Repeats the kick until the rates, and after the first half-kick the couplings at the end of the
  // step, have converged. Throws RunError when the couplings cannot be met.
  KickSolution solve_kick(const MechanismState& s, HalfKick half, const KickEquations& e,
                          JointImpulses& holds) {
    const bool first = half == HalfKick::first;
    const double h = 0.5 * s.dt;
    KickSolution out{e.start, VectorXd(), e.q, false};
    // Target rates of the constraints: zero, or those that close the couplings at the end of the
    // step.
    VectorXd wanted = VectorXd::Zero(e.g.rows());
    double error = 0;
    for (int r = 0; r < kMostRepetitions; ++r) {
      if (r > 0) tree.place(e.q, out.u);
      out.applied = e.known + h * forces(s, e.q);
      VectorXd next = e.mobility * out.applied;
      // Rounding error of terms that may cancel, for example when friction holds a load.
      const double small =
          kSameRates * (e.mobility.cwiseAbs() * out.applied.cwiseAbs()).lpNorm<Eigen::Infinity>();
      next -= e.along * e.constraint.solve(e.g * next - wanted);
      const bool is_solved = holds.apply(next, small);
      const double change = first ? (next - out.u).lpNorm<Eigen::Infinity>() : 0,
                   scale = std::max(small / kSameRates, next.lpNorm<Eigen::Infinity>());
      const bool is_same = !first || change <= small;
      out.converged = is_solved && change <= kSolvedRates * scale;
      out.u = next;
      if (first) out.end = e.q + s.dt * out.u;
      if (first && e.g.rows() > 0) {
        tree.place(out.end, out.u);
        const VectorXd errors = constraint_errors(out.end);
        const double before = std::exchange(error, errors.lpNorm<Eigen::Infinity>());
        // Due to rounding, the error may stop decreasing above kMet.
        const bool is_met = error <= kMet || (r > 5 && error < kUnmet && error >= before);
        if (is_same && is_met) break;
        if (!is_met) wanted -= errors / s.dt;
      } else if (is_same) {
        break;
      }
    }
    if (!(error < kUnmet))
      throw RunError(
          fmt::format("the mechanism of the motion frame \"{}\" cannot meet its couplings "
                      "at {:.6g} s: they are off by {:.3g}",
                      name, s.time, error));
    return out;
  }

  MechanismKick kick(const MechanismState& s, HalfKick half) {
    const KickEquations e = kick_equations(s, half);
    const MatrixXd tied_mobility = e.mobility - e.along * e.constraint.solve(e.along.transpose());
    JointForces given{VectorXd::Zero(e.q.size()), gather(s, &FreeBodyMotion::motor_impulse),
                      gather(s, &FreeBodyMotion::limit_impulse), pin_friction(s)};
    JointImpulses holds(bounded_impulses(s, half, e.q, e.start, given.friction),
                        directed_impulses(given.pins, 0.5 * s.dt), tied_mobility, e.mobility);
    const KickSolution solution = solve_kick(s, half, e, holds);
    holds.share();
    tree.place(e.q, solution.u);
    const VectorXd multipliers = e.constraint.solve(
        e.along.transpose() * (e.resists * solution.u - solution.applied - holds.impulses()));
    scatter(s, &FreeBodyMotion::coordinate, solution.end);
    scatter(s, &FreeBodyMotion::rate, solution.u);
    MechanismKick out{
        coupling_loads(s, multipliers), std::vector<double>(ties.size()), {}, solution.converged};
    add_joint_forces(s, half, e.start, solution.u, given, out);
    return out;
  }

  // Impulses of a half-kick along the coordinates [coordinates], N s or N m s; motors and limits:
  // their sums in the state before it.
  struct JointForces {
    VectorXd friction, motors_before, limits_before;
    std::vector<PinFriction> pins;
  };
  // Work of the impulses of a half-kick that changed the rates from `start` to `u`, and the
  // friction of couplings as loads on their bodies b.
  void add_joint_forces(const MechanismState& s, HalfKick half, const VectorXd& start,
                        const VectorXd& u, const JointForces& given, MechanismKick& out) const {
    const VectorXd mean = 0.5 * (start + u);
    for (std::size_t i = 0; i < joint.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      s.motion[joint[i].first].dissipated_friction[joint[i].second] -=
          given.friction[at] * mean[at];
    }
    for (const PinFriction& pin : given.pins) {
      JointLoad& load = out.couplings[pin.coupling];
      const bool turns = ties[pin.coupling].bearing->kind == Joint::Kind::rotation;
      (turns ? load.torque : load.force) += s.ground * pin.axis * pin.impulse;
      out.dissipated_friction[pin.coupling] = -pin.impulse * pin.direction.dot(mean);
    }
    const VectorXd motors = gather(s, &FreeBodyMotion::motor_impulse) - given.motors_before,
                   limits = gather(s, &FreeBodyMotion::limit_impulse) - given.limits_before;
    out.work.motors = motors.dot(mean);
    out.work.limits = limits.dot(mean);
    const VectorXd& damped = half == HalfKick::first ? u : start;
    out.work.dampers = -0.5 * s.dt * damping.cwiseProduct(damped).dot(mean);
  }

  // The multipliers that keep the couplings at zero rates, with the forces at rest.
  std::vector<JointLoad> starting_coupling_loads(const MechanismState& s) {
    const VectorXd q = gather(s, &FreeBodyMotion::coordinate);
    tree.set_orientations(s.orientations);
    tree.place(q, VectorXd::Zero(q.size()));
    const MatrixXd mass = mass_matrix();
    const Eigen::LLT<MatrixXd> factors(mass);
    const MatrixXd g = constraint_matrix(q), along = factors.solve(g.transpose());
    const VectorXd accelerations = factors.solve(forces(s, q));
    const ConstraintSolver constraint(g * along, rounding_mobility(mass));
    VectorXd multipliers = constraint.solve(g * accelerations);
    multipliers = -multipliers;
    return coupling_loads(s, multipliers);
  }

  std::vector<JointLoad> coupling_loads(const MechanismState& s,
                                        const VectorXd& multipliers) const {
    std::vector<JointLoad> out(ties.size());
    if (ties.empty()) return out;
    const Eigen::Index rows = multipliers.size() - tied_joints();
    Eigen::Index row = rows;
    for (std::size_t c = 0; c < ties.size(); ++c) {
      const Tie& tie = ties[c];
      JointLoad& load = out[c];
      if (tie.loop < 0) {
        const auto [f, k] = joint[static_cast<std::size_t>(tie.coordinate_b)];
        const Joint& one = frames[f]->free->joints[k];
        const Vec3 axis = world_axis(s, f, one) * multipliers[row++];
        (one.kind == Joint::Kind::rotation ? load.torque : load.force) = axis;
        continue;
      }
      const std::vector<TreeLoad> loads = tree.loop_loads(tie.loop, multipliers.head(rows));
      const Vec3 at = point(c);
      Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
      const auto add = [&](std::size_t body, double sign) {
        const TreeLoad& one = loads[body];
        const Vec3 arm = at - tree.pose(static_cast<int>(body)).origin;
        force += sign * one.force;
        torque += sign * (one.torque - arm.cross(one.force));
      };
      if (tie.body_b >= 0) {
        add(static_cast<std::size_t>(tie.body_b), 1);
      } else {
        for (std::size_t b = 0; b < loads.size(); ++b) add(b, -1);
      }
      load = {s.ground * force, s.ground * torque};
    }
    return out;
  }
  // Of a joint of frame f, where the tree is placed.
  Vec3 world_axis(const MechanismState& s, std::size_t f, const Joint& one) const {
    return s.ground * (axes_of_parent(f) * one.direction);
  }
  Mat3 axes_of_parent(std::size_t f) const {
    const int above = parent_body[f];
    return above < 0 ? Mat3(Mat3::Identity()) : Mat3(tree.pose(above).rotation);
  }
  // m, in the axes of the ground.
  Vec3 point(std::size_t coupling) const {
    const int b = ties[coupling].body_b;
    const Vec3& drawn = couplings[coupling]->position;
    if (b < 0) return drawn;
    const TreePose pose = tree.pose(b);
    return pose.origin + pose.rotation * (drawn - frames[static_cast<std::size_t>(b)]->origin);
  }
};

Mechanism::Mechanism(const std::vector<MotionFrame>& frames, const std::vector<Coupling>& couplings,
                     MechanismMembers members)
    : impl_(std::make_unique<Impl>(frames, couplings, std::move(members))) {}
Mechanism::~Mechanism() = default;
Mechanism::Mechanism(Mechanism&&) noexcept = default;
Mechanism& Mechanism::operator=(Mechanism&&) noexcept = default;

const MechanismMembers& Mechanism::members() const { return impl_->members; }

MechanismKick Mechanism::integrate_positions(const MechanismState& state) {
  return impl_->kick(state, HalfKick::first);
}

MechanismKick Mechanism::second_kick(const MechanismState& state) {
  return impl_->kick(state, HalfKick::second);
}

bool Mechanism::has_coupling_friction() const {
  return std::ranges::any_of(impl_->ties, [](const auto& tie) { return tie.bearing.has_value(); });
}

std::vector<JointLoad> Mechanism::starting_coupling_loads(const MechanismState& state) {
  return impl_->starting_coupling_loads(state);
}

Vec3 Mechanism::coupling_point(std::size_t coupling, const MechanismState& state) const {
  return state.ground * (impl_->point(coupling) - state.ground_origin);
}

double Mechanism::highest_frequency() const {
  const VectorXd root = impl_->stiffness.cwiseSqrt();
  if (root.isZero(0)) return 0;
  const VectorXd zero = VectorXd::Zero(root.size());
  impl_->tree.set_orientations(std::vector<Quat>(impl_->frames.size(), Quat::Identity()));
  impl_->tree.place(zero, zero);
  const MatrixXd squares = root.asDiagonal() * impl_->mass_matrix().inverse() * root.asDiagonal();
  return std::sqrt(std::max(0.0, symmetric_eigenvalues(squares).maxCoeff()));
}

}  // namespace firn
