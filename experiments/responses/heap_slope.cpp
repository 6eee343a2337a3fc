#include "experiments/responses/heap_slope.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include "experiments/analysis/sample_statistics.h"

namespace firn {
namespace {

constexpr double kCellsPerParticle = 8;  // resolution of the surface
// In particle sizes:
constexpr double kReach = 0.25;  // nearer counts as resting on
constexpr double kPit = 1.5;     // narrower pits are no part of the surface
constexpr double kStrip = 1.5;   // width of the strips that are resampled
constexpr double kPiece = 3;     // length of the pieces that the height at the walls is cut into
constexpr int kResamples = 200;

double degrees(double slope) { return std::atan(slope) * kRadToDeg; }

// Both angles after resampling strips of the surface that run up the slope, as wide as a pit:
// neighboring cells show the same particle and are not independent; strips nearly are.
struct AngleSpread {
  double robust = 0, least_squares = 0;  // deg
};
AngleSpread bootstrap(const Eigen::ArrayXXd& height, const std::vector<double>& distance,
                      double strip_cells) {
  const Eigen::Index rows = height.cols();
  const auto strips =
      std::max<Eigen::Index>(2, std::lround(static_cast<double>(rows) / strip_cells));
  Eigen::ArrayXXd sum = Eigen::ArrayXXd::Zero(height.rows(), strips);
  Eigen::ArrayXd count = Eigen::ArrayXd::Zero(strips);
  for (Eigen::Index j = 0; j < rows; ++j) {
    sum.col(j * strips / rows) += height.col(j);
    count(j * strips / rows) += 1;
  }

  std::mt19937_64 random(20260119);  // the same draws every time: one heap has one uncertainty
  std::vector<double> robust, least_squares, profile(distance.size());
  for (int k = 0; k < kResamples; ++k) {
    Eigen::Map<Eigen::ArrayXd> mean(profile.data(), sum.rows());
    mean.setZero();
    double drawn_rows = 0;
    for (Eigen::Index s = 0; s < strips; ++s) {
      const auto drawn = static_cast<Eigen::Index>(random() % static_cast<std::uint64_t>(strips));
      mean += sum.col(drawn);
      drawn_rows += count(drawn);
    }
    mean /= drawn_rows;
    robust.push_back(degrees(theil_sen_line(distance, profile).slope));
    least_squares.push_back(degrees(least_squares_line(distance, profile).slope));
  }
  // Redrawing n of n strips scatters less than n fresh ones would, by (n - 1) / n in the variance.
  const double n = static_cast<double>(strips), small_sample = std::sqrt(n / (n - 1));
  return {standard_deviation(robust) * small_sample,
          standard_deviation(least_squares) * small_sample};
}

// How far one particle more or less, anywhere in the window, turns the least-squares line (root
// mean square over its place): its volume spread over the depth is an area A of the profile, and
// d(slope) = A (s - s_mean) / integral (s - s_mean)^2 ds.
double one_particle_angle(const FitWindow& window, double depth, double volume) {
  const double length = window.to - window.from;
  return degrees(std::sqrt(12.0) * volume / (depth * length * length));
}

}  // namespace

FitWindow fit_window(double length, double begin_margin, double end_margin, double particle_size,
                     const std::string& what) {
  const FitWindow window{begin_margin, length - end_margin};
  if (!(window.from >= 0 && end_margin >= 0 && window.to - window.from >= 2 * particle_size)) {
    throw InputError(
        fmt::format("{} leave no window of two particle sizes ({:.4g} m) on a ledge of {:.4g} m; "
                    "expected smaller margins",
                    what, 2 * particle_size, length));
  }
  return window;
}

FitWindow fit_window(const DrainedRepose& setup, double particle_size) {
  return fit_window((setup.box.x() - setup.door_width) / 2, setup.door_margin, setup.end_margin,
                    particle_size,
                    fmt::format("drained angle of repose: margins of {:.4g} m at the door and "
                                "{:.4g} m at the end wall",
                                setup.door_margin, setup.end_margin));
}

Ledge ledge_of(const DrainedRepose& setup, Side side, double particle_size) {
  const double sign = side == Side::right ? 1 : -1;
  return {sign * setup.door_width / 2, sign * setup.box.x() / 2, -setup.box.y() / 2,
          setup.box.y() / 2, fit_window(setup, particle_size)};
}

HeightMap closed_height_map(const std::vector<PlacedMesh>& particles, double x_from, double x_to,
                            double y_min, double y_max, double particle_size) {
  const PlanGrid grid =
      PlanGrid::between(x_from, x_to, y_min, y_max, particle_size / kCellsPerParticle);
  return close_height_map(height_map(particles, grid), kPit * particle_size);
}

MeanHeight mean_height(const Eigen::ArrayXXd& height, const PlanGrid& grid, double particle_size) {
  const auto cells = [&](double step) {
    return std::max<Eigen::Index>(1, std::lround(particle_size / std::abs(step)));
  };
  const Eigen::Index nx = cells(grid.step_x), ny = cells(grid.step_y);
  std::vector<double> tiles;
  for (Eigen::Index i = 0; i + nx <= height.rows(); i += nx) {
    for (Eigen::Index j = 0; j + ny <= height.cols(); j += ny) {
      tiles.push_back(height.block(i, j, nx, ny).mean());
    }
  }
  return {height.mean(), standard_deviation(tiles) / std::sqrt(static_cast<double>(tiles.size()))};
}

namespace {

// Columns of a surface that lie in the window, and their distance from the ledge's begin, m.
struct WindowColumns {
  std::vector<Eigen::Index> columns;
  std::vector<double> distance;
};
WindowColumns columns_in(const FitWindow& window, const PlanGrid& grid) {
  WindowColumns result;
  for (int i = 0; i < grid.nx; ++i) {
    const double distance = (i + 0.5) * std::abs(grid.step_x);
    if (distance < window.from || distance > window.to) continue;
    result.columns.push_back(i);
    result.distance.push_back(distance);
  }
  return result;
}

// The surface of the whole ledge, so that closing includes cells beyond the window.
HeightMap ledge_surface(const std::vector<PlacedMesh>& particles, const Ledge& ledge,
                        double particle_size) {
  return closed_height_map(particles, ledge.begin, ledge.end, ledge.y_min, ledge.y_max,
                           particle_size);
}

}  // namespace

PlanGrid outline_grid(double length, double particle_size) {
  const double step = particle_size / kCellsPerParticle;
  return PlanGrid::between(0, length, 0, step, step);
}

HeightMap closed_outline(const Eigen::ArrayXd& height,
                         const Eigen::Array<bool, Eigen::Dynamic, 1>& covered, double length,
                         double particle_size) {
  HeightMap outline{outline_grid(length, particle_size), height, covered};
  if (height.size() != outline.grid.nx || covered.size() != outline.grid.nx)
    throw std::logic_error("an outline has the cells of outline_grid()");
  return close_height_map(std::move(outline), kPit * particle_size);
}

// An outline is a line with bumps that are independent after about a particle size d; n of them fit
// into a window of length L. With the variance s^2 of the residuals, that of the slope is
// 12 (d / L) s^2 n / (n - 2) / L^2. A smooth outline is not free of doubt either: one particle more
// or less, which shows 0.3 of its square over the others, turns the line by
// 0.3 sqrt(12) d^2 / L^2.
double outline_roughness(const HeapSlope& outline, double particle_size) {
  constexpr double kShown = 0.3;  // of the square of a particle size
  const double length = outline.window.to - outline.window.from;
  double squares = 0;
  for (std::size_t k = 0; k < outline.distance.size(); ++k) {
    const double residual = outline.mean_height[k] - outline.robust.intercept -
                            outline.robust.slope * outline.distance[k];
    squares += residual * residual / static_cast<double>(outline.distance.size());
  }
  const double n = std::max(length / particle_size, 3.0);
  const double bumps = 12 / n * squares * n / (n - 2) / (length * length);
  const double particle = std::sqrt(12.0) * kShown * std::pow(particle_size / length, 2);
  // d(atan m) = dm / (1 + m^2)
  const double slope = outline.robust.slope;
  return kRadToDeg * std::sqrt(bumps + particle * particle) / (1 + slope * slope);
}

HeapSlope outline_slope(const std::vector<PlacedMesh>& particles, const Ledge& ledge,
                        double particle_size) {
  const HeightMap surface =
      height_map(particles, PlanGrid::between(ledge.begin, ledge.end, ledge.y_min, ledge.y_max,
                                              particle_size / kCellsPerParticle));
  HeapSlope result = surface_slope(
      closed_outline(surface.height.rowwise().maxCoeff(), surface.covered.rowwise().any(),
                     std::abs(ledge.end - ledge.begin), particle_size),
      ledge.window);
  result.robust_uncertainty = result.least_squares_uncertainty =
      outline_roughness(result, particle_size);
  return result;
}

HeapSlope surface_slope(const HeightMap& closed, const FitWindow& window) {
  const auto [columns, distance] = columns_in(window, closed.grid);
  HeapSlope result;
  result.window = window;
  result.distance = distance;
  const Eigen::ArrayXd mean = closed.height(columns, Eigen::all).rowwise().mean();
  result.mean_height.assign(mean.begin(), mean.end());
  result.covered = closed.covered(columns, Eigen::all).cast<double>().mean();
  result.robust = theil_sen_line(result.distance, result.mean_height);
  result.least_squares = least_squares_line(result.distance, result.mean_height);
  result.robust_angle = degrees(result.robust.slope);
  result.least_squares_angle = degrees(result.least_squares.slope);
  return result;
}

HeapSlope heap_slope(const std::vector<PlacedMesh>& particles, const DrainedRepose& setup,
                     Side side, double particle_size, double mean_volume) {
  return heap_slope(particles, ledge_of(setup, side, particle_size), particle_size, mean_volume);
}

HeapSlope heap_slope(const std::vector<PlacedMesh>& particles, const Ledge& ledge,
                     double particle_size, double mean_volume) {
  const HeightMap surface = ledge_surface(particles, ledge, particle_size);
  HeapSlope result = surface_slope(surface, ledge.window);
  const Eigen::ArrayXXd height =
      surface.height(columns_in(ledge.window, surface.grid).columns, Eigen::all);
  const AngleSpread spread =
      bootstrap(height, result.distance, kStrip * particle_size / std::abs(surface.grid.step_y));
  // Resampling covers differences between strips, not correlations of neighbors: a particle is
  // longer than a strip is wide.
  const double shared = one_particle_angle(result.window, ledge.y_max - ledge.y_min, mean_volume);
  result.robust_uncertainty = std::hypot(spread.robust, shared);
  result.least_squares_uncertainty = std::hypot(spread.least_squares, shared);
  return result;
}

MeanHeight wall_height_excess(const std::vector<PlacedMesh>& particles, const Ledge& ledge,
                              double particle_size) {
  const double d = particle_size, depth = ledge.y_max - ledge.y_min;
  if (depth < 4 * d) {
    throw InputError(fmt::format(
        "height at the walls: a box {:.4g} m deep has no room for a strip of one particle size "
        "({:.4g} m) at either wall and two between them; expected a deeper one",
        depth, d));
  }
  // Every strip is closed by itself. In a surface closed as a whole, a pit at a wall is filled from
  // one side only, and the walls come out 2.4 mm too low.
  const auto profile = [&](double y_min) -> Eigen::ArrayXd {
    Ledge strip = ledge;
    strip.y_min = y_min;
    strip.y_max = y_min + d;
    const HeightMap surface = ledge_surface(particles, strip, d);
    return surface.height(columns_in(ledge.window, surface.grid).columns, Eigen::all)
        .rowwise()
        .mean();
  };
  const double middle = (ledge.y_min + ledge.y_max) / 2;
  const Eigen::ArrayXd rise =
      (profile(ledge.y_min) + profile(ledge.y_max - d) - profile(middle - d) - profile(middle)) / 2;
  // Pieces along the ledge of about a cube's length are nearly independent.
  const double length = ledge.window.to - ledge.window.from;
  const auto n = std::max<Eigen::Index>(2, std::lround(length / (kPiece * d)));
  std::vector<double> pieces;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index first = k * rise.size() / n, last = (k + 1) * rise.size() / n;
    pieces.push_back(rise.segment(first, last - first).mean());
  }
  return {rise.mean(), standard_deviation(pieces) / std::sqrt(static_cast<double>(n))};
}

