#include "solver/step/bond_forces.h"

#include <algorithm>

#include "solver/core/parallel.h"
#include "solver/state/workspace.h"

namespace firn {

namespace {

constexpr std::size_t kBondsPerTask = 64;  // bonds a task

BodyInMotion body(const State& s, int body) {
  const BodyMotion& m = s.motion[body];
  return {m.position, m.velocity, m.angular_velocity, s.orientation[body]};
}

bool acts(const Model& model, const State& s, std::size_t bond) {
  const Bond& b = model.bonds[bond];
  // The bonds of a boundary that is removed are not intact.
  return s.bonds[bond].mode == BondMode::intact && s.presence[b.a] == Presence::present &&
         (!is_particle(model, b.b) || s.presence[b.b] == Presence::present);
}

Vec3 middle_of(const BodyInMotion& a, const BeamPose& pose) {
  return a.position + pose.arm_a + 0.5 * pose.end_offset;
}

double energy_now(const Model& model, const BondWorkspace& w, const State& s, std::size_t bond) {
  if (!acts(model, s, bond)) return 0;
  const Bond& b = model.bonds[bond];
  return elastic_energy(w.stiffness[bond],
                        pose_of(model.beams[b.law], b, body(s, b.a), body(s, b.b)));
}

// The body with its accelerations by a load in the place of its velocities.
BodyInMotion accelerated(const Model& model, const State& s, int body, const Vec3& force,
                         const Vec3& torque) {
  const Shape& shape = bonded_shape(model, body);
  const Quat& q = s.orientation[body];
  return {s.motion[body].position, force / shape.mass,
          q * Vec3((q.conjugate() * torque).cwiseQuotient(shape.inertia)), q};
}

Vec6 accelerations(const Model& model, const State& s, const Bond& bond, const BeamPose& pose,
                   const BeamLoad& load) {
  return rates_of(pose, accelerated(model, s, bond.a, load.force, load.moment_a),
                  accelerated(model, s, bond.b, -load.force, load.moment_b));
}

// Adds the forces of the dampers to the elastic ones; returns the power that they take, W.
//
// The bodies have the velocities of the half step before and the places of the full step. The rates
// of the full step lack half a kick by all forces. That of the bond itself, damper included, is
// taken implicitly. That of everything else is taken from the step before: State::load and
// State::bond_loads are still those. So force and deformation belong to the same time to second
// order. Gravity counts for a bond to a boundary; it accelerates two particles alike.
double add_damping(const Model& model, const BeamDampers& dampers, const State& s,
                   std::size_t number, const BeamPose& pose, BeamForces& forces) {
  const Bond& bond = model.bonds[number];
  const double half = 0.5 * model.timestep;
  BodyLoad on_a = s.load[bond.a], on_b;
  if (is_particle(model, bond.b))
    on_b = s.load[bond.b];
  else
    on_a.force += shape_of(model, bond.a).mass * model.gravity;
  const BeamLoad& own = s.bond_loads[number];
  const Vec6 others = rates_of(
      pose, accelerated(model, s, bond.a, on_a.force - own.force, on_a.torque - own.moment_a),
      accelerated(model, s, bond.b, on_b.force + own.force, on_b.torque - own.moment_b));
  const Vec6 before = rates_of(pose, body(s, bond.a), body(s, bond.b)) + half * others;
  const auto with = [&](const Vec6& rates) {
    const Vec6 damping = dampers.constants.cwiseProduct(rates);
    return BeamForces{forces.force + damping.head<3>(), forces.moment + damping.tail<3>()};
  };
  // `implicit` belongs to the pose without stress: one correction makes up for that.
  Vec6 rates = Vec6::Zero();
  for (int k = 0; k < 2; ++k) {
    const Vec6 kicked =
        before + half * accelerations(model, s, bond, pose, load_of(pose, with(rates)));
    rates += dampers.implicit * (kicked - rates);
  }
  forces = with(rates);
  return dampers.constants.dot(rates.cwiseAbs2());
}

// What breaks a bond, Pa.
double breaking_stress(const BeamStress& stress, BondMode mode) {
  if (mode == BondMode::tension || mode == BondMode::bending)
    return stress.tension + stress.bending;
  return stress.shear + stress.torsion;
}

BeamLoad strained(const Model& model, BondWorkspace& w, State& s, std::size_t number) {
  w.lost[number] = 0;
  if (!acts(model, s, number)) return {};
  const Bond& bond = model.bonds[number];
  const BeamLaw& law = model.beams[bond.law];
  const BodyInMotion a = body(s, bond.a), b = body(s, bond.b);
  const BeamPose pose = pose_of(law, bond, a, b);
  BeamForces forces = elastic_forces(w.stiffness[number], pose);
  const BeamStress stress = stress_of(law, forces);
  BondRecord& record = s.bonds[number];
  const double now = static_cast<double>(s.steps + 1) * model.timestep;
  const bool over = now - record.made > law.lifetime - 0.5 * model.timestep;
  const BondMode mode = over ? BondMode::lifetime : failure_mode(law, stress, bond.strength);
  if (mode != BondMode::intact) {
    record = {mode, now, over ? 0 : breaking_stress(stress, mode), middle_of(a, pose), record.made};
    // The last kick of the bond was that of the step before. It acted up to half a step ago.
    const Vec6 rates = rates_of(pose, a, b);
    const double power = forces.force.dot(rates.head<3>()) + forces.moment.dot(rates.tail<3>());
    w.lost[number] = elastic_energy(w.stiffness[number], pose) - 0.5 * model.timestep * power;
    return {};
  }
  if (law.damping_ratio > 0) {
    w.lost[number] =
        model.timestep * add_damping(model, w.dampers[number], s, number, pose, forces);
  }
  return load_of(pose, forces);
}

// Calls visit(bond, is_b) for the bonds of a body.
template <class Visit>
void for_bonds_of(const BondWorkspace& w, int body, const Visit& visit) {
  for (std::uint32_t k = w.first[body]; k < w.first[body + 1]; ++k)
    visit(w.ends[k] / 2, w.ends[k] % 2 != 0);
}

}  // namespace

void compute_bond_forces(const Model& model, int threads, BondWorkspace& w, State& s) {
  parallel_for_blocks(threads, model.bonds.size(), kBondsPerTask,
                      [&](std::size_t begin, std::size_t end) {
                        for (std::size_t k = begin; k < end; ++k)
                          s.bond_loads[k] = strained(model, w, s, k);
                      });
  for (const double lost : w.lost) s.lost_in_bonds += lost;
}

void add_bond_loads(const BondWorkspace& w, const State& s, std::size_t begin, std::size_t end,
                    BodyLoad* loads) {
  for (std::size_t i = begin; i < end; ++i) {
    BodyLoad& load = loads[i - begin];
    for_bonds_of(w, static_cast<int>(i), [&](std::size_t bond, bool is_b) {
      const BeamLoad& one = s.bond_loads[bond];
      load.force += is_b ? Vec3(-one.force) : one.force;
      load.torque += is_b ? one.moment_b : one.moment_a;
    });
  }
}

double bond_energy(const Model& model, const BondWorkspace& w, const State& s) {
  double sum = 0;
  for (std::size_t k = 0; k < model.bonds.size(); ++k) sum += energy_now(model, w, s, k);
  return sum;
}

double bond_energy_of(const Model& model, const BondWorkspace& w, const State& s, int body) {
  double sum = 0;
  for_bonds_of(w, body, [&](std::size_t k, bool) { sum += energy_now(model, w, s, k); });
  return sum;
}

void begin_bonds(const Model& model, const BondWorkspace& w, State& s, int particle) {
  for_bonds_of(w, particle, [&](std::size_t k, bool) {
    if (acts(model, s, k)) s.bonds[k].made = s.time;
  });
}

double last_work_of_bonds(const Model& model, const BondWorkspace& w, const State& s, int body) {
  double power = 0;
  for_bonds_of(w, body, [&](std::size_t k, bool is_b) {
    if (!acts(model, s, k)) return;
    const int partner = is_b ? model.bonds[k].a : model.bonds[k].b;
    if (!is_particle(model, partner)) return;
    const BeamLoad& load = s.bond_loads[k];
    const BodyMotion& motion = s.motion[partner];
    power += (is_b ? load.force : Vec3(-load.force)).dot(motion.velocity) +
             (is_b ? load.moment_a : load.moment_b).dot(motion.angular_velocity);
  });
  return 0.5 * model.timestep * power;
}

void release_bonds(const Model& model, const BondWorkspace& w, State& s, int body) {
  for_bonds_of(w, body, [&](std::size_t k, bool) {
    if (s.bonds[k].mode != BondMode::intact) return;
    const BondState now = bond_state(model, w, s, k);
    s.bonds[k] = {BondMode::removed, s.time, 0, now.middle, s.bonds[k].made};
  });
}

BondState bond_state(const Model& model, const BondWorkspace& w, const State& s,
                     std::size_t number) {
  BondState out;
  out.acts = acts(model, s, number);
  if (!out.acts) return out;
  const Bond& bond = model.bonds[number];
  const BeamLaw& law = model.beams[bond.law];
  const BodyInMotion a = body(s, bond.a), b = body(s, bond.b);
  const BeamPose pose = pose_of(law, bond, a, b);
  out.middle = middle_of(a, pose);
  out.orientation = Quat(pose.axes);
  out.forces = elastic_forces(w.stiffness[number], pose);
  out.stress = stress_of(law, out.forces);
  out.load = s.bond_loads[number];
  return out;
}

}  // namespace firn
