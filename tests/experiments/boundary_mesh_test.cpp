#include "experiments/boundary_mesh.h"

#include <gtest/gtest.h>

#include <cmath>

namespace firn {
namespace {

// Two triangles that share the y axis from (0,0,0) to (0,1,0); their far corners lie at x = -1 and
// x = 1, raised by `left` and `right`. Both face upwards.
TriangleMesh two_triangles(double left, double right) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 1, 0}, {-1, 0.5, left}, {1, 0.5, right}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}};
  return mesh;
}

// The one internal face of a part.
const ConvexPart::Face& seam(const ConvexPart& part) {
  const ConvexPart::Face* found = nullptr;
  for (const auto& face : part.faces) {
    if (!face.internal) continue;
    EXPECT_EQ(found, nullptr) << "more than one seam";
    found = &face;
  }
  EXPECT_NE(found, nullptr) << "no seam";
  return *found;
}

double volume(const ConvexPart& part) {
  double six_volumes = 0;  // of tetrahedra from the origin to fans of the faces
  for (const auto& face : part.faces) {
    const Vec3 a = part.vertex(part.loops[face.first]);
    for (int i = 1; i + 1 < face.count; ++i) {
      six_volumes += a.dot(part.vertex(part.loops[face.first + i])
                               .cross(part.vertex(part.loops[face.first + i + 1])));
    }
  }
  return six_volumes / 6;
}

TEST(BoundaryMesh, CoplanarTrianglesMeetSquarely) {
  const auto parts = boundary_parts(two_triangles(0, 0), 0.1);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_TRUE(seam(parts[0]).normal.isApprox(Vec3::UnitX(), 1e-12));
  EXPECT_TRUE(seam(parts[1]).normal.isApprox(-Vec3::UnitX(), 1e-12));
  // Prisms of area 1/2: their free sides are square to the face.
  for (const auto& part : parts) {
    EXPECT_NEAR(volume(part), 0.5 * 0.1, 1e-12);
    EXPECT_EQ(part.radius, 0);
    EXPECT_EQ(part.faces.size(), 5u);
  }
}

TEST(BoundaryMesh, RidgeIsCutAlongItsBisector) {
  // Both faces fall away from the ridge by 45 degrees: the bisector is upright. The left prism
  // narrows downwards: its section is a parallelogram less the triangle behind the bisector.
  const double t = 0.1, slope = std::sqrt(2.0);
  const auto parts = boundary_parts(two_triangles(-1, -1), t);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_TRUE(seam(parts[0]).normal.isApprox(Vec3::UnitX(), 1e-12));
  EXPECT_TRUE(seam(parts[1]).normal.isApprox(-Vec3::UnitX(), 1e-12));
  // Each normal belongs to exactly one side: n2 . n <= n1 . n on the side of the first.
  const Vec3 toward_right = Vec3(0.2, 0, 1).normalized();
  EXPECT_GT(seam(parts[0]).normal.dot(toward_right), 0);
  EXPECT_LT(seam(parts[1]).normal.dot(toward_right), 0);
  // Face area slope/2; at depth h the wedge over the ridge has taken h along the slope
  // (tan 45 = 1) off its base edge, where the face is 1 - h/slope long.
  const double steps = 1e4;
  double expected = 0;
  for (double i = 0.5; i < steps; ++i) {
    const double h = t * i / steps, left = slope - h;
    expected += t / steps * 0.5 * left * (left / slope);
  }
  EXPECT_NEAR(volume(parts[0]), expected, 1e-9);
}

TEST(BoundaryMesh, ValleyIsClosedAlongItsBisector) {
  const double t = 0.1;
  const auto parts = boundary_parts(two_triangles(1, 1), t);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_TRUE(seam(parts[0]).normal.isApprox(Vec3::UnitX(), 1e-12));
  // Behind the valley the prisms widen until they meet: the lowest points lie on the bisector,
  // below the edge by t / cos 45.
  double lowest = 0;
  for (int i = 0; i < parts[0].vertex_count; ++i) {
    const Vec3 v = parts[0].vertex(i);
    EXPECT_LE(v.x(), 1e-12);
    lowest = std::min(lowest, v.z());
  }
  EXPECT_NEAR(lowest, -t * std::sqrt(2.0), 1e-12);
}

TEST(BoundaryMesh, ThinFinsStayOpenAtTheFold) {
  // Two triangles that fold back on each other: a bisector would leave nothing of the sheet.
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 1, 0}, {-1, 0.5, 0.02}, {-1, 0.5, -0.02}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}};
  for (const auto& part : boundary_parts(mesh, 0.1)) {
    for (const auto& face : part.faces) EXPECT_FALSE(face.internal);
  }
}

TEST(BoundaryMesh, ClosedConvexMeshIsOnePart) {
  const auto parts = boundary_parts(box_mesh({1, 2, 3}), 0.1);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].faces.size(), 6u);
  EXPECT_NEAR(volume(parts[0]), 6, 1e-12);
}

TEST(BoundaryMesh, ClosedConcaveMeshIsAShell) {
  // A box whose lid is pressed in at its middle.
  TriangleMesh mesh = box_mesh({2, 2, 2});
  const int middle = static_cast<int>(mesh.vertices.size());
  mesh.vertices.push_back({0, 0, 0.5});
  std::erase_if(mesh.triangles, [&](const auto& t) {
    return std::ranges::all_of(t, [&](int i) { return mesh.vertices[i].z() > 0.9; });
  });
  for (const auto& [a, b] : {std::pair{4, 5}, {5, 7}, {7, 6}, {6, 4}}) {
    mesh.triangles.push_back({a, b, middle});
  }
  ASSERT_TRUE(inspect(mesh).sound()) << inspect(mesh).sentence();
  const auto parts = boundary_parts(mesh, 0.1);
  EXPECT_EQ(parts.size(), 14u);
  for (const auto& part : parts) EXPECT_EQ(part.internal_normals.size(), 3u);
}

TEST(BoundaryMesh, RefusesNeighboursThatFaceOppositeWays) {
  TriangleMesh mesh = two_triangles(0, 0);
  std::swap(mesh.triangles[1][0], mesh.triangles[1][1]);
  EXPECT_THROW(boundary_parts(mesh, 0.1), InputError);
}

TEST(BoundaryMesh, BoxFacesOutwards) {
  const TriangleMesh box = box_mesh({1, 2, 3});
  EXPECT_TRUE(inspect(box).sound());
  EXPECT_NEAR(mass_properties(box).volume, 6, 1e-12);
}

}  // namespace
}  // namespace firn
