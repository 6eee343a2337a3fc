// Contact forces of all patches, and their sums per body in a fixed order.
#include "solver/workspace.h"

namespace firn {

namespace {

constexpr std::size_t kGrain = 256;  // pairs a task

void pair_load(const State& s, const PairLaw& law, const Pair& pair, Patch* patches,
               ContactPoint* points, double dt, PairLoad& out) {
  const BodyMotion& a = s.motion[pair.a];
  const BodyMotion& b = s.motion[pair.b];
  const Vec3 apart = a.position - b.position;
  RelativeMotion motion;
  motion.spin = a.spin - b.spin;
  out = PairLoad{};
  for (std::uint32_t k = 0; k < pair.patch_count; ++k) {
    Patch& patch = patches[pair.first_patch + k];
    const Vec3& arm_a = patch.arm;
    const Vec3 arm_b = arm_a + apart;
    motion.velocity = a.velocity - b.velocity + a.spin.cross(arm_a) - b.spin.cross(arm_b);
    const PatchLoad load = advance_patch(law, patch, points + patch.first_point, motion, dt);
    out.work_normal += load.work_normal;
    out.work_friction += load.work_friction;
    if (load.normal_force <= 0) continue;
    out.force += load.force;
    out.moment_a += arm_a.cross(load.force) + load.moment;
    out.moment_b -= arm_b.cross(load.force) + load.moment;
    out.peak = std::max(out.peak, load.normal_force);
    out.overlap = std::max(out.overlap, load.overlap);
  }
}

}  // namespace

void contact_forces(const Model& model, Workspace& w, State& s) {
  w.loads.resize(w.active.size());
  for_chunks(model.numerics.threads, w.active.size(), kGrain,
             [&](std::size_t begin, std::size_t end) {
               for (std::size_t k = begin; k < end; ++k) {
                 const Pair& pair = s.pairs[w.active[k]];
                 pair_load(s, w.laws[pair.law], pair, s.patches.data(), s.points.data(),
                           model.timestep, w.loads[k]);
               }
             });
}

void sum_forces(const Model& model, const Workspace& w, State& s) {
  const int n = static_cast<int>(model.particles.size());
  const double dt = model.timestep;
  std::fill(s.force.begin(), s.force.end(), Vec3::Zero());
  std::fill(s.torque.begin(), s.torque.end(), Vec3::Zero());
  for (std::size_t k = 0; k < w.active.size(); ++k) {
    const Pair& pair = s.pairs[w.active[k]];
    const PairLoad& load = w.loads[k];
    s.work_normal += load.work_normal;
    s.work_friction += load.work_friction;
    s.force[pair.a] += load.force;
    s.torque[pair.a] += load.moment_a;
    s.peak_normal_force[pair.a] = std::max(s.peak_normal_force[pair.a], load.peak);
    if (pair.b < n) {
      s.force[pair.b] -= load.force;
      s.torque[pair.b] += load.moment_b;
      s.peak_normal_force[pair.b] = std::max(s.peak_normal_force[pair.b], load.peak);
    } else {
      const int b = pair.b - n;
      s.work_walls += load.work_normal + load.work_friction;
      s.boundary_impulse[b] -= load.force * dt;
      s.boundary_angular_impulse[b] += load.moment_b * dt;
      s.boundary_peak[b] = std::max(s.boundary_peak[b], load.peak);
      const BodyMotion& wall = s.motion[pair.b];
      s.boundary_work += dt * (load.force.dot(wall.velocity) - load.moment_b.dot(wall.spin));
    }
    if (load.overlap > s.health.largest_overlap) {
      s.health.largest_overlap = load.overlap;
      s.health.largest_overlap_particle = pair.a;
    }
  }
}

}  // namespace firn
