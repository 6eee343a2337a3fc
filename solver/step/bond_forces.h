// Bonds within the step: what they do to their bodies, when they break, and their energy.
#pragma once

#include <cstddef>

#include "firn/model.h"

namespace firn {

struct State;
struct BodyLoad;
struct BondState;
struct BondWorkspace;

// The phase of the step: loads of all bonds, and which of them break. A bond that is beyond its
// strength bears nothing from this very step on; its elastic energy is lost.
void compute_bond_forces(const Model& model, int threads, BondWorkspace& w, State& s);
// Adds them to the loads of the particles [begin, end), in order of the bonds.
void add_bond_loads(const BondWorkspace& w, const State& s, std::size_t begin, std::size_t end,
                    BodyLoad* loads);

// Elastic energy, J: of all, and of those of one particle.
double bond_energy(const Model& model, const BondWorkspace& w, const State& s);
double bond_energy_of(const Model& model, const BondWorkspace& w, const State& s, int particle);
// Ends those of a particle that leaves.
void release_bonds(const Model& model, const BondWorkspace& w, State& s, int particle);
BondState bond_state(const Model& model, const BondWorkspace& w, const State& s, std::size_t bond);

}  // namespace firn
