// Narrow phase with temporal coherence: tests only pairs whose motion bounds allow a change.
// Queries their parts and rebuilds their patches.
#include "solver/contact_detection/find_contacts.h"

#include <fmt/format.h>

#include "solver/contact/surface_contacts.h"
#include "solver/contact_detection/patch_storage.h"
#include "solver/contact_detection/relative_poses.h"
#include "solver/contact_detection/tunneling_guard.h"
#include "solver/core/prefetch.h"
#include "solver/state/workspace.h"

namespace firn {

namespace {

// Motion that two parts with this gap allow before they must be queried again, m.
double slack(double gap, const PairCoefficients& law) {
  return std::max(gap - law.contact_margin, law.contact_update_distance);
}

double deepest(const PatchBuffer& found) {
  double gap = 0;
  for (const ContactPoint& p : found.points) gap = std::min(gap, p.gap);
  return -gap;
}

// Tests the pairs that are due, and searches the contacts of those that have moved enough.
class ContactSearch {
 public:
  ContactSearch(const Model& model, const Workspace& w, State& s, TaskScratch& scratch)
      : model_(model),
        w_(w),
        s_(s),
        n_(static_cast<int>(model.particles.size())),
        scratch_(scratch),
        contacts_(scratch.contacts) {}

  // Tests `count` pairs against their motion bounds. Updates their next test distances and appends
  // the pairs that need a contact search. Branch-free: the outcome is unpredictable.
  void test_pairs(const std::uint32_t* numbers, int count, const PairPoses& poses) {
    struct Found {
      int k;
      double bound, moved;
    } found[PairPoses::capacity + 1];
    int many = 0;
    for (int k = 0; k < count; ++k) {
      const Pair& pair = s_.pairs[numbers[k]];
      const PairMotionBound& motion_bound = s_.motion_bound[numbers[k]];
      const double bound = s_.translation_bound[pair.a] + s_.translation_bound[pair.b];
      const double moved = motion_bound.moved + moved_since(pair, motion_bound, poses, k, bound);
      const double rotation_left = rotation_left_of(pair, motion_bound);
      s_.next_test_distance[numbers[k]] =
          bound + std::min(motion_bound.test_distance - moved, rotation_left);
      found[many].k = k;
      found[many].bound = bound;
      found[many].moved = moved;
      many += (moved >= motion_bound.test_distance) | (rotation_left <= 0);
    }
    for (int i = 0; i < many; ++i) {
      PairToTest& due = scratch_.searched.emplace_back();
      due.pair = numbers[found[i].k];
      due.translation_bound = found[i].bound;
      due.moved = found[i].moved;
      poses.get_pose(found[i].k, due.pose);
    }
  }

  void search(const PairToTest& due, ContactSearchResult& out) {
    const Pair& pair = s_.pairs[due.pair];
    PairMotionBound& motion_bound = s_.motion_bound[due.pair];
    const PairCoefficients& law = w_.laws[pair.law];
    out.late_contacts = 0;
    out.tunneled = false;
    const bool is_first_search = motion_bound.moved == 0 && motion_bound.test_distance == 0;
    const double part_test_distance = query(pair, due.pose, law, due.moved, out);
    out.initial_penetration =
        is_first_search ? deepest(out.found) - step_motion(model_, w_, s_, pair.a, pair.b) : 0;

    motion_bound.moved = due.moved;
    motion_bound.test_distance =
        out.found.patches.empty()
            ? part_test_distance
            : std::min(due.moved + law.contact_update_distance, part_test_distance);
    motion_bound.reference_translation_bound = due.translation_bound;
    motion_bound.reference_rotation_bound = s_.rotation_bound[pair.a];
    std::copy_n(due.pose.rotation.data(), 9, motion_bound.reference_rotation);
    std::copy_n(due.pose.translation.data(), 3, motion_bound.reference_translation);
    s_.next_test_distance[due.pair] =
        due.translation_bound + (motion_bound.test_distance - due.moved);
  }

 private:
  // Upper bound of the displacement of any point of b relative to a since the reference pose, m.
  // It is the smaller of two bounds: the sum of the path lengths of both bodies, and the
  // displacement in a's axes. The second one is not used for a boundary. A boundary may be large,
  // and its farthest point would make the bound useless at the contact.
  double moved_since(const Pair& pair, const PairMotionBound& motion_bound, const PairPoses& poses,
                     int k, double bound) const {
    const double by_bound = bound - motion_bound.reference_translation_bound;
    const bool is_particle = pair.b < n_;
    const double reach_b = w_.reach[model_.particles[is_particle ? pair.b : pair.a].shape];
    const double by_pose = poses.shift(k) + poses.turn(k) * reach_b;
    return std::min(by_bound, is_particle ? by_pose : by_bound);
  }

