// Positions of the views of a scene on one canvas.
#pragma once

#include <Eigen/Core>
#include <array>

namespace firn {

// A rectangle of the canvas, pixels from the left and from the top.
struct CanvasBox {
  double left = 0, top = 0, width = 0, height = 0;
};

// Pixels that each panel needs around its picture: the axes left and below, the title above. A
// picture narrower than its title has `title_width` pixels, in whose middle it stands.
struct PanelMargins {
  double left = 0, below = 0, above = 0, right = 0, title_width = 0;
};

struct SceneLayout {
  CanvasBox plan, front, side;  // the pictures, without their margins
  CanvasBox overview;
  double height = 0;  // pixels of all views with their margins
};

// The plan (x to the right, y up), the front (x, z) and the side (y, z) of a box of the size `size`
// (m, each component positive) to one scale, and an overview of the given ratio of height to width.
// The width exceeds the
// margins left and right. The views are disjoint and lie within `width` and the height of the
// result. Of some arrangements in columns and several sizes of the overview, the result is the one
// with the largest product of two shares of the canvas: that of the overview and that of the other
// views.
SceneLayout arrange_scene(const Eigen::Vector3d& size, double overview_height_over_width,
                          double width, const PanelMargins& margins);

}  // namespace firn
