// Statistics of contacts, kept over every step of a simulation beside its motion: what may be asked
// for, and what comes of it. They change nothing of the motion. docs/statistics.md.
#pragma once

#include <cstdint>

#include "solver/types.h"

namespace firn {

// What a simulation keeps. Nothing of it costs anything while it is not asked for.
struct StatisticsOptions {
  bool events = false;   // contacts, one by one
  double threshold = 0;  // N: contacts whose peak normal force stays below are not kept
  double merge = 0;      // s: a pair parted for less than this is in the same contact still

  bool any() const { return events; }
};

// One contact of two bodies: from the first step in which they bear on each other to the last one
// before they part. Forces are sums over the patches of the pair. `a` is a particle; `b` a particle
// above a, or number of particles + boundary.
struct ContactEvent {
  std::int32_t a = 0, b = 0;
  double start = 0;               // s, first step with a force
  double duration = 0;            // s, steps with a force and merged gaps
  double peak_time = 0;           // s
  double peak_normal_force = 0;   // N
  double peak_friction = 0;       // N, friction at that moment
  double normal_impulse = 0;      // N s, of the normal force
  double tangential_impulse = 0;  // N s, of the size of friction
  Vec3 impulse = Vec3::Zero();    // N s, world, on a, of the whole force
  // m/s, of a against b at the place of the first force: along the normal (positive: approaching),
  // and across it.
  double approach_normal = 0, approach_tangential = 0;
  Vec3 normal = Vec3::UnitZ();  // unit, world, from a to b, at the peak
  Vec3 place = Vec3::Zero();    // m, world, at the peak; between the patches by their forces
  // m, the same in the axes in which each body's mesh is drawn (a boundary: its own)
  Vec3 place_on_a = Vec3::Zero(), place_on_b = Vec3::Zero();
  double dissipated = 0;    // J lost; while the contact lasts, what its springs hold included
  std::uint64_t lasts = 0;  // 1: still under way
};

}  // namespace firn
