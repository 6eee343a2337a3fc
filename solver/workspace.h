// What a step needs beside model and state: tables made once from the model, and scratch memory.
// Nothing here outlives a step in meaning; a restored state may use a new workspace.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "solver/broadphase.h"
#include "solver/integrate.h"
#include "solver/patch_block.h"
#include "solver/patches.h"
#include "solver/state.h"

namespace firn {

// Outcome of one look at one pair.
struct Look {
  bool queried = false;  // contacts were searched; otherwise only the wake-up call moved
  int queries = 0;
  int deep_births = 0;
  bool passed = false;  // parts have gone through each other
  double buried = 0;    // m, overlap of bodies that were placed into each other
  double wake = 0;      // m
  FoundPatches found;
};

struct Workspace {
  explicit Workspace(const Model& model);

  std::vector<RigidBody> rigid;               // [shapes]
  std::vector<PairLaw> laws;                  // [shape * (shapes + boundaries) + other]
  std::vector<std::optional<BoxTree>> trees;  // [boundaries]; none for planes
  std::vector<double> reach;          // [shapes + boundaries] m, farthest point from the centre
  std::vector<double> thinnest;       // [shapes + boundaries] m, least thickness of a part
  std::vector<double> smallest_part;  // [shapes] m, least bounding radius of a part
  double skin = 0;                    // m
  double least_overlap_limit = 0;     // m, over all laws

  std::vector<std::array<std::int32_t, 2>>
      ends;                           // [pairs] the bodies, packed for the scan of a step
  std::vector<std::uint32_t> due;     // pairs to look at in this step
  std::vector<Look> looks;            // [due]
  std::vector<std::uint32_t> active;  // pairs with patches, ascending
  std::vector<std::uint32_t> changed, spare_active;  // scratch of its update
  bool active_is_stale = true;                       // the neighbour list was made anew
  bool ends_are_stale = true;                        // the neighbour list was made anew
  std::vector<std::vector<PatchLoad>> loads;         // of each task

  int law_index(int shape_a, int shape_b) const { return shape_a * columns + shape_b; }
  int law_index_boundary(int shape_a, int boundary) const {
    return shape_a * columns + shapes + boundary;
  }
  int shapes = 0, columns = 0;
};

// Calls body(begin, end) over [0, n) in chunks of `grain` whose limits do not depend on the number
// of threads.
void for_chunks(int threads, std::size_t n, std::size_t grain,
                const std::function<void(std::size_t, std::size_t)>& body);

// The phases of a step, in order (see Solver::step).
void advance_boundaries(const Model& model, State& state);
void kick_and_drift(const Model& model, const Workspace& workspace, State& state);
void refresh_neighbours(const Model& model, Workspace& workspace, State& state);
void find_contacts(const Model& model, Workspace& workspace, State& state);
void contact_forces(const Model& model, Workspace& workspace, State& state);
void kick(const Model& model, const Workspace& workspace, State& state);
void check_state(const Model& model, const Workspace& workspace, State& state);

// Energy of the present state, J.
Energy energy_of(const Model& model, const Workspace& workspace, const State& state);
// Kinetic plus gravitational energy of one particle, J.
double particle_energy(const Model& model, const Workspace& workspace, const State& state,
                       int particle);

// "particle 3" or "boundary "floor"".
std::string name_of_body(const Model& model, int body);

// The placement of b's axes in a's.
inline Pose relative_pose(const State& s, int a, int b) {
  Pose p;
  const Mat3 at = s.rotation[a].transpose();
  p.rotation = at * s.rotation[b];
  p.translation = at * (s.motion[b].position - s.motion[a].position);
  return p;
}

}  // namespace firn
