#include "experiments/meshes/wall_solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "validation/verification/fixtures/meshes.h"
#include "validation/verification/fixtures/scenes.h"

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
    const Vec3 a = part.vertex(part.face_vertices[face.first]);
    for (int i = 1; i + 1 < face.count; ++i) {
      six_volumes += a.dot(part.vertex(part.face_vertices[face.first + i])
                               .cross(part.vertex(part.face_vertices[face.first + i + 1])));
    }
  }
  return six_volumes / 6;
}

TEST(BoundaryMesh, CoplanarTrianglesAreOnePart) {
  const auto parts = wall_solids(two_triangles(0, 0), 0.1);
  ASSERT_EQ(parts.size(), 1u);
  // A prism of area 1: its free sides are square to the face.
  EXPECT_NEAR(volume(parts[0]), 0.1, 1e-12);
  EXPECT_EQ(parts[0].radius, 0);
  EXPECT_EQ(parts[0].faces.size(), 6u);
  EXPECT_TRUE(parts[0].internal_normals.empty());
}

TEST(BoundaryMesh, AlmostCoplanarTrianglesKeepTheirSeam) {
  // Well beyond the rounding of a file of single precision.
  for (const double height : {1e-5, -1e-5}) {
    const auto parts = wall_solids(two_triangles(0, height), 0.1);
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_NEAR(seam(parts[0]).normal.x(), 1, 1e-5);
    EXPECT_NEAR(seam(parts[1]).normal.x(), -1, 1e-5);
  }
}

// Area of the upper faces, and whether they cover the square about the origin once: each random
// point is below exactly one of them.
void expect_tiling(const std::vector<ConvexPart>& parts, double size, double area,
                   const Mat3& turn) {
  double sum = 0;
  for (const ConvexPart& part : parts) {
    for (const auto& face : part.faces) {
      if (face.normal.dot(turn.col(2)) < 0.999) continue;
      for (int k = 1; k + 1 < face.count; ++k) {
        const Vec3 a = part.vertex(part.face_vertices[face.first]);
        sum += 0.5 * (part.vertex(part.face_vertices[face.first + k]) - a)
                         .cross(part.vertex(part.face_vertices[face.first + k + 1]) - a)
                         .norm();
      }
    }
  }
  EXPECT_NEAR(sum, area, 1e-6 * area);
  scenes::Random random(5);
  for (int i = 0; i < 200; ++i) {
    const Vec3 at = turn * Vec3(random.uniform(-size / 2, size / 2),
                                random.uniform(-size / 2, size / 2), -1e-4);
    const auto holds = [&](const ConvexPart& part) {
      return std::ranges::all_of(
          part.faces, [&](const ConvexPart::Face& f) { return f.normal.dot(at) <= f.offset; });
    };
    EXPECT_LE(std::ranges::count_if(parts, holds), 1);
  }
}

TEST(BoundaryMesh, FlatMeshesAreOnePartHoweverTheyAreCut) {
  const double size = 0.1;
  for (int cells = 1; cells <= 40; cells += 3) {
    for (const bool single_precision : {false, true}) {
      TriangleMesh mesh = verification::meshes::irregular_floor(size, cells, 100 + cells);
      const Mat3 turn = scenes::Random(cells).orientation().toRotationMatrix();
      for (Vec3& v : mesh.vertices) {
        v = turn * v;
        if (single_precision) v = v.cast<float>().cast<double>();
      }
      const auto parts = wall_solids(mesh, 2e-3);
      EXPECT_EQ(parts.size(), 1u) << cells << " cells";
      expect_tiling(parts, size, size * size, turn);
    }
  }
}

TEST(BoundaryMesh, FlatMeshesWithHolesAreFewConvexParts) {
  const double size = 0.1;
  for (int cells = 4; cells <= 20; cells += 4) {
    TriangleMesh mesh = verification::meshes::irregular_floor(size, cells, cells);
    double area = size * size;
    for (const int cell : {cells + 1, cells * cells / 2 + 1}) {
      for (const int t : {2 * cell, 2 * cell + 1}) {
        const auto& [a, b, c] = mesh.triangles[t];
        const Vec3& p = mesh.vertices[a];
        area -= 0.5 * (mesh.vertices[b] - p).cross(mesh.vertices[c] - p).norm();
      }
    }
    for (const int cell : {cells * cells / 2 + 1, cells + 1})
      mesh.triangles.erase(mesh.triangles.begin() + 2 * cell,
                           mesh.triangles.begin() + 2 * cell + 2);
    const auto parts = wall_solids(mesh, 2e-3);
    EXPECT_LT(parts.size(), mesh.triangles.size() / 2 + 10);
    expect_tiling(parts, size, area, Mat3::Identity());
  }
}

