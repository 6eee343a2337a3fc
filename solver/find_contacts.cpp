// Narrow phase with temporal coherence: only pairs whose motion bounds say that something can have
// changed are looked at; their parts are queried and their patches made anew.
#include <fmt/format.h>

#include "solver/sides.h"
#include "solver/workspace.h"

namespace firn {

namespace {

constexpr std::size_t kGrain = 16;  // looks a task

// A bound on how far any point of b has moved relative to a since the reference pose: the smaller
// of the ways both have gone and of the displacement in a's axes.
double moved_since(const State& s, const Pair& pair, const PairWatch& watch, const Pose& now,
                   double reach_b, double path) {
  const double by_path = path - watch.reference_path;
  double turned = 0;
  for (int k = 0; k < 9; ++k) {
    const double d = now.rotation.data()[k] - watch.reference_rotation[k];
    turned += d * d;
  }
  // The operator norm of a difference of two rotations is its Frobenius norm over sqrt(2).
  const Vec3 shift(now.translation[0] - watch.reference_translation[0],
                   now.translation[1] - watch.reference_translation[1],
                   now.translation[2] - watch.reference_translation[2]);
  const bool boundary = pair.b >= static_cast<int>(s.angular_momentum.size());
  if (boundary) return by_path;  // may be large: its own points say nothing about the contact
  return std::min(by_path, shift.norm() + std::sqrt(0.5 * turned) * reach_b);
}

// The gap of two parts as of a query: how long they may be left alone, m.
double slack(double gap, const PairLaw& law) {
  return std::max({gap - law.shell, 0.5 * gap, law.refresh});
}

double deepest(const FoundPatches& found) {
  double gap = 0;
  for (const ContactPoint& p : found.points) gap = std::min(gap, p.gap);
  return -gap;
}

class Looker {
 public:
  Looker(const Model& model, Workspace& w, State& s)
      : model_(model), w_(w), s_(s), n_(static_cast<int>(model.particles.size())) {}

  void look(std::uint32_t index, Look& out) {
    const Pair& pair = s_.pairs[index];
    PairWatch& watch = s_.watch[index];
    const PairLaw& law = w_.laws[pair.law];
    const int shape_a = model_.particles[pair.a].shape;
    const Pose pose = relative_pose(s_, pair.a, pair.b);
    const double path = s_.path[pair.a] + s_.path[pair.b];
    const double reach_b = pair.b < n_ ? w_.reach[model_.particles[pair.b].shape] : 0;
    const double moved = watch.moved + moved_since(s_, pair, watch, pose, reach_b, path);
    // World-fixed normals and arms also age when both bodies turn together.
    const double turn_left =
        pair.patch_count == 0
            ? std::numeric_limits<double>::infinity()
            : law.refresh - (s_.turn[pair.a] - watch.reference_turn) * w_.reach[shape_a];
    out.queried = false;
    out.queries = 0;
    out.deep_births = 0;
    if (moved < watch.need && turn_left > 0) {
      out.wake = path + std::min(watch.need - moved, turn_left);
      return;
    }
    out.queried = true;
    out.passed = false;
    const bool first_look = watch.moved == 0 && watch.need == 0;
    query(pair, pose, law, moved, out);
    out.buried = first_look ? deepest(out.found) - step_motion(model_, w_, s_, pair.a, pair.b) : 0;

    double need = next_need(pair, law, moved, !out.found.patches.empty());
    watch.moved = moved;
    watch.need = need;
    watch.reference_path = path;
    watch.reference_turn = s_.turn[pair.a];
    std::copy_n(pose.rotation.data(), 9, watch.reference_rotation);
    std::copy_n(pose.translation.data(), 3, watch.reference_translation);
    out.wake = path + (need - moved);
  }

