// Height maps of heaps, from triangle meshes with given poses.
#pragma once

#include <functional>
#include <vector>

#include "firn/mesh.h"

namespace firn {

// The surface of a particle. The mesh is not owned.
struct PlacedMesh {
  const TriangleMesh* mesh = nullptr;  // m, shape axes
  Pose pose;                           // shape axes -> world
};

// Rectangular cells in the horizontal plane. Cell (i, j) is sampled at its center,
//   x = corner_x + (i + 1/2) step_x, y = corner_y + (j + 1/2) step_y.
// A negative step reverses the order of the cells: mirrored grids give equal maps of mirrored
// heaps.
struct PlanGrid {
  double corner_x = 0, corner_y = 0;  // m, world
  double step_x = 0, step_y = 0;      // m
  int nx = 0, ny = 0;

  // A whole number of cells of about `step` (m) in each direction. Throws InputError for more than
  // 1e8 cells.
  static PlanGrid between(double x_from, double x_to, double y_from, double y_to, double step);
  double x(int i) const { return corner_x + (i + 0.5) * step_x; }
  double y(int j) const { return corner_y + (j + 0.5) * step_y; }
};

// The part of the vertical line through the center of a cell that is inside a particle: from the
// first intersection with the mesh, `bottom`, to the last one, `top`. Hollows in between count as
// filled.
struct ColumnSpan {
  int i = 0, j = 0;
  double bottom = 0, top = 0;  // m, world z
};
std::vector<ColumnSpan> column_spans(const PlacedMesh& body, const PlanGrid& grid);

// Particles that the floor z = 0 supports, directly or through other particles [bodies]. A particle
// is supported if, in some cell, its bottom is within `reach` (m) of the floor or of the top of a
// supported particle. Particles that still fall are not supported. `has_floor`: whether there is a
// floor at x, y (m).
std::vector<bool> find_supported(const std::vector<PlacedMesh>& bodies, const PlanGrid& grid,
                                 double reach,
                                 const std::function<bool(double x, double y)>& has_floor);

// Height of the highest point of the bodies in each cell; 0 in cells without a body.
struct HeightMap {
  PlanGrid grid;
  Eigen::ArrayXXd height;                                      // [nx, ny] m
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> covered;  // [nx, ny]
};
HeightMap height_map(const std::vector<PlacedMesh>& bodies, const PlanGrid& grid);

// Morphological closing (ISO 16610-85) with a horizontal square of edge `width` (m): fills all pits
// that the square cannot enter. Plane slopes do not change, also at the edges of the map.
HeightMap close_height_map(HeightMap surface, double width);

}  // namespace firn
