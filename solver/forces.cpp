// Contact forces of all patches, summed per body: first within each range of pairs, then over the
// ranges, in an order that is the same for any number of threads.
#include <fmt/format.h>

#include <algorithm>

#include "solver/fetch.h"
#include "solver/patch_block.h"
#include "solver/workspace.h"

namespace firn {

namespace {

constexpr std::ptrdiff_t kAhead = 12;  // pairs, whose bodies and contacts are fetched
constexpr std::size_t kPoints = 128;   // bytes: what most pairs have

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

ActivePair active_pair(const PairRange& range, const State& s, std::uint32_t p) {
  const Pair& pair = s.pairs[p];
  const auto [local_a, local_b] = range.locals[p % kPairsOfRange];
  return {p,      pair.first_patch, pair.patch_count, pair.first_point, pair.a,
          pair.b, pair.law,         local_a,          local_b};
}

// The active pairs of a range after some have been looked at.
void update_active(const State& s, std::size_t begin, std::size_t end, PairRange& range) {
  if (range.active_is_stale) {
    range.active.clear();
    for (std::size_t p = begin; p < end; ++p) {
      if (s.pairs[p].patch_count > 0)
        range.active.push_back(active_pair(range, s, static_cast<std::uint32_t>(p)));
    }
    range.active_is_stale = false;
    return;
  }
  if (range.refreshed.empty()) return;
  std::vector<ActivePair>& merged = range.spare_active;
  merged.clear();
  auto old = range.active.begin();
  for (const std::uint32_t p : range.refreshed) {
    for (; old != range.active.end() && old->pair < p; ++old) merged.push_back(*old);
    if (old != range.active.end() && old->pair == p) ++old;
    if (s.pairs[p].patch_count > 0) merged.push_back(active_pair(range, s, p));
  }
  merged.insert(merged.end(), old, range.active.end());
  std::swap(range.active, merged);
}

// Advances the patches of the active pairs of a range, block by block, and hands each block to
// `take`. Loads from `next_loads` on, of the next range, are fetched on the way.
template <class Take>
void advance_patches(const Model& model, const Workspace& w, State& s,
                     const std::vector<ActivePair>& active, const RangeLoad* next_loads,
                     const Take& take) {
  // Plain pointers: vectors' own would be read again after every wide store, which may be to
  // anywhere as far as the compiler knows.
  const BodyMotion* const motions = s.motion.data();
  const PairLaw* const laws = w.laws.data();
  Patch* const patches = s.patches.data();
  const ActivePair* const end = active.data() + active.size();
  ContactPoint* const points = s.points.data();
  PatchBlock block(patches, s.rolling.data(), static_cast<std::int32_t>(model.particles.size()));
  // Not inlined, as it would push out of the registers what the loop needs.
  const auto flush = [&]() __attribute__((noinline)) {
    block.advance(model.timestep);
    take(block);
    block.clear();
  };
  for (const ActivePair* pair = active.data(); pair != end; ++pair) {
    if (end - pair > kAhead) {
      fetch(motions + pair[kAhead].a);
      fetch(motions + pair[kAhead].b);
      fetch(patches + pair[kAhead].first_patch);
      fetch_bytes(points + pair[kAhead].first_point, kPoints);
    }
    // A range has about half as many bodies as active pairs.
    __builtin_prefetch(next_loads + (pair - active.data()) / 2, 1);
    PairMotion motion;
    pair_motion(motions[pair->a], motions[pair->b], motion);
    Patch* const last = patches + pair->first_patch + pair->patch_count;
    for (Patch* patch = patches + pair->first_patch; patch != last; ++patch) {
      block.add(*pair, laws[pair->law], *patch, points + patch->first_point, motion);
      if (block.full()) flush();
    }
  }
  if (block.size() > 0) flush();
}

// Patches come in the order of the active pairs.
void note_work(const PatchBlock& block, std::vector<PatchWork>& work) {
  for (int k = 0; k < block.size(); ++k)
    work.push_back({block.work_normal(k), block.work_friction(k)});
}

// The accounts of one range of pairs: what patches do beside pushing their bodies.
class Bookkeeper {
 public:
  Bookkeeper(const Model& model, const Workspace& w, const State& s, ContactAccounts& accounts)
      : w_(w),
        s_(s),
        accounts_(accounts),
        n_(static_cast<int>(model.particles.size())),
        dt_(model.timestep),
        overlap_(std::min(s.health.largest_overlap, w.least_overlap_limit)) {
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
    for (const int k : block.at_boundary()) note_wall(block.load(k));
    if (block.deepest() > overlap_) note_overlaps(block);
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

  [[gnu::noinline]] void note_overlaps(const PatchBlock& block) {
    for (int k = 0; k < block.size(); ++k) {
      const double overlap = block.overlap(k);
      if (overlap > overlap_ && block.normal_force(k) > 0) note_overlap(block.load(k), overlap);
    }
  }

  void note_overlap(const PatchLoad& load, double overlap) {
    const double limit = w_.laws[load.law].overlap_limit;
    if (overlap > limit && accounts_.beyond_limit == 0) {
      accounts_.beyond_limit = overlap;
      accounts_.beyond_limit_a = load.a;
      accounts_.beyond_limit_b = load.b;
      accounts_.limit = limit;
    }
    if (overlap > accounts_.largest_overlap) {
      accounts_.largest_overlap = overlap;
      accounts_.largest_overlap_particle = load.a;
    }
    overlap_ = std::min(std::max(overlap_, accounts_.largest_overlap), w_.least_overlap_limit);
  }

  const Workspace& w_;
  const State& s_;
  ContactAccounts& accounts_;
  int n_;
  double dt_;
  double overlap_;  // m, what is no more need not be noted
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
    s.boundary_load[b].force += wall.impulse / model.timestep;
    s.boundary_load[b].torque += wall.angular_impulse / model.timestep;
  }
}

// Adds a force to that on a body, or takes it away; the fourth number keeps the largest normal
// force. Written as a whole, as it is read again soon.
template <int sign>
[[gnu::always_inline]] inline void push(const Four& force, RangeLoad& load) {
  Four so_far;
  get(&load.force, so_far);
  const Four sum = so_far + sign * force, largest = so_far < force ? force : so_far;
  put(__builtin_shufflevector(sum, largest, 0, 1, 2, 7), &load.force);
}

// Adds what a block does to the loads of a range's bodies; what bears nothing adds zeros.
void add_loads(const PatchBlock& block, RangeLoad* loads) {
  for (int k = 0; k < block.size(); ++k) {
    RangeLoad &a = loads[block.local_a(k)], &b = loads[block.local_b(k)];
    Four force, moment;
    get(&block.force(k), force);
    push<1>(force, a);
    push<-1>(force, b);
    get(&block.moment_a(k), moment);
    add_to(&a.torque, moment);
    get(&block.moment_b(k), moment);
    add_to(&b.torque, moment);
  }
}

}  // namespace

void contact_forces(const Model& model, Workspace& w, State& s) {
  const bool noted = model.statistics.any();
  const bool in_turn = goes_on(model.numerics.threads, s.pairs.size(), kPairsOfRange);
  for_ranges(
      model.numerics.threads, s.pairs.size(), kPairsOfRange,
      [&](std::size_t begin, std::size_t end) {
        PairRange& range = w.ranges[begin / kPairsOfRange];
        range.notes.work.clear();
        update_active(s, begin, end, range);
        RangeLoad* const loads = w.loads.data() + range.first_load;
        std::fill_n(loads, range.bodies.size(), RangeLoad{});
        Bookkeeper books(model, w, s, range.accounts);
        const auto take = [&](const PatchBlock& block) {
          books.note(block);
          add_loads(block, loads);
          if (noted) note_work(block, range.notes.work);
        };
        // The next range's lie behind these.
        const RangeLoad* const next = in_turn ? loads + range.bodies.size() : loads;
        advance_patches(model, w, s, range.active, next, take);
      },
      &w.pair_shares);
  std::ranges::fill(s.boundary_load, BodyLoad{});
  for (const PairRange& range : w.ranges) add_up(model, range.accounts, s);
}

}  // namespace firn
