// Contact forces of all patches, summed per body in the order of the pairs, which is the same for
// any number of threads.
#include <fmt/format.h>

#include "solver/patch_block.h"
#include "solver/workspace.h"

namespace firn {

namespace {

constexpr std::size_t kGrain = 256;  // pairs a task

// a x b; the fourth number is zero.
[[gnu::always_inline]] inline void cross(const Four& a, const Four& b, Four& out) {
  const Four twisted =
      a * __builtin_shufflevector(b, b, 1, 2, 0, 3) - __builtin_shufflevector(a, a, 1, 2, 0, 3) * b;
  out = __builtin_shufflevector(twisted, twisted, 1, 2, 0, 3);
}
[[gnu::always_inline]] inline void add_to(void* sum, const Four& v) {
  Four s;
  get(sum, s);
  put(s + v, sum);
}

[[gnu::always_inline]] inline void pair_motion(const BodyMotion& a, const BodyMotion& b,
                                               PairMotion& out) {
  Four place_a, place_b, velocity_a, velocity_b, spin_a, spin_b, dragged;
  get(&a.position, place_a);
  get(&b.position, place_b);
  get(&a.velocity, velocity_a);
  get(&b.velocity, velocity_b);
  get(&a.spin, spin_a);
  get(&b.spin, spin_b);
  const Four apart = place_a - place_b;
  cross(spin_b, apart, dragged);
  put(apart, &out.apart);
  put(velocity_a - velocity_b - dragged, &out.velocity);
  put(spin_a - spin_b, &out.spin);
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
    PairMotion motion;
    pair_motion(s.motion[pair.a], s.motion[pair.b], motion);
    for (std::uint32_t i = 0; i < pair.patch_count; ++i) {
      Patch& patch = s.patches[pair.first_patch + i];
      block.add(pair.a, pair.b, pair.law, w.laws[pair.law], patch,
                s.points.data() + patch.first_point, motion);
      if (block.full()) flush();
    }
  }
  if (block.size() > 0) flush();
}

// Loads that tasks have left, read as a block is.
struct KeptLoads {
  const std::vector<PatchLoad>& all;
  std::int32_t a(int k) const { return all[k].a; }
  std::int32_t b(int k) const { return all[k].b; }
  const Quad& force(int k) const { return all[k].force; }
  const Quad& moment_a(int k) const { return all[k].moment_a; }
  const Quad& moment_b(int k) const { return all[k].moment_b; }
  double normal_force(int k) const { return all[k].normal; }
  double overlap(int k) const { return all[k].overlap; }
  double work_normal(int k) const { return all[k].work_normal; }
  double work_friction(int k) const { return all[k].work_friction; }
  const PatchLoad& load(int k) const { return all[k]; }
};

[[noreturn]] void fail_by_overlap(const Model& model, double time, const PatchLoad& load,
                                  double limit) {
  throw RunError(fmt::format(
      "particle {} overlaps {} by {:.4g} m at {:.6g} s, beyond the limit of {:.4g} m: the contact "
      "is too soft for this speed or load; expected a stiffer one, or a higher overlap_limit",
      load.a, name_of_body(model, load.b), load.overlap, time, limit));
}

// Adds what patches do to their bodies and to the accounts. The accounts are kept here, in
// registers, and written back at the end.
class Sums {
 public:
  Sums(const Model& model, const Workspace& w, State& s)
      : model_(model),
        w_(w),
        s_(s),
        n_(static_cast<int>(model.particles.size())),
        dt_(model.timestep),
        work_normal_(s.work_normal),
        work_friction_(s.work_friction) {
    std::fill(s.load.begin(), s.load.end(), BodyLoad{});
  }

  // `Loads` is a block or a list of kept loads.
  template <class Loads>
  [[gnu::always_inline]] void add(const Loads& loads, int k) {
    const int a = loads.a(k), b = loads.b(k);
    work_normal_ += loads.work_normal(k);
    work_friction_ += loads.work_friction(k);
    if (b >= n_) add_to_boundary(loads.load(k));
    const double normal = loads.normal_force(k);
    if (!(normal > 0)) return;
    Four force, moment;
    get(&loads.force(k), force);
    get(&loads.moment_a(k), moment);
    add_to(&s_.load[a].force, force);
    add_to(&s_.load[a].torque, moment);
    s_.peak_normal_force[a] = std::max(s_.peak_normal_force[a], normal);
    if (b < n_) {
      get(&loads.moment_b(k), moment);
      add_to(&s_.load[b].force, -force);
      add_to(&s_.load[b].torque, moment);
      s_.peak_normal_force[b] = std::max(s_.peak_normal_force[b], normal);
    }
    if (loads.overlap(k) > least_to_report_) report_overlap(loads.load(k));
  }

  void finish() {
    s_.work_normal = work_normal_;
    s_.work_friction = work_friction_;
  }

 private:
  [[gnu::noinline]] void add_to_boundary(const PatchLoad& load) {
    const int b = load.b - n_;
    const Vec3 force = eigen(plain(load.force)), moment = eigen(plain(load.moment_b));
    const BodyMotion& wall = s_.motion[load.b];
    s_.work_walls += load.work_normal + load.work_friction;
    s_.boundary_impulse[b] -= force * dt_;
    s_.boundary_angular_impulse[b] += moment * dt_;
    s_.boundary_peak[b] = std::max(s_.boundary_peak[b], load.normal);
    s_.boundary_work += dt_ * (force.dot(wall.velocity) - moment.dot(wall.spin));
  }

  [[gnu::noinline]] void report_overlap(const PatchLoad& load) {
    const double limit = w_.laws[load.law].overlap_limit;
    if (load.overlap > limit) fail_by_overlap(model_, s_.time, load, limit);
    if (load.overlap > s_.health.largest_overlap) {
      s_.health.largest_overlap = load.overlap;
      s_.health.largest_overlap_particle = load.a;
    }
    least_to_report_ = std::min(s_.health.largest_overlap, w_.least_overlap_limit);
  }

  const Model& model_;
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
      for (int k = 0; k < block.size(); ++k) sums.add(block, k);
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
    const KeptLoads kept{loads};
    for (std::size_t k = 0; k < loads.size(); ++k) sums.add(kept, static_cast<int>(k));
  }
  sums.finish();
}

}  // namespace firn
