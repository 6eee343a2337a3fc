#include "reports/rendering/scene_layout.h"

#include <gtest/gtest.h>

#include <random>

namespace firn {
namespace {

// By more than `tolerance`.
bool overlap(const CanvasBox& a, const CanvasBox& b, double tolerance) {
  return std::min(a.left + a.width, b.left + b.width) > std::max(a.left, b.left) + tolerance &&
         std::min(a.top + a.height, b.top + b.height) > std::max(a.top, b.top) + tolerance;
}

// Scenes from a plate to a tower, canvases from a thumbnail to a poster.
TEST(SceneLayout, ViewsAreDisjointInsideAndToOneScale) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-1.5, 1.5), pixels(250, 4000);
  const PanelMargins margins{.left = 60, .below = 40, .above = 30, .right = 10, .title_width = 120};
  constexpr int kScenes = 1000;
  for (int k = 0; k < kScenes; ++k) {
    const Eigen::Vector3d size(std::pow(10, exponent(random)), std::pow(10, exponent(random)),
                               std::pow(10, exponent(random)));
    // About that of a view from above, from the side of positive x and y.
    const double ratio =
        std::pow(10, exponent(random) / 10) * (0.6 + size.z() / (size.x() + size.y()));
    const double width = pixels(random);
    const SceneLayout layout = arrange_scene(size, ratio, width, margins);
    SCOPED_TRACE(testing::Message() << "scene " << k << ", " << size.transpose());
    const double scale = layout.plan.width / size.x();
    const double tolerance = 1e-6 * width;
    EXPECT_GT(scale, 0);
    EXPECT_NEAR(layout.plan.height, scale * size.y(), tolerance);
    EXPECT_NEAR(layout.front.width, scale * size.x(), tolerance);
    EXPECT_NEAR(layout.front.height, scale * size.z(), tolerance);
    EXPECT_NEAR(layout.side.width, scale * size.y(), tolerance);
    EXPECT_NEAR(layout.side.height, scale * size.z(), tolerance);
    EXPECT_NEAR(layout.overview.height, ratio * layout.overview.width, tolerance);

    // The panels with their margins.
    std::vector<CanvasBox> boxes = {layout.overview};
    double area = layout.overview.width * layout.overview.height;
    for (const CanvasBox& panel : {layout.plan, layout.front, layout.side}) {
      boxes.push_back({panel.left - margins.left, panel.top - margins.above,
                       panel.width + margins.left + margins.right,
                       panel.height + margins.above + margins.below});
      area += panel.width * panel.height;
    }
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      EXPECT_GE(boxes[i].left, -tolerance);
      EXPECT_GE(boxes[i].top, -tolerance);
      EXPECT_LE(boxes[i].left + boxes[i].width, width + tolerance);
      EXPECT_LE(boxes[i].top + boxes[i].height, layout.height + tolerance);
      for (std::size_t j = 0; j < i; ++j)
        EXPECT_FALSE(overlap(boxes[i], boxes[j], tolerance)) << i << j;
    }
    // The sides of the scene are alike within a factor of ten.
    if (width > 1000 && size.maxCoeff() < 10 * size.minCoeff()) {
      EXPECT_GT(area, 0.35 * width * layout.height);
      EXPECT_LT(layout.height, 1.5 * width);
    }
  }
}

}  // namespace
}  // namespace firn
