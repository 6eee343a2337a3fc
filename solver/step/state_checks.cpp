// Energy accounts, and the checks that stop a run which went wrong.
#include "solver/step/state_checks.h"

#include <fmt/format.h>

#include "solver/state/workspace.h"
#include "solver/step/bond_forces.h"

namespace firn {

double particle_energy(const Model& model, const Workspace& w, const State& s, int i) {
  const RigidBody& body = w.rigid[model.particles[i].shape];
  const BodyMotion& m = s.motion[i];
  return 0.5 * body.mass * m.velocity.squaredNorm() +
         0.5 * s.angular_momentum[i].cwiseAbs2().dot(body.inverse_inertia) -
         body.mass * model.gravity.dot(m.position);
}

Energy energy_of(const Model& model, const Workspace& w, const State& s) {
  Energy e;
  for (std::size_t i = 0; i < model.particles.size(); ++i) {
    if (s.presence[i] != Presence::present) continue;
    const double gravitational =
        -w.rigid[model.particles[i].shape].mass * model.gravity.dot(s.motion[i].position);
    e.gravitational += gravitational;
    e.kinetic += particle_energy(model, w, s, static_cast<int>(i)) - gravitational;
  }
  StoredEnergy stored;
  double stored_walls = 0;
  for (const Pair& pair : s.pairs) {
    for (std::uint32_t k = 0; k < pair.patch_count; ++k) {
      const ContactPatch& patch = s.patches[pair.first_patch + k];
      const StoredEnergy one =
          stored_energy(w.laws[pair.law], patch, s.patch_details[pair.first_patch + k].rolling,
                        s.points.data() + patch.first_point);
      stored.normal += one.normal;
      stored.friction += one.friction;
      if (pair.b >= static_cast<int>(model.particles.size()))
        stored_walls += one.normal + one.friction;
    }
  }
  // What contacts took from the bodies and do not hold any more is lost.
  e.elastic = stored.normal + stored.friction + bond_energy(model, w.bonds, s);
  e.dissipated_normal = s.work_normal - stored.normal;
  e.dissipated_friction = s.work_friction - stored.friction;
  e.dissipated_boundaries = s.work_boundaries - stored_walls;
  e.dissipated_bonds = s.lost_in_bonds;
  e.boundary_work = s.boundary_work;
  e.removed = s.removed_energy;
  return e;
}

namespace {

constexpr std::uint64_t kFiniteEvery = 10;   // steps between two searches for non-finite motion
constexpr std::uint64_t kEnergyEvery = 500;  // and between two energy balances
static_assert(kEnergyEvery % kFiniteEvery == 0);
constexpr double kRunaway = 0.25;  // of the energy at play

void check_finite(const Model& model, const State& s) {
  double sum = 0;
  for (std::size_t i = 0; i < model.particles.size(); ++i) {
    if (s.presence[i] == Presence::present) {
      sum += s.motion[i].velocity.squaredNorm() + s.motion[i].angular_velocity.squaredNorm();
    }
  }
  if (std::isfinite(sum)) return;
  for (std::size_t i = 0; i < model.particles.size(); ++i) {
    const BodyMotion& m = s.motion[i];
    if (!m.position.allFinite() || !m.velocity.allFinite() || !m.angular_velocity.allFinite()) {
      throw RunError(fmt::format("non-finite motion of particle {} at {:.6g} s", i, s.time));
    }
  }
  throw RunError(fmt::format("speeds beyond all bounds at {:.6g} s", s.time));
}

// J: a millionth of what lifts the heaviest body by its own size.
double negligible_energy(const Model& model) {
  double most = 0;
  for (const Shape& shape : model.shapes) most = std::max(most, shape.mass * shape.bounding_radius);
  return 1e-6 * most * model.gravity.norm();
}

// Contacts only ever take energy, so what is left of it after the work of boundaries and of
// insertions is taken out may not rise.
void check_energy(const Model& model, const Workspace& w, State& s) {
  const Energy e = energy_of(model, w, s);
  const double left = e.kinetic + e.gravitational + e.elastic - e.boundary_work + e.removed;
  s.largest_kinetic = std::max(s.largest_kinetic, e.kinetic);
  if (!s.energy_known || left < s.lowest_energy) {
    s.lowest_energy = left;
    s.energy_known = true;
    return;
  }
  const double rise = left - s.lowest_energy;
  s.diagnostics.energy_error = std::max(s.diagnostics.energy_error, rise);
  // Contacts of bodies that were placed into each other give more than they ever took; what
  // adhesion holds is below zero.
  const double taken = std::max(0.0, s.work_normal + s.work_friction);
  const double at_play = s.largest_kinetic + std::abs(e.elastic) + taken;
  if (rise > kRunaway * at_play && rise > negligible_energy(model)) {
    throw RunError(fmt::format(
        "energy grew by {:.4g} J without cause up to {:.6g} s (kinetic {:.4g} J): the time step is "
        "too long for these contacts",
        rise, s.time, e.kinetic));
  }
}

}  // namespace

bool is_check_step(const State& s) { return s.steps % kFiniteEvery == 0; }

void check_state(const Model& model, const Workspace& w, State& s) {
  check_finite(model, s);
  if (s.steps % kEnergyEvery == 0) check_energy(model, w, s);
}

}  // namespace firn
