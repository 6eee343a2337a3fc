// Tables over a neighbor list: the ranges of pairs for tasks, and the ranges in which each body
// occurs.
#include "solver/state/workspace.h"

namespace firn {

namespace {

// Numbers bodies in the order in which they come.
class LocalBodies {
 public:
  explicit LocalBodies(std::vector<std::int32_t>& bodies) : bodies_(bodies) {
    bodies_.clear();
    slots_.fill(kNone);
  }
  std::uint16_t number(std::int32_t body) {
    std::size_t at = static_cast<std::size_t>(body) * 2654435761u % slots_.size();
    while (slots_[at] != kNone && bodies_[slots_[at]] != body) at = (at + 1) % slots_.size();
    if (slots_[at] == kNone) {
      slots_[at] = static_cast<std::uint16_t>(bodies_.size());
      bodies_.push_back(body);
    }
    return slots_[at];
  }

 private:
  static constexpr std::uint16_t kNone = 0xffff;
  std::vector<std::int32_t>& bodies_;
  std::array<std::uint16_t, 4 * kPairsPerBlock> slots_;  // open addressing, at most half full
};

// Which loads of ranges make up that of each particle.
void build_load_index(std::size_t particles, Workspace& w) {
  LoadIndex& lists = w.load_index;
  std::size_t loads = 0;
  lists.first.assign(particles + 1, 0);
  for (PairBlock& range : w.ranges) {
    range.first_load = loads;
    loads += range.bodies.size();
    for (const std::int32_t i : range.bodies) {
      if (static_cast<std::size_t>(i) < particles) ++lists.first[i + 1];
    }
  }
  for (std::size_t i = 0; i < particles; ++i) lists.first[i + 1] += lists.first[i];
  lists.loads.resize(lists.first.back());
  std::vector<std::uint32_t> end(lists.first.begin(), lists.first.end() - 1);
  for (const PairBlock& range : w.ranges) {
    for (std::size_t k = 0; k < range.bodies.size(); ++k) {
      const auto i = static_cast<std::size_t>(range.bodies[k]);
      if (i < particles) lists.loads[end[i]++] = static_cast<std::uint32_t>(range.first_load + k);
    }
  }
  resize_discarding(w.loads, loads);
}

}  // namespace

void build_pair_blocks(const Model& model, Workspace& w, const State& s) {
  const std::size_t pairs = s.pairs.size();
  w.ranges.resize((pairs + kPairsPerBlock - 1) / kPairsPerBlock);
  parallel_for_blocks(w.threads, pairs, kPairsPerBlock, [&](std::size_t begin, std::size_t end) {
    PairBlock& range = w.ranges[begin / kPairsPerBlock];
    LocalBodies local(range.bodies);
    range.locals.clear();
    range.more_patches = range.more_points = 0;
    for (std::size_t p = begin; p < end; ++p) {
      const Pair& pair = s.pairs[p];
      const std::uint16_t a = local.number(pair.a), b = local.number(pair.b);
      range.locals.push_back({a, b});
      range.more_patches += pair.patch_count;
      range.more_points += points_of(pair, s);
    }
    range.active_is_stale = true;
  });
  w.patches = w.points = 0;
  for (const PairBlock& range : w.ranges) {
    w.patches += range.more_patches;
    w.points += range.more_points;
  }
  w.blocks_per_task = blocks_per_task(w.threads, w.ranges.size());
  w.scratch.resize((w.ranges.size() + w.blocks_per_task - 1) / w.blocks_per_task);
  build_load_index(model.particles.size(), w);
  w.neighbor_list_rebuilt = false;
}

}  // namespace firn
