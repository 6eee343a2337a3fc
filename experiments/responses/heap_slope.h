// Slope of a drained heap: a line fitted to the height map of the particles on one ledge. Reasons
// and measured accuracy: docs/responses.md.
#pragma once

#include <string>
#include <vector>

#include "experiments/analysis/height_map.h"
#include "experiments/analysis/line_fit.h"
#include "experiments/case/case.h"

namespace firn {

// Axes of the experiment: the box is centered at x = 0, y = 0; its floor is z = 0; the door is the
// strip |x| < door_width / 2 of the floor.
enum class Side { left, right };  // x < 0, x > 0

// Fit window, m: distances from the begin of the ledge.
struct FitWindow {
  double from = 0, to = 0;
};

// A strip of floor (z = 0) along x with a heap. Distances count from `begin`, which may be larger
// or smaller than `end`.
struct Ledge {
  double begin = 0, end = 0;    // m, x
  double y_min = 0, y_max = 0;  // m
  FitWindow window;
};
// Fit window of the ledge on either side of the door, from the lip to the end wall. Throws
// InputError if the margins leave less than two particle sizes.
FitWindow fit_window(const DrainedRepose& setup, double particle_size);
// The same for a ledge of the length `length` (m). `what`: begin of the message.
FitWindow fit_window(double length, double begin_margin, double end_margin, double particle_size,
                     const std::string& what);
Ledge ledge_of(const DrainedRepose& setup, Side side, double particle_size);

// Height profile of a heap over the distance from the begin of the ledge, and fitted lines.
struct HeapSlope {
  FitWindow window;
  std::vector<double> distance;     // [columns] m
  std::vector<double> mean_height;  // [columns] m, mean over y
  double covered = 0;               // fraction of the area of the window below particles
  Line robust, least_squares;       // slope in m/m, intercept in m
  double robust_angle = 0,
         least_squares_angle = 0;  // deg; positive: height increases towards `end`
  double robust_uncertainty = 0, least_squares_uncertainty = 0;  // deg, one standard deviation
};
// `particles`: those of the heap, see supported_particles(). `mean_volume` (m^3): of a particle;
// determines the least uncertainty. The slope of an empty ledge is 0. Deterministic.
HeapSlope heap_slope(const std::vector<PlacedMesh>& particles, const Ledge& ledge,
                     double particle_size, double mean_volume);
HeapSlope heap_slope(const std::vector<PlacedMesh>& particles, const DrainedRepose& setup,
                     Side side, double particle_size, double mean_volume);

// Lines fitted to a closed height map whose first axis is the distance from the begin of the ledge,
// without uncertainties. Common part of heap_slope() and of outlines in photographs, which have one
// row.
HeapSlope surface_slope(const HeightMap& closed, const FitWindow& window);

// Closed height map of an outline. `height` (m) [cells]: at the centers of the cells of a ledge of
// the length `length` (m), counted from its begin. `covered` [cells]: true where there are
// particles.
HeightMap closed_outline(const Eigen::ArrayXd& height,
                         const Eigen::Array<bool, Eigen::Dynamic, 1>& covered, double length,
                         double particle_size);
// Cells of that outline: eight per particle size.
PlanGrid outline_grid(double length, double particle_size);
// Standard uncertainty of the robust angle of an outline due to its roughness, deg.
double outline_roughness(const HeapSlope& outline, double particle_size);
// Slope of the outline of simulated particles in parallel projection along y: highest point in each
// column. Uncertainties: outline_roughness().
HeapSlope outline_slope(const std::vector<PlacedMesh>& particles, const Ledge& ledge,
                        double particle_size);

struct MeanHeight {
  double value = 0, uncertainty = 0;  // m, one standard deviation
};
// Height of the heap at the two walls along the ledge less that in the middle: mean over the window
// of two strips of one particle size at the walls, less that of two such strips in the middle.
// Throws InputError if the box is too narrow for them.
MeanHeight wall_height_excess(const std::vector<PlacedMesh>& particles, const Ledge& ledge,
                              double particle_size);

// Mean of a height map (m). Its uncertainty follows from the scatter of tiles of one particle size.
MeanHeight mean_height(const Eigen::ArrayXXd& height, const PlanGrid& grid, double particle_size);

// [particles] true for a particle that the floor supports, directly or through others. `door_open`:
// there is no floor in the opening.
std::vector<bool> supported_particles(const std::vector<PlacedMesh>& particles,
                                      const DrainedRepose& setup, double particle_size,
                                      bool door_open);

// Height map of a rectangle of the floor (m), with pits closed that a particle cannot enter.
HeightMap closed_height_map(const std::vector<PlacedMesh>& particles, double x_from, double x_to,
                            double y_min, double y_max, double particle_size);

// True if particles cover the opening from lip to lip in the projection along z.
bool spans_opening(const std::vector<PlacedMesh>& particles, const DrainedRepose& setup,
                   double particle_size);

}  // namespace firn
