#include "solver/shapes/convex_decomposition.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <map>
#include <random>

#include "solver/geometry/point_in_mesh.h"
#include "solver/geometry/quick_hull.h"
#include "solver/shapes/shape_builder.h"
#include "solver/shapes/wall_thickness.h"
#include "validation/verification/fixtures/meshes.h"
#include "validation/verification/fixtures/solids.h"

namespace firn {
namespace {

using verification::solid;
using verification::solid_families;

struct Dice {
  explicit Dice(std::uint64_t seed) : random(seed) {}
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  Vec3 vector(double size) {
    const double x = (*this)(-size, size), y = (*this)(-size, size);
    return {x, y, (*this)(-size, size)};
  }
  Quat turn() {
    std::normal_distribution<double> normal;
    const double w = normal(random), x = normal(random), y = normal(random);
    return Quat(w, x, y, normal(random)).normalized();
  }
  std::mt19937_64 random;
};

ShapeOptions ice_options() {
  ShapeOptions options;
  options.density = 916.7;
  options.young_modulus = 1e7;
  return options;
}

std::vector<HalfSpace> half_spaces(const ConvexPart& part) {
  std::vector<HalfSpace> faces;
  for (const auto& f : part.faces) faces.push_back({f.normal, f.offset, f.internal});
  return faces;
}

double volume(const std::vector<HalfSpace>& piece) {
  try {
    return mass_properties(surface_mesh(convex_part(piece, 0))).volume;
  } catch (const InputError&) {
    return 0;
  }
}

double surface_area(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 &p = mesh.vertices[a], &q = mesh.vertices[b], &r = mesh.vertices[c];
    sum += 0.5 * (q - p).cross(r - p).norm();
  }
  return sum;
}

bool holds(const std::vector<HalfSpace>& piece, const Vec3& p, double margin) {
  return std::all_of(piece.begin(), piece.end(),
                     [&](const HalfSpace& h) { return h.normal.dot(p) <= h.offset + margin; });
}

// A shell that curves two ways can take more parts than a shape can have.
bool fits_in_64_parts(const std::string& family) { return family != "bowl" && family != "bullet"; }

void check_solid(const std::string& family, std::uint64_t member, const TriangleMesh& mesh,
                 bool fits = true) {
  SCOPED_TRACE(family + ", member " + std::to_string(member) + ", " +
               std::to_string(mesh.triangles.size()) + " triangles");
  ASSERT_TRUE(inspect(mesh).is_valid()) << inspect(mesh).to_message();
  const std::clock_t begun = std::clock();
  const Shape shape = make_mesh(mesh, ice_options());
  [[maybe_unused]] const double seconds =
      static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC;
  const double edge = shape.box.minCoeff(), size = shape.box.norm();
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_LT(seconds, 60) << "of processor time";
#endif
  EXPECT_LE(shape.parts.size(), 64u);
  if (fits && fits_in_64_parts(family)) {
    EXPECT_LE(shape.surface_deviation, 0.02 * edge) << shape.deviation_reason;
  } else {
    EXPECT_TRUE(shape.surface_deviation <= (fits ? 0.02 : 0.025) * edge ||
                shape.deviation_reason == "max_parts = 64 reached")
        << shape.surface_deviation / edge << ", " << shape.deviation_reason;
  }
  EXPECT_GE(shape.rounding, 1e-3 * edge);
  EXPECT_LE(shape.rounding, 0.02 * edge);

  // No slivers: 2.8 % of the smallest edge, or 28 % of the solid's own walls.
  ShapeOptions sharp = ice_options();
  sharp.rounding = 0;
  const Shape shape_of_pieces = make_mesh(mesh, sharp);
  const double thinnest = 0.5625 * std::min(0.05 * edge, 0.5 * wall_thickness(mesh));
  for (const ConvexPart& part : shape_of_pieces.parts) EXPECT_GE(part.thickness, 0.99 * thinnest);

  // The pieces hold the solid, and little else.
  std::vector<std::vector<HalfSpace>> pieces;
  double sum = 0;
  for (const ConvexPart& part : shape_of_pieces.parts) {
    pieces.push_back(half_spaces(part));
    sum += volume(pieces.back());
  }
  // Hulls of more than a thousand corners lose those that stand out by less than 0.17 %.
  const double margin = mesh.triangles.size() > 5000 ? 1.8e-3 * edge : 1e-6 * size;
  EXPECT_GE(sum, shape.volume - (margin + 1e-6 * size) * surface_area(mesh));
  const double exact = 1e-9 * shape.volume;
  EXPECT_LE(sum, shape.volume + shape_of_pieces.surface_deviation * surface_area(mesh) + exact);
  const PointInMesh interior(mesh);
  Dice dice(member + 1);
  int inside = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto [low, high] = bounding_box(mesh);
    const Vec3 p(dice(low.x(), high.x()), dice(low.y(), high.y()), dice(low.z(), high.z()));
    if (!interior.contains(p)) continue;
    ++inside;
    const Vec3 body = shape.shape_from_body.conjugate() * (p - shape.centroid);
    EXPECT_TRUE(std::any_of(pieces.begin(), pieces.end(), [&](const auto& piece) {
      return holds(piece, body, margin);
    })) << p.transpose();
  }
  EXPECT_GT(inside, 100);

