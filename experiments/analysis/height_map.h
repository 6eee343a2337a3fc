// The surface of a heap, seen from above: pure geometry of placed triangle meshes.
#pragma once

#include <functional>
#include <vector>

#include "firn/mesh.h"

namespace firn {

// A particle where it lies. The mesh is not owned.
struct PlacedMesh {
  const TriangleMesh* mesh = nullptr;  // m, shape axes
  Pose pose;                           // shape axes -> world
};

// Rectangular cells in plan. Cell (i, j) is read at its middle,
// x = corner_x + (i + 1/2) step_x, y = corner_y + (j + 1/2) step_y.
// A negative step runs the cells the other way, so that two mirrored grids see mirrored heaps
// alike.
struct PlanGrid {
  double corner_x = 0, corner_y = 0;  // m, world
  double step_x = 0, step_y = 0;      // m
  int nx = 0, ny = 0;

  // Cells of about `step` between two corners, an exact number of them each way. Throws InputError
  // for more than 1e8 of them.
  static PlanGrid between(double x_from, double x_to, double y_from, double y_to, double step);
  double x(int i) const { return corner_x + (i + 0.5) * step_x; }
  double y(int j) const { return corner_y + (j + 0.5) * step_y; }
};

// What one particle covers of one cell: the vertical line through the middle of the cell enters the
// mesh first at `bottom` and leaves it last at `top` (a hollow between them counts as filled).
struct ColumnSpan {
  int i = 0, j = 0;
  double bottom = 0, top = 0;  // m, world z
};
std::vector<ColumnSpan> column_spans(const PlacedMesh& body, const PlanGrid& grid);

// Which particles stand, through others, on the floor z = 0: those whose underside comes within
// `reach` (m) of the floor or of the top of a particle that does, in some cell. What hangs in the
// air (still falling when the run ended) does not. `has_floor` says where in x, y there is a floor.
std::vector<bool> supported(const std::vector<PlacedMesh>& bodies, const PlanGrid& grid,
                            double reach, const std::function<bool(double x, double y)>& has_floor);

// Highest point of the bodies in every cell; the floor (z = 0) where nothing covers the cell.
struct HeapSurface {
  PlanGrid grid;
  Eigen::ArrayXXd height;                                      // [nx, ny] m
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> covered;  // [nx, ny]
};
HeapSurface heap_surface(const std::vector<PlacedMesh>& bodies, const PlanGrid& grid);

// The same with every pit filled that a horizontal square of edge `width` (m) cannot enter: a
// morphological closing (ISO 16610-85). A slope of any angle passes unchanged, edges included.
HeapSurface close_pits(HeapSurface surface, double width);

}  // namespace firn
