// Fillings, taps and what is measured in a bed: helpers of the bulk cases.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "validation/verification/scenes.h"

namespace firn::scenes {

// The five Platonic solids by their number of faces: 4, 6, 8, 12, 20. Corners of the one whose
// volume is that of a sphere of this diameter (m), about its centre.
std::vector<Vec3> platonic_solid(int faces, double diameter);
// Of a solid that is convex: whether a point (m, shape axes) lies within, by its half-spaces.
bool inside(const std::vector<HalfSpace>& sides, const Vec3& point);

// A bed of one shape of die with the volume of a sphere of diameter kDie, in a material of water's
// density. Stiff enough that its own weight overlaps it by a `hardness`-th of the diameter.
inline constexpr double kDie = 0.02;  // m
struct Dice {
  int faces = 12;  // 0: spheres
  double friction = 0.4, wall_friction = 0.4, restitution = 0.3, rolling_resistance = 0;
  double hardness = 5000, density = 1000;
};
double die_mass(const Dice& dice);  // kg
// Model with its shape and materials, no particles, no boundaries.
Model dice_model(const Dice& dice);

// Adds waiting particles [first, last) to a bed as gently as can be: each is turned at random, set
// over a random place of the region, lowered until it comes within `step` of what lies below, and
// let go there from rest. `batch` of them at a time, then `interval` (s) of simulation.
struct Rain {
  Vec3 lower, upper;  // m, region that bodies' centres may take
  double step = 0;    // m
  int batch = 1;
  double interval = 0;  // s
  std::uint64_t seed = 1;
};
void rain(Solver& solver, int first, int last, const Rain& how);

// Lifts all boundaries at `speed` (m/s) by speed * `rise`, takes them down again at once, and waits
// until `period` (s) is over: the bed is thrown up by speed^2 / 2 g.
void tap(Solver& solver, double speed, double rise, double period);

// Fraction of a box of space that present particles fill; convex ones, by their drawn meshes. Read
// on a grid of points `spacing` (m) apart.
double packing_fraction(const Solver& solver, const Vec3& lower, const Vec3& upper, double spacing);
// The height (m) below which this fraction of the present particles have their centres.
double height_below(const Solver& solver, double fraction);

// Mean over independent runs, its standard error, and the scatter of one run.
struct Sample {
  double mean = 0, error = 0, deviation = 0;
  int count = 0;
};
Sample sample(const std::vector<double>& values);

// Kinetic + gravitational + elastic + dissipated - done by boundaries + carried away - brought in
// by particles placed: what the account misses, J.
double energy_gap(const Energy& energy);

// Steps until the kinetic energy per present particle (J) has stayed below `still` for 20 ms, and
// returns true; false when `patience` (s) is over before.
bool settle(Solver& solver, double still, double patience);

}  // namespace firn::scenes
