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

// What advancing reads, as plain pointers: vectors' own would be read again after every wide store,
// which may be to anywhere as far as the compiler knows.
struct Tables {
  const Pair* pairs;
  const BodyMotion* motion;
  const BodyLoad* load;
  Patch* patches;
  ContactPoint* points;
  const PairLaw* laws;
  const std::array<std::int32_t, 2>* ends;
  std::size_t particles;

  Tables(const Workspace& w, State& s)
      : pairs(s.pairs.data()),
        motion(s.motion.data()),
        load(s.load.data()),
        patches(s.patches.data()),
        points(s.points.data()),
        laws(w.laws.data()),
        ends(w.ends.data()),
        particles(s.load.size()) {}

  // What lies scattered of a pair further down the list: its later body, somewhere in a large bed.
  [[gnu::always_inline]] void prefetch(std::uint32_t p) const {
    const std::int32_t b = ends[p][1];
    const auto* place = reinterpret_cast<const char*>(motion + b);
    __builtin_prefetch(pairs + p);
    __builtin_prefetch(place);
    __builtin_prefetch(place + 64);
    __builtin_prefetch(load + (static_cast<std::size_t>(b) < particles ? b : 0), 1);
  }
};

// Advances the patches of the active pairs of a range, block by block, and hands each block to
// `take`.
template <class Take>
void advance_patches(const Model& model, const Workspace& w, State& s,
                     const std::vector<std::uint32_t>& active, const Take& take) {
  const Tables t(w, s);
  const std::uint32_t* const list = active.data();
  const std::size_t count = active.size();
  PatchBlock block(s.patches.data(), s.rolling.data());
  const auto flush = [&] {
    block.advance(model.timestep);
    take(block);
    block.clear();
  };
  for (std::size_t k = 0; k < count; ++k) {
    if (k + 8 < count) t.prefetch(list[k + 8]);
    const Pair& pair = t.pairs[list[k]];
    PairMotion motion;
    pair_motion(t.motion[pair.a], t.motion[pair.b], motion);
    Patch* const end = t.patches + pair.first_patch + pair.patch_count;
    for (Patch* patch = t.patches + pair.first_patch; patch != end; ++patch) {
      block.add(pair.a, pair.b, pair.law, t.laws[pair.law], *patch, t.points + patch->first_point,
                motion);
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
    accounts.work_normal = accounts.work_friction = 0;
    accounts.work_walls = accounts.boundary_work = 0;
    accounts.largest_overlap = accounts.beyond_limit = 0;
  }

  void note(const PatchBlock& block) {
    double normal = accounts_.work_normal, friction = accounts_.work_friction;
    for (int k = 0; k < block.size(); ++k) {
      normal += block.work_normal(k);
      friction += block.work_friction(k);
    }
    accounts_.work_normal = normal;
    accounts_.work_friction = friction;
    for (int k = 0; k < block.size(); ++k) {
      if (block.b(k) >= n_) note_wall(block.load(k));
      if (block.overlap(k) > overlap_ && block.normal_force(k) > 0) note_overlap(block.load(k));
    }
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
      accounts_.beyond_limit_a = load.a;
      accounts_.beyond_limit_b = load.b;
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
  double dt_;
  double overlap_ = 0;  // m, what is no more need not be noted
};

void add_up(const Model& model, const ContactAccounts& accounts, State& s) {
  if (accounts.beyond_limit > 0) {
    throw RunError(fmt::format(
        "particle {} overlaps {} by {:.4g} m at {:.6g} s, beyond the limit of {:.4g} m: the "
        "contact "
        "is too soft for this speed or load; expected a stiffer one, or a higher overlap_limit",
        accounts.beyond_limit_a, name_of_body(model, accounts.beyond_limit_b),
        accounts.beyond_limit, s.time, accounts.limit));
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
  BodyLoad* const load = s.load.data();
  double* const peak = s.peak_normal_force.data();
  const auto add = [n, load, peak](const PatchBlock& block, int k) {
    const double normal = block.normal_force(k);
    if (!(normal > 0)) return;
    const int a = block.a(k), b = block.b(k);
    Four force, moment;
    get(&block.force(k), force);
    get(&block.moment_a(k), moment);
    add_to(&load[a].force, force);
    add_to(&load[a].torque, moment);
    peak[a] = std::max(peak[a], normal);
    if (b >= n) return;
    get(&block.moment_b(k), moment);
    add_to(&load[b].force, -force);
    add_to(&load[b].torque, moment);
    peak[b] = std::max(peak[b], normal);
  };
  for (PairRange& range : w.ranges) {
    Bookkeeper books(model, w, s, range.accounts);
    advance_patches(model, w, s, range.active, [&](const PatchBlock& block) {
      books.note(block);
      for (int k = 0; k < block.size(); ++k) add(block, k);
    });
  }
}

// Several threads keep what the patches do, each at the patch's place...
void keep_loads(const Model& model, Workspace& w, State& s, PairRange& range) {
  Bookkeeper books(model, w, s, range.accounts);
  KeptLoad* const all = w.kept.data();
  advance_patches(model, w, s, range.active, [&](const PatchBlock& block) {
    books.note(block);
    for (int k = 0; k < block.size(); ++k) {
      KeptLoad& kept = all[block.place(k)];
      copy_four(&block.force(k), &kept.force);
      copy_four(&block.moment_a(k), &kept.moment_a);
      copy_four(&block.moment_b(k), &kept.moment_b);
      kept.force.w = block.normal_force(k);
    }
  });
}

// ... and then sum it up for each body, in the order in which one thread would.
void sum_loads(const Workspace& w, State& s, std::size_t begin, std::size_t end) {
  const Pair* const all = s.pairs.data();
  for (std::size_t i = begin; i < end; ++i) {
    Four force = {0, 0, 0, 0}, torque = force, push, moment;
    double peak = s.peak_normal_force[i];
    const std::uint32_t* const pairs = w.touch.pairs.data() + w.touch.first[i];
    const std::uint32_t count = w.touch.count[i];
    for (std::uint32_t k = 0; k < count; ++k) {
      const Pair& pair = all[pairs[k]];
      const bool is_a = static_cast<std::size_t>(pair.a) == i;
      const KeptLoad* kept = w.kept.data() + pair.first_patch;
      for (const KeptLoad* const last = kept + pair.patch_count; kept != last; ++kept) {
        const double normal = kept->force.w;
        if (!(normal > 0)) continue;
        get(&kept->force, push);
        get(is_a ? &kept->moment_a : &kept->moment_b, moment);
        if (is_a)
          force += push;
        else
          force -= push;
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
  for (const PairRange& range : w.ranges) add_up(model, range.accounts, s);
}

}  // namespace firn
