#include "firn/mesh_conflicts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "firn/shape.h"
#include "tests/support/error_of.h"

namespace firn {
namespace {

using testing::HasSubstr;

// An axis-aligned box from one corner.
TriangleMesh mesh_box(const Vec3& low, const Vec3& size) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back(low + Vec3(i & 1, i >> 1 & 1, i >> 2).cwiseProduct(size));
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

TriangleMesh cube(const Vec3& low, double size) { return mesh_box(low, Vec3::Constant(size)); }

TriangleMesh flipped(TriangleMesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  return mesh;
}

TriangleMesh together(TriangleMesh a, const TriangleMesh& b) {
  const int first = static_cast<int>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles)
    a.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  return a;
}

// Intersections, overlapping, nested and inverted shells.
using Counts = std::array<int, 4>;
Counts counts(const TriangleMesh& mesh) {
  const MeshConflicts c = find_conflicts(mesh);
  EXPECT_EQ(c.none(), c.to_message().empty());
  return {c.intersections, c.overlapping_shells, c.nested_shells, c.inverted_shells};
}
const Counts kNone{}, kOverlap{0, 1, 0, 0}, kNested{0, 0, 1, 0}, kInverted{0, 0, 0, 1};

const TriangleMesh kCube = cube(Vec3::Zero(), 0.02);

TEST(MeshConflicts, OfTwoCubes) {
  EXPECT_EQ(counts(kCube), kNone);
  EXPECT_EQ(counts(together(kCube, cube({0.05, 0, 0}, 0.02))), kNone);
  EXPECT_EQ(counts(together(kCube, cube({0.01, 0, 0}, 0.02))), kOverlap);
  EXPECT_EQ(counts(together(kCube, cube({0.01, 0.01, 0.01}, 0.02))), kOverlap);
  EXPECT_EQ(counts(together(kCube, kCube)), kOverlap);
  EXPECT_EQ(counts(together(kCube, cube({0.005, 0.005, 0.005}, 0.01))), kNested);
}

TEST(MeshConflicts, TouchIsNone) {
  EXPECT_EQ(counts(together(kCube, cube({0.02, 0, 0}, 0.02))), kNone);           // face on face
  EXPECT_EQ(counts(together(kCube, cube({0.005, -0.005, 0.02}, 0.01))), kNone);  // over an edge
  EXPECT_EQ(counts(together(kCube, cube({0.02, 0.02, 0}, 0.02))), kNone);        // edge on edge
  EXPECT_EQ(counts(together(kCube, cube({0.02, 0.02, 0.02}, 0.02))), kNone);     // corner on corner
}

TEST(MeshConflicts, ACavityIsNoneAndNorIsASolidInIt) {
  const TriangleMesh hollow = together(kCube, flipped(cube({0.005, 0.005, 0.005}, 0.01)));
  EXPECT_EQ(counts(hollow), kNone);
  EXPECT_EQ(counts(together(hollow, cube({0.007, 0.007, 0.007}, 0.005))), kNone);
  EXPECT_EQ(counts(together(kCube, flipped(cube({0.05, 0, 0}, 0.01)))), kInverted);
}

TEST(MeshConflicts, ApexThroughTheBaseCrosses) {
  TriangleMesh mesh = kCube;
  mesh.vertices.push_back({0.01, 0.01, -0.01});
  mesh.triangles.resize(10);  // without its top
  for (const auto& [a, b] : {std::pair(4, 5), {5, 7}, {7, 6}, {6, 4}})
    mesh.triangles.push_back({a, b, 8});
  ASSERT_TRUE(inspect(mesh).is_valid()) << inspect(mesh).to_message();
  const MeshConflicts found = find_conflicts(mesh);
  EXPECT_GT(found.intersections, 0);
  ASSERT_EQ(found.examples.size(), 1U);
  EXPECT_NEAR(found.examples[0].position.z(), 0, 1e-9);  // on the base
}

// Two boxes with known intervals, turned and moved together: what they are to each other is known,
// and remains the same.
TEST(MeshConflicts, OfRandomBoxes) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  std::array<int, 3> seen{};
  for (int member = 0; member < 2000; ++member) {
    const auto vector = [&](double low, double high) {
      return Vec3(low + (high - low) * unit(random), low + (high - low) * unit(random),
                  low + (high - low) * unit(random));
    };
    const Vec3 low = vector(0, 1), size = vector(0.2, 1.5), other = vector(-0.5, 1.5),
               other_size = member % 3 == 0 ? vector(0.05, 0.2) : vector(0.2, 1.5);
    const Vec3 overlap = (low + size).cwiseMin(other + other_size) - low.cwiseMax(other);
    const auto holds = [](const Vec3& a, const Vec3& s, const Vec3& b, const Vec3& t) {
      return (b.array() > a.array()).all() && ((b + t).array() < (a + s).array()).all();
    };
    const bool nested = holds(low, size, other, other_size) || holds(other, other_size, low, size);
    const Counts expected = overlap.minCoeff() <= 0 ? kNone : nested ? kNested : kOverlap;
    ++seen[overlap.minCoeff() <= 0 ? 0 : nested ? 1 : 2];
    TriangleMesh mesh = together(mesh_box(low, size), mesh_box(other, other_size));
    const Mat3 turn = Quat(unit(random), unit(random), unit(random), unit(random) - 0.5)
                          .normalized()
                          .toRotationMatrix();
    const Vec3 shift = vector(-5, 5);
    for (Vec3& v : mesh.vertices) v = turn * v + shift;
    EXPECT_EQ(counts(mesh), expected) << "member " << member;
  }
  for (const int n : seen) EXPECT_GT(n, 20);
}

