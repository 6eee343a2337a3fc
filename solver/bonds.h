// Bonds within the step: what they do to their bodies, when they break, and their energy.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "solver/model.h"

namespace firn {

struct State;
struct BodyLoad;
struct BondState;

// The six dampers of a bond.
struct BeamDampers {
  Vec6 constants;  // N s/m and N m s/rad
  Mat6 implicit;   // (1 + dt/2 mobility constants)^-1
};

struct BondWorkspace {
  explicit BondWorkspace(const Model& model);

  std::vector<BeamSprings> stiffness;  // [bonds]
  std::vector<BeamDampers> dampers;    // [bonds]
  // The bonds of particle i are ends[first[i]] ... ends[first[i + 1] - 1], ascending: twice the
  // number of the bond, and 1 more for its end b.
  std::vector<std::uint32_t> first;  // [particles + 1]
  std::vector<std::uint32_t> ends;   // [2 * bonds]
  std::vector<double> lost;          // [bonds] J, in the present step
};

// The phase of the step: loads of all bonds, and which of them break. A bond that is beyond its
// strength bears nothing from this very step on; its elastic energy is lost.
void strain_bonds(const Model& model, BondWorkspace& w, State& s);
// Adds them to the loads of the particles [begin, end), in order of the bonds.
void add_bond_loads(const BondWorkspace& w, const State& s, std::size_t begin, std::size_t end,
                    BodyLoad* loads);

// Elastic energy, J: of all, and of those of one particle.
double bond_energy(const Model& model, const BondWorkspace& w, const State& s);
double bond_energy_of(const Model& model, const BondWorkspace& w, const State& s, int particle);
// Ends those of a particle that leaves.
void part_bonds(const Model& model, const BondWorkspace& w, State& s, int particle);
BondState bond_state(const Model& model, const BondWorkspace& w, const State& s, std::size_t bond);

// Throws InputError for bonds that are none.
void check_bonds(const Model& model);
// The bond that swings fastest, for time steps; none: -1.
struct FastestBond {
  int bond = -1;
  double frequency = 0;  // rad/s
};
FastestBond fastest_bond(const Model& model);

}  // namespace firn
