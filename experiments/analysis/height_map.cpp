#include "experiments/analysis/height_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "experiments/analysis/triangle_scan.h"

namespace firn {
namespace {

constexpr double kSlack = 1e-12;  // of barycentric coordinates

// Largest value within `half` rows. The result has `half` rows more at either end, with the values
// beyond the edge; with them the closing preserves a slope at the edges.
Eigen::ArrayXXd dilate_rows(const Eigen::ArrayXXd& z, int half) {
  Eigen::ArrayXXd out = Eigen::ArrayXXd::Constant(z.rows() + 2 * half, z.cols(), -INFINITY);
  for (int k = 0; k <= 2 * half; ++k) {
    out.middleRows(k, z.rows()) = out.middleRows(k, z.rows()).max(z);
  }
  return out;
}

// Smallest value within `half` rows, undoing the growth of dilate_rows().
Eigen::ArrayXXd erode_rows(const Eigen::ArrayXXd& z, int half) {
  const Eigen::Index rows = z.rows() - 2 * half;
  Eigen::ArrayXXd out = z.topRows(rows);
  for (int k = 1; k <= 2 * half; ++k) out = out.min(z.middleRows(k, rows));
  return out;
}

}  // namespace

PlanGrid PlanGrid::between(double x_from, double x_to, double y_from, double y_to, double step) {
  assert(step > 0);
  constexpr double kMostCells = 1e8;
  const double across = std::abs(x_to - x_from), along = std::abs(y_to - y_from);
  if (!(across > 0 && along > 0 && across / step * (along / step) <= kMostCells))
    throw InputError(
        fmt::format("a surface of {:.4g} m by {:.4g} m cannot be measured in cells of {:.4g} m; "
                    "expected at most {:g} cells",
                    across, along, step, kMostCells));
  PlanGrid grid;
  grid.corner_x = x_from;
  grid.corner_y = y_from;
  grid.nx = std::max(1, static_cast<int>(std::lround(std::abs(x_to - x_from) / step)));
  grid.ny = std::max(1, static_cast<int>(std::lround(std::abs(y_to - y_from) / step)));
  grid.step_x = (x_to - x_from) / grid.nx;
  grid.step_y = (y_to - y_from) / grid.ny;
  return grid;
}

std::vector<ColumnSpan> column_spans(const PlacedMesh& body, const PlanGrid& grid) {
  const TriangleMesh& mesh = *body.mesh;
  std::vector<Vec3> corners(mesh.vertices.size());  // in cell units
  constexpr double huge = std::numeric_limits<double>::infinity();
  double u_min = huge, u_max = -huge, v_min = huge, v_max = -huge;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vec3 p = body.pose * mesh.vertices[k];
    corners[k] = {(p.x() - grid.corner_x) / grid.step_x, (p.y() - grid.corner_y) / grid.step_y,
                  p.z()};
    u_min = std::min(u_min, corners[k].x());
    u_max = std::max(u_max, corners[k].x());
    v_min = std::min(v_min, corners[k].y());
    v_max = std::max(v_max, corners[k].y());
  }
  if (u_max < 0 || v_max < 0 || u_min > grid.nx || v_min > grid.ny) return {};

  // Spans of the body's own rectangle of cells, then only those that were hit.
  const int i_first = std::max(0, cell_index(std::floor(u_min)));
  const int i_last = std::min(grid.nx - 1, cell_index(std::floor(u_max)));
  const int j_first = std::max(0, cell_index(std::floor(v_min)));
  const int j_last = std::min(grid.ny - 1, cell_index(std::floor(v_max)));
  const int across = j_last - j_first + 1;
  std::vector<ColumnSpan> spans(static_cast<std::size_t>((i_last - i_first + 1) * across),
                                ColumnSpan{0, 0, huge, -huge});
  for (const auto& t : mesh.triangles) {
    scan_triangle(corners[t[0]], corners[t[1]], corners[t[2]], grid.nx, grid.ny, kSlack,
                  [&](int i, int j, double z) {
                    ColumnSpan& span =
                        spans[static_cast<std::size_t>((i - i_first) * across + j - j_first)];
                    span.i = i;
                    span.j = j;
                    span.bottom = std::min(span.bottom, z);
                    span.top = std::max(span.top, z);
                  });
  }
  std::erase_if(spans, [](const ColumnSpan& span) { return span.top < span.bottom; });
  return spans;
}

std::vector<bool> find_supported(const std::vector<PlacedMesh>& bodies, const PlanGrid& grid,
                                 double reach,
                                 const std::function<bool(double x, double y)>& has_floor) {
  struct Layer {
    int body;
    double bottom, top;
  };
  std::vector<std::vector<Layer>> layers(static_cast<std::size_t>(grid.nx) * grid.ny);
  std::vector<bool> stands(bodies.size(), false);
  std::vector<int> reached;  // bodies whose dependants are still to be found
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    for (const ColumnSpan& span : column_spans(bodies[k], grid)) {
      layers[static_cast<std::size_t>(span.i) * grid.ny + span.j].push_back(
          {static_cast<int>(k), span.bottom, span.top});
      const bool touches = span.bottom <= reach && span.top > 0;
      if (touches && has_floor(grid.x(span.i), grid.y(span.j))) stands[k] = true;
    }
    if (stands[k]) reached.push_back(static_cast<int>(k));
  }

  std::vector<std::vector<int>> above(bodies.size());  // bodies that rest on body k
  for (const auto& column : layers) {
    for (const Layer& low : column) {
      for (const Layer& high : column) {
        const bool is_above = high.bottom + high.top > low.bottom + low.top;
        if (is_above && high.bottom - low.top <= reach) above[low.body].push_back(high.body);
      }
    }
  }
  while (!reached.empty()) {
    const int k = reached.back();
    reached.pop_back();
    for (int j : above[k]) {
      if (stands[j]) continue;
      stands[j] = true;
      reached.push_back(j);
    }
  }
  return stands;
}

HeightMap height_map(const std::vector<PlacedMesh>& bodies, const PlanGrid& grid) {
  HeightMap surface;
  surface.grid = grid;
  surface.height.setZero(grid.nx, grid.ny);
  surface.covered.setConstant(grid.nx, grid.ny, false);
  for (const PlacedMesh& body : bodies) {
    for (const ColumnSpan& span : column_spans(body, grid)) {
      if (span.top <= 0) continue;
      surface.covered(span.i, span.j) = true;
      surface.height(span.i, span.j) = std::max(surface.height(span.i, span.j), span.top);
    }
  }
  return surface;
}

HeightMap close_height_map(HeightMap surface, double width) {
  const int half_x = static_cast<int>(std::lround(0.5 * width / std::abs(surface.grid.step_x)));
  const int half_y = static_cast<int>(std::lround(0.5 * width / std::abs(surface.grid.step_y)));
  const Eigen::ArrayXXd dilated =
      dilate_rows(dilate_rows(surface.height, half_x).transpose(), half_y);
  surface.height = erode_rows(erode_rows(dilated, half_y).transpose(), half_x);
  return surface;
}

}  // namespace firn