 private:
  void query(const Pair& pair, const Pose& pose, const PairLaw& law, double moved, Look& out) {
    const Shape& shape_a = model_.shapes[model_.particles[pair.a].shape];
    const bool solids = pair.b < n_ || model_.boundaries[pair.b - n_].kind == Boundary::Kind::solid;
    std::optional<Sides> sides;
    if (solids) sides.emplace(SideInput{model_, w_, s_, pair});
    std::size_t used = 0;
    for (std::uint32_t k = pair.first_part; k < pair.first_part + pair.part_count; ++k) {
      PartPair& p = s_.part_pairs[k];
      if (!p.touching && p.wake > moved) continue;
      if (contacts_.size() == used) contacts_.emplace_back();
      PartContact& c = contacts_[used];
      c.a = p.a;
      c.b = static_cast<int>(p.b);
      collide_parts(pair, shape_a.parts[p.a], p, pose, law.shell, c.manifold);
      if (sides && (c.manifold.gap < 0 || p.touching || sides->fast()))
        out.passed |= !sides->keep(p, pose, law.shell, c.manifold);
      ++out.queries;
      p.touching = c.manifold.points.empty() ? 0 : 1;
      p.wake = moved + (p.touching ? 0 : slack(c.manifold.gap, law));
      used += p.touching;
    }
    PatchInput in{law,
                  s_.rotation[pair.a],
                  {contacts_.data(), used},
                  shape_a.part_neighbours,
                  {},
                  {s_.patches.data() + pair.first_patch, pair.patch_count},
                  s_.points.data()};
    if (pair.b < n_)
      in.neighbours_b = model_.shapes[model_.particles[pair.b].shape].part_neighbours;
    out.deep_births = build_patches(in, scratch_, out.found);
  }

  void collide_parts(const Pair& pair, const ConvexPart& part_a, PartPair& p, const Pose& pose,
                     double shell, Manifold& out) const {
    if (pair.b < n_) {
      collide(part_a, model_.shapes[model_.particles[pair.b].shape].parts[p.b], pose, shell,
              p.cache, out);
      return;
    }
    const Boundary& boundary = model_.boundaries[pair.b - n_];
    if (boundary.kind == Boundary::Kind::plane) {
      const Vec3 normal = pose.rotation.col(2);
      collide_plane(part_a, normal, normal.dot(pose.translation), shell, out);
    } else {
      collide(part_a, boundary.parts[p.b], pose, shell, p.cache, out);
    }
  }

  double next_need(const Pair& pair, const PairLaw& law, double moved, bool touching) const {
    double need = touching ? moved + law.refresh : std::numeric_limits<double>::infinity();
    for (std::uint32_t k = pair.first_part; k < pair.first_part + pair.part_count; ++k) {
      if (!s_.part_pairs[k].touching) need = std::min(need, s_.part_pairs[k].wake);
    }
    return need;
  }

