// Contact statistics, accumulated in every step: options and results. No effect on the motion.
// docs/statistics.md.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "firn/mesh.h"

namespace firn {

// A boundary with sums of loads for each triangle. The mesh may differ from that of the boundary.
struct MonitoredBoundary {
  int boundary = 0;   // index into Model::boundaries
  TriangleMesh mesh;  // m, boundary axes
};

// Energy classes of equal width on a logarithmic scale. Class 0: below the lowest bound. Last
// class: at or above the highest bound.
struct EnergyBins {
  double lowest = 0;   // J, above 0
  int per_decade = 0;  // 0: no classes
  int decades = 0;

  int count() const { return per_decade > 0 ? per_decade * decades + 2 : 0; }
  int of(double energy) const;      // class of an energy in J
  double lower_bound(int k) const;  // J; of class 0: 0
};

// Statistics that a simulation accumulates. Disabled ones cost no time.
struct StatisticsOptions {
  bool deferred = false;  // begin with Solver::start_statistics(), not with the first step

  double merge_gap = 0;  // s: separations of a pair shorter than this do not end a contact

  bool events = false;   // list of contacts
  double threshold = 0;  // N: contacts with a lower peak normal force are not listed

  bool compressive_loads = false;  // on each particle

  std::vector<MonitoredBoundary> monitored;  // loads on the triangles of boundaries
  double interval = 0;                       // s, length of an interval of sums; 0: the whole run

  // Contacts on the surface of each shape, over all of its particles; [shapes] of meshes in shape
  // axes as drawn (m), or none.
  std::vector<TriangleMesh> surfaces;

  EnergyBins energies;  // histogram of dissipated energies

  bool contacts() const { return events || !surfaces.empty() || energies.count() > 0; }
  bool any() const { return contacts() || compressive_loads || !monitored.empty(); }
};

// One contact of two bodies: from the first step with a force to the last one before they separate.
// Forces are sums over the patches of the pair. `a` is a particle; `b` a particle above a, or
// number of particles + boundary.
struct ContactEvent {
  std::int32_t a = 0, b = 0;
  double start = 0;               // s, first step with a force
  double duration = 0;            // s, steps with a force and merged gaps
  double peak_time = 0;           // s
  double peak_normal_force = 0;   // N
  double peak_friction = 0;       // N, friction at peak_time
  double normal_impulse = 0;      // N s, of the normal force
  double tangential_impulse = 0;  // N s, of the magnitude of friction
  Vec3 impulse = Vec3::Zero();    // N s, world, on a, of the total force
  // m/s, of a relative to b at the position of the first force: along the normal (positive:
  // approaching) and tangential.
  double impact_velocity_normal = 0, impact_velocity_tangential = 0;
  Vec3 normal = Vec3::UnitZ();   // unit, world, from a to b, at the peak
  Vec3 position = Vec3::Zero();  // m, world, at the peak; mean of the patches weighted by force
  // m, the same in the shape axes of each body, or in boundary axes.
  Vec3 position_on_a = Vec3::Zero(), position_on_b = Vec3::Zero();
  double dissipated = 0;          // J; of an open contact including the elastic energy
  std::uint64_t open_at_end = 0;  // 1: not ended yet
};

// Two-sided load on a particle: of all pairs of patches on it in one step, the largest min(F_i,
// F_j) (-n_i . n_j), with the normal forces F and the normals n out of the particle. Pairs of
// normals at an angle of at most 90 degrees do not count.
struct CompressiveLoad {
  double load = 0;  // N, largest over all steps; 0: none
  double time = 0;  // s, of that load
  // Bodies that exert it, as in ContactEvent; the one with the larger force first; -1: none.
  std::array<std::int32_t, 2> bodies = {-1, -1};
};

// Loads on one triangle of a boundary, summed over an interval. Each contact point of a patch acts
// on the triangle that was nearest to it at the last contact search of its pair, and friction in
// the proportion of the points' normal forces.
struct TriangleSums {
  double normal_impulse = 0;      // N s, of normal forces
  double tangential_impulse = 0;  // N s, of the magnitude of friction
  Vec3 impulse = Vec3::Zero();    // N s, on the boundary, boundary axes
  double peak = 0;                // N, largest sum of normal forces in a step
  double sliding_distance = 0;    // m, of sliding patches, by their fraction on this triangle
  double sliding_work = 0;        // N m, normal force times sliding distance (Archard)
  double friction_work = 0;       // J taken from the bodies by friction
};
struct LoadInterval {
  double start = 0, end = 0;            // s
  std::vector<TriangleSums> triangles;  // of all monitored boundaries, concatenated
};

// Sums over ended contacts with their peak on one triangle of a shape.
struct SurfaceSums {
  double normal_impulse = 0;     // N s
  double peak_normal_force = 0;  // N, largest
  std::uint64_t contacts = 0;
};

// Sums over ended contacts of one kind of pair and one class of energy.
struct EnergySums {
  double dissipated = 0;  // J
  std::uint64_t contacts = 0;
};

}  // namespace firn
