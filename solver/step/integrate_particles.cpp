// Kicks and drifts of all present particles, eight side by side: each lane does what half_kick()
// and rotate_torque_free() do, in the same order of operations.
#include "solver/step/integrate_particles.h"

#include <algorithm>

#include "solver/core/prefetch.h"
#include "solver/core/simd_batch.h"
#include "solver/state/workspace.h"
#include "solver/step/bond_forces.h"

namespace firn {

namespace {
constexpr std::size_t kBodiesPerTask = 128;  // bodies a task
constexpr std::size_t kBodiesAhead = 32;     // bodies, to be fetched

// Up to Simd8d::size bodies, one in each lane; lanes beyond `count` repeat the last one.
struct BodyBatch {
  std::size_t body[Simd8d::size];
  int count = 0;

  void fill_up() {
    for (int k = count; k < Simd8d::size; ++k) body[k] = body[count - 1];
  }
};

class BodyIntegrator {
 public:
  // `loads` are those of the particles from `first` on.
  BodyIntegrator(const Model& model, const Workspace& w, State& s, const BodyLoad* loads,
                 std::size_t first)
      : model_(model), w_(w), s_(s), loads_(loads), first_(first), dt_(model.timestep) {
    get_three(model.gravity, gravity_);
  }

  // Half kicks of the velocity, one body at a time: its vectors are rows already.
  template <int kicks>
  [[gnu::always_inline]] void kick_velocity(std::size_t i, Simd4d& velocity) const {
    Simd4d force;
    get(&s_.motion[i].velocity, velocity);
    get(&load(i).force, force);
    const Simd4d change = half_ * (body(i).inverse_mass * force + gravity_);
    for (int k = 0; k < kicks; ++k) velocity += change;
    put(velocity, &s_.motion[i].velocity);
  }

  template <int kicks>
  [[gnu::always_inline]] void kick_momentum(const BodyBatch& batch, const Rotations& r,
                                            Columns4& momentum) const {
    Columns4 torque;
    Columns3 turned;
    gather(
        batch.body, [&](std::size_t i, Simd4d& row) { get(&load(i).torque, row); }, torque);
    gather(
        batch.body, [&](std::size_t i, Simd4d& row) { get_three(s_.angular_momentum[i], row); },
        momentum);
    r.rotate_inverse(half_, torque, turned);
    for (int k = 0; k < kicks; ++k) {
      momentum.x = momentum.x + turned.x;
      momentum.y = momentum.y + turned.y;
      momentum.z = momentum.z + turned.z;
    }
  }

  [[gnu::always_inline]] void gather_orientation(const BodyBatch& batch, Columns4& q) const {
    gather(
        batch.body,
        [&](std::size_t i, Simd4d& row) { get(s_.orientation[i].coeffs().data(), row); }, q);
  }
  [[gnu::always_inline]] void gather_inverse_inertia(const BodyBatch& batch,
                                                     Columns4& inverse) const {
    gather(
        batch.body, [&](std::size_t i, Simd4d& row) { get_three(body(i).inverse_inertia, row); },
        inverse);
  }
  [[gnu::always_inline]] void compute_angular_velocity(const Rotations& r, const Columns4& momentum,
                                                       const Columns4& inverse,
                                                       Columns4& angular_velocity) const {
    const Columns3 rates{momentum.x * inverse.x, momentum.y * inverse.y, momentum.z * inverse.z};
    r.rotate(rates, angular_velocity);
    angular_velocity.w = Simd8d(0.0);
  }

  [[gnu::always_inline]] void store_angular_velocity(const BodyBatch& batch,
                                                     Columns4& angular_velocity) const {
    Simd4d rows[Simd8d::size];
    scatter(angular_velocity, rows);
    for (int k = 0; k < batch.count; ++k) put(rows[k], &s_.motion[batch.body[k]].angular_velocity);
  }
  [[gnu::always_inline]] void store_momentum(const BodyBatch& batch, Columns4& momentum) const {
    Simd4d rows[Simd8d::size];
    scatter(momentum, rows);
    for (int k = 0; k < batch.count; ++k) put_three(rows[k], s_.angular_momentum[batch.body[k]]);
  }

  const RigidBody& body(std::size_t i) const { return w_.rigid[model_.particles[i].shape]; }
  const BodyLoad& load(std::size_t i) const { return loads_[i - first_]; }

