// The part of the state that statistics are made from (solver/include/firn/contact_statistics.h).
// It does not affect the motion.
#pragma once

#include <cstdint>
#include <vector>

#include "firn/contact_statistics.h"
#include "firn/model.h"

namespace firn {

// Sums of an open contact that every step updates: one cache line.
struct alignas(64) ContactSums {
  Vec3 impulse = Vec3::Zero();                        // N s, world, on a
  double normal_impulse = 0, tangential_impulse = 0;  // N s
  double work = 0;                                    // J taken from the bodies
  double peak = 0;                                    // N
  std::uint64_t last = 0;                             // last step with a force
};
static_assert(sizeof(ContactSums) == 64);

// Data of an open contact that are written when it begins and at new peaks.
struct OpenContact {
  ContactEvent event;       // a below 0: unused element
  std::uint64_t start = 0;  // step
  std::int64_t pair = -1;   // in the neighbor list; -1: not listed now
};

struct StatisticsState {
  std::uint64_t recording = 1;  // 0: before Solver::start_statistics()
  // Contacts
  std::uint64_t list = 0;                  // number of the neighbor list that pairs refer to
  std::vector<std::int32_t> open_of_pair;  // [pairs] its open contact; -1: none
  std::vector<OpenContact> open;           // with unused elements
  std::vector<ContactSums> sums;           // [open]
  std::vector<std::int32_t> parted;        // open contacts without a force now
  std::uint64_t free_places = 0;           // unused elements of `open`
  std::vector<SurfaceSums> surfaces;       // [triangles of all shapes]
  std::vector<EnergySums> energies;        // [1 + boundaries][classes]; particles' own pairs first
  // Loads
  std::vector<CompressiveLoad> opposed;  // [particles]
  std::vector<TriangleSums> triangles;   // of all monitored boundaries, since:
  std::uint64_t interval_start = 0;      // step
  // [points of the state] triangle of each point at a monitored boundary, as of the last contact
  // search of its pair; and the number of the neighbor list with which the points were stored.
  std::vector<std::uint32_t> triangle_of_point;
  std::uint64_t points_list = 0;
  // Finished, not yet passed to the caller.
  std::vector<ContactEvent> finished;
  std::vector<double> finished_intervals;        // s, start and end of each
  std::vector<TriangleSums> finished_triangles;  // of each interval, concatenated
};

// State before the first step, with arrays sized for the options of the model.
StatisticsState empty_statistics(const Model& model);

}  // namespace firn
