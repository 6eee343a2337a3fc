// Beds of many sizes in the same state, for measurements: one bed, laid next to itself.
#pragma once

#include "validation/verification/fixtures/scenes.h"

namespace firn::beds {

inline constexpr int kCubes = 880;  // of one tile

// The box of the drained repose experiment. `stirrer` puts a shaft along its length, 100 mm above
// the floor, with twelve twisted blades of 60 mm tip to tip, which turns at 4 rad/s.
struct Tile {
  scenes::ReposeBox box;
  bool stirrer = false;
  int stirrer_boundary = -1;
};
Tile tile(bool stirrer);

// Fills a tile at rest by dropping its cubes, 1 s (about 20 s of work).
Solver filled(const Tile& tile);

// along x across tiles like this one side by side, with walls of 10 mm between them; every cube,
// and the stirrers, are placed and move as in `from`, in an order that says nothing of their
// places. Only the memory of the contacts is lost: run it a little. The doors of tiles behind each
// other are one.
struct Tiled {
  Model model;
  std::vector<int> doors;  // boundaries
  std::vector<Vec3> position;
  std::vector<Quat> orientation;  // shape axes -> world
  std::vector<Vec3> velocity, angular_velocity;
};
Tiled tiled(const Tile& tile, const Solver& from, int along, int across);
Solver start(const Tiled& bed, int threads);

}  // namespace firn::beds