  const Model& model_;
  const Workspace& w_;
  State& s_;
  const BodyLoad* loads_;
  std::size_t first_;
  double dt_, half_ = 0.5 * dt_;
  Simd4d gravity_;
};

// True when a body has moved further than its skin.
template <int kicks>
bool kick_and_drift_batch(const BodyIntegrator& integrator, BodyBatch& batch) {
  bool leaves = false;
  State& s = integrator.s_;
  batch.fill_up();
  Columns4 q, momentum, inverse, angular_velocity, velocity;
  Simd4d rows[Simd8d::size];
  for (int k = 0; k < batch.count; ++k) {
    const std::size_t i = batch.body[k];
    Simd4d place;
    integrator.kick_velocity<kicks>(i, rows[k]);
    get(&s.motion[i].position, place);
    put(place + integrator.dt_ * rows[k], &s.motion[i].position);
  }
  for (int k = batch.count; k < Simd8d::size; ++k) get(&s.motion[batch.body[k]].velocity, rows[k]);
  integrator.gather_orientation(batch, q);
  integrator.kick_momentum<kicks>(batch, Rotations(q), momentum);
  integrator.gather_inverse_inertia(batch, inverse);
  FreeRotations free{{q.x, q.y, q.z, q.w},
                     {momentum.x, momentum.y, momentum.z},
                     {inverse.x, inverse.y, inverse.z}};
  rotate_torque_free(free, integrator.dt_);
  q = {free.q[0], free.q[1], free.q[2], free.q[3]};
  momentum = {free.momentum[0], free.momentum[1], free.momentum[2], Simd8d(0.0)};
  const Rotations r(q);
  integrator.compute_angular_velocity(r, momentum, inverse, angular_velocity);
  const Simd8d turned =
      norm(angular_velocity.x, angular_velocity.y, angular_velocity.z) * Simd8d(integrator.dt_);
  velocity = {{rows[0], rows[4]}, {rows[1], rows[5]}, {rows[2], rows[6]}, {rows[3], rows[7]}};
  transpose(velocity.x.low, velocity.y.low, velocity.z.low, velocity.w.low);
  transpose(velocity.x.high, velocity.y.high, velocity.z.high, velocity.w.high);
  const Simd8d gone = norm(velocity.x, velocity.y, velocity.z) * Simd8d(integrator.dt_);
  for (int k = 0; k < batch.count; ++k) {
    const std::size_t i = batch.body[k];
    s.rotation_bound[i] += turned[k];
    s.translation_bound[i] +=
        gone[k] + turned[k] * integrator.w_.reach[integrator.model_.particles[i].shape];
    leaves |= s.translation_bound[i] > s.rebuild_distance[i];
  }
  integrator.store_angular_velocity(batch, angular_velocity);
  integrator.store_momentum(batch, momentum);
  scatter(q, rows);
  for (int k = 0; k < batch.count; ++k) put(rows[k], s.orientation[batch.body[k]].coeffs().data());
  return leaves;
}

void kick_batch(const BodyIntegrator& integrator, BodyBatch& batch) {
  batch.fill_up();
  Columns4 q, momentum, inverse, angular_velocity;
  Simd4d velocity;
  for (int k = 0; k < batch.count; ++k) integrator.kick_velocity<1>(batch.body[k], velocity);
  integrator.gather_orientation(batch, q);
  const Rotations r(q);
  integrator.kick_momentum<1>(batch, r, momentum);
  integrator.gather_inverse_inertia(batch, inverse);
  integrator.compute_angular_velocity(r, momentum, inverse, angular_velocity);
  integrator.store_angular_velocity(batch, angular_velocity);
  integrator.store_momentum(batch, momentum);
}

// Adds up what contacts and bonds do to the bodies [begin, end), into `loads`.
void sum_loads(const Workspace& w, State& s, std::size_t begin, std::size_t end, BodyLoad* loads) {
  constexpr std::uint32_t kAhead = 16;  // loads of a body may be anywhere
  const std::uint32_t* const first = w.load_index.first.data();
  const std::uint32_t* const list = w.load_index.loads.data();
  const std::uint32_t last = first[end];
  const BlockLoad* const of_ranges = w.loads.data();
  for (std::size_t i = begin; i < end; ++i) {
    Simd4d force = {0, 0, 0, 0}, torque = force, more;
    double peak = s.peak_normal_force[i];
    for (std::uint32_t k = first[i]; k < first[i + 1]; ++k) {
      if (k + kAhead < last) prefetch<Cache::first>(of_ranges + list[k + kAhead]);
      const BlockLoad& load = of_ranges[list[k]];
      peak = std::max(peak, load.force.w);
      get(&load.force, more);
      force += more;
      get(&load.torque, more);
      torque += more;
    }
    force[3] = 0;
    put(force, &loads[i - begin].force);
    put(torque, &loads[i - begin].torque);
    s.peak_normal_force[i] = peak;
  }
  if (!s.bonds.empty()) add_bond_loads(w.bonds, s, begin, end, loads);
}

// Fetches the loads of the bodies [begin, end), as many at a time as a batch has: they lie
// anywhere, and sum_loads() alone would only wait for them.
class LoadPrefetcher {
 public:
  LoadPrefetcher(const Workspace& w, std::size_t begin, std::size_t end)
      : loads_(w.loads.data()),
        next_(w.load_index.loads.data() + w.load_index.first[begin]),
        end_(w.load_index.loads.data() + w.load_index.first[end]) {}