  // Rotation that is left before a search, as a distance, m. Normals and lever arms are stored in
  // world axes, so they become outdated even when both bodies rotate together.
  double rotation_left_of(const Pair& pair, const PairMotionBound& motion_bound) const {
    const double left = w_.laws[pair.law].contact_update_distance -
                        (s_.rotation_bound[pair.a] - motion_bound.reference_rotation_bound) *
                            w_.reach[model_.particles[pair.a].shape];
    return select(pair.patch_count == 0, std::numeric_limits<double>::infinity(), left);
  }

  // Queries the due part pairs. Returns the least test distance of the part pairs that do not
  // touch, as a value of PairMotionBound::moved.
  double query(const Pair& pair, const Pose& pose, const PairCoefficients& law, double moved,
               ContactSearchResult& out) {
    const Shape& shape_a = model_.shapes[model_.particles[pair.a].shape];
    const bool solids = pair.b < n_ || model_.boundaries[pair.b - n_].kind == Boundary::Kind::solid;
    const Mat3 rotation_a = rotation_of(s_, pair.a);
    std::optional<TunnelingGuard> sides;
    if (solids) sides.emplace(SideInput{model_, w_, s_, pair});
    std::size_t used = 0;
    PartPair* const parts = s_.part_pairs.data() + pair.first_part;
    double test_distance = find_due_parts({parts, pair.part_count}, moved);
    bool left_to_neighbor = false;
    for (const std::uint32_t k : scratch_.due_parts) {
      PartPair& p = parts[k];
      if (contacts_.size() == used) contacts_.emplace_back();
      PartContact& c = contacts_[used];
      c.a = p.a;
      c.b = static_cast<int>(p.b);
      c.other_a = c.other_b = 0;
      const ConvexPart* part_b = part_of_b(pair, p);
      c.radius_a = shape_a.parts[p.a].radius;
      c.radius_b = part_b ? part_b->radius : 0;
      collide_parts(shape_a.parts[p.a], part_b, p.cache, pose, law.contact_margin, c.manifold);
      if (sides && (c.manifold.gap < 0 || p.touching || sides->needs_sweep()))
        out.tunneled |= !sides->enforce_contact_side(p, pose, law.contact_margin, c.manifold);
      p.touching = c.manifold.points.empty() ? 0 : 1;
      // The contact at an internal face belongs to the adjacent part. This part gets the contact
      // when the adjacent part loses it, so it is queried in every query of the pair.
      const bool at_internal_face = !p.touching && c.manifold.gap < law.contact_margin;
      left_to_neighbor |= at_internal_face;
      p.next_test_distance =
          moved + (p.touching || at_internal_face ? 0 : slack(c.manifold.gap, law));
      if (!p.touching && !at_internal_face)
        test_distance = std::min(test_distance, p.next_test_distance);
      used += p.touching;
    }
    if (left_to_neighbor && used == 0) test_distance = moved;
    out.queries = static_cast<int>(scratch_.due_parts.size());
    const FlatSurfaces& surfaces_a = w_.surfaces[model_.particles[pair.a].shape];
    const FlatSurfaces& surfaces_b =
        w_.surfaces[pair.b < n_ ? model_.particles[pair.b].shape : w_.shapes + pair.b - n_];
    if (!surfaces_a.empty() || !surfaces_b.empty()) {
      const std::span<const ConvexPart> parts_b =
          pair.b < n_ ? model_.shapes[model_.particles[pair.b].shape].parts
                      : model_.boundaries[pair.b - n_].parts;
      used = join_surface_contacts(
          {shape_a.parts, solids ? parts_b : std::span<const ConvexPart>(), surfaces_a, surfaces_b,
           pose, pose.rotation.col(2).dot(pose.translation), law.contact_margin},
          contacts_, used);
    }
    PatchInput in{law,
                  rotation_a,
                  {contacts_.data(), used},
                  shape_a.part_neighbors,
                  {},
                  {s_.patches.data() + pair.first_patch, pair.patch_count},
                  s_.patch_details.data() + pair.first_patch,
                  s_.points.data()};
    const BodyMotion &motion_a = s_.motion[pair.a], &motion_b = s_.motion[pair.b];
    const Vec3 apart = motion_a.position - motion_b.position;
    const Vec3 closing = motion_a.velocity - motion_b.velocity;
    in.velocity = closing - motion_b.angular_velocity.cross(apart);
    in.velocity_before =
        closing - motion_b.angular_velocity.cross(apart - model_.timestep * closing);
    in.angular_velocity = motion_a.angular_velocity - motion_b.angular_velocity;
    in.dt = model_.timestep;
    if (pair.b < n_) in.neighbors_b = model_.shapes[model_.particles[pair.b].shape].part_neighbors;
    out.late_contacts = build_patches(in, scratch_.patches, out.found);
    return test_distance;
  }

