// The neighbor list: rebuilt when a body has moved further than its skin. Pairs that stay keep
// their contact history. Fast bodies get a wider skin, so that a few falling ones do not force
// rebuilds for all.
#include "solver/contact_detection/neighbor_list.h"

#include <algorithm>
#include <atomic>

#include "solver/contact_detection/bounding_spheres.h"
#include "solver/contact_detection/tunneling_guard.h"
#include "solver/core/prefetch.h"
#include "solver/state/workspace.h"

namespace firn {

namespace {

constexpr std::size_t kBodiesPerTask = 64;  // bodies a task

// A quarter of the skin, and as much again for each time that a body is faster than the average;
// at constant speed no body then needs a rebuild before the average body has moved a quarter.
void set_skins(const Model& model, const Workspace& w, State& s) {
  constexpr double kWidest = 2;  // skins
  const std::size_t n = model.particles.size();
  const auto speed = [&](std::size_t i) {
    return s.motion[i].velocity.norm() +
           s.motion[i].angular_velocity.norm() * w.reach[model.particles[i].shape];
  };
  double mean = 0;
  std::size_t present = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (s.presence[i] != Presence::present) continue;
    mean += speed(i);
    ++present;
  }
  if (present > 0) mean /= static_cast<double>(present);
  const double base = 0.25 * w.skin;
  for (std::size_t i = 0; i < s.translation_bound.size(); ++i) {
    const bool moves = i < n && s.presence[i] == Presence::present && mean > 0;
    s.skin[i] = moves ? std::min(base * (1 + speed(i) / mean), kWidest * w.skin) : 2 * base;
    s.rebuild_distance[i] = s.translation_bound[i] + s.skin[i];
  }
}

// Indices of the pairs in the present list.
class PreviousPairs {
 public:
  PreviousPairs(const HugePageVector<Pair>& pairs, std::size_t bodies, int threads)
      : first_(bodies + 1, 0), partners_(pairs.size()) {
    // The order of a body's partners has no effect.
    const auto add_one = [&](std::uint32_t& x) {
      return threads > 1 ? std::atomic_ref(x).fetch_add(1, std::memory_order_relaxed) : x++;
    };
    parallel_for_blocks(threads, pairs.size(), kPairsPerBlock,
                        [&](std::size_t begin, std::size_t end) {
                          for (std::size_t k = begin; k < end; ++k) add_one(first_[pairs[k].a + 1]);
                        });
    for (std::size_t i = 0; i < bodies; ++i) first_[i + 1] += first_[i];
    std::vector<std::uint32_t> filled(first_.begin(), first_.end() - 1);
    parallel_for_blocks(
        threads, pairs.size(), kPairsPerBlock, [&](std::size_t begin, std::size_t end) {
          for (std::size_t k = begin; k < end; ++k)
            partners_[add_one(filled[pairs[k].a])] = {pairs[k].b, static_cast<std::uint32_t>(k)};
        });
  }
  std::uint32_t find(int a, int b) const {
    for (std::uint32_t k = first_[a]; k < first_[a + 1]; ++k) {
      if (partners_[k].b == b) return partners_[k].pair;
    }
    return CandidatePair::kNew;
  }
  // What find() reads, in this order.
  [[gnu::always_inline]] void prefetch_first(int a) const { prefetch(&first_[a]); }
  [[gnu::always_inline]] void prefetch_partners(int a) const {
    prefetch(partners_.data() + first_[a], first_[a + 1] - first_[a]);
  }

