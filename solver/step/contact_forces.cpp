// Contact forces of all patches, summed per body: first within each range of pairs, then over the
// ranges, in an order that is the same for any number of threads.
#include "solver/step/contact_forces.h"

#include <fmt/format.h>

#include <algorithm>

#include "solver/contact/contact_law_batch.h"
#include "solver/core/prefetch.h"
#include "solver/state/workspace.h"

namespace firn {

namespace {

constexpr std::ptrdiff_t kPairsAhead = 12;  // pairs, whose bodies and contacts are fetched
constexpr std::size_t kPoints = 128;        // bytes: what most pairs have

// a x b; the fourth number is zero.
[[gnu::always_inline]] inline void cross(const Simd4d& a, const Simd4d& b, Simd4d& out) {
  const Simd4d twisted =
      a * __builtin_shufflevector(b, b, 1, 2, 0, 3) - __builtin_shufflevector(a, a, 1, 2, 0, 3) * b;
  out = __builtin_shufflevector(twisted, twisted, 1, 2, 0, 3);
}
[[gnu::always_inline]] inline void add_to(void* sum, const Simd4d& v) {
  Simd4d s;
  get(sum, s);
  put(s + v, sum);
}

[[gnu::always_inline]] inline void pair_motion(const BodyMotion& a, const BodyMotion& b,
                                               PairMotion& out) {
  Simd4d place_a, place_b, velocity_a, velocity_b, angular_velocity_a, angular_velocity_b, dragged;
  get(&a.position, place_a);
  get(&b.position, place_b);
  get(&a.velocity, velocity_a);
  get(&b.velocity, velocity_b);
  get(&a.angular_velocity, angular_velocity_a);
  get(&b.angular_velocity, angular_velocity_b);
  const Simd4d apart = place_a - place_b;
  cross(angular_velocity_b, apart, dragged);
  put(apart, &out.apart);
  put(velocity_a - velocity_b - dragged, &out.velocity);
  put(angular_velocity_a - angular_velocity_b, &out.angular_velocity);
}

// Replaces pairs of `active` by those refreshed, both ascending. Whether these are the same pairs;
// if not, some may have been replaced.
bool replace(const std::vector<ActivePair>& refreshed, std::vector<ActivePair>& active) {
  auto at = active.begin();
  for (const ActivePair& fresh : refreshed) {
    while (at != active.end() && at->pair < fresh.pair) ++at;
    const bool is_there = at != active.end() && at->pair == fresh.pair;
    if (is_there != (fresh.patch_count > 0)) return false;
    if (is_there) *at = fresh;
  }
  return true;
}

// The active pairs of range `r` after some have been looked at.
void update_active(const State& s, std::size_t r, PairBlock& range,
                   std::vector<ActivePair>& merged) {
  if (range.active_is_stale) {
    range.active.clear();
    const std::size_t begin = r * kPairsPerBlock;
    for (std::size_t p = begin; p < std::min(s.pairs.size(), begin + kPairsPerBlock); ++p) {
      if (s.pairs[p].patch_count > 0)
        range.active.push_back(active_pair(range, s, static_cast<std::uint32_t>(p)));
    }
    range.active_is_stale = false;
    return;
  }
  if (replace(range.refreshed, range.active)) return;
  merged.clear();
  auto old = range.active.begin();
  for (const ActivePair& fresh : range.refreshed) {
    for (; old != range.active.end() && old->pair < fresh.pair; ++old) merged.push_back(*old);
    if (old != range.active.end() && old->pair == fresh.pair) ++old;
    if (fresh.patch_count > 0) merged.push_back(fresh);
  }
  merged.insert(merged.end(), old, range.active.end());
  std::swap(range.active, merged);
}

// Advances the patches of the active pairs of a range, block by block, and hands each block to
// `take`. What the next range, if it is this task's, will need is fetched on the way.
template <class Take>
void advance_patches(const Model& model, const Workspace& w, State& s, const PairBlock& range,
                     const PairBlock* next, const Take& take) {
  // Plain pointers: vectors' own would be read again after every wide store, which may be to
  // anywhere as far as the compiler knows.
  const BodyMotion* const motions = s.motion.data();
  const PairCoefficients* const laws = w.laws.data();
  ContactPatch* const patches = s.patches.data();
  const ActivePair* const begin = range.active.data();
  const ActivePair* const end = begin + range.active.size();
  const BlockLoad* const next_loads = w.loads.data() + (next ? *next : range).first_load;
  const std::span<const ActivePair> next_active(next ? next->active : range.active);
  ContactPoint* const points = s.points.data();
  PatchBlock block(patches, s.patch_details.data(),
                   static_cast<std::int32_t>(model.particles.size()));
  // Not inlined, as it would push out of the registers what the loop needs.
  const auto flush = [&]() __attribute__((noinline)) {
    block.advance(model.timestep);
    take(block);
    block.clear();
  };
  const auto prefetch_contacts = [&](const ActivePair& pair) __attribute__((always_inline)) {
    prefetch<Cache::first>(motions + pair.a);
    prefetch<Cache::first>(motions + pair.b);
    prefetch<Cache::first>(patches + pair.first_patch);
    prefetch_bytes<Cache::first>(points + pair.first_point, kPoints);
  };
  for (const ActivePair* pair = begin; pair != end; ++pair) {
    if (end - pair > kPairsAhead) prefetch_contacts(pair[kPairsAhead]);
    const auto k = static_cast<std::size_t>(pair - begin);
    __builtin_prefetch(next_loads + k / 2, 1);  // about half as many as active pairs
    if (k < next_active.size()) prefetch(&next_active[k]);
    PairMotion motion;
    pair_motion(motions[pair->a], motions[pair->b], motion);
    ContactPatch* const last = patches + pair->first_patch + pair->patch_count;
    for (ContactPatch* patch = patches + pair->first_patch; patch != last; ++patch) {
      block.add(*pair, laws[pair->law], *patch, points + patch->first_point, motion);
      if (block.full()) flush();
    }
  }
  if (block.size() > 0) flush();
  if (next) {
    for (std::size_t k = 0; k < std::min<std::size_t>(kPairsAhead, next_active.size()); ++k)
      prefetch_contacts(next_active[k]);
  }
}

// Patches come in the order of the active pairs.
void note_work(const PatchBlock& block, std::vector<PatchWork>& work) {
  for (int k = 0; k < block.size(); ++k)
    work.push_back({block.work_normal(k), block.work_friction(k)});
}

// Sums over one range of pairs in addition to the forces on bodies.
class ContactAccumulator {
 public:
  ContactAccumulator(const Model& model, const Workspace& w, const State& s,
                     ContactTotals& accounts)
      : w_(w),
        s_(s),
        accounts_(accounts),
        n_(static_cast<int>(model.particles.size())),
        dt_(model.timestep),
        overlap_(std::min(s.diagnostics.largest_overlap, w.least_overlap_limit)) {
    for (const std::int32_t wall : accounts.touched) accounts.walls[wall] = {};
    accounts.touched.clear();
    accounts.walls.resize(model.boundaries.size());
    accounts.work_normal = accounts.work_friction = 0;
    accounts.work_boundaries = accounts.boundary_work = 0;
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
    ContactTotals::Wall& wall = accounts_.walls[b];
    if (!wall.touched) {
      wall.touched = true;
      accounts_.touched.push_back(b);
    }
    const Vec3 force = to_eigen(to_vec(load.force)), moment = to_eigen(to_vec(load.moment_b));
    const BodyMotion& motion = s_.motion[load.b];
    accounts_.work_boundaries += load.work_normal + load.work_friction;
    wall.impulse -= force * dt_;
    wall.angular_impulse += moment * dt_;
    wall.peak = std::max(wall.peak, load.normal);
    accounts_.boundary_work +=
        dt_ * (force.dot(motion.velocity) - moment.dot(motion.angular_velocity));
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
  ContactTotals& accounts_;
  int n_;
  double dt_;
  double overlap_;  // m, what is no more need not be noted
};

void add_up(const Model& model, const ContactTotals& accounts, State& s) {
  if (accounts.beyond_limit > 0) {
    throw RunError(fmt::format(
        "particle {} overlaps {} by {:.4g} m at {:.6g} s, beyond the limit of {:.4g} m: the "
        "contact "
        "is too soft for this speed or load; expected a stiffer one, or a higher overlap_limit",
        accounts.beyond_limit_a, name_of_body(model, accounts.beyond_limit_b),
        accounts.beyond_limit, s.time, accounts.limit));
  }
  if (accounts.largest_overlap > s.diagnostics.largest_overlap) {
    s.diagnostics.largest_overlap = accounts.largest_overlap;
    s.diagnostics.largest_overlap_particle = accounts.largest_overlap_particle;
  }
  s.work_normal += accounts.work_normal;
  s.work_friction += accounts.work_friction;
  s.work_boundaries += accounts.work_boundaries;
  s.boundary_work += accounts.boundary_work;
  for (const std::int32_t b : accounts.touched) {
    const ContactTotals::Wall& wall = accounts.walls[b];
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
[[gnu::always_inline]] inline void push(const Simd4d& force, BlockLoad& load) {
  Simd4d so_far;
  get(&load.force, so_far);
  const Simd4d sum = so_far + sign * force, largest = so_far < force ? force : so_far;
  put(__builtin_shufflevector(sum, largest, 0, 1, 2, 7), &load.force);
}

// Adds what a block does to the loads of a range's bodies; what bears nothing adds zeros.
void add_loads(const PatchBlock& block, BlockLoad* loads) {
  for (int k = 0; k < block.size(); ++k) {
    BlockLoad &a = loads[block.local_a(k)], &b = loads[block.local_b(k)];
    Simd4d force, moment;
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
  const auto forces_of = [&](std::size_t r, const PairBlock* next, std::vector<ActivePair>& spare) {
    PairBlock& range = w.ranges[r];
    range.notes.work.clear();
    update_active(s, r, range, spare);
    BlockLoad* const loads = w.loads.data() + range.first_load;
    std::fill_n(loads, range.bodies.size(), BlockLoad{});
    ContactAccumulator books(model, w, s, range.accounts);
    advance_patches(model, w, s, range, next, [&](const PatchBlock& block) {
      books.note(block);
      add_loads(block, loads);
      if (noted) note_work(block, range.notes.work);
    });
  };
  parallel_for_blocks(
      w.threads, w.ranges.size(), w.blocks_per_task,
      [&](std::size_t first, std::size_t last) {
        std::vector<ActivePair>& spare = w.scratch[first / w.blocks_per_task].active;
        for (std::size_t r = first; r < last; ++r)
          forces_of(r, r + 1 < last ? &w.ranges[r + 1] : nullptr, spare);
      },
      &w.pair_shares);
  std::ranges::fill(s.boundary_load, BodyLoad{});
  for (const PairBlock& range : w.ranges) add_up(model, range.accounts, s);
}

}  // namespace firn
