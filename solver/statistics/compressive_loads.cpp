// Two-sided loads on particles, over every step (see CompressiveLoad).
#include "solver/statistics/compressive_loads.h"

#include <algorithm>
#include <utility>

#include "solver/state/workspace.h"

namespace firn {

namespace {

// Two patches bear an opposed load of no more than the lesser of their forces, so only those that
// bear more than the largest load so far can make a larger one: in a bed at rest, next to none.
void read(const State& s, const PairBlock& range, std::vector<NormalLoadSample>& pressed) {
  const std::vector<CompressiveLoad>& opposed = s.statistics.opposed;
  const auto particles = static_cast<std::int32_t>(opposed.size());
  pressed.clear();
  for (const ActivePair& pair : range.active) {
    for (std::uint32_t k = 0; k < pair.patch_count; ++k) {
      const ContactPatch& patch = s.patches[pair.first_patch + k];
      const double force = patch.normal_force;
      if (force > opposed[pair.a].load) pressed.push_back({pair.a, pair.b, force, patch.normal});
      if (pair.b < particles && force > opposed[pair.b].load)
        pressed.push_back({pair.b, pair.a, force, -patch.normal});
    }
  }
}

void note(const NormalLoadSample& p, const NormalLoadSample& q, double time,
          CompressiveLoad& most) {
  const double lesser = std::min(p.force, q.force);
  if (!(lesser > most.load)) return;
  const double load = lesser * -p.out.dot(q.out);
  if (!(load > most.load)) return;
  most.load = load;
  most.time = time;
  most.bodies = p.force >= q.force ? std::array{p.by, q.by} : std::array{q.by, p.by};
}

}  // namespace

void record_compressive_loads(const Model& model, Workspace& w, State& s) {
  parallel_for_blocks(w.threads, s.pairs.size(), kPairsPerBlock,
                      [&](std::size_t begin, std::size_t) {
                        PairBlock& range = w.ranges[begin / kPairsPerBlock];
                        read(s, range, range.notes.pressed);
                      });
  // Each with those before it on the same particle.
  std::vector<NormalLoadSample>& all = w.statistics.pressed;
  std::vector<std::int32_t>& last = w.statistics.last_pressed;
  all.clear();
  const double time = static_cast<double>(s.steps + 1) * model.timestep;
  for (const PairBlock& range : w.ranges) {
    for (NormalLoadSample p : range.notes.pressed) {
      CompressiveLoad& most = s.statistics.opposed[p.particle];
      for (std::int32_t k = last[p.particle]; k >= 0; k = all[k].before)
        note(p, all[k], time, most);
      p.before = std::exchange(last[p.particle], static_cast<std::int32_t>(all.size()));
      all.push_back(p);
    }
  }
  for (const NormalLoadSample& p : all) last[p.particle] = -1;
}

}  // namespace firn