 private:
  struct Partner {
    std::int32_t b;
    std::uint32_t pair;
  };
  std::vector<std::uint32_t> first_;  // [bodies + 1] into:
  std::vector<Partner> partners_;
};

// A present boundary.
struct Wall {
  int boundary;
  Pose pose;  // of its axes in the world
  // m, world: a body has no part near the boundary if its center is farther from this box than
  // sqrt(3) times its reach, the distance of the corners of the boxes that are searched in the
  // boundary's axes. A plane's has no end.
  Aabb box;
};

std::vector<Wall> present_walls(const Model& model, const Workspace& w, const State& s) {
  const std::size_t n = model.particles.size();
  std::vector<Wall> walls;
  for (std::size_t b = 0; b < model.boundaries.size(); ++b) {
    if (!s.boundary_present[b]) continue;
    Wall& wall = walls.emplace_back();
    wall.boundary = static_cast<int>(b);
    wall.pose = {rotation_of(s, static_cast<int>(n + b)), s.motion[n + b].position};
    Vec3 center = wall.pose.translation;
    Vec3 half = Vec3::Constant(std::numeric_limits<double>::infinity());
    if (w.trees[b]) {
      const Aabb& bounds = w.trees[b]->bounds();
      center = wall.pose * (0.5 * (bounds.lower + bounds.upper));
      half = wall.pose.rotation.cwiseAbs() * (0.5 * (bounds.upper - bounds.lower));
      half.array() += std::sqrt(3.0) * s.skin[n + b] + kRounding;
    }
    wall.box = {center - half, center + half};
  }
  return walls;
}

// Boundaries that may be near a body with index in [begin, end).
std::vector<const Wall*> near_walls(const std::vector<Wall>& walls, const Model& model,
                                    const State& s, const BoundingSpheres& spheres,
                                    std::size_t begin, std::size_t end) {
  Aabb box{Vec3::Constant(std::numeric_limits<double>::infinity()),
           Vec3::Constant(-std::numeric_limits<double>::infinity())};
  for (std::size_t k = begin; k < end; ++k) {
    const int i = spheres.particle[k];
    const double reach = spheres.reach[model.particles[i].shape] + s.skin[i];
    const Vec3 far = Vec3::Constant(std::sqrt(3.0) * reach);
    box.lower = box.lower.cwiseMin(s.motion[i].position - far);
    box.upper = box.upper.cwiseMax(s.motion[i].position + far);
  }
  std::vector<const Wall*> near;
  for (const Wall& wall : walls)
    if (wall.box.overlaps(box)) near.push_back(&wall);
  return near;
}

// Finds the pairs of a piece.
class PairFinder {
 public:
  PairFinder(const Model& model, const Workspace& w, const State& s, const BoundingSpheres& spheres,
             NeighborListChunk& piece)
      : model_(model),
        w_(w),
        s_(s),
        n_(static_cast<int>(model.particles.size())),
        spheres_(spheres),
        piece_(piece) {}

  void add_particles(std::size_t i, std::size_t j) {
    if (spheres_.particle[i] > spheres_.particle[j]) std::swap(i, j);
    const int a = spheres_.particle[i], b = spheres_.particle[j];
    const int shape_a = model_.particles[a].shape, shape_b = model_.particles[b].shape;
    const std::size_t room =
        model_.shapes[shape_a].parts.size() * model_.shapes[shape_b].parts.size();
    parts_.resize(std::max(parts_.size(), room + SphereGroup::size));
    const Vec4 &of_a = spheres_.places[i], &of_b = spheres_.places[j];
    const int count = find_close_parts(spheres_.of(i), spheres_.of(j), {of_b.x, of_b.y, of_b.z},
                                       spheres_.reach[shape_b], of_a.w + of_b.w, parts_.data());
    add(a, b, w_.law_index(shape_a, shape_b), {parts_.data(), static_cast<std::size_t>(count)});
  }

  void add_wall(std::size_t i, const Wall& wall) {
    const int boundary = wall.boundary;
    const int a = spheres_.particle[i], b = n_ + boundary;
    const int shape = model_.particles[a].shape;
    const Pose& pose = wall.pose;
    const double all_of_a = spheres_.reach[shape] + s_.skin[a] + s_.skin[b] + kRounding;
    const Vec3 center = pose.rotation.transpose() * (s_.motion[a].position - pose.translation);
    if (w_.trees[boundary]) {
      const Aabb& bounds = w_.trees[boundary]->bounds();
      const Vec3 all = Vec3::Constant(all_of_a);
      if (!bounds.overlaps({center - all, center + all})) return;
    } else if (center.z() > all_of_a) {
      return;
    }
    parts_.clear();
    const std::vector<ConvexPart>& parts = model_.shapes[shape].parts;
    for (std::uint32_t k = 0; k < parts.size(); ++k) {
      const Vec3 c = pose.rotation.transpose() * (spheres_.center(i, k) - pose.translation);
      const double reach = parts[k].bounding_radius + s_.skin[a] + s_.skin[b];
      if (model_.boundaries[boundary].kind == Boundary::Kind::plane) {
        if (c.z() < reach) parts_.push_back({k, 0});
        continue;
      }
      found_.clear();
      w_.trees[boundary]->find({c - Vec3::Constant(reach), c + Vec3::Constant(reach)}, found_);
      for (const int l : found_) parts_.push_back({k, static_cast<std::uint32_t>(l)});
    }
    add(a, b, w_.law_index_boundary(shape, boundary), parts_);
  }

