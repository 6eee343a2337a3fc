#include "reports/rendering/simplify_mesh.h"

#include <gtest/gtest.h>

#include "firn/shape.h"

namespace firn {
namespace {

TEST(SimplifyMesh, ACrescentKeepsItsFormWithFewTriangles) {
  const TriangleMesh fine = crescent_mesh({});
  const TriangleMesh coarse = simplified_mesh(fine, 150);
  EXPECT_LE(coarse.triangles.size(), 150U);
  EXPECT_TRUE(inspect(coarse).is_valid()) << inspect(coarse).to_message();
  const double volume = mass_properties(fine).volume;
  EXPECT_NEAR(mass_properties(coarse).volume, volume, 0.02 * volume);
  const auto before = bounding_box(fine), after = bounding_box(coarse);
  for (std::size_t k = 0; k < 2; ++k) EXPECT_LT((before[k] - after[k]).norm(), 0.2e-3);
}

TEST(SimplifyMesh, FlatPartsOfAnOpenSheetGoAndItsRimStays) {
  TriangleMesh sheet;  // 10 x 10 squares, 1 m wide
  for (int j = 0; j <= 10; ++j)
    for (int i = 0; i <= 10; ++i) sheet.vertices.emplace_back(0.1 * i, 0.1 * j, 0);
  for (int j = 0; j < 10; ++j) {
    for (int i = 0; i < 10; ++i) {
      const int a = 11 * j + i;
      sheet.triangles.push_back({a, a + 1, a + 12});
      sheet.triangles.push_back({a, a + 12, a + 11});
    }
  }
  const TriangleMesh coarse = simplified_mesh(sheet, 2);
  EXPECT_LE(coarse.triangles.size(), 4U);
  double area = 0;
  for (const auto& t : coarse.triangles) {
    const Vec3& a = coarse.vertices[static_cast<std::size_t>(t[0])];
    area += 0.5 * (coarse.vertices[static_cast<std::size_t>(t[1])] - a)
                      .cross(coarse.vertices[static_cast<std::size_t>(t[2])] - a)
                      .z();
  }
  EXPECT_NEAR(area, 1, 1e-12);
}

TEST(SimplifyMesh, OneThatIsCoarseEnoughStaysAsItIs) {
  const TriangleMesh mesh = crescent_mesh({});
  EXPECT_EQ(simplified_mesh(mesh, mesh.triangles.size()).triangles, mesh.triangles);
}

}  // namespace
}  // namespace firn
