// Kicks and drifts of all present particles.
#include "solver/workspace.h"

namespace firn {

namespace {
constexpr std::size_t kGrain = 128;  // bodies a task

Vec3 spin_of(const RigidBody& body, const Mat3& rotation, const Vec3& angular_momentum) {
  return rotation * angular_momentum.cwiseProduct(body.inverse_inertia);
}

// The rotational drift of up to Lanes::size bodies, one in each lane.
void drift_rotations(const Workspace& w, const Model& model, State& s, const std::size_t* bodies,
                     int count) {
  FreeRotations r;
  for (int k = 0; k < Lanes::size; ++k) {
    const std::size_t i = bodies[std::min(k, count - 1)];
    const Vec3& inverse = w.rigid[model.particles[i].shape].inverse_inertia;
    for (int c = 0; c < 4; ++c) r.q[c].set(k, s.orientation[i].coeffs()[c]);
    for (int c = 0; c < 3; ++c) {
      r.momentum[c].set(k, s.angular_momentum[i][c]);
      r.inverse_inertia[c].set(k, inverse[c]);
    }
  }
  rotate_free(r, model.timestep);
  for (int k = 0; k < count; ++k) {
    const std::size_t i = bodies[k];
    for (int c = 0; c < 4; ++c) s.orientation[i].coeffs()[c] = r.q[c][k];
    for (int c = 0; c < 3; ++c) s.angular_momentum[i][c] = r.momentum[c][k];
  }
}

void kick_and_drift_range(const Model& model, Workspace& w, State& s, std::size_t begin,
                          std::size_t end) {
  const double dt = model.timestep;
  std::size_t lanes[Lanes::size];
  int filled = 0;
  double growth = 0;  // m
  bool leaves = false;
  const auto finish = [&] {
    if (filled == 0) return;
    drift_rotations(w, model, s, lanes, filled);
    for (int k = 0; k < filled; ++k) {
      const std::size_t i = lanes[k];
      const int shape = model.particles[i].shape;
      BodyMotion& m = s.motion[i];
      s.rotation[i] = s.orientation[i].toRotationMatrix();
      m.spin = spin_of(w.rigid[shape], s.rotation[i], s.angular_momentum[i]);
      const double turned = m.spin.norm() * dt;
      s.turn[i] += turned;
      const double way = m.velocity.norm() * dt + turned * w.reach[shape];
      s.path[i] += way;
      growth = std::max(growth, way);
      leaves |= s.path[i] > s.relist_path[i];
    }
    filled = 0;
  };
  for (std::size_t i = begin; i < end; ++i) {
    if (s.presence[i] != Presence::present) continue;
    BodyMotion& m = s.motion[i];
    half_kick(w.rigid[model.particles[i].shape], s.load[i].force, s.load[i].torque, model.gravity,
              dt, s.rotation[i], m.velocity, s.angular_momentum[i]);
    m.position += dt * m.velocity;
    lanes[filled++] = i;
    if (filled == Lanes::size) finish();
  }
  finish();
  w.growth[begin / kGrain] = growth;
  w.must_relist[begin / kGrain] = leaves;
}

}  // namespace

void kick_and_drift(const Model& model, Workspace& w, State& s) {
  const double dt = model.timestep;
  const std::size_t n = model.particles.size();
  w.growth.assign((n + kGrain - 1) / kGrain, 0);
  w.must_relist.assign(w.growth.size(), 0);
  for_ranges(model.numerics.threads, n, kGrain, [&](std::size_t begin, std::size_t end) {
    kick_and_drift_range(model, w, s, begin, end);
  });
  double growth = 0;
  for (const double g : w.growth) growth = std::max(growth, g);
  for (std::size_t b = 0; b < model.boundaries.size(); ++b) {
    const BodyMotion& m = s.motion[n + b];
    const double turned = m.spin.norm() * dt;
    if (turned == 0 && m.velocity.isZero(0)) continue;
    // A turning plane has no farthest point of its own: take that of the particles around it.
    double reach = w.reach[w.shapes + b];
    if (turned > 0 && model.boundaries[b].kind == Boundary::Kind::plane) {
      for (std::size_t i = 0; i < n; ++i) {
        if (s.presence[i] != Presence::present) continue;
        reach = std::max(
            reach, (s.motion[i].position - m.position).norm() + w.reach[model.particles[i].shape]);
      }
    }
    s.turn[n + b] += turned;
    const double way = m.velocity.norm() * dt + turned * reach;
    s.path[n + b] += way;
    growth = std::max(growth, way);
  }
  w.farthest += growth;
}

void kick(const Model& model, const Workspace& w, State& s) {
  for_ranges(model.numerics.threads, model.particles.size(), kGrain,
             [&](std::size_t begin, std::size_t end) {
               for (std::size_t i = begin; i < end; ++i) {
                 if (s.presence[i] != Presence::present) continue;
                 const RigidBody& body = w.rigid[model.particles[i].shape];
                 half_kick(body, s.load[i].force, s.load[i].torque, model.gravity, model.timestep,
                           s.rotation[i], s.motion[i].velocity, s.angular_momentum[i]);
                 s.motion[i].spin = spin_of(body, s.rotation[i], s.angular_momentum[i]);
               }
             });
}

}  // namespace firn