  // They do not overlap.
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const ConvexPart &a = shape_of_pieces.parts[i], &b = shape_of_pieces.parts[j];
      if ((a.center - b.center).norm() > a.bounding_radius + b.bounding_radius) continue;
      std::vector<HalfSpace> both = pieces[i];
      both.insert(both.end(), pieces[j].begin(), pieces[j].end());
      EXPECT_LT(volume(both), 1e-5 * shape.volume) << "parts " << i << " and " << j;
    }
  }
}

void check_member(const std::string& family, std::uint64_t member) {
  check_solid(family, member, solid(family, member));
}

// The same solid of more than 2500 triangles, each cut into four as often as needed: cuts are
// planned on a simplified mesh.
TriangleMesh divided(TriangleMesh mesh) {
  while (mesh.triangles.size() <= 2500) {
    TriangleMesh finer;
    finer.vertices = mesh.vertices;
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [low, high] = std::minmax(a, b);
      const auto [at, added] =
          middles.try_emplace({low, high}, static_cast<int>(finer.vertices.size()));
      if (added) finer.vertices.push_back((mesh.vertices[low] + mesh.vertices[high]) / 2);
      return at->second;
    };
    for (const auto& [a, b, c] : mesh.triangles) {
      const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const auto& t : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
        finer.triangles.push_back({t[0], t[1], t[2]});
    }
    mesh = std::move(finer);
  }
  return mesh;
}

std::string name_of(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::erase_if(name, [](char c) { return c == ' '; });
  return name;
}

class Solids : public testing::TestWithParam<std::string> {};
TEST_P(Solids, AreFilledByFewConvexPartsNearTheSurface) { check_member(GetParam(), 0); }

class DividedSolids : public testing::TestWithParam<std::string> {};
TEST_P(DividedSolids, AreFilledAsWell) {
  for (int member = 0; member < 2; ++member)
    check_solid(GetParam(), member, divided(solid(GetParam(), member)));
}
INSTANTIATE_TEST_SUITE_P(Families, DividedSolids,
                         testing::Values("gear", "ring", "torus", "half moon", "tube ice",
                                         "channel"),
                         name_of);

class DividedSolidsLong : public testing::TestWithParam<std::string> {};
TEST_P(DividedSolidsLong, AreFilledAsWell) {
  // Cuts planned on a simplified mesh are not as good: the worst of these members deviates by
  // 2.2 %, or takes all 64 parts.
  constexpr bool kFits = false;
  for (int member = 0; member < 6; ++member) {
    const TriangleMesh mesh = divided(solid(GetParam(), member));
    if (mesh.triangles.size() <= 20000) check_solid(GetParam(), member, mesh, kFits);
  }
}

// Rings of many triangles: neighboring corners of their pieces nearly coincide.
TEST(Decompose, RingsOfManyTriangles) {
  for (const auto& [around, across] : {std::pair{50, 32}, {62, 40}, {100, 40}}) {
    SCOPED_TRACE(around);
    const Shape ring = make_mesh(verification::meshes::torus(around, across), ice_options());
    EXPECT_LE(ring.surface_deviation, 0.02 * ring.box.minCoeff()) << ring.deviation_reason;
    EXPECT_LE(ring.parts.size(), 32u);
  }
}

