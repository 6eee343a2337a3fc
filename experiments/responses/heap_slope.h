// The slope of a drained heap: a line through the surface that the particles make on one ledge.
// Choices and their measured accuracy: docs/responses.md.
#pragma once

#include <string>
#include <vector>

#include "experiments/analysis/height_map.h"
#include "experiments/analysis/line_fit.h"
#include "experiments/case/case.h"

namespace firn {

// World frame of the experiment: the box is centred on x = 0 and y = 0, its floor is z = 0, and the
// door is the strip |x| < door_width / 2 of the floor.
enum class Side { left, right };  // x < 0, x > 0

// The window in which a surface is fitted, m: distance from where the ledge begins.
struct FitWindow {
  double from = 0, to = 0;
};

// A strip of floor (z = 0) along x with a heap on it, as wide as the box is deep. `begin` may lie
// on either side of `end`: distances count from it.
struct Ledge {
  double begin = 0, end = 0;    // m, x
  double y_min = 0, y_max = 0;  // m
  FitWindow window;
};
// The ledge on one side of the door, from its lip to the end wall. Throws InputError when the
// margins leave less than two particle sizes of the ledge.
FitWindow fit_window(const DrainedRepose& setup, double particle_size);
// The same of a ledge of any length, m; `what` begins the message.
FitWindow fit_window(double length, double begin_margin, double end_margin, double particle_size,
                     const std::string& what);
Ledge ledge_of(const DrainedRepose& setup, Side side, double particle_size);

// Height over distance from the ledge's begin.
struct HeapSlope {
  FitWindow window;
  std::vector<double> distance;     // [columns] m
  std::vector<double> mean_height;  // [columns] m, mean over the depth of the box
  double covered = 0;               // fraction of the window's plan area under particles
  Line robust, least_squares;       // m over m
  double robust_angle = 0, least_squares_angle = 0;  // deg, positive: rises towards `end`
  double robust_uncertainty = 0, least_squares_uncertainty = 0;  // deg, one standard deviation
};
// `particles` are those that belong to the heap (see standing()); `mean_volume` (m^3) of one of
// them sets the smallest uncertainty. An empty ledge is a slope of zero. Deterministic.
HeapSlope heap_slope(const std::vector<PlacedMesh>& particles, const Ledge& ledge,
                     double particle_size, double mean_volume);
HeapSlope heap_slope(const std::vector<PlacedMesh>& particles, const DrainedRepose& setup,
                     Side side, double particle_size, double mean_volume);

// The lines through a closed surface whose first axis counts from where the ledge begins, without
// uncertainties. Both heap_slope() and outlines of photographs, which have one row, end here.
HeapSlope surface_slope(const HeightMap& closed, const FitWindow& window);

// The surface of an outline: height(k) at the middle of cell k of a ledge `length` long, counted
// from its begin, with the pits closed as in heap_slope(). `covered`: where there are particles.
HeightMap closed_outline(const Eigen::ArrayXd& height,
                           const Eigen::Array<bool, Eigen::Dynamic, 1>& covered, double length,
                           double particle_size);
// Cells of that outline: eight a particle.
PlanGrid outline_grid(double length, double particle_size);
// What the roughness of an outline leaves open of its robust angle, one standard deviation, deg.
double outline_roughness(const HeapSlope& outline, double particle_size);
// The outline of simulated particles in parallel projection from the front of the box: the highest
// point over the depth in each column. Uncertainties are outline_roughness().
HeapSlope outline_slope(const std::vector<PlacedMesh>& particles, const Ledge& ledge,
                        double particle_size);

struct MeanHeight {
  double value = 0, uncertainty = 0;  // m, one standard deviation
};
// How much higher the heap stands against the two walls along the ledge than in the middle between
// them, over the window: mean height of two strips one particle size wide at the walls, less that
// of two such strips in the middle. Throws InputError when the box is not deep enough for them.
MeanHeight wall_height_excess(const std::vector<PlacedMesh>& particles, const Ledge& ledge,
                              double particle_size);

// Of a patch of surface; the uncertainty from tiles of one particle size, as many as fit.
MeanHeight mean_height(const Eigen::ArrayXXd& height, const PlanGrid& grid, double particle_size);

// Which particles stand on the floor, the rest hang in the air.
std::vector<bool> standing(const std::vector<PlacedMesh>& particles, const DrainedRepose& setup,
                           double particle_size, bool door_open);

// Surface over a rectangle of the floor, without pits that no particle fits into.
HeightMap closed_surface(const std::vector<PlacedMesh>& particles, double x_from, double x_to,
                           double y_min, double y_max, double particle_size);

// Whether particles bridge the opening from lip to lip, seen from above.
bool spans_opening(const std::vector<PlacedMesh>& particles, const DrainedRepose& setup,
                   double particle_size);

}  // namespace firn