std::vector<bool> supported_particles(const std::vector<PlacedMesh>& particles,
                                      const DrainedRepose& setup, double particle_size,
                                      bool door_open) {
  const PlanGrid grid = PlanGrid::between(-setup.box.x() / 2, setup.box.x() / 2, -setup.box.y() / 2,
                                          setup.box.y() / 2, particle_size / kCellsPerParticle);
  return find_supported(particles, grid, kReach * particle_size, [&](double x, double) {
    return !door_open || std::abs(x) >= setup.door_width / 2;
  });
}

bool spans_opening(const std::vector<PlacedMesh>& particles, const DrainedRepose& setup,
                   double particle_size) {
  const PlanGrid grid =
      PlanGrid::between(-setup.door_width / 2, setup.door_width / 2, -setup.box.y() / 2,
                        setup.box.y() / 2, particle_size / kCellsPerParticle);
  const HeightMap surface = height_map(particles, grid);
  // Covered cells joined edge to edge, starting from the left lip.
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> open = surface.covered;  // not yet reached
  std::vector<std::array<int, 2>> front;
  const auto enter = [&](int i, int j) {
    if (i < 0 || j < 0 || i >= grid.nx || j >= grid.ny || !open(i, j)) return;
    open(i, j) = false;
    front.push_back({i, j});
  };
  for (int j = 0; j < grid.ny; ++j) enter(0, j);
  while (!front.empty()) {
    const auto [i, j] = front.back();
    front.pop_back();
    if (i == grid.nx - 1) return true;
    enter(i - 1, j);
    enter(i + 1, j);
    enter(i, j - 1);
    enter(i, j + 1);
  }
  return false;
}

}  // namespace firn