class SolidsLong : public testing::TestWithParam<std::string> {};
TEST_P(SolidsLong, AreFilledByFewConvexPartsNearTheSurface) {
  for (int member = 1; member < 20; ++member) check_member(GetParam(), member);
}

INSTANTIATE_TEST_SUITE_P(Families, Solids, testing::ValuesIn(solid_families()), name_of);
INSTANTIATE_TEST_SUITE_P(Families, SolidsLong, testing::ValuesIn(solid_families()), name_of);
INSTANTIATE_TEST_SUITE_P(Families, DividedSolidsLong, testing::ValuesIn(solid_families()), name_of);

DecomposeOptions options_for(const TriangleMesh& mesh) {
  const auto [low, high] = bounding_box(mesh);
  DecomposeOptions options;
  options.tolerance = 0.016 * (high - low).minCoeff();
  options.min_thickness = 0.05 * (high - low).minCoeff();
  options.max_parts = 64;
  return options;
}

TEST(Decompose, OrderOfVerticesAndTrianglesDoesNotMatter) {
  for (const std::string family : {"dimpled cube", "star", "ring", "banana"}) {
    SCOPED_TRACE(family);
    const TriangleMesh mesh = solid(family, 1);
    TriangleMesh shuffled;
    std::mt19937 random(7);
    std::vector<int> order(mesh.vertices.size()), place(mesh.vertices.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
    std::shuffle(order.begin(), order.end(), random);
    for (std::size_t i = 0; i < order.size(); ++i) {
      place[order[i]] = static_cast<int>(i);
      shuffled.vertices.push_back(mesh.vertices[order[i]]);
    }
    for (const auto& [a, b, c] : mesh.triangles) {
      shuffled.triangles.push_back({place[b], place[c], place[a]});
    }
    std::shuffle(shuffled.triangles.begin(), shuffled.triangles.end(), random);
    const auto one = decompose(mesh, options_for(mesh)).pieces;
    const auto other = decompose(shuffled, options_for(mesh)).pieces;
    ASSERT_EQ(one.size(), other.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      ASSERT_EQ(one[i].size(), other[i].size());
      for (std::size_t k = 0; k < one[i].size(); ++k) {
        EXPECT_EQ(one[i][k].normal, other[i][k].normal);
        EXPECT_EQ(one[i][k].offset, other[i][k].offset);
      }
    }
  }
}

// In another unit of length or at another place, corners round differently.
TEST(Decompose, UnitAndPlaceOfAMeshDoNotMatter) {
  Dice dice(8);
  for (const std::string family : {"gourmet cube", "ring", "cup", "half moon"}) {
    for (int member = 0; member < 3; ++member) {
      SCOPED_TRACE(family + ", member " + std::to_string(member));
      const TriangleMesh mesh = solid(family, member);
      const auto one = decompose(mesh, options_for(mesh)).pieces;
      for (const double unit : {0.0254, 0.3048, 1000.0, dice(0.1, 10)}) {
        TriangleMesh other = mesh;
        const Vec3 place = dice.vector(0.1);
        for (Vec3& v : other.vertices) v = unit * v + place;
        EXPECT_EQ(one.size(), decompose(other, options_for(other)).pieces.size()) << unit;
      }
    }
  }
}

TEST(Decompose, TurnedSolidIsAsNear) {
  Dice dice(3);
  for (const std::string family : {"gourmet cube", "star", "channel", "crescent", "half moon"}) {
    SCOPED_TRACE(family);
    const TriangleMesh mesh = solid(family, 1);
    TriangleMesh turned = mesh;
    const Quat turn = dice.turn();
    for (Vec3& v : turned.vertices) v = turn * v;
    const Decomposition straight = decompose(mesh, options_for(mesh));
    const Decomposition other = decompose(turned, options_for(mesh));
    EXPECT_FALSE(straight.part_limit_reached);
    EXPECT_FALSE(other.part_limit_reached);
  }
}

TEST(Decompose, SaysWhyItStopsEarly) {
  const TriangleMesh mesh = solid("torus", 0);
  DecomposeOptions options = options_for(mesh);
  options.max_parts = 5;
  const Decomposition few = decompose(mesh, options);
  EXPECT_LE(few.pieces.size(), 5u);
  EXPECT_TRUE(few.part_limit_reached);
  options = options_for(mesh);
  options.min_thickness = 40 * options.min_thickness;  // two smallest edges
  EXPECT_TRUE(decompose(mesh, options).thickness_limit_reached);
}

TEST(WallThickness, OfTubesAndBoxes) {
  const Shape box = make_box({0.03, 0.02, 0.01}, ice_options());
  EXPECT_NEAR(wall_thickness(box.mesh), 0.01, 1e-9);
  // A plate with a hole is as thick as its wall or its rim, whichever is less.
  EXPECT_LT(wall_thickness(solid("cup", 0)), 4.6e-3);
}

// --- Hulls and insides. --------------------------------------------------------------------------

TEST(QuickHull, AgreesWithTheExactHull) {
  Dice dice(11);
  for (int round = 0; round < 200; ++round) {
    std::vector<Vec3> points;
    const Vec3 scale(dice(0.01, 1), dice(0.01, 1), dice(0.01, 1));
    for (int i = 0; i < 4 + round; ++i) points.push_back(dice.vector(1).cwiseProduct(scale));
    const auto hull = quick_hull(points, 1e-12);
    ASSERT_TRUE(hull);
    double outside = 0;
    for (const Vec3& p : points) {
      for (const HalfSpace& h : hull->planes)
        outside = std::max(outside, h.normal.dot(p) - h.offset);
    }
    EXPECT_LT(outside, 1e-11);
    const double exact = mass_properties(surface_mesh(convex_part(convex_hull(points), 0))).volume;
    EXPECT_NEAR(hull->volume, exact, 1e-5 * exact);
  }
}

TEST(QuickHull, OfALatticeIsItsBox) {
  std::vector<Vec3> points;
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 6; ++y) {
      for (int z = 0; z < 6; ++z) points.emplace_back(x, y, z);
    }
  }
  const auto hull = quick_hull(points, 1e-9);
  ASSERT_TRUE(hull);
  EXPECT_NEAR(hull->volume, 125, 1e-9);
}

