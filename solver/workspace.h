// What a step needs beside model and state: tables made once from the model, and scratch memory.
// Nothing here outlives a step in meaning; a restored state may use a new workspace.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "solver/broadphase.h"
#include "solver/integrate.h"
#include "solver/patches.h"
#include "solver/state.h"

namespace firn {

// What one body pair adds to its bodies in this step.
struct PairLoad {
  Vec3 force = Vec3::Zero();     // N, on a; b feels the opposite
  Vec3 moment_a = Vec3::Zero();  // N m, about the centre of a
  Vec3 moment_b = Vec3::Zero();  // N m, about the centre (origin) of b
  double peak = 0;               // N, largest normal force of a patch
  double overlap = 0;            // m
  double work_normal = 0;        // J taken from the bodies by normal forces
  double work_friction = 0;      // J by friction
};

// Outcome of one look at one pair.
struct Look {
  bool queried = false;  // contacts were searched; otherwise only the wake-up call moved
  int queries = 0;
  int deep_births = 0;
  double wake = 0;  // m
  FoundPatches found;
};

struct Workspace {
  explicit Workspace(const Model& model);

  std::vector<RigidBody> rigid;               // [shapes]
  std::vector<PairLaw> laws;                  // [shape * (shapes + boundaries) + other]
  std::vector<std::optional<BoxTree>> trees;  // [boundaries]; none for planes
  std::vector<double> reach;     // [shapes + boundaries] m, farthest point from the centre
  double skin = 0;               // m
  double smallest_box_edge = 0;  // m, over all shapes

  std::vector<std::array<std::int32_t, 2>>
      ends;                           // [pairs] the bodies, packed for the scan of a step
  std::vector<std::uint32_t> due;     // pairs to look at in this step
  std::vector<Look> looks;            // [due]
  std::vector<std::uint32_t> active;  // pairs with patches
  bool active_is_stale = true;        // a pair came into touch or out of it
  bool ends_are_stale = true;         // the neighbour list was made anew
  std::vector<PairLoad> loads;        // [active]

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
void sum_forces(const Model& model, const Workspace& workspace, State& state);
void kick(const Model& model, const Workspace& workspace, State& state);
void check_state(const Model& model, Workspace& workspace, State& state);

// Energy of the present state, J.
Energy energy_of(const Model& model, const Workspace& workspace, const State& state);
// Kinetic plus gravitational energy of one particle, J.
double particle_energy(const Model& model, const Workspace& workspace, const State& state,
                       int particle);

// The placement of b's axes in a's.
inline Pose relative_pose(const State& s, int a, int b) {
  Pose p;
  const Mat3 at = s.rotation[a].transpose();
  p.rotation = at * s.rotation[b];
  p.translation = at * (s.motion[b].position - s.motion[a].position);
  return p;
}

}  // namespace firn
