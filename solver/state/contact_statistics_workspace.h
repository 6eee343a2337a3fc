// Scratch memory and tables of the statistics (solver/include/firn/contact_statistics.h).
#pragma once

#include <cstdint>
#include <vector>

#include "firn/model.h"
#include "solver/geometry/nearest_triangle.h"
#include "solver/state/contact_statistics_state.h"

namespace firn {

// Work taken from the bodies by one patch in this step, J: stored in springs or dissipated.
struct PatchWork {
  double normal = 0, friction = 0;
};

struct NewContact {
  OpenContact contact;
  ContactSums sums;
};

// A patch whose force exceeds the largest compressive load of the particle so far.
struct NormalLoadSample {
  std::int32_t particle = 0, by = 0;  // bodies
  double force = 0;                   // N
  Vec3 out = Vec3::Zero();            // unit, normal out of the particle, world
  std::int32_t before = -1;           // previous sample of the same particle; -1: none
};

// Load of one contact point on a triangle in this step.
struct TriangleLoad {
  std::uint32_t triangle = 0;
  double normal_force = 0, friction = 0;  // N
  Vec3 force = Vec3::Zero();              // N, on the boundary, its axes
  // m/s, slip speed of the patch times the share of the point; 0: sticking
  double sliding_speed = 0;
  double sliding_power = 0;  // N m/s
  double friction_work = 0;  // J
};

// Data of the present step in one range of pairs, for the statistics.
struct RangeStatistics {
  std::vector<PatchWork> work;       // [patches of the active pairs]
  std::vector<NewContact> begun;     // contacts, in order of their pairs
  std::vector<std::int32_t> parted;  // open contacts that have lost their force
  std::vector<NormalLoadSample> pressed;
  std::vector<TriangleLoad> triangle_loads;
};

struct StatisticsWorkspace {
  explicit StatisticsWorkspace(const Model& model);

  std::vector<std::int32_t>
      monitored;  // [boundaries] number among the monitored boundaries; -1: not monitored
  std::vector<NearestTriangle> monitored_index;  // [monitored]
  std::vector<std::uint32_t>
      first_of_monitored;  // [monitored] triangle, in StatisticsState::triangles
  std::vector<NearestTriangle> surface_index;  // [shapes], or none
  std::vector<std::uint32_t> first_of_shape;   // [shapes] triangle, in StatisticsState::surfaces
  // Of the present step:
  std::vector<NormalLoadSample> pressed;
  std::vector<std::int32_t> last_pressed;  // [particles] in `pressed`; -1 between two steps
  std::vector<double> force;               // N, [triangles] 0 between two steps
  std::vector<std::uint32_t> touched;      // triangles
};

}  // namespace firn
