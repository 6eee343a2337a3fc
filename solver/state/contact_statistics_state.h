// The part of the state that statistics are made from (solver/include/firn/contact_statistics.h).
// The motion reads nothing of it.
#pragma once

#include <cstdint>
#include <vector>

#include "firn/contact_statistics.h"

namespace firn {

// What every step adds to an open contact: one line of the processor's caches.
struct alignas(64) ContactSums {
  Vec3 impulse = Vec3::Zero();                        // N s, world, on a
  double normal_impulse = 0, tangential_impulse = 0;  // N s
  double work = 0;                                    // J taken from the bodies
  double peak = 0;                                    // N
  std::uint64_t last = 0;                             // step that bore a force last
};
static_assert(sizeof(ContactSums) == 64);

// What is written when a contact begins and at new peaks.
struct OpenContact {
  ContactEvent event;       // a below 0: a place that is free
  std::uint64_t start = 0;  // step
  std::int64_t pair = -1;   // in the neighbour list; -1: not listed now
};

struct StatisticsState {
  // Contacts
  std::uint64_t list = 0;                  // number of the neighbour list that pairs refer to
  std::vector<std::int32_t> open_of_pair;  // [pairs] its open contact; -1: none
  std::vector<OpenContact> open;           // with free places
  std::vector<ContactSums> sums;           // [open]
  std::vector<std::int32_t> parted;        // open contacts that bear nothing now
  std::uint64_t free_places = 0;           // in open
  std::vector<SurfaceSums> surfaces;       // [triangles of all shapes]
  std::vector<EnergySums> energies;        // [1 + boundaries][classes]; particles' own pairs first
  // Loads
  std::vector<CompressiveLoad> opposed;  // [particles]
  std::vector<TriangleSums> triangles;   // of all watched boundaries, since:
  std::uint64_t interval_start = 0;      // step
  // [points of the state] the triangle of each at a watched boundary, as of the last search for
  // contacts of its pair; and the neighbour list that the points were stored with.
  std::vector<std::uint32_t> triangle_of_point;
  std::uint64_t points_list = 0;
  // Finished, and not taken yet.
  std::vector<ContactEvent> finished;
  std::vector<double> finished_intervals;        // s, start and end of each
  std::vector<TriangleSums> finished_triangles;  // of each, one behind the other
};

}  // namespace firn
