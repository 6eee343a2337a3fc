// The contacts of a choice from step to step.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "experiments/inspection/contact_inspection.h"
#include "experiments/system/output_file.h"

namespace firn {

struct Motion6 {  // m, m/s, rad/s, world
  Vec3 center = Vec3::Zero(), velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();
};

struct LoadOnBody {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();  // N, N m about the body's center
};

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Motion6 motion_of(const Solver& solver, int body) {
  const std::size_t n = solver.model().particles.size(), i = static_cast<std::size_t>(body);
  if (i < n) {
    const ParticleState& s = solver.particles();
    return {s.position[i], s.velocity[i], s.angular_velocity[i]};
  }
  const BoundaryState& b = solver.boundaries()[i - n];
  return {b.position, b.velocity, b.angular_velocity};
}

}  // namespace

struct ContactHistory::PairForces {
  int a = 0, b = 0;
  int bearing = 0;  // patches
  std::array<Motion6, 2> motion;
  // On a and on b, by normal forces (0) and by friction with torsion and rolling (1).
  std::array<std::array<LoadOnBody, 2>, 2> push;

  PairForces without_forces() const {
    PairForces p;
    p.a = a;
    p.b = b;
    p.motion = motion;
    return p;
  }
  void add(const Contact& contact);  // one that bears

  // W, of the means of both ends of a step.
  double power(const PairForces& other, int kind) const {
    double sum = 0;
    for (int i : {0, 1}) {
      const LoadOnBody &p = push[kind][i], &q = other.push[kind][i];
      const Motion6 &m = motion[i], &n = other.motion[i];
      sum += 0.25 * (p.force + q.force).dot(m.velocity + n.velocity);
      sum += 0.25 * (p.moment + q.moment).dot(m.angular_velocity + n.angular_velocity);
    }
    return sum;
  }
};

const ContactHistory::PairForces* ContactHistory::find(const std::vector<PairForces>& pairs,
                                                       const PairForces& like) {
  for (const PairForces& p : pairs)
    if (p.a == like.a && p.b == like.b) return &p;
  return nullptr;
}

ContactHistory::ContactHistory(ContactSelection choice, std::uint64_t every)
    : choice_(choice), every_(std::max<std::uint64_t>(every, 1)) {}
ContactHistory::~ContactHistory() = default;

ContactHistory::PairForces ContactHistory::pair_of(const Solver& solver, const Contact& c) {
  PairForces pair;
  pair.a = c.a;
  pair.b = c.b;
  pair.motion[0] = motion_of(solver, c.a);
  pair.motion[1] = motion_of(solver, c.b);
  return pair;
}

void ContactHistory::PairForces::add(const Contact& c) {
  ++bearing;
  Vec3 lever[2] = {Vec3::Zero(), Vec3::Zero()};  // moments of the normal forces
  for (const ContactPointInfo& spot : c.points) {
    lever[0] -= (spot.position - motion[0].center).cross(spot.force * c.normal);
    lever[1] += (spot.position - motion[1].center).cross(spot.force * c.normal);
  }
  const Vec3 whole[2] = {c.moment_a, c.moment_b};
  for (int i : {0, 1}) {
    const double sign = i == 0 ? 1 : -1;
    push[0][i].force -= sign * c.normal_force * c.normal;
    push[0][i].moment += lever[i];
    push[1][i].force += sign * c.friction;
    push[1][i].moment += whole[i] - lever[i];
  }
}

void ContactHistory::add_step(const Solver& solver, bool last) {
  std::vector<PairForces> pairs;
  now_.time = solver.time();
  now_.step = solver.steps();
  now_.patches = now_.sliding = 0;
  now_.gap = now_.approach = now_.slip = kNaN;
  now_.normal_force = now_.friction_mobilization = 0;
  now_.force.setZero();
  Vec3 friction = Vec3::Zero();
  for (const ContactView& view : select_contacts(solver, choice_)) {
    const Contact& c = view.contact;
    if (pairs.empty() || pairs.back().a != c.a || pairs.back().b != c.b)
      pairs.push_back(pair_of(solver, c));
    if (std::isnan(now_.gap) || c.gap < now_.gap) {
      const Motion6 &a = pairs.back().motion[0], &b = pairs.back().motion[1];
      const Vec3 relative = a.velocity + a.angular_velocity.cross(c.position - a.center) -
                            b.velocity - b.angular_velocity.cross(c.position - b.center);
      now_.gap = c.gap;
      now_.approach = relative.dot(c.normal);
      now_.slip = (relative - now_.approach * c.normal).norm();
    }
    if (!view.is_active()) continue;
    pairs.back().add(c);
    ++now_.patches;
    now_.sliding += c.sliding;
    now_.normal_force += c.normal_force;
    now_.friction_mobilization = std::max(now_.friction_mobilization, view.friction_mobilization());
    now_.force += c.force;
    friction += c.friction;
  }
  now_.friction = friction.norm();
  now_.peak_normal_force = std::max(now_.peak_normal_force, now_.normal_force);
  if (begun_) {
    add_work(pairs, solver.model().timestep);
    note_events(solver, pairs);
  } else {
    first_step_ = solver.steps();
  }
  before_ = std::move(pairs);
  if (!begun_ || last || (solver.steps() - first_step_) % every_ == 0) {
    rows_.push_back(now_);
    now_.peak_normal_force = 0;
    now_.new_patches = now_.lost_patches = 0;
  }
  begun_ = true;
}

// A pair that is in one list alone bore nothing at the other end of the step; its bodies' motion
// there is taken to be the one known.
void ContactHistory::add_work(const std::vector<PairForces>& now, double timestep) {
  const auto add = [&](const PairForces& p, const PairForces& q) {
    now_.work_normal -= timestep * p.power(q, 0);
    now_.work_friction -= timestep * p.power(q, 1);
  };
  for (const PairForces& p : now) {
    const PairForces* before = find(before_, p);
    add(p, before ? *before : p.without_forces());
  }
  for (const PairForces& p : before_)
    if (!find(now, p)) add(p, p.without_forces());
}

void ContactHistory::note_events(const Solver& solver, const std::vector<PairForces>& now) {
  const auto note = [&](const PairForces& p, int before, int after) {
    if (before == after) return;
    events_.push_back({solver.time(), solver.steps(), p.a, p.b, before, after});
    now_.new_patches += std::max(0, after - before);
    now_.lost_patches += std::max(0, before - after);
  };
  for (const PairForces& p : now) {
    const PairForces* before = find(before_, p);
    note(p, before ? before->bearing : 0, p.bearing);
  }
  for (const PairForces& p : before_)
    if (!find(now, p)) note(p, p.bearing, 0);
}

void write_history_csv(const std::vector<HistoryRow>& rows, const std::string& file) {
  OutputFile out(file);
  out << "time_s,step,patches,sliding,gap_m,normal_force_N,peak_normal_force_N,friction_N,"
         "friction_mobilization_1,force_x_N,force_y_N,force_z_N,approach_m_per_s,slip_m_per_s,"
         "work_normal_J,work_friction_J,new_patches,lost_patches\n";
  for (const HistoryRow& r : rows) {
    out << fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", r.time, r.step,
                       r.patches, r.sliding, r.gap, r.normal_force, r.peak_normal_force, r.friction,
                       r.friction_mobilization, r.force.x(), r.force.y(), r.force.z(), r.approach,
                       r.slip, r.work_normal, r.work_friction, r.new_patches, r.lost_patches);
  }
  out.commit();
}

}  // namespace firn