  void advance() {
    constexpr std::ptrdiff_t kSome = 20;  // 2.4 for each body
    const std::uint32_t* const stop = next_ + std::min(kSome, end_ - next_);
    while (next_ < stop) prefetch(loads_ + *next_++);
  }

 private:
  const BlockLoad* loads_;
  const std::uint32_t *next_, *end_;
};

// Fetches what a batch reads of as many bodies from the first one on, which may lie beyond the
// last. Processors follow an array by themselves, but stop at the end of every page, and a batch
// reads six. Always inlined, see prefetch.h.
[[gnu::always_inline]] inline void prefetch_bodies(const State& s, std::size_t first) {
  constexpr std::size_t kMany = Simd8d::size;
  prefetch(s.motion.data() + first, kMany);
  prefetch(s.orientation.data() + first, kMany);
  prefetch(s.angular_momentum.data() + first, kMany);
  prefetch(s.translation_bound.data() + first, kMany);
  prefetch(s.rotation_bound.data() + first, kMany);
  prefetch(s.rebuild_distance.data() + first, kMany);
}

// Calls move(batch) for the present bodies of [begin, end).
template <class Move>
void for_body_batches(const State& s, std::size_t begin, std::size_t end, const Move& move) {
  BodyBatch batch;
  for (std::size_t i = begin; i < end; ++i) {
    if (s.presence[i] != Presence::present) continue;
    batch.body[batch.count++] = i;
    if (batch.count < Simd8d::size) continue;
    move(batch);
    batch.count = 0;
  }
  if (batch.count > 0) move(batch);
}

}  // namespace

void integrate_positions(const Model& model, Workspace& w, State& s, bool both_kicks) {
  const double dt = model.timestep;
  const std::size_t n = model.particles.size();
  w.needs_rebuild.assign((n + kBodiesPerTask - 1) / kBodiesPerTask, 0);
  const auto move = [&](std::size_t begin, bool goes_on) {
    const std::size_t end = std::min(n, begin + kBodiesPerTask);
    bool leaves = false;
    if (both_kicks) {
      // Not stored in the state: no other function needs them, and each is a cache line.
      BodyLoad loads[kBodiesPerTask];
      sum_loads(w, s, begin, end, loads);
      // Dampers of bonds read them (bond_forces.cpp).
      if (!s.bonds.empty()) std::copy_n(loads, end - begin, s.load.data() + begin);
      const BodyIntegrator integrator(model, w, s, loads, begin);
      LoadPrefetcher ahead(w, end, goes_on ? std::min(n, end + kBodiesPerTask) : end);
      for_body_batches(s, begin, end, [&](BodyBatch& batch) {
        ahead.advance();
        if (goes_on || batch.body[0] + kBodiesAhead < end)
          prefetch_bodies(s, batch.body[0] + kBodiesAhead);
        leaves |= kick_and_drift_batch<2>(integrator, batch);
      });
    } else {
      const BodyIntegrator integrator(model, w, s, s.load.data(), 0);
      for_body_batches(s, begin, end, [&](BodyBatch& batch) {
        leaves |= kick_and_drift_batch<1>(integrator, batch);
      });
    }
    w.needs_rebuild[begin / kBodiesPerTask] = leaves;
  };
  const std::size_t ranges = w.needs_rebuild.size();
  parallel_for_blocks(
      w.threads, ranges, blocks_per_task(w.threads, ranges),
      [&](std::size_t first, std::size_t last) {
        for (std::size_t r = first; r < last; ++r) move(r * kBodiesPerTask, r + 1 < last);
      },
      &w.body_shares);
  for (std::size_t b = 0; b < model.boundaries.size(); ++b) {
    const BodyMotion& m = s.motion[n + b];
    const double turned = m.angular_velocity.norm() * dt;
    if (turned == 0 && m.velocity.isZero(0)) continue;
    // A turning plane has no farthest point: use that of the particles around it.
    double reach = w.reach[w.shapes + b];
    if (turned > 0 && model.boundaries[b].kind == Boundary::Kind::plane) {
      for (std::size_t i = 0; i < n; ++i) {
        if (s.presence[i] != Presence::present) continue;
        reach = std::max(
            reach, (s.motion[i].position - m.position).norm() + w.reach[model.particles[i].shape]);
      }
    }
    s.rotation_bound[n + b] += turned;
    s.translation_bound[n + b] += m.velocity.norm() * dt + turned * reach;
  }
}

void finish_velocities(const Model& model, const Workspace& w, State& s) {
  parallel_for_blocks(
      w.threads, model.particles.size(), kBodiesPerTask, [&](std::size_t begin, std::size_t end) {
        BodyLoad* const loads = s.load.data() + begin;
        sum_loads(w, s, begin, end, loads);
        const BodyIntegrator integrator(model, w, s, loads, begin);
        for_body_batches(s, begin, end, [&](BodyBatch& batch) { kick_batch(integrator, batch); });
      });
}

}  // namespace firn