 private:
  void add(int a, int b, int law, std::span<const PartNumbers> parts) {
    if (parts.empty()) return;
    piece_.pairs.push_back(
        {a, b, law, CandidatePair::kNew, static_cast<std::uint32_t>(parts.size())});
    piece_.parts.insert(piece_.parts.end(), parts.begin(), parts.end());
  }

  const Model& model_;
  const Workspace& w_;
  const State& s_;
  int n_;
  const BoundingSpheres& spheres_;
  NeighborListChunk& piece_;
  // Scratch memory.
  std::vector<PartNumbers> parts_;
  std::vector<int> found_;
};

// Finds the pairs of a chunk in the old list and counts the data to copy. Three passes: each reads
// the addresses that the next one needs, which are prefetched.
void match_previous_pairs(const State& s, const PreviousPairs& old_pairs,
                          NeighborListChunk& piece) {
  constexpr std::size_t kAhead = 16;  // pairs
  const std::size_t count = piece.pairs.size();
  for (const CandidatePair& pair : piece.pairs) old_pairs.prefetch_first(pair.a);
  for (std::size_t k = 0; k < count; ++k) {
    if (k + kAhead < count) old_pairs.prefetch_partners(piece.pairs[k + kAhead].a);
    CandidatePair& pair = piece.pairs[k];
    pair.old = old_pairs.find(pair.a, pair.b);
    if (pair.old != CandidatePair::kNew) prefetch(&s.pairs[pair.old]);
  }
  piece.size = {count, piece.parts.size(), 0, 0};
  for (std::size_t k = 0; k < count; ++k) {
    if (k + kAhead < count && piece.pairs[k + kAhead].old != CandidatePair::kNew)
      prefetch(s.patches.data() + s.pairs[piece.pairs[k + kAhead].old].first_patch);
    if (piece.pairs[k].old == CandidatePair::kNew) continue;
    const Pair& old = s.pairs[piece.pairs[k].old];
    piece.size.patches += old.patch_count;
    piece.size.points += static_cast<std::size_t>(points_of(old, s));
  }
}

// Writes a chunk into the new list. Pairs of the old list keep their motion bounds and contacts.
class ListWriter {
 public:
  ListWriter(const State& s, const NeighborListChunk& piece, NeighborListBuffers& list)
      : s_(s), list_(list), at_(piece.first) {}

  void write(const CandidatePair& found, const PartNumbers* parts) {
    Pair pair;
    pair.a = found.a;
    pair.b = found.b;
    pair.law = found.law;
    pair.first_part = static_cast<std::uint32_t>(at_.parts);
    pair.part_count = found.part_count;
    PairMotionBound motion_bound;
    double next_test_distance =
        s_.translation_bound[pair.a] + s_.translation_bound[pair.b];  // test now
    if (found.old == CandidatePair::kNew) {
      copy_parts({parts, found.part_count}, {}, 0);
      motion_bound.reference_translation_bound = next_test_distance;
      motion_bound.reference_rotation_bound = s_.rotation_bound[pair.a];
      const Pose pose = relative_pose(s_, pair.a, pair.b);
      std::copy_n(pose.rotation.data(), 9, motion_bound.reference_rotation);
      std::copy_n(pose.translation.data(), 3, motion_bound.reference_translation);
    } else {
      const Pair& old = s_.pairs[found.old];
      motion_bound = s_.motion_bound[found.old];
      const std::span old_parts(s_.part_pairs.data() + old.first_part, old.part_count);
      if (copy_parts({parts, found.part_count}, old_parts, motion_bound.moved)) {
        motion_bound.test_distance = motion_bound.moved;
      } else {
        next_test_distance = s_.next_test_distance[found.old];
      }
      copy_contacts(s_, old, pair, list_, at_.patches, at_.points);
    }
    list_.pairs[at_.pairs] = pair;
    list_.next_test_distance[at_.pairs] = next_test_distance;
    list_.motion_bound[at_.pairs] = motion_bound;
    ++at_.pairs;
  }