  // Null: a plane.
  const ConvexPart* part_of_b(const Pair& pair, const PartPair& p) const {
    if (pair.b < n_) return &model_.shapes[model_.particles[pair.b].shape].parts[p.b];
    const Boundary& boundary = model_.boundaries[pair.b - n_];
    return boundary.kind == Boundary::Kind::plane ? nullptr : &boundary.parts[p.b];
  }

  // `b` null: the plane z = 0 of body b.
  static void collide_parts(const ConvexPart& a, const ConvexPart* b, GjkCache& cache,
                            const Pose& pose, double contact_margin, Manifold& out) {
    if (b) {
      collide(a, *b, pose, contact_margin, cache, out);
    } else {
      const Vec3 normal = pose.rotation.col(2);
      collide_plane(a, normal, normal.dot(pose.translation), contact_margin, out);
    }
  }

  // Lists the part pairs to be queried. Returns the least test distance of the other ones.
  // Branch-free: the outcome is unpredictable.
  double find_due_parts(std::span<const PartPair> parts, double moved) const {
    std::vector<std::uint32_t>& due = scratch_.due_parts;
    due.resize(parts.size());
    std::size_t many = 0;
    double test_distance = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const PartPair& p = parts[k];
      const bool is_due = (p.touching != 0) | (p.next_test_distance <= moved);
      due[many] = static_cast<std::uint32_t>(k);
      many += is_due;
      test_distance =
          std::min(select(is_due, std::numeric_limits<double>::infinity(), p.next_test_distance),
                   test_distance);
    }
    due.resize(many);
    return test_distance;
  }

