#include "firn/mesh.h"

#include <gtest/gtest.h>

#include <cmath>

namespace firn {
namespace {

TriangleMesh unit_cube() {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.vertices.emplace_back(i & 1, i >> 1 & 1, i >> 2);
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

TriangleMesh corner_tetrahedron(double a, double b, double c) {
  return {{Vec3::Zero(), {a, 0, 0}, {0, b, 0}, {0, 0, c}},
          {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

TriangleMesh moved(TriangleMesh mesh, const Pose& pose) {
  for (Vec3& v : mesh.vertices) v = pose * v;
  return mesh;
}

TEST(MassProperties, CubeHasItsClosedForm) {
  const MassProperties m = mass_properties(unit_cube());
  EXPECT_NEAR(m.volume, 1, 1e-15);
  EXPECT_LT((m.centroid - Vec3(0.5, 0.5, 0.5)).norm(), 1e-15);
  EXPECT_LT((m.inertia - Mat3::Identity() / 6).norm(), 1e-15);  // (b^2 + c^2) / 12 each
}

TEST(MassProperties, CornerTetrahedronHasItsClosedForm) {
  const double a = 2, b = 3, c = 5;
  const MassProperties m = mass_properties(corner_tetrahedron(a, b, c));
  const double volume = a * b * c / 6;
  EXPECT_NEAR(m.volume, volume, 1e-14);
  EXPECT_LT((m.centroid - Vec3(a, b, c) / 4).norm(), 1e-14);
  // About the centroid: integral of x^2 = V a^2 3/80, of x y = -V a b / 80.
  EXPECT_NEAR(m.inertia(0, 0), volume * 3 / 80 * (b * b + c * c), 1e-13);
  EXPECT_NEAR(m.inertia(1, 1), volume * 3 / 80 * (c * c + a * a), 1e-13);
  EXPECT_NEAR(m.inertia(2, 2), volume * 3 / 80 * (a * a + b * b), 1e-13);
  EXPECT_NEAR(m.inertia(0, 1), volume * a * b / 80, 1e-13);
  EXPECT_NEAR(m.inertia(1, 2), volume * b * c / 80, 1e-13);
}

TEST(MassProperties, TurnAndShiftWithTheBody) {
  const TriangleMesh mesh = corner_tetrahedron(2, 3, 5);
  const Pose pose = {Quat(0.8, 0.3, -0.5, 0.1).normalized().toRotationMatrix(), {10, -20, 30}};
  const MassProperties at_home = mass_properties(mesh), away = mass_properties(moved(mesh, pose));
  EXPECT_NEAR(away.volume, at_home.volume, 1e-13);
  EXPECT_LT((away.centroid - pose * at_home.centroid).norm(), 1e-13);
  EXPECT_LT((away.inertia - pose.rotation * at_home.inertia * pose.rotation.transpose()).norm(),
            1e-12);
}

TEST(MassProperties, SmallBodyFarAwayKeepsItsDigits) {
  const Pose pose = {0.01 * Mat3::Identity(), {3, 4, 5}};
  const MassProperties m = mass_properties(moved(unit_cube(), pose));
  // Coordinates of 5 m hold 1e-15 m, one part in 1e13 of the edge.
  EXPECT_NEAR(m.volume * 1e6, 1, 1e-12);
  EXPECT_LT((m.inertia * 1e10 - Mat3::Identity() / 6).norm(), 1e-12);
}

TEST(Inspect, ClosedMeshIsSound) {
  EXPECT_TRUE(inspect(unit_cube()).is_valid());
  EXPECT_EQ(inspect(unit_cube()).to_message(), "");
}

TEST(Inspect, MissingTriangleLeavesThreeOpenEdges) {
  TriangleMesh mesh = unit_cube();
  mesh.triangles.pop_back();
  EXPECT_EQ(inspect(mesh).open_edges, 3);
  EXPECT_EQ(inspect(mesh).to_message(), "3 open edges");
}

TEST(Inspect, TurnedTriangleIsFlippedAgainstThreeNeighbors) {
  TriangleMesh mesh = unit_cube();
  std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  const MeshDefects defects = inspect(mesh);
  EXPECT_EQ(defects.flipped_edges, 3);
  EXPECT_FALSE(defects.is_valid());
}

TEST(Inspect, InsideOutMeshIsNamed) {
  TriangleMesh mesh = unit_cube();
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_TRUE(inspect(mesh).inside_out);
  EXPECT_EQ(inspect(mesh).flipped_edges, 0);
  EXPECT_EQ(inspect(mesh).to_message(), "inside out");
}

TEST(Inspect, RepeatedTriangleMakesEdgesOfThree) {
  TriangleMesh mesh = unit_cube();
  mesh.triangles.push_back(mesh.triangles[0]);
  EXPECT_EQ(inspect(mesh).duplicated, 1);
  EXPECT_EQ(inspect(mesh).nonmanifold_edges, 3);
}

TEST(Inspect, NeedleOfNoAreaIsDegenerate) {
  TriangleMesh mesh = unit_cube();
  mesh.vertices.emplace_back(0.5, 0, 0);  // on the edge 0-1
  mesh.triangles.push_back({0, 8, 1});
  EXPECT_EQ(inspect(mesh).degenerate, 1);
}

TEST(Inspect, NonFiniteCoordinateIsNamedAndNothingElseMeasured) {
  TriangleMesh mesh = unit_cube();
  mesh.vertices[3].x() = std::nan("");
  EXPECT_TRUE(inspect(mesh).non_finite);
  EXPECT_EQ(inspect(mesh).to_message(), "a coordinate is not a finite number");
}

TEST(BoundingBox, HoldsAllVertices) {
  const auto [lower, upper] = bounding_box(corner_tetrahedron(2, 3, 5));
  EXPECT_EQ(lower, Vec3::Zero());
  EXPECT_EQ(upper, Vec3(2, 3, 5));
}

// Every triangle with separate corners, as STL files have it.
TriangleMesh exploded(const TriangleMesh& mesh, double scatter) {
  TriangleMesh result;
  for (const auto& t : mesh.triangles) {
    const int first = static_cast<int>(result.vertices.size());
    for (int k = 0; k < 3; ++k) {
      const double sign = (first + k) % 2 ? 1 : -1;
      result.vertices.push_back(mesh.vertices[t[k]] + sign * scatter * Vec3(1, -1, 1));
    }
    result.triangles.push_back({first, first + 1, first + 2});
  }
  return result;
}

TEST(Weld, JoinsCornersWithinTheTolerance) {
  const TriangleMesh loose = exploded(unit_cube(), 1e-7);
  EXPECT_EQ(inspect(loose).open_edges, 36);
  EXPECT_FALSE(inspect(weld(loose, 0)).is_valid());
  const TriangleMesh welded = weld(loose, 1e-6);
  EXPECT_EQ(welded.vertices.size(), 8u);
  EXPECT_TRUE(inspect(welded).is_valid());
}

TEST(Weld, WithoutToleranceJoinsEqualCorners) {
  TriangleMesh loose = exploded(unit_cube(), 0);
  for (Vec3& v : loose.vertices) {
    if (v.x() == 0) v.x() = -0.0;  // equal to +0
  }
  EXPECT_EQ(weld(loose, 0).vertices.size(), 8u);
}

TEST(Weld, DropsTrianglesThatCollapse) {
  TriangleMesh mesh = unit_cube();
  mesh.vertices.push_back(mesh.vertices[7] + Vec3(1e-9, 0, 0));
  mesh.triangles.push_back({0, 7, 8});
  EXPECT_EQ(weld(mesh, 1e-6).triangles.size(), 12u);
}

}  // namespace
}  // namespace firn
