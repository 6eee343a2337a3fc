// Bonds within a step: loads on their bodies, breakage and elastic energy.
#pragma once

#include <cstddef>

#include "firn/model.h"

namespace firn {

struct State;
struct BodyLoad;
struct BondState;
struct BondWorkspace;

// Phase of a step: computes the loads of all bonds and ends those beyond their strength, and those
// whose lifetime ends nearest to this step. They have no load from this step on; their elastic
// energy is lost. What a bond does to a boundary is not added to the loads of contacts on it.
void compute_bond_forces(const Model& model, int threads, BondWorkspace& w, State& s);
// Adds the loads of the bonds to those of the particles [begin, end), in order of the bonds.
void add_bond_loads(const BondWorkspace& w, const State& s, std::size_t begin, std::size_t end,
                    BodyLoad* loads);

// Elastic energy of all bonds and of the bonds of one body, J.
double bond_energy(const Model& model, const BondWorkspace& w, const State& s);
double bond_energy_of(const Model& model, const BondWorkspace& w, const State& s, int body);
// Begins the bonds of a particle that has been inserted with the bodies that are there.
void begin_bonds(const Model& model, const BondWorkspace& w, State& s, int particle);
// J, what the last loads of the bonds of a body that is removed now still do on their other bodies,
// in the first half-kick of the next step. Call it before release_bonds().
double last_work_of_bonds(const Model& model, const BondWorkspace& w, const State& s, int body);
// Ends the bonds of a body that is removed.
void release_bonds(const Model& model, const BondWorkspace& w, State& s, int body);
BondState bond_state(const Model& model, const BondWorkspace& w, const State& s, std::size_t bond);

}  // namespace firn
