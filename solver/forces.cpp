// Contact forces of all patches, summed per body in the order of the pairs, which is the same for
// any number of threads.
#include <fmt/format.h>

#include "solver/patch_block.h"
#include "solver/workspace.h"

namespace firn {

namespace {

constexpr std::size_t kBodiesOfTask = 128;

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

// What lies scattered of a pair further down the list: its later body, somewhere in a large bed.
[[gnu::always_inline]] inline void prefetch(const Workspace& w, const State& s, std::uint32_t p) {
  const std::int32_t b = w.ends[p][1];
  const auto* motion = reinterpret_cast<const char*>(&s.motion[b]);
  __builtin_prefetch(&s.pairs[p]);
  __builtin_prefetch(motion);
  __builtin_prefetch(motion + 64);
  if (static_cast<std::size_t>(b) < s.load.size()) __builtin_prefetch(&s.load[b], 1);
}

// Advances the patches of the active pairs of a range, block by block, and hands each block to
// `take`.
template <class Take>
void advance_patches(const Model& model, const Workspace& w, State& s,
                     const std::vector<std::uint32_t>& active, const Take& take) {
  PatchBlock block;
  const auto flush = [&] {
    block.advance(model.timestep);
    take(block);
    block.clear();
  };
  for (std::size_t k = 0; k < active.size(); ++k) {
    if (k + 8 < active.size()) prefetch(w, s, active[k + 8]);
    const Pair& pair = s.pairs[active[k]];
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

// The accounts of one range of pairs: what patches do beside pushing their bodies.
class Bookkeeper {
 public:
  Bookkeeper(const Model& model, const Workspace& w, const State& s, ContactAccounts& accounts)
      : w_(w),
        s_(s),
        accounts_(accounts),
        n_(static_cast<int>(model.particles.size())),
        dt_(model.timestep) {
    for (const std::int32_t wall : accounts.touched) accounts.walls[wall] = {};
    accounts.touched.clear();
    accounts.walls.resize(model.boundaries.size());
    accounts.work_walls = accounts.boundary_work = 0;
    accounts.largest_overlap = accounts.beyond_limit = 0;
  }

  [[gnu::always_inline]] void note(const PatchBlock& block, int k) {
    work_normal_ += block.work_normal(k);
    work_friction_ += block.work_friction(k);
    if (block.b(k) >= n_) note_wall(block.load(k));
    if (block.overlap(k) > overlap_ && block.normal_force(k) > 0) note_overlap(block.load(k));
  }

  void finish() {
    accounts_.work_normal = work_normal_;
    accounts_.work_friction = work_friction_;
  }

 private:
  [[gnu::noinline]] void note_wall(const PatchLoad& load) {
    const int b = load.b - n_;
    ContactAccounts::Wall& wall = accounts_.walls[b];
    if (!wall.touched) {
      wall.touched = true;
      accounts_.touched.push_back(b);
    }
    const Vec3 force = eigen(plain(load.force)), moment = eigen(plain(load.moment_b));
    const BodyMotion& motion = s_.motion[load.b];
    accounts_.work_walls += load.work_normal + load.work_friction;
    wall.impulse -= force * dt_;
    wall.angular_impulse += moment * dt_;
    wall.peak = std::max(wall.peak, load.normal);
    accounts_.boundary_work += dt_ * (force.dot(motion.velocity) - moment.dot(motion.spin));
  }

  [[gnu::noinline]] void note_overlap(const PatchLoad& load) {
    const double limit = w_.laws[load.law].overlap_limit;
    if (load.overlap > limit && accounts_.beyond_limit == 0) {
      accounts_.beyond_limit = load.overlap;
      accounts_.beyond_limit_particle = load.a;
      accounts_.limit = limit;
    }
    if (load.overlap > accounts_.largest_overlap) {
      accounts_.largest_overlap = load.overlap;
      accounts_.largest_overlap_particle = load.a;
    }
    overlap_ = std::min(accounts_.largest_overlap, w_.least_overlap_limit);
  }

  const Workspace& w_;
  const State& s_;
  ContactAccounts& accounts_;
  int n_;
  double dt_, work_normal_ = 0, work_friction_ = 0;
  double overlap_ = 0;  // m, what is no more need not be noted
};

void add_up(const ContactAccounts& accounts, double time, State& s) {
  if (accounts.beyond_limit > 0) {
    throw RunError(
        fmt::format("particle {} overlaps by {:.4g} m at {:.6g} s, beyond the limit of {:.4g} m",
                    accounts.beyond_limit_particle, accounts.beyond_limit, time, accounts.limit));
  }
  if (accounts.largest_overlap > s.health.largest_overlap) {
    s.health.largest_overlap = accounts.largest_overlap;
    s.health.largest_overlap_particle = accounts.largest_overlap_particle;
  }
  s.work_normal += accounts.work_normal;
  s.work_friction += accounts.work_friction;
  s.work_walls += accounts.work_walls;
  s.boundary_work += accounts.boundary_work;
  for (const std::int32_t b : accounts.touched) {
    const ContactAccounts::Wall& wall = accounts.walls[b];
    s.boundary_impulse[b] += wall.impulse;
    s.boundary_angular_impulse[b] += wall.angular_impulse;
    s.boundary_peak[b] = std::max(s.boundary_peak[b], wall.peak);
  }
}

// One thread adds each patch to its bodies as it comes.
void forces_of_one_thread(const Model& model, Workspace& w, State& s) {
  const int n = static_cast<int>(model.particles.size());
  std::fill(s.load.begin(), s.load.end(), BodyLoad{});
  const auto add = [&](const PatchBlock& block, int k) {
    const double normal = block.normal_force(k);
    if (!(normal > 0)) return;
    const int a = block.a(k), b = block.b(k);
    Four force, moment;
    get(&block.force(k), force);
    get(&block.moment_a(k), moment);
    add_to(&s.load[a].force, force);
    add_to(&s.load[a].torque, moment);
    s.peak_normal_force[a] = std::max(s.peak_normal_force[a], normal);
    if (b >= n) return;
    get(&block.moment_b(k), moment);
    add_to(&s.load[b].force, -force);
    add_to(&s.load[b].torque, moment);
    s.peak_normal_force[b] = std::max(s.peak_normal_force[b], normal);
  };
  for (PairRange& range : w.ranges) {
    Bookkeeper books(model, w, s, range.accounts);
    advance_patches(model, w, s, range.active, [&](const PatchBlock& block) {
      for (int k = 0; k < block.size(); ++k) {
        books.note(block, k);
        add(block, k);
      }
    });
    books.finish();
  }
}

// Several threads keep what the patches do, each at the patch's place...
void keep_loads(const Model& model, Workspace& w, State& s, PairRange& range) {
  Bookkeeper books(model, w, s, range.accounts);
  advance_patches(model, w, s, range.active, [&](const PatchBlock& block) {
    for (int k = 0; k < block.size(); ++k) {
      books.note(block, k);
      KeptLoad& kept = w.kept[block.place(k, s.patches.data())];
      copy_four(&block.force(k), &kept.force);
      copy_four(&block.moment_a(k), &kept.moment_a);
      copy_four(&block.moment_b(k), &kept.moment_b);
      kept.force.w = block.normal_force(k);
    }
  });
  books.finish();
}

// ... and then sum it up for each body, in the order in which one thread would.
void sum_loads(const Workspace& w, State& s, std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) {
    Four force = {0, 0, 0, 0}, torque = force, push, moment;
    double peak = s.peak_normal_force[i];
    const std::uint32_t* const pairs = w.touch.pairs.data() + w.touch.first[i];
    for (std::uint32_t k = 0; k < w.touch.count[i]; ++k) {
      const Pair& pair = s.pairs[pairs[k]];
      const bool is_a = static_cast<std::size_t>(pair.a) == i;
      for (std::uint32_t p = pair.first_patch; p < pair.first_patch + pair.patch_count; ++p) {
        const KeptLoad& kept = w.kept[p];
        const double normal = kept.force.w;
        if (!(normal > 0)) continue;
        get(&kept.force, push);
        get(is_a ? &kept.moment_a : &kept.moment_b, moment);
        force = is_a ? force + push : force - push;
        torque += moment;
        peak = std::max(peak, normal);
      }
    }
    force[3] = torque[3] = 0;
    put(force, &s.load[i].force);
    put(torque, &s.load[i].torque);
    s.peak_normal_force[i] = peak;
  }
}

}  // namespace

void contact_forces(const Model& model, Workspace& w, State& s) {
  const int threads = model.numerics.threads;
  if (threads <= 1) {
    forces_of_one_thread(model, w, s);
  } else {
    w.kept.resize(std::max(w.kept.size(), s.patches.size()));
    for_ranges(threads, w.ranges.size(), 1,
               [&](std::size_t begin, std::size_t) { keep_loads(model, w, s, w.ranges[begin]); });
    for_ranges(threads, s.load.size(), kBodiesOfTask,
               [&](std::size_t begin, std::size_t end) { sum_loads(w, s, begin, end); });
  }
  for (const PairRange& range : w.ranges) add_up(range.accounts, s.time, s);
}

}  // namespace firn
