#include "solver/step/removed_bodies.h"

#include "solver/state/workspace.h"

namespace firn {

namespace {

// J, taken from the bodies by the present forces of a patch over `duration` (s). velocity: m/s, of
// a minus b, of their material points at the center of a. angular_velocity: rad/s, a minus b.
PatchWork work_at_constant_forces(const PairCoefficients& law, const ContactPatch& patch,
                                  const Vec3& rolling, const ContactPoint* points,
                                  const Vec3& velocity, const Vec3& angular_velocity,
                                  double duration) {
  PatchWork work{0, 0};
  if (!(patch.normal_force > 0)) return work;  // a patch that bears nothing does nothing
  const PatchMotion motion =
      patch_motion(to_vec(patch.normal), to_vec(velocity + angular_velocity.cross(patch.arm)),
                   to_vec(angular_velocity), duration);
  const double shares = sum_of_fractions(patch, points);
  for (std::uint32_t i = 0; i < patch.point_count; ++i) {
    const ContactPoint& p = points[i];
    const double pull = adhesion_of(law, p, p.gap, shares).force;
    work.normal += (p.force - pull) * closing_of(motion, p);
  }
  const Vec3 across = angular_velocity - patch.normal * angular_velocity.dot(patch.normal);
  work.friction = -duration * (dot(to_vec(patch.tangential), motion.slip) + rolling.dot(across)) -
                  patch.torsion * motion.turn;
  return work;
}

// A particle that is removed no longer moves, and the load takes nothing from it.
BodyMotion motion_under_last_load(const State& s, int body, bool is_removed_particle) {
  BodyMotion motion = s.motion[index(body)];
  if (is_removed_particle) motion.velocity = motion.angular_velocity = Vec3::Zero();
  return motion;
}

}  // namespace

void add_work_of_removed_bodies(const Model& model, const Workspace& w, State& s) {
  const int n = static_cast<int>(model.particles.size());
  for (std::size_t p = 0; p < s.pairs.size(); ++p) {
    const Pair& pair = s.pairs[p];
    const bool on_wall = pair.b >= n;
    const bool a_gone = s.presence[index(pair.a)] != Presence::present;
    const bool b_gone = on_wall ? !s.boundary_present[index(pair.b - n)]
                                : s.presence[index(pair.b)] != Presence::present;
    if (a_gone == b_gone) continue;
    const BodyMotion a = motion_under_last_load(s, pair.a, a_gone),
                     b = motion_under_last_load(s, pair.b, b_gone && !on_wall);
    const Vec3 closing = a.velocity - b.velocity;
    // The arms of the load are those at the start of the step.
    const Vec3 apart = a.position - b.position - model.timestep * closing;
    const Vec3 velocity = closing - b.angular_velocity.cross(apart);
    const Vec3 angular_velocity = a.angular_velocity - b.angular_velocity;
    PatchWork sum{0, 0};
    for (std::uint32_t k = pair.first_patch; k < pair.first_patch + pair.patch_count; ++k) {
      const ContactPatch& patch = s.patches[k];
      const PatchWork work = work_at_constant_forces(
          w.laws[index(pair.law)], patch, s.patch_details[k].rolling,
          s.points.data() + patch.first_point, velocity, angular_velocity, 0.5 * model.timestep);
      sum.normal += work.normal;
      sum.friction += work.friction;
    }
    s.work_normal += sum.normal;
    s.work_friction += sum.friction;
    if (on_wall) s.work_boundaries += sum.normal + sum.friction;
    if (s.statistics.open_of_pair.empty()) continue;  // no statistics of contacts, or none yet
    if (const std::int32_t open = s.statistics.open_of_pair[p]; open >= 0)
      s.statistics.sums[index(open)].work += sum.normal + sum.friction;
  }
}

}  // namespace firn
