// Sampling of a triangle at the centers of the cells of a grid.
#pragma once

#include <algorithm>
#include <cmath>

#include "firn/math.h"

namespace firn {

// The index of a cell from a coordinate in cell units, limited to the range of int.
inline int cell_index(double number) { return static_cast<int>(std::clamp(number, -1e9, 1e9)); }

// Calls visit(i, j, z) for every cell of a grid of rows x columns cells whose center lies on the
// triangle. Corners: row and column in cell units, and the value to interpolate. `slack`: by which
// a barycentric coordinate may be below 0, so that no cell is missed between two triangles. A
// triangle without area has no cells.
template <class Visit>
void scan_triangle(const Vec3& a, const Vec3& b, const Vec3& c, int rows, int columns, double slack,
                   Visit&& visit) {
  const double area = (b.x() - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (b.y() - a.y());
  if (area == 0) return;
  const auto [u_min, u_max] = std::minmax({a.x(), b.x(), c.x()});
  const auto [v_min, v_max] = std::minmax({a.y(), b.y(), c.y()});
  const int i_first = std::max(0, cell_index(std::ceil(u_min - 0.5)));
  const int i_last = std::min(rows - 1, cell_index(std::floor(u_max - 0.5)));
  const int j_first = std::max(0, cell_index(std::ceil(v_min - 0.5)));
  const int j_last = std::min(columns - 1, cell_index(std::floor(v_max - 0.5)));
  for (int i = i_first; i <= i_last; ++i) {
    for (int j = j_first; j <= j_last; ++j) {
      const double u = i + 0.5, v = j + 0.5;
      const double wa = ((b.x() - u) * (c.y() - v) - (c.x() - u) * (b.y() - v)) / area;
      const double wb = ((c.x() - u) * (a.y() - v) - (a.x() - u) * (c.y() - v)) / area;
      const double wc = 1 - wa - wb;
      if (wa < -slack || wb < -slack || wc < -slack) continue;
      visit(i, j, wa * a.z() + wb * b.z() + wc * c.z());
    }
  }
}

}  // namespace firn