TEST(QuickHull, FlatPointsHaveNone) {
  EXPECT_FALSE(quick_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.5, 0.2, 0}}, 1e-9));
  EXPECT_FALSE(quick_hull({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, 1e-9));
  EXPECT_FALSE(quick_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, 1e-9));
}

TEST(PointInMesh, OfATorusHasItsClosedForm) {
  const TriangleMesh mesh = solid("torus", 0);  // 13 and 5.5 mm
  const PointInMesh interior(mesh);
  Dice dice(5);
  for (int i = 0; i < 5000; ++i) {
    const Vec3 p = dice.vector(0.02);
    const double tube = std::hypot(std::hypot(p.x(), p.y()) - 0.013, p.z());
    if (std::abs(tube - 0.0055) < 2e-4) continue;  // facets
    EXPECT_EQ(interior.contains(p), tube < 0.0055) << p.transpose();
  }
}

// Cuts end at the concave edges of this star, where their rounded edges stand out.
TEST(Deviation, OfCutsThatEndAtConcaveEdgesIsTheirRounding) {
  const Shape star = make_mesh(solid("star", 14), ice_options());
  EXPECT_LE(star.surface_deviation, 0.02 * star.box.minCoeff());
}

TEST(Deviation, CountsAVoidThatAHullSpans) {
  // The hull of a plate closes its hole: the middle of the lid is a radius away from the rim.
  ShapeOptions options = ice_options();
  options.max_parts = 1;
  const Shape shape = make_mesh(solid("plate with hole", 0), options);
  const double hole = 9e-3;
  EXPECT_NEAR(shape.surface_deviation, hole, 0.1 * hole);
  EXPECT_EQ(shape.deviation_reason, "max_parts = 1 reached");
}

}  // namespace
}  // namespace firn