 private:
  // Copies part pairs that are in the old list and initializes the others. Both lists are
  // ascending. Returns true when there are new part pairs.
  bool copy_parts(std::span<const PartNumbers> parts, std::span<const PartPair> old, double moved) {
    bool is_new = false;
    auto known = old.begin();
    const auto before = [](const PartPair& p, const PartNumbers& q) {
      return p.a < q.a || (p.a == q.a && p.b < q.b);
    };
    for (const PartNumbers& part : parts) {
      PartPair& out = list_.part_pairs[at_.parts++];
      while (known != old.end() && before(*known, part)) ++known;
      if (known != old.end() && known->a == part.a && known->b == part.b) {
        out = *known;
        continue;
      }
      out = PartPair{};
      out.a = static_cast<std::uint16_t>(part.a);
      out.b = part.b;
      out.next_test_distance = moved;
      is_new = true;
    }
    return is_new;
  }

  const State& s_;
  NeighborListBuffers& list_;
  ListSizes at_;
};

// Concatenates the chunks. The list does not depend on the division into chunks.
void write_list(std::vector<NeighborListChunk>& pieces, int threads, NeighborListBuffers& spare,
                State& s) {
  ListSizes all;
  for (NeighborListChunk& piece : pieces) {
    piece.first = all;
    all.add(piece.size);
  }
  resize_discarding(spare.pairs, all.pairs);
  resize_discarding(spare.next_test_distance, all.pairs);
  resize_discarding(spare.motion_bound, all.pairs);
  resize_discarding(spare.part_pairs, all.parts);
  resize_discarding(spare.patches, all.patches);
  resize_discarding(spare.patch_details, all.patches);
  resize_discarding(spare.points, all.points);
  parallel_for_blocks(threads, pieces.size(), 1, [&](std::size_t k, std::size_t) {
    ListWriter writer(s, pieces[k], spare);
    const PartNumbers* parts = pieces[k].parts.data();
    for (const CandidatePair& pair : pieces[k].pairs) {
      writer.write(pair, parts);
      parts += pair.part_count;
    }
  });
  std::swap(s.pairs, spare.pairs);
  std::swap(s.next_test_distance, spare.next_test_distance);
  std::swap(s.motion_bound, spare.motion_bound);
  std::swap(s.part_pairs, spare.part_pairs);
  std::swap(s.patches, spare.patches);
  std::swap(s.patch_details, spare.patch_details);
  std::swap(s.points, spare.points);
}

bool must_rebuild(const Model& model, const Workspace& w, const State& s) {
  if (s.neighbor_list_invalid) return true;
  for (const char leaves : w.needs_rebuild) {
    if (leaves) return true;
  }
  for (std::size_t i = model.particles.size(); i < s.translation_bound.size(); ++i) {
    if (s.translation_bound[i] > s.rebuild_distance[i]) return true;
  }
  return false;
}

}  // namespace

void update_neighbor_list(const Model& model, Workspace& w, State& s) {
  if (!must_rebuild(model, w, s)) return;
  check_step_lengths(model, w, s);
  set_skins(model, w, s);
  const BoundingSpheres spheres = update_bounding_spheres(model, w, s);
  const int threads = w.threads;
  const AabbOverlaps neighbors = find_aabb_overlaps(spheres.boxes, threads);
  const std::vector<Wall> walls = present_walls(model, w, s);
  const std::size_t present = spheres.particle.size();
  const PreviousPairs old_pairs(s.pairs, s.motion.size(), threads);
  std::vector<NeighborListChunk>& pieces = w.list_chunks;
  pieces.resize((present + kBodiesPerTask - 1) / kBodiesPerTask);
  parallel_for_blocks(threads, present, kBodiesPerTask, [&](std::size_t begin, std::size_t end) {
    NeighborListChunk& piece = pieces[begin / kBodiesPerTask];
    piece.clear();
    PairFinder pairs(model, w, s, spheres, piece);
    const std::vector<const Wall*> near = near_walls(walls, model, s, spheres, begin, end);
    for (std::size_t i = begin; i < end; ++i) {
      if (i + 2 < end) {
        const std::span<const std::int32_t> later = neighbors.of(i + 2);
        prefetch(later.data(), later.size());
      }
      for (const std::int32_t j : neighbors.of(i))
        pairs.add_particles(i, static_cast<std::size_t>(j));
      for (const Wall* const wall : near) pairs.add_wall(i, *wall);
    }
    match_previous_pairs(s, old_pairs, piece);
  });
  write_list(pieces, threads, w.back_buffer, s);
  s.neighbor_list_invalid = false;
  w.neighbor_list_rebuilt = true;
  ++s.diagnostics.rebuilds;
  s.diagnostics.pairs = s.pairs.size();
}

}  // namespace firn
