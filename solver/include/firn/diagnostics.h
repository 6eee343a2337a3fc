// Energies, state hashes and diagnostics of a run.
#pragma once

#include <array>
#include <cstdint>

namespace firn {

// Of free bodies and of the contacts between boundaries, J; zero without free bodies.
struct FreeBodyEnergy {
  double kinetic = 0;           // with the rotors of the joints (Joint::armature)
  double gravitational = 0;     // relative to the origin of the world
  double elastic = 0;           // springs of joints
  double contacts_elastic = 0;  // recoverable energy of contacts between boundaries
  // Since the start: by friction of joints and couplings, by dampers and limits of joints, and in
  // the contacts between boundaries.
  double dissipated_friction = 0, dissipated_damping = 0, dissipated_contacts = 0;
  // Since the start, done on the free bodies: by motors, by contacts with particles, and by
  // boundaries and frames with prescribed motions.
  double work = 0;

  // Constant but for the error of the time step.
  double balance() const {
    return kinetic + gravitational + elastic + contacts_elastic + dissipated_friction +
           dissipated_damping + dissipated_contacts - work;
  }
};

// Of the particles, but for the last member.
struct Energy {  // J
  double kinetic = 0;
  double gravitational = 0;      // relative to the origin of the world
  double elastic = 0;            // recoverable energy of contact springs and bonds
  double dissipated_normal = 0;  // since the start, by restitution
  double dissipated_friction = 0;
  double dissipated_boundaries = 0;  // part of the two above at boundaries
  double dissipated_bonds = 0;       // since the start, by damping of bonds and when they end
  double boundary_work = 0;          // done by moving boundaries on the particles since the start
  // Mechanical energy of removed particles minus that of inserted ones, and the elastic energy of
  // the bonds of removed boundaries.
  double removed = 0;
  FreeBodyEnergy free_bodies;
};

// An energy (J) with the name of its dataset below /energy of a results file.
struct EnergyTerm {
  const char* name;
  double value;
};
inline std::array<EnergyTerm, 9> energy_terms(const Energy& e) {  // of the particles
  return {{{"kinetic", e.kinetic},
           {"gravitational", e.gravitational},
           {"elastic", e.elastic},
           {"dissipated_normal", e.dissipated_normal},
           {"dissipated_friction", e.dissipated_friction},
           {"dissipated_boundaries", e.dissipated_boundaries},
           {"dissipated_bonds", e.dissipated_bonds},
           {"boundary_work", e.boundary_work},
           {"removed", e.removed}}};
}
inline std::array<EnergyTerm, 8> energy_terms(const FreeBodyEnergy& e) {
  return {{{"free_bodies_kinetic", e.kinetic},
           {"free_bodies_gravitational", e.gravitational},
           {"free_bodies_elastic", e.elastic},
           {"boundary_contacts_elastic", e.contacts_elastic},
           {"dissipated_joint_friction", e.dissipated_friction},
           {"dissipated_joint_damping", e.dissipated_damping},
           {"dissipated_boundary_contacts", e.dissipated_contacts},
           {"free_bodies_work", e.work}}};
}

// Numerical quality and counters of a run.
struct Diagnostics {
  double largest_overlap = 0;  // m, over all steps
  int largest_overlap_particle = -1;
  // Patches first detected with an overlap above 1 % of the rounding radii. Those of the first step
  // belong to the initial state and do not count.
  std::uint64_t late_contacts = 0;
  // Steps in which friction, motors and limits of mechanisms did not converge.
  std::uint64_t unconverged_steps = 0;
  double energy_error = 0;             // J, sum of unexplained rises
  std::uint64_t rebuilds = 0;          // of the neighbor list
  std::uint64_t queries = 0;           // narrow-phase queries of part pairs
  std::uint64_t contact_searches = 0;  // contact searches of body pairs with patches
  std::uint64_t patches = 0;           // current
  std::uint64_t points = 0;            // current
  std::uint64_t pairs = 0;             // current, in the neighbor list
};

// Hash of a group of arrays of the state, to find the group in which two runs diverge first.
struct GroupHash {
  const char* group;
  std::uint64_t hash;
};

// Wall time of a phase of the step.
struct PhaseTime {
  const char* name;
  double seconds;  // s
};

}  // namespace firn