  const Model& model_;
  Workspace& w_;
  State& s_;
  int n_;
  std::vector<PartContact> contacts_;
  PatchScratch scratch_;
};

// Bodies are placed by somebody who may err; one that starts deeper in another than this part of
// its smallest edge would be thrown out by the spring.
constexpr double kBuried = 0.05;

void check_look(const Model& model, const Workspace& w, const State& s, const Pair& pair,
                const Look& look) {
  if (look.passed) {
    throw RunError(fmt::format(
        "{} has passed through {} at {:.6g} s, {:.4g} m a step: shorten the time step, or make "
        "the thin one thicker or the contact stiffer",
        name_of_body(model, pair.a), name_of_body(model, pair.b), s.time,
        step_motion(model, w, s, pair.a, pair.b)));
  }
  const int n = static_cast<int>(model.particles.size());
  double edge = model.shapes[model.particles[pair.a].shape].box.minCoeff();
  if (pair.b < n) edge = std::min(edge, model.shapes[model.particles[pair.b].shape].box.minCoeff());
  if (look.buried > kBuried * edge) {
    throw RunError(
        fmt::format("{} was placed {:.4g} m inside {} at {:.6g} s: place it where nothing is",
                    name_of_body(model, pair.a), look.buried, name_of_body(model, pair.b), s.time));
  }
}

// Stores what a look found in the pair's place, or at the end when it has outgrown it.
void commit(const Look& look, Pair& pair, State& s) {
  const FoundPatches& f = look.found;
  const auto patches = static_cast<std::uint32_t>(f.patches.size());
  const auto points = static_cast<std::uint32_t>(f.points.size());
  if (patches > pair.patch_capacity) {
    pair.first_patch = static_cast<std::uint32_t>(s.patches.size());
    pair.patch_capacity = std::max(patches, 2u);
    s.patches.resize(s.patches.size() + pair.patch_capacity);
  }
  if (points > pair.point_capacity) {
    pair.first_point = static_cast<std::uint32_t>(s.points.size());
    pair.point_capacity = std::max(points, 6u);
    s.points.resize(s.points.size() + pair.point_capacity);
  }
  for (std::uint32_t k = 0; k < patches; ++k) {
    Patch& patch = s.patches[pair.first_patch + k];
    patch = f.patches[k];
    patch.first_point += pair.first_point;
  }
  std::copy(f.points.begin(), f.points.end(), s.points.begin() + pair.first_point);
  pair.patch_count = patches;
}

// What looks further down the list will read: it lies scattered, and waiting for it would cost as
// much as the look itself.
void prefetch(const State& s, const std::vector<std::uint32_t>& due, std::size_t k,
              std::size_t end) {
  if (k + 4 < end) {
    const std::uint32_t far = due[k + 4];
    __builtin_prefetch(&s.pairs[far]);
    const auto* watch = reinterpret_cast<const char*>(&s.watch[far]);
    __builtin_prefetch(watch);
    __builtin_prefetch(watch + 64);
  }
  if (k + 2 < end) {
    const Pair& near = s.pairs[due[k + 2]];
    const auto* parts = reinterpret_cast<const char*>(s.part_pairs.data() + near.first_part);
    for (std::uint32_t i = 0; i < near.part_count * sizeof(PartPair); i += 64)
      __builtin_prefetch(parts + i);
    __builtin_prefetch(s.patches.data() + near.first_patch);
  }
}

// The list of pairs with patches after some have come into touch (now on) or out of it.
void update_active(const State& s, const std::vector<std::uint32_t>& changed, Workspace& w) {
  if (!w.active_is_stale) {
    if (changed.empty()) return;
    w.spare_active.clear();
    std::size_t c = 0;
    for (const std::uint32_t p : w.active) {
      for (; c < changed.size() && changed[c] < p; ++c) w.spare_active.push_back(changed[c]);
      if (c < changed.size() && changed[c] == p)
        ++c;  // out of touch
      else
        w.spare_active.push_back(p);
    }
    w.spare_active.insert(w.spare_active.end(), changed.begin() + static_cast<std::ptrdiff_t>(c),
                          changed.end());
    std::swap(w.active, w.spare_active);
    return;
  }
  w.active.clear();
  for (std::size_t p = 0; p < s.pairs.size(); ++p) {
    if (s.pairs[p].patch_count > 0) w.active.push_back(static_cast<std::uint32_t>(p));
  }
  w.active_is_stale = false;
}

}  // namespace

void find_contacts(const Model& model, Workspace& w, State& s) {
  const std::size_t pairs = s.pairs.size();
  if (w.ends_are_stale) {
    w.ends.resize(pairs);
    for (std::size_t p = 0; p < pairs; ++p) w.ends[p] = {s.pairs[p].a, s.pairs[p].b};
    w.ends_are_stale = false;
  }
  w.due.clear();
  for (std::size_t p = 0; p < pairs; ++p) {
    if (s.wake[p] <= s.path[w.ends[p][0]] + s.path[w.ends[p][1]]) {
      w.due.push_back(static_cast<std::uint32_t>(p));
    }
  }
  if (w.looks.size() < w.due.size()) w.looks.resize(w.due.size());
  for_chunks(model.numerics.threads, w.due.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    Looker looker(model, w, s);
    for (std::size_t k = begin; k < end; ++k) {
      prefetch(s, w.due, k, end);
      looker.look(w.due[k], w.looks[k]);
    }
  });
  w.changed.clear();
  for (std::size_t k = 0; k < w.due.size(); ++k) {
    const Look& look = w.looks[k];
    Pair& pair = s.pairs[w.due[k]];
    s.wake[w.due[k]] = look.wake;
    s.health.queries += look.queries;
    s.health.deep_births += look.deep_births;
    if (look.queried && (look.passed || look.buried > 0)) check_look(model, w, s, pair, look);
    if (!look.queried || (look.found.patches.empty() && pair.patch_count == 0)) continue;
    ++s.health.refreshes;
    if ((pair.patch_count == 0) != look.found.patches.empty()) w.changed.push_back(w.due[k]);
    commit(look, pair, s);
  }
  update_active(s, w.changed, w);
}

}  // namespace firn
