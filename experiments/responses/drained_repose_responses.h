// Responses of the drained angle of repose experiment. Equations and choices: docs/responses.md.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "experiments/analysis/height_map.h"
#include "experiments/case/case.h"
#include "experiments/results/response.h"
#include "experiments/results/results_file.h"

namespace firn {

// What the experiment leaves behind, as plain data.
struct DrainedHeap {
  DrainedRepose setup;
  double particle_size = 0;  // m: mean of the middle bounding-box edges
  struct Particle {
    PlacedMesh placed;
    Vec3 center = Vec3::Zero();  // m, centre of mass, world
    double mass = 0;             // kg
    double volume = 0;           // m^3
  };
  std::vector<Particle> filled;     // in the box when the door opened; empty: it never opened
  std::vector<Particle> remaining;  // in the box at the end, above the floor's underside
  bool opened = false;              // the stage that opens the door began
  bool settled = false;             // the last stage ended at rest
  double observed = 0;              // s from the opening of the door to the end
  std::vector<double> door_times;   // s after the opening, ascending: one per particle through it
  double time_resolution = 0;       // s, time step of the simulation
};

// Angles, what remained, the discharge, the fill, and whether it arched and settled. Nothing when
// the door never opened. Throws InputError when the margins leave no window to fit.
std::vector<Response> drained_repose_responses(const DrainedHeap& heap);

// A particle of a frame; the mesh is the shape's.
PlacedMesh placed_mesh(const Frame& frame, std::size_t particle, const Shape& shape);

// Those present in a frame with their centre of mass above the floor's underside. The meshes of
// the result point into `c`, which must outlive it; so do those of drained_heap().
std::vector<DrainedHeap::Particle> particles_in_box(const Recording& recording, const Case& c,
                                                    std::size_t frame);
// Mean over the particles of the middle edge of their bounding box, m.
double mean_particle_size(const Recording& recording, const Case& c);
// Start of the stage that opens the door, s; none when it never began.
std::optional<double> opening_time(const Recording& recording, const Case& c);

DrainedHeap drained_heap(const Recording& recording, const Case& c);

}  // namespace firn
