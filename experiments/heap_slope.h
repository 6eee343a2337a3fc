// The slope of a drained heap: a line through the surface that the particles make on one ledge.
// Choices and their measured accuracy: docs/responses.md.
#pragma once

#include <vector>

#include "experiments/case.h"
#include "experiments/line_fit.h"
#include "experiments/surface.h"

namespace firn {

// World frame of the experiment: the box is centred on x = 0 and y = 0, its floor is z = 0, and the
// door is the strip |x| < door_width / 2 of the floor.
enum class Side { left, right };  // x < 0, x > 0

// The window of one ledge in which the surface is fitted, m: distance from the door's lip.
struct FitWindow {
  double from = 0, to = 0;
};
// Throws InputError when the margins leave less than two particle sizes of the ledge.
FitWindow fit_window(const DrainedRepose& setup, double particle_size);

// Height over distance from the door's lip.
struct HeapSlope {
  FitWindow window;
  std::vector<double> distance;     // [columns] m from the lip
  std::vector<double> mean_height;  // [columns] m, mean over the depth of the box
  double covered = 0;               // fraction of the window's plan area under particles
  Line robust, least_squares;       // m over m
  double robust_angle = 0, least_squares_angle = 0;              // deg, positive: rises to the wall
  double robust_uncertainty = 0, least_squares_uncertainty = 0;  // deg, one standard deviation
};
// `particles` are those that belong to the heap (see standing()); `mean_volume` (m^3) of one of
// them sets the smallest uncertainty. An empty ledge is a slope of zero. Deterministic.
HeapSlope heap_slope(const std::vector<PlacedMesh>& particles, const DrainedRepose& setup,
                     Side side, double particle_size, double mean_volume);

// Which particles stand on the floor, the rest hang in the air.
std::vector<bool> standing(const std::vector<PlacedMesh>& particles, const DrainedRepose& setup,
                           double particle_size, bool door_open);

// Surface over the whole depth of the box between two x, without pits that no particle fits into.
HeapSurface closed_surface(const std::vector<PlacedMesh>& particles, double x_from, double x_to,
                           const DrainedRepose& setup, double particle_size);

// Whether particles bridge the opening from lip to lip, seen from above.
bool spans_opening(const std::vector<PlacedMesh>& particles, const DrainedRepose& setup,
                   double particle_size);

// Of a sample (n - 1); of at least two values.
double standard_deviation(const std::vector<double>& values);

}  // namespace firn
