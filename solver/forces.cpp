// Contact forces of all patches, summed per body in the order of the pairs, which is the same for
// any number of threads.
#include <fmt/format.h>

#include "solver/patch_block.h"
#include "solver/workspace.h"

namespace firn {

namespace {

constexpr std::size_t kGrain = 256;  // pairs a task

PairMotion pair_motion(const BodyMotion& a, const BodyMotion& b) {
  PairMotion out;
  const Vec spin_b = plain(b.spin);
  out.apart = plain(a.position) - plain(b.position);
  out.velocity = plain(a.velocity) - plain(b.velocity) - cross(spin_b, out.apart);
  out.spin = plain(a.spin) - spin_b;
  return out;
}

// Advances the patches of active pairs [begin, end), block by block, and hands each block to
// `take`.
template <class Take>
void advance_patches(const Model& model, const Workspace& w, State& s, std::size_t begin,
                     std::size_t end, const Take& take) {
  PatchBlock block;
  const auto flush = [&] {
    block.advance(model.timestep);
    take(block);
    block.clear();
  };
  for (std::size_t k = begin; k < end; ++k) {
    if (k + 8 < end) {
      __builtin_prefetch(&s.pairs[w.active[k + 8]]);
      __builtin_prefetch(&s.motion[w.ends[w.active[k + 8]][1]]);
    }
    const Pair& pair = s.pairs[w.active[k]];
    const PairMotion motion = pair_motion(s.motion[pair.a], s.motion[pair.b]);
    for (std::uint32_t i = 0; i < pair.patch_count; ++i) {
      Patch& patch = s.patches[pair.first_patch + i];
      block.add(pair.a, pair.b, pair.law, w.laws[pair.law], patch,
                s.points.data() + patch.first_point, motion);
      if (block.full()) flush();
    }
  }
  if (block.size() > 0) flush();
}

[[noreturn]] void fail_by_overlap(double time, const PatchLoad& load, double limit) {
  throw RunError(
      fmt::format("particle {} overlaps by {:.4g} m at {:.6g} s, beyond the limit of {:.4g} m",
                  load.a, load.overlap, time, limit));
}

// Adds what patches do to their bodies and to the accounts. The accounts are kept here, in
// registers, and written back at the end.
class Sums {
 public:
  Sums(const Model& model, const Workspace& w, State& s)
      : w_(w),
        s_(s),
        n_(static_cast<int>(model.particles.size())),
        dt_(model.timestep),
        work_normal_(s.work_normal),
        work_friction_(s.work_friction) {
    std::fill(s.force.begin(), s.force.end(), Vec3::Zero());
    std::fill(s.torque.begin(), s.torque.end(), Vec3::Zero());
  }

  [[gnu::always_inline]] void add(const PatchLoad& load) {
    work_normal_ += load.work_normal;
    work_friction_ += load.work_friction;
    if (load.b >= n_) add_to_boundary(load);
    if (!(load.normal > 0)) return;
    const Vec3 force = eigen(load.force);
    s_.force[load.a] += force;
    s_.torque[load.a] += eigen(load.moment_a);
    double& peak = s_.peak_normal_force[load.a];
    peak = std::max(peak, load.normal);
    if (load.b < n_) {
      s_.force[load.b] -= force;
      s_.torque[load.b] += eigen(load.moment_b);
      double& other = s_.peak_normal_force[load.b];
      other = std::max(other, load.normal);
    }
    if (load.overlap > least_to_report_) report_overlap(load);
  }

  void finish() {
    s_.work_normal = work_normal_;
    s_.work_friction = work_friction_;
  }

 private:
  // By value, and out of line: an address taken here would keep every load out of registers.
  [[gnu::noinline]] void add_to_boundary(PatchLoad load) {
    const int b = load.b - n_;
    const Vec3 force = eigen(load.force), moment = eigen(load.moment_b);
    const BodyMotion& wall = s_.motion[load.b];
    s_.work_walls += load.work_normal + load.work_friction;
    s_.boundary_impulse[b] -= force * dt_;
    s_.boundary_angular_impulse[b] += moment * dt_;
    s_.boundary_peak[b] = std::max(s_.boundary_peak[b], load.normal);
    s_.boundary_work += dt_ * (force.dot(wall.velocity) - moment.dot(wall.spin));
  }

  [[gnu::noinline]] void report_overlap(PatchLoad load) {
    const double limit = w_.laws[load.law].overlap_limit;
    if (load.overlap > limit) fail_by_overlap(s_.time, load, limit);
    if (load.overlap > s_.health.largest_overlap) {
      s_.health.largest_overlap = load.overlap;
      s_.health.largest_overlap_particle = load.a;
    }
    least_to_report_ = std::min(s_.health.largest_overlap, w_.least_overlap_limit);
  }

  const Workspace& w_;
  State& s_;
  int n_;
  double dt_, work_normal_, work_friction_;
  double least_to_report_ = 0;  // m
};

}  // namespace

void contact_forces(const Model& model, Workspace& w, State& s) {
  Sums sums(model, w, s);
  const std::size_t pairs = w.active.size();
  if (model.numerics.threads <= 1) {
    advance_patches(model, w, s, 0, pairs, [&](const PatchBlock& block) {
      for (int k = 0; k < block.size(); ++k) sums.add(block.load(k));
    });
    sums.finish();
    return;
  }
  w.loads.resize((pairs + kGrain - 1) / kGrain);
  for_chunks(model.numerics.threads, pairs, kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<PatchLoad>& loads = w.loads[begin / kGrain];
    loads.clear();
    advance_patches(model, w, s, begin, end, [&](const PatchBlock& block) {
      for (int k = 0; k < block.size(); ++k) loads.push_back(block.load(k));
    });
  });
  for (const auto& loads : w.loads) {
    for (const PatchLoad& load : loads) sums.add(load);
  }
  sums.finish();
}

}  // namespace firn
