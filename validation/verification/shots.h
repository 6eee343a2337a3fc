// One body fired at a wall, and what became of it: shared by the cases on tunnelling.
#pragma once

#include <string>

#include "validation/verification/scenes.h"

namespace firn::verification {

// A square sheet about the origin, solid below z = 0.
struct Sheet {
  enum class Kind { plane, box, mesh };
  Kind kind = Kind::box;
  double thickness = 1e-3;  // m
  int cells = 0;            // a mesh has 2 cells^2 triangles
  double size = 0.06;       // m
};
Boundary sheet(const Sheet& s);
// The top of it, as triangles.
TriangleMesh grid(double size, int cells);

struct Shot {
  double speed = 1;              // m/s
  double angle = 0;              // rad from the normal of the sheet
  Vec3 target = Vec3::Zero();    // m, on the sheet
  Quat turn = Quat::Identity();  // shape axes -> world
  Vec3 spin = Vec3::Zero();      // rad/s
  double steps = 10;             // in the shortest quarter period
};
enum class End { held, failed, through };
struct Outcome {
  End end = End::held;
  double energy = 0;    // kinetic energy after, over that before
  std::string message;  // of a run that failed
};
// The body starts above the sheet without gravity. `through`: it came out below, inside the outline
// of the sheet, and nobody complained.
Outcome fire(const Shape& shape, const Sheet& wall, const Shot& shot);

// Height of the lowest point of the swept parts over the centre of mass, m; below zero. turn: shape
// axes -> world.
double lowest_point(const Shape& shape, const Quat& turn);

// Sums over many shots.
struct Tally {
  int shots = 0, held = 0, failed = 0, through = 0;
  double energy = 0;  // largest of those held

  void add(const Outcome& o);
};

}  // namespace firn::verification
