#include "reports/rendering/scene_layout.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace firn {
namespace {

enum SceneView { kPlan, kFront, kSide, kOverview };
using Columns = std::vector<std::vector<SceneView>>;

CanvasBox& box_of(SceneLayout& layout, SceneView view) {
  switch (view) {
    case kPlan:
      return layout.plan;
    case kFront:
      return layout.front;
    case kSide:
      return layout.side;
    case kOverview:
      break;
  }
  return layout.overview;
}

// The front is above the plan, and the side next to the front: as in drawings of machines.
const std::array<Columns, 6> kArrangements = {{{{kFront, kPlan}, {kSide, kOverview}},
                                               {{kFront, kPlan}, {kSide}, {kOverview}},
                                               {{kFront, kPlan, kSide}, {kOverview}},
                                               {{kFront}, {kSide}, {kPlan}, {kOverview}},
                                               {{kOverview}, {kFront, kSide, kPlan}},
                                               {{kOverview, kFront, kSide, kPlan}}}};

struct Candidate {
  SceneLayout layout;
  double width = 0;
};

// The columns side by side with `scale` pixels a meter and an overview of the given width.
Candidate arrange_columns(const Columns& columns, const Eigen::Vector3d& size, double scale,
                          double overview_width, double ratio, const PanelMargins& m) {
  Candidate result;
  for (const std::vector<SceneView>& column : columns) {
    double top = 0, widest = 0;
    for (const SceneView view : column) {
      CanvasBox& box = box_of(result.layout, view);
      if (view == kOverview) {
        box = {result.width, top, overview_width, ratio * overview_width};
        top += box.height;
        widest = std::max(widest, box.width + m.right);
        continue;
      }
      const double wide = scale * size[view == kSide ? 1 : 0];
      const double room = std::max(wide, m.title_width);
      box = {result.width + m.left + (room - wide) / 2, top + m.above, wide,
             scale * size[view == kPlan ? 1 : 2]};
      top += m.above + box.height + m.below;
      widest = std::max(widest, m.left + room + m.right);
    }
    result.width += widest;
    result.layout.height = std::max(result.layout.height, top);
  }
  return result;
}

// Large where the overview and the other views both cover much of the canvas.
double score_of(const SceneLayout& layout, double width) {
  // What is beyond three quarters of the width counts twice: pages and screens are no taller.
  const double height = layout.height + std::max(0.0, layout.height - 0.75 * width);
  const auto share = [&](const CanvasBox& box) {
    return box.width * box.height / (width * height);
  };
  return share(layout.overview) * (share(layout.plan) + share(layout.front) + share(layout.side));
}

}  // namespace

SceneLayout arrange_scene(const Eigen::Vector3d& size, double overview_height_over_width,
                          double width, const PanelMargins& margins) {
  constexpr int kOverviewSizes = 40;
  // A column of all views always fits.
  PanelMargins fitted = margins;
  fitted.title_width = std::min(margins.title_width, width - margins.left - margins.right);
  SceneLayout best;
  double best_score = -1;
  for (const Columns& columns : kArrangements) {
    for (int k = 1; k <= kOverviewSizes; ++k) {
      // From a fiftieth of the width, for towers, to all of it.
      const double overview_width =
          width * std::pow(50, static_cast<double>(k) / kOverviewSizes - 1);
      const auto placed = [&](double scale) {
        return arrange_columns(columns, size, scale, overview_width, overview_height_over_width,
                               fitted);
      };
      // The width grows with the scale.
      double low = 0, high = width / size.maxCoeff();
      if (placed(low).width > width) continue;
      for (int bisection = 0; bisection < 40; ++bisection) {
        const double scale = 0.5 * (low + high);
        (placed(scale).width > width ? high : low) = scale;
      }
      const SceneLayout layout = placed(low).layout;
      const double score = score_of(layout, width);
      if (score > best_score) {
        best_score = score;
        best = layout;
      }
    }
  }
  return best;
}

}  // namespace firn