  const Model& model_;
  const Workspace& w_;
  State& s_;
  int n_;
  TaskScratch& scratch_;
  std::vector<PartContact>& contacts_;
};

// Limit on the overlap of an inserted body, as a fraction of its smallest edge. A deeper one would
// be expelled by the contact spring.
constexpr double kInitialPenetration = 0.05;

void check_fault(const Model& model, const Workspace& w, const State& s,
                 const ContactFault& fault) {
  const Pair& pair = s.pairs[fault.pair];
  if (fault.tunneled) {
    throw RunError(fmt::format(
        "{} has passed through {} at {:.6g} s, {:.4g} m a step: shorten the time step, or make "
        "the thin one thicker or the contact stiffer",
        name_of_body(model, pair.a), name_of_body(model, pair.b), s.time,
        step_motion(model, w, s, pair.a, pair.b)));
  }
  const int n = static_cast<int>(model.particles.size());
  double edge = model.shapes[model.particles[pair.a].shape].box.minCoeff();
  if (pair.b < n) edge = std::min(edge, model.shapes[model.particles[pair.b].shape].box.minCoeff());
  if (fault.initial_penetration > kInitialPenetration * edge) {
    throw RunError(
        fmt::format("{} was placed {:.4g} m inside {} at {:.6g} s: move it to a free position",
                    name_of_body(model, pair.a), fault.initial_penetration,
                    name_of_body(model, pair.b), s.time));
  }
}

// Prefetch the data of pairs further down the list. Their data are scattered: without prefetch, the
// wait for memory costs as much as the test. prefetch_pair() must come first, because the pair
// holds the indices of its bodies and contacts. Always inlined, see prefetch.h.
[[gnu::always_inline]] inline void prefetch_pair(const State& s, std::uint32_t p) {
  prefetch(&s.pairs[p]);
  prefetch(&s.motion_bound[p]);
}
[[gnu::always_inline]] inline void prefetch_bodies(const Model& model, const State& s,
                                                   std::uint32_t p) {
  const Pair& pair = s.pairs[p];
  const int last = static_cast<int>(model.particles.size()) - 1;
  for (const std::int32_t body : {pair.a, pair.b}) {
    prefetch(&s.motion[body]);
    prefetch(&s.orientation[body]);
    prefetch(&model.particles[std::min(body, last)].shape);
  }
  prefetch(&s.rotation_bound[pair.a]);
}
[[gnu::always_inline]] inline void prefetch_contacts(const State& s, std::uint32_t p) {
  constexpr std::size_t kPoints = 128;  // bytes: what most pairs have
  const Pair& pair = s.pairs[p];
  prefetch(s.part_pairs.data() + pair.first_part, pair.part_count);
  prefetch(s.patches.data() + pair.first_patch);
  prefetch_bytes(s.points.data() + pair.first_point, kPoints);
  prefetch(s.patch_details.data() + pair.first_patch);
}

// Finds the pairs of range `r` that are due. Prefetches what the call for the range `next` will
// read; null: the next range belongs to another task. The function computes little per pair, so
// without prefetch it would wait for memory.
void find_due_pairs(const Workspace& w, const State& s, std::size_t r, const PairBlock* next,
                    std::vector<std::uint32_t>& out) {
  const PairBlock& range = w.ranges[r];
  const std::size_t begin = r * kPairsPerBlock;
  const std::size_t end = std::min(s.pairs.size(), begin + kPairsPerBlock);
  // A body is in about seven pairs of the range, but its bound is read from the state only once.
  double bounds[2 * kPairsPerBlock];
  for (std::size_t k = 0; k < range.bodies.size(); ++k)
    bounds[k] = s.translation_bound[range.bodies[k]];
  if (next) prefetch(next->bodies.data(), next->bodies.size());
  std::uint32_t due[kPairsPerBlock];
  std::size_t many = 0;
  constexpr std::size_t kSome = 16;
  std::size_t body = 0;
  for (std::size_t from = begin; from < end; from += kSome) {
    if (next) {
      prefetch(s.next_test_distance.data() + from + kPairsPerBlock, kSome);
      prefetch(next->locals.data() + (from - begin), kSome);
      for (; body < next->bodies.size() * (from - begin) / kPairsPerBlock; ++body)
        prefetch(&s.translation_bound[next->bodies[body]]);
    }
    // Branch-free: the outcome is unpredictable.
    for (std::size_t p = from; p < std::min(from + kSome, end); ++p) {
      const auto [a, b] = range.locals[p - begin];
      due[many] = static_cast<std::uint32_t>(p);
      many += s.next_test_distance[p] <= bounds[a] + bounds[b];
    }
  }
  out.assign(due, due + many);
}

// Tests the pairs that have reached their next test distance, several side by side.
void test_due_pairs(const Model& model, const State& s, TaskScratch& scratch,
                    ContactSearch& search) {
  constexpr std::size_t kFar = 16, kNear = 8;  // pairs ahead
  const std::vector<std::uint32_t>& due = scratch.due;
  PairPoses poses;
  scratch.searched.clear();
  for (std::size_t k = 0; k < std::min(kFar, due.size()); ++k) prefetch_pair(s, due[k]);
  for (std::size_t k = 0; k < std::min(kNear, due.size()); ++k) prefetch_bodies(model, s, due[k]);
  for (std::size_t k = 0; k < due.size(); k += PairPoses::capacity) {
    const std::size_t end = std::min(k + PairPoses::capacity, due.size());
    for (std::size_t i = k + kFar; i < std::min(end + kFar, due.size()); ++i)
      prefetch_pair(s, due[i]);
    for (std::size_t i = k + kNear; i < std::min(end + kNear, due.size()); ++i)
      prefetch_bodies(model, s, due[i]);
    poses.find(s, &due[k], static_cast<int>(end - k));
    search.test_pairs(&due[k], static_cast<int>(end - k), poses);
  }
}

// Prefetches the data for the pair tests of the next range. Each search in this range prefetches a
// part of them. Without that, the tests would wait for memory.
class PairPrefetcher {
 public:
  PairPrefetcher(const Model& model, const State& s, const TaskScratch& scratch)
      : model_(model),
        s_(s),
        due_(scratch.next_due),
        some_(due_.size() / std::max<std::size_t>(scratch.searched.size(), 1) + 1) {}

  void advance() {
    for (; bodies_ < pairs_; ++bodies_) prefetch_bodies(model_, s_, due_[bodies_]);
    const std::size_t stop = std::min(pairs_ + some_, due_.size());
    for (; pairs_ < stop; ++pairs_) prefetch_pair(s_, due_[pairs_]);
  }

