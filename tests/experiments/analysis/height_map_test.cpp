#include "experiments/analysis/height_map.h"

#include <gtest/gtest.h>

#include "tests/support/synthetic_heap.h"

namespace firn {
namespace {

using synthetic::box_mesh;

// 20 x 10 cells of 1 mm around the origin.
const PlanGrid kGrid = PlanGrid::between(-10e-3, 10e-3, -5e-3, 5e-3, 1e-3);

PlacedMesh at(const TriangleMesh& mesh, double x, double y, double z) {
  return {&mesh, {Mat3::Identity(), Vec3(x, y, z)}};
}

bool everywhere(double, double) { return true; }

TEST(Surface, ColumnSpansOfABox) {
  const TriangleMesh box = box_mesh({6e-3, 4e-3, 8e-3});
  const std::vector<ColumnSpan> spans = column_spans(at(box, 1e-3, 0, 10e-3), kGrid);
  ASSERT_EQ(spans.size(), 24u);  // 6 x 4 cells of 1 mm
  for (const ColumnSpan& s : spans) {
    EXPECT_NEAR(s.bottom, 6e-3, 1e-15);
    EXPECT_NEAR(s.top, 14e-3, 1e-15);
    EXPECT_LT(std::abs(kGrid.x(s.i) - 1e-3), 3e-3);
    EXPECT_LT(std::abs(kGrid.y(s.j)), 2e-3);
  }
}

TEST(Surface, ColumnSpansFollowATiltedFace) {
  // A cube on its edge: underside |x|, top 2 h - |x| with h half the diagonal.
  const double edge = 10e-3, h = edge / std::sqrt(2.0);
  const TriangleMesh cube = box_mesh({edge, edge, edge});
  PlacedMesh body = at(cube, 0, 0, h);
  body.pose.rotation = Eigen::AngleAxisd(M_PI / 4, Vec3::UnitY()).toRotationMatrix();
  for (const ColumnSpan& s : column_spans(body, kGrid)) {
    const double x = std::abs(kGrid.x(s.i));
    EXPECT_NEAR(s.bottom, x, 1e-12);
    EXPECT_NEAR(s.top, 2 * h - x, 1e-12);
  }
}

TEST(Surface, OutsideTheGridThereIsNothing) {
  const TriangleMesh box = box_mesh({4e-3, 4e-3, 4e-3});
  EXPECT_TRUE(column_spans(at(box, 20e-3, 0, 0), kGrid).empty());
  EXPECT_EQ(column_spans(at(box, 10e-3, 0, 0), kGrid).size(), 8u);  // half of it: 2 x 4 cells
}

TEST(Surface, HighestPointsAndTheFloor) {
  const TriangleMesh box = box_mesh({4e-3, 4e-3, 4e-3});
  const HeightMap s = height_map({at(box, 0, 0, 2e-3), at(box, 2e-3, 0, 6e-3)}, kGrid);
  const auto height = [&](double x) { return s.height(static_cast<int>((x + 10e-3) / 1e-3), 5); };
  EXPECT_NEAR(height(-1.5e-3), 4e-3, 1e-15);
  EXPECT_NEAR(height(0.5e-3), 8e-3, 1e-15);
  EXPECT_EQ(height(6.5e-3), 0);
  EXPECT_EQ(s.covered.count(), 6 * 4);
}

TEST(Surface, MirroredGridsSeeMirroredHeapsAlike) {
  const TriangleMesh cube = synthetic::crescent(0.2);
  TriangleMesh mirrored = cube;
  for (Vec3& v : mirrored.vertices) v.x() = -v.x();
  for (auto& t : mirrored.triangles) std::swap(t[1], t[2]);
  Pose pose{Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix(),
            Vec3(3e-3, 1e-3, 5e-3)};
  const Mat3 flip = Vec3(-1, 1, 1).asDiagonal();
  const Pose image{flip * pose.rotation * flip, flip * pose.translation};
  const PlanGrid back = PlanGrid::between(10e-3, -10e-3, -5e-3, 5e-3, 1e-3);
  const HeightMap a = height_map({{&cube, pose}}, kGrid);
  const HeightMap b = height_map({{&mirrored, image}}, back);
  EXPECT_GT(a.covered.count(), 10);
  EXPECT_TRUE((a.covered == b.covered).all());
  EXPECT_LT((a.height - b.height).abs().maxCoeff(), 1e-15);
}

TEST(Surface, WhatHangsInTheAirIsNotSupported) {
  const TriangleMesh box = box_mesh({4e-3, 4e-3, 4e-3});
  const std::vector<PlacedMesh> bodies{
      at(box, 0, 0, 2e-3),       // on the floor
      at(box, 2e-3, 0, 6.3e-3),  // on the first, 0.3 mm above it
      at(box, 2e-3, 0, 20e-3),   // in the air
      at(box, 2e-3, 0, 24e-3),   // on the one in the air
      at(box, -8e-3, 0, 3e-3),   // 1 mm above the floor
  };
  EXPECT_EQ(find_supported(bodies, kGrid, 0.5e-3, everywhere),
            (std::vector<bool>{true, true, false, false, false}));
  const auto left_half = [](double x, double) { return x < -2e-3; };
  EXPECT_EQ(find_supported(bodies, kGrid, 0.5e-3, left_half), std::vector<bool>(5, false));
}

TEST(Surface, ClosingLeavesASlopeAsItIs) {
  HeightMap slope = height_map({}, kGrid);
  for (int i = 0; i < kGrid.nx; ++i) {
    for (int j = 0; j < kGrid.ny; ++j) slope.height(i, j) = 0.3 * kGrid.x(i) - 0.1 * kGrid.y(j);
  }
  const HeightMap closed = close_height_map(slope, 5e-3);
  EXPECT_LT((closed.height - slope.height).abs().maxCoeff(), 1e-15);
}

TEST(Surface, ClosingFillsNarrowPitsOnly) {
  HeightMap flat = height_map({}, kGrid);
  flat.height.setConstant(10e-3);
  flat.height.block(3, 3, 3, 4).setZero();    // 3 mm wide: a 5 mm square does not enter
  flat.height.block(10, 0, 8, 10).setZero();  // 8 mm wide: it does
  const HeightMap closed = close_height_map(flat, 5e-3);
  EXPECT_EQ(closed.height.topRows(10).minCoeff(), 10e-3);
  EXPECT_EQ(closed.height.block(10, 0, 8, 10).maxCoeff(), 0);
}

}  // namespace
}  // namespace firn