// Fans of 5000 triangles around one corner are the worst case of the search.
TEST(MeshConflicts, SlenderRodOf20000TrianglesHasNone) {
  constexpr int kSides = 5000;
  TriangleMesh rod;
  for (int end = 0; end < 2; ++end) {
    for (int i = 0; i < kSides; ++i) {
      const double angle = 2 * EIGEN_PI * i / kSides;
      rod.vertices.push_back({1e-3 * std::cos(angle), 1e-3 * std::sin(angle), 0.1 * end});
    }
  }
  rod.vertices.push_back({0, 0, 0});
  rod.vertices.push_back({0, 0, 0.1});
  for (int i = 0; i < kSides; ++i) {
    const int k = (i + 1) % kSides;
    rod.triangles.push_back({i, k, kSides + k});
    rod.triangles.push_back({i, kSides + k, kSides + i});
    rod.triangles.push_back({2 * kSides, k, i});
    rod.triangles.push_back({2 * kSides + 1, kSides + i, kSides + k});
  }
  ASSERT_TRUE(inspect(rod).is_valid());
  EXPECT_EQ(counts(rod), kNone);
}

TEST(MeshConflicts, CrescentsHaveNone) {
  for (const int facets : {68, 1272, 5000})
    EXPECT_EQ(counts(crescent_mesh({.facets = facets})), kNone) << facets;
}

TEST(MeshConflicts, ParticleIsRefusedWithTrianglesAndPlace) {
  ShapeOptions options;
  options.density = 900;
  options.young_modulus = 1e6;
  const auto refusal = [&](const TriangleMesh& mesh) {
    return test::error_of([&] { make_mesh(mesh, options); });
  };
  EXPECT_THAT(refusal(together(kCube, cube({0.01, 0, 0}, 0.02))),
              HasSubstr("1 pair of shells that overlap (triangles "));
  EXPECT_THAT(refusal(together(kCube, cube({0.005, 0.005, 0.005}, 0.01))),
              HasSubstr("1 shell inside another one (triangles 13 and 1 at 5 8.333 11.67 mm)"));
}

}  // namespace
}  // namespace firn