// A sliver between two triangles, however thin and however it leans, is a part or joined to a
// neighbor, or the mesh is refused in one line that names the triangle.
TEST(BoundaryMesh, SliversLeaveTheOtherTrianglesAsTheyAre) {
  scenes::Random random(41);
  int accepted = 0;
  for (int member = 0; member < 2000; ++member) {
    const bool is_flat = member % 4 == 0;
    const auto height = [&] { return is_flat ? 0.0 : random.uniform(-0.4, 0.4); };
    const double left = height(), right = height(), width = std::pow(10, random.uniform(-13, -2));
    const double lean = is_flat ? 0 : random.uniform(-1.5, 1.5);
    TriangleMesh mesh = two_triangles(left, 0);
    mesh.vertices[3] = {width * std::cos(lean), random.uniform(0.1, 0.9), width * std::sin(lean)};
    mesh.vertices.emplace_back(1, 0.5, right);
    mesh.triangles.push_back({3, 0, 4});
    mesh.triangles.push_back({1, 3, 4});
    std::vector<ConvexPart> parts;
    try {
      parts = wall_solids(mesh, 0.1);
    } catch (const InputError& refused) {
      EXPECT_EQ(std::string(refused.what()).find('\n'), std::string::npos);
      EXPECT_NE(std::string(refused.what()).find("triangle"), std::string::npos) << refused.what();
      continue;
    }
    ++accepted;
    double all = 0;
    for (const ConvexPart& part : parts) {
      ASSERT_GE(part.vertex_count, 4) << "member " << member;
      const double its = volume(part);
      ASSERT_TRUE(std::isfinite(its)) << "member " << member;
      all += its;
    }
    if (is_flat) {
      EXPECT_NEAR(all, 0.1, 1e-6) << "member " << member << ", width " << width;
    } else {
      EXPECT_GT(all, 0.05) << "member " << member << ", width " << width;
    }
  }
  EXPECT_GT(accepted, 1000);
}

TEST(BoundaryMesh, SideWithDifferentNeighborsIsNoSideOfOnePart) {
  // A flat square of two triangles; beyond one half of its side y = 1 a flap rises, beyond the
  // other half one falls.
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {2, 0, 0},   {2, 1, 0},   {1, 1, 0},
                   {0, 1, 0}, {0.5, 2, 1}, {1.5, 2, -1}};
  mesh.triangles = {{0, 1, 3}, {1, 2, 3}, {0, 3, 4}, {4, 3, 5}, {3, 2, 6}};
  for (const ConvexPart& part : wall_solids(mesh, 0.1)) EXPECT_LE(part.internal_normals.size(), 3u);
  EXPECT_GT(wall_solids(mesh, 0.1).size(), 3u);
}

TEST(BoundaryMesh, RidgeIsCutAlongItsBisector) {
  // Both faces fall away from the ridge by 45 degrees: the bisector is upright. The left prism
  // narrows downwards: its section is a parallelogram less the triangle behind the bisector.
  const double t = 0.1, slope = std::sqrt(2.0);
  const auto parts = wall_solids(two_triangles(-1, -1), t);
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
  const auto parts = wall_solids(two_triangles(1, 1), t);
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
  for (const auto& part : wall_solids(mesh, 0.1)) {
    for (const auto& face : part.faces) EXPECT_FALSE(face.internal);
  }
}

TEST(BoundaryMesh, ClosedConvexMeshIsOnePart) {
  const auto parts = wall_solids(box_mesh({1, 2, 3}), 0.1);
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
  ASSERT_TRUE(inspect(mesh).is_valid()) << inspect(mesh).to_message();
  const auto parts = wall_solids(mesh, 0.1);
  EXPECT_EQ(parts.size(), 9u);  // five sides, and the lid
  for (const auto& part : parts) EXPECT_GE(part.internal_normals.size(), 3u);
}

TEST(BoundaryMesh, RefusesNeighborsThatFaceOppositeWays) {
  TriangleMesh mesh = two_triangles(0, 0);
  std::swap(mesh.triangles[1][0], mesh.triangles[1][1]);
  EXPECT_THROW(wall_solids(mesh, 0.1), InputError);
}

TEST(BoundaryMesh, BoxFacesOutwards) {
  const TriangleMesh box = box_mesh({1, 2, 3});
  EXPECT_TRUE(inspect(box).is_valid());
  EXPECT_NEAR(mass_properties(box).volume, 6, 1e-12);
}

}  // namespace
}  // namespace firn
