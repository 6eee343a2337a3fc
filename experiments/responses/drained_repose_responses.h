// Responses of the experiment "drained_repose". Equations and reasons: docs/responses.md.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "experiments/analysis/height_map.h"
#include "experiments/case/case.h"
#include "experiments/results/response.h"
#include "experiments/results/results_file.h"

namespace firn {

// Data of the experiment from which its responses are computed.
struct DrainedHeap {
  DrainedRepose setup;
  double particle_size = 0;  // m, see mean_particle_size()
  struct Particle {
    PlacedMesh placed;
    Vec3 center = Vec3::Zero();  // m, center of mass, world
    double mass = 0;             // kg
    double volume = 0;           // m^3
  };
  std::vector<Particle> filled;     // in the box when the door opened; empty: not opened
  std::vector<Particle> remaining;  // in the box at the end, above the lower side of the floor
  bool opened = false;              // the stage that opens the door began
  bool settled = false;             // the last stage ended with "settled"
  double observed = 0;              // s from the opening of the door to the end
  std::vector<double>
      discharge_times;         // s after the opening, ascending, of all discharged particles
  double time_resolution = 0;  // s, time step of the simulation
};

// Angles of repose, remaining mass, discharge, fill, and whether it arched and settled. Empty if
// the door was not opened. Throws InputError if the margins leave no fit window.
std::vector<Response> drained_repose_responses(const DrainedHeap& heap);

// A particle of a frame with the mesh of `shape`, which must outlive the result.
PlacedMesh placed_mesh(const Frame& frame, std::size_t particle, const Shape& shape);

// The particles of a frame with their center of mass above the lower side of the floor. `c` must
// outlive the result, which refers to its meshes; the same holds for drained_heap().
std::vector<DrainedHeap::Particle> particles_in_box(const Recording& recording, const Case& c,
                                                    std::size_t frame);
// Mean of middle_edge() over the particles, m.
double mean_particle_size(const Recording& recording, const Case& c);
// Start of the stage that opens the door, s. Nothing if it did not begin.
std::optional<double> opening_time(const Recording& recording, const Case& c);

DrainedHeap drained_heap(const Recording& recording, const Case& c);

}  // namespace firn