 private:
  const Model& model_;
  const State& s_;
  const std::vector<std::uint32_t>& due_;
  std::size_t some_, pairs_ = 0, bodies_ = 0;  // numbers of prefetched items
};

// Searches the contacts of those of a range's pairs that have moved enough.
void search_range(const Model& model, State& s, PairBlock& range, TaskScratch& scratch,
                  ContactSearch& contact_search) {
  range.refreshed.clear();
  range.overflowed.clear();
  range.contact_faults.clear();
  range.queries = range.contact_searches = range.late_contacts = 0;
  range.more_patches = range.more_points = 0;
  constexpr std::size_t kAhead = 4;  // searches
  const std::vector<PairToTest>& searched = scratch.searched;
  PairPrefetcher prefetcher(model, s, scratch);
  for (std::size_t k = 0; k < std::min(kAhead, searched.size()); ++k)
    prefetch_contacts(s, searched[k].pair);
  ContactSearchResult& search = scratch.search;
  for (std::size_t k = 0; k < searched.size(); ++k) {
    if (k + kAhead < searched.size()) prefetch_contacts(s, searched[k + kAhead].pair);
    prefetcher.advance();
    const std::uint32_t p = searched[k].pair;
    contact_search.search(searched[k], search);
    Pair& pair = s.pairs[p];
    range.queries += search.queries;
    range.late_contacts += search.late_contacts;
    if (search.tunneled || search.initial_penetration > 0)
      range.contact_faults.push_back({p, search.tunneled, search.initial_penetration});
    if (search.found.patches.empty() && pair.patch_count == 0) continue;
    ++range.contact_searches;
    range.more_patches += static_cast<std::int64_t>(search.found.patches.size()) - pair.patch_count;
    range.more_points += static_cast<std::int64_t>(search.found.points.size()) - points_of(pair, s);
    if (patches_fit(search.found, pair)) {
      store_patches(search.found, pair, s);
      range.refreshed.push_back(active_pair(range, s, p));
      continue;
    }
    const std::size_t kept = range.overflowed.size();
    range.overflowed.push_back(static_cast<std::uint32_t>(range.refreshed.size()));
    range.refreshed.push_back({.pair = p});  // completed after reallocate_patches()
    if (range.found.size() == kept) range.found.emplace_back();
    std::swap(range.found[kept], search.found);
  }
}

// The ranges [first, last) of one task.
void search_ranges(const Model& model, Workspace& w, State& s, std::size_t first,
                   std::size_t last) {
  TaskScratch& scratch = w.scratch[first / w.blocks_per_task];
  ContactSearch search(model, w, s, scratch);
  const auto find_due_of = [&](std::size_t r, std::vector<std::uint32_t>& due) {
    due.clear();
    if (r < last) find_due_pairs(w, s, r, r + 1 < last ? &w.ranges[r + 1] : nullptr, due);
  };
  find_due_of(first, scratch.due);
  for (std::size_t r = first; r < last; ++r) {
    test_due_pairs(model, s, scratch, search);
    find_due_of(r + 1, scratch.next_due);
    search_range(model, s, w.ranges[r], scratch, search);
    std::swap(scratch.due, scratch.next_due);
  }
}

}  // namespace

void find_contacts(const Model& model, Workspace& w, State& s) {
  if (w.neighbor_list_rebuilt) build_pair_blocks(model, w, s);
  parallel_for_blocks(
      w.threads, w.ranges.size(), w.blocks_per_task,
      [&](std::size_t first, std::size_t last) { search_ranges(model, w, s, first, last); },
      &w.pair_shares);
  // Reallocations and counts depend on the order, so they are serial.
  for (PairBlock& range : w.ranges) {
    s.diagnostics.queries += range.queries;
    s.diagnostics.contact_searches += range.contact_searches;
    // Overlaps of the initial state are given, not detected late.
    if (s.steps > 0) s.diagnostics.late_contacts += range.late_contacts;
    w.patches += range.more_patches;
    w.points += range.more_points;
    for (std::size_t k = 0; k < range.overflowed.size(); ++k) {
      ActivePair& refreshed = range.refreshed[range.overflowed[k]];
      Pair& pair = s.pairs[refreshed.pair];
      reallocate_patches(range.found[k], pair, s);
      store_patches(range.found[k], pair, s);
      refreshed = active_pair(range, s, refreshed.pair);
    }
  }
  for (const PairBlock& range : w.ranges) {
    for (const ContactFault& fault : range.contact_faults) check_fault(model, w, s, fault);
  }
  w.points_moved = needs_compaction(w, s);
  if (w.points_moved) {
    compact_patches(w.threads, w.back_buffer, s);
    for (PairBlock& range : w.ranges) range.active_is_stale = true;
  }
}

}  // namespace firn
