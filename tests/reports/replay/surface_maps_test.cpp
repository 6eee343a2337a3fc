#include "reports/replay/surface_maps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace firn {
namespace {

// A wall of 40 x 40 squares, 1 m wide and 1 cm thick, hit on one spot of its upper side only.
SurfaceMap wall() {
  SurfaceMap map;
  constexpr int n = 40;
  for (const double z : {0.0, -0.01})
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) map.mesh.vertices.emplace_back(i / double(n), j / double(n), z);
  for (int side = 0; side < 2; ++side) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const int a = side * (n + 1) * (n + 1) + j * (n + 1) + i, b = a + 1, c = b + n + 1;
        const std::array<int, 3> up{a, b, c}, more{a, c, c - 1};
        for (const auto& t : {up, more})
          map.mesh.triangles.push_back(side == 0 ? t : std::array<int, 3>{t[2], t[1], t[0]});
      }
    }
  }
  const std::size_t triangles = map.mesh.triangles.size();
  map.computed = triangles;
  map.fields = {{"contacts", "", "", MapMerge::sum, std::vector<double>(triangles, 1)},
                {"peak", "", "N", MapMerge::largest, std::vector<double>(triangles, 0)},
                {"stress", "", "Pa", MapMerge::mean, std::vector<double>(triangles, 3)}};
  map.fields[1].values[2 * (20 * n + 10)] = 7;  // the square at x = 0.25, y = 0.5
  return map;
}

TEST(SurfaceMaps, CoarserOnesKeepSumsPeaksAndMeans) {
  const SurfaceMap fine = wall(), coarse = simplified_map(fine, 600);
  EXPECT_LE(coarse.mesh.triangles.size(), 600U);
  EXPECT_GT(coarse.mesh.triangles.size(), 200U);
  EXPECT_EQ(coarse.computed, fine.mesh.triangles.size());
  const auto& contacts = coarse.fields[0].values;
  EXPECT_EQ(contacts.size(), coarse.mesh.triangles.size());
  EXPECT_EQ(std::accumulate(contacts.begin(), contacts.end(), 0.0), 6400);
  for (const double stress : coarse.fields[2].values) EXPECT_NEAR(stress, 3, 1e-12);
  const auto& peak = coarse.fields[1].values;
  ASSERT_EQ(std::ranges::count(peak, 7.0), 1);
  EXPECT_EQ(std::ranges::count(peak, 0.0), static_cast<long>(peak.size()) - 1);
  const auto& t =
      coarse.mesh.triangles[static_cast<std::size_t>(std::ranges::find(peak, 7.0) - peak.begin())];
  Vec3 middle = Vec3::Zero();
  for (const int v : t) middle += coarse.mesh.vertices[static_cast<std::size_t>(v)] / 3;
  EXPECT_EQ(middle.z(), 0) << "the lower side was not hit";
  EXPECT_LT((middle - Vec3(0.2625, 0.5125, 0)).norm(), 0.1);
}

TEST(SurfaceMaps, OneThatIsCoarseEnoughStaysAsItIs) {
  const SurfaceMap fine = wall();
  EXPECT_EQ(simplified_map(fine, fine.mesh.triangles.size()).mesh.triangles, fine.mesh.triangles);
}

}  // namespace
}  // namespace firn
