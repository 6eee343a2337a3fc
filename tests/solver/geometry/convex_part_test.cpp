#include "firn/convex_part.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace firn {
namespace {

std::vector<HalfSpace> box(const Vec3& half, const Vec3& center = Vec3::Zero()) {
  std::vector<HalfSpace> sides;
  for (int k = 0; k < 3; ++k) {
    for (const double sign : {-1.0, 1.0}) {
      const Vec3 n = sign * Vec3::Unit(k);
      sides.push_back({n, half(k) + n.dot(center), false});
    }
  }
  return sides;
}

std::vector<Vec3> points_on_sphere(int count) {
  std::mt19937_64 random(7);
  const auto uniform = [&random] { return static_cast<double>(random() >> 11) * 0x1p-52 - 1; };
  std::vector<Vec3> points;
  while (static_cast<int>(points.size()) < count) {
    const Vec3 v(uniform(), uniform(), uniform());
    if (v.norm() < 1 && v.norm() > 0.1) points.push_back(v.normalized());
  }
  return points;
}

// Faces are counter-clockwise on their planes, edges are those of the faces, and V - E + F = 2.
// `merged` (relative to the size): how far slivers that were merged may leave vertices off planes.
void expect_sound(const ConvexPart& part, double merged = 1e-12) {
  EXPECT_TRUE(inspect(surface_mesh(part)).is_valid()) << inspect(surface_mesh(part)).to_message();
  EXPECT_EQ(
      part.vertex_count - static_cast<int>(part.edges.size()) + static_cast<int>(part.faces.size()),
      2);
  EXPECT_EQ(part.x.size() % 8, 0u);
  EXPECT_EQ(part.x.size(), part.y.size());
  EXPECT_EQ(part.x.size(), part.z.size());
  for (std::size_t i = part.vertex_count; i < part.x.size(); ++i) {
    EXPECT_EQ(part.vertex(static_cast<int>(i)), part.vertex(part.vertex_count - 1));
  }
  for (const auto& face : part.faces) {
    for (int k = 0; k < face.count; ++k) {
      const Vec3 v = part.vertex(part.face_vertices[face.first + k]);
      EXPECT_NEAR(face.normal.dot(v), face.offset, merged * part.bounding_radius);
    }
  }
  for (int i = 0; i < part.vertex_count; ++i) {
    EXPECT_LE((part.vertex(i) - part.center).norm() + part.radius,
              part.bounding_radius * (1 + 1e-14));
  }
}

TEST(ConvexPart, BoxIsErodedByTheRounding) {
  const Vec3 half(0.03, 0.02, 0.01);
  const double rounding = 1e-3;
  const ConvexPart part = convex_part(box(half), rounding);
  expect_sound(part);
  EXPECT_EQ(part.vertex_count, 8);
  EXPECT_EQ(part.faces.size(), 6u);
  EXPECT_EQ(part.edges.size(), 12u);
  EXPECT_EQ(part.radius, rounding);
  for (int i = 0; i < 8; ++i) {
    EXPECT_LT((part.vertex(i).cwiseAbs() - (half - Vec3::Constant(rounding))).norm(), 1e-17);
  }
  EXPECT_LT(part.center.norm(), 1e-17);
}

TEST(ConvexPart, InternalFacesStayAndMarkTheirVertices) {
  auto sides = box({0.03, 0.02, 0.01});
  sides[1].internal = true;  // +x
  const ConvexPart part = convex_part(sides, 1e-3);
  expect_sound(part);
  ASSERT_EQ(part.internal_normals.size(), 1u);
  EXPECT_EQ(part.internal_normals[0], Vec3::UnitX());
  for (int i = 0; i < 8; ++i) {
    const bool on_cut = part.x[i] > 0;
    EXPECT_NEAR(part.x[i], on_cut ? 0.03 : -0.029, 1e-17);
    EXPECT_EQ(part.internal_faces[i], on_cut ? 1u : 0u);
  }
}

TEST(ConvexPart, FarFromTheOriginIsAsGood) {
  const ConvexPart part = convex_part(box({0.03, 0.02, 0.01}, {5, -7, 9}), 1e-3);
  expect_sound(part);
  EXPECT_EQ(part.vertex_count, 8);
  EXPECT_LT((part.center - Vec3(5, -7, 9)).norm(), 1e-14);
}

TEST(ConvexPart, NeedlesSpitsAndRepeatedPlanesVanish) {
  auto sides = box({1, 1, 1});
  const auto plain = convex_part(sides, 0);
  sides.push_back(sides[0]);                                             // the same plane again
  sides.push_back({Vec3(1, 1, 0).normalized(), std::sqrt(2.0), false});  // touches an edge
  sides.push_back({Vec3(1, 1, 1).normalized(), std::sqrt(3.0), false});  // touches a corner
  // cuts off a corner of 1e-10
  sides.push_back({Vec3(-1, -1, -1).normalized(), std::sqrt(3.0) - 1e-10, false});
  const auto part = convex_part(sides, 0);
  expect_sound(part);
  EXPECT_EQ(part.vertex_count, plain.vertex_count);
  EXPECT_EQ(part.faces.size(), plain.faces.size());
  EXPECT_EQ(part.edges.size(), plain.edges.size());
}

TEST(ConvexPart, CutCornerGivesATriangle) {
  auto sides = box({1, 1, 1});
  sides.push_back({Vec3(1, 1, 1).normalized(), 2 / std::sqrt(3.0), false});  // x + y + z <= 2
  const auto part = convex_part(sides, 0);
  expect_sound(part);
  EXPECT_EQ(part.vertex_count, 10);
  EXPECT_EQ(part.faces.size(), 7u);
  // A corner tetrahedron with legs of one is missing.
  EXPECT_NEAR(mass_properties(surface_mesh(part)).volume, 8 - 1.0 / 6, 1e-13);
}

TEST(ConvexPart, PyramidOfManyFacesMeetsInOnePoint) {
  std::vector<HalfSpace> sides = {{-Vec3::UnitZ(), 0, false}};
  const int count = 12;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count;
    sides.push_back(
        {Vec3(std::cos(angle), std::sin(angle), 1).normalized(), 1 / std::sqrt(2.0), false});
  }
  const auto part = convex_part(sides, 0);
  expect_sound(part);
  EXPECT_EQ(part.vertex_count, count + 1);
}

TEST(ConvexPart, SeveralHundredPlanesStaySound) {
  const auto hull = convex_hull(points_on_sphere(300));
  const auto part = convex_part(hull, 1e-3);
  expect_sound(part, 5e-9);
  EXPECT_EQ(part.faces.size(), hull.size());
}

TEST(ConvexPart, NothingLeftOpenOrEmptyIsRefused) {
  EXPECT_THROW(convex_part(box({1, 1, 0.01}), 0.01), InputError);
  EXPECT_NO_THROW(convex_part(box({1, 1, 0.01}), 0.0099));
  auto open = box({1, 1, 1});
  open.pop_back();
  EXPECT_THROW(convex_part(open, 0), InputError);
  auto empty = box({1, 1, 1});
  empty.push_back({Vec3::UnitX(), -2, false});
  EXPECT_THROW(convex_part(empty, 0), InputError);
  EXPECT_THROW(convex_part(box({1, 1, 1}), -1), InputError);
}

TEST(ConvexHull, BoxHasSixExactPlanesWhateverLiesInside) {
  std::vector<Vec3> points;
  for (int i = 0; i <= 6; ++i) {
    for (int j = 0; j <= 6; ++j) {
      for (int k = 0; k <= 6; ++k) points.emplace_back(0.1 * i, 0.01 * j, 0.001 * k);
    }
  }
  const auto hull = convex_hull(points);
  ASSERT_EQ(hull.size(), 6u);
  for (const auto& h : hull) {
    EXPECT_NEAR(h.normal.cwiseAbs().maxCoeff(), 1, 1e-15);
    double highest = -1;
    for (const Vec3& p : points) highest = std::max(highest, h.normal.dot(p));
    EXPECT_NEAR(highest, h.offset, 1e-14);
  }
}

TEST(ConvexHull, SinglePrecisionBoxStillHasSixFaces) {
  const Quat turn = Quat(0.8, 0.3, 0.5, 0.1).normalized();
  std::vector<Vec3> points;
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner(i & 1 ? 0.01 : -0.01, i & 2 ? 0.02 : -0.02, i & 4 ? 0.03 : -0.03);
    points.push_back((turn * corner).cast<float>().cast<double>());
  }
  EXPECT_EQ(convex_hull(points).size(), 6u);
}

TEST(ConvexHull, EveryPointIsInsideAndOnItsFacets) {
  const auto points = points_on_sphere(200);
  const auto hull = convex_hull(points);
  EXPECT_EQ(hull.size(), 2 * points.size() - 4);  // Euler, all triangles
  for (const Vec3& p : points) {
    int touching = 0;
    for (const auto& h : hull) {
      const double height = h.normal.dot(p) - h.offset;
      EXPECT_LE(height, 1e-12);
      touching += height > -1e-12;
    }
    EXPECT_GE(touching, 3);
  }
}

// Points on an ellipsoid or on a piece of a ring, some of them in pairs that nearly coincide.
TEST(ConvexHull, HoldsPointsThatNearlyCoincide) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  const auto uniform = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto vector = [&] {
    const double x = normal(random), y = normal(random);
    return Vec3(x, y, normal(random));
  };
  for (int round = 0; round < 1000; ++round) {
    SCOPED_TRACE(round);
    const Vec3 axes(uniform(0.1, 1), uniform(0.1, 1), uniform(0.1, 1));
    const double from = uniform(0, 2 * M_PI), span = uniform(0.2, 1.5);
    std::vector<Vec3> points;
    for (int i = 0; i < 8 + round % 200; ++i) {
      const double a = from + uniform(0, span), b = uniform(0, 2 * M_PI);
      const double r = 0.7 + 0.3 * std::cos(b);
      const Vec3 on_ring(r * std::cos(a), r * std::sin(a), 0.3 * std::sin(b));
      const Vec3 p = round % 2 ? on_ring : vector().normalized().cwiseProduct(axes);
      points.push_back(p);
      const double near = std::pow(10, -uniform(1, 8));
      if (i % 3 == 0) points.push_back(p + near * vector());
    }
    const auto hull = convex_hull(points);
    const auto part = convex_part(hull, 0);
    double outside = 0, bent = 0;
    for (const auto& h : hull) {
      for (const Vec3& p : points) outside = std::max(outside, h.normal.dot(p) - h.offset);
      for (int i = 0; i < part.vertex_count; ++i)
        bent = std::max(bent, h.normal.dot(part.vertex(i)) - h.offset);
    }
    EXPECT_LE(outside, 5e-6);
    EXPECT_LE(bent, 1e-7);
  }
}

TEST(ConvexHull, TetrahedronComesBackAsItsOwnCorners) {
  const std::vector<Vec3> corners = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {0, 0, 5}};
  const auto part = convex_part(convex_hull(corners), 0);
  expect_sound(part);
  ASSERT_EQ(part.vertex_count, 4);
  for (const Vec3& corner : corners) {
    double nearest = 1;
    for (int i = 0; i < 4; ++i) nearest = std::min(nearest, (part.vertex(i) - corner).norm());
    EXPECT_LT(nearest, 1e-14);
  }
}

TEST(ConvexHull, FlatOrFewPointsAreRefused) {
  EXPECT_THROW(convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), InputError);
  EXPECT_THROW(convex_hull({{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}, {.3, .2, 1}}), InputError);
}

// However the plane lies, and however its coordinates are rounded.
TEST(ConvexHull, PointsOfAnyPlaneAreRefused) {
  std::mt19937_64 random(3);
  const auto whole = [&random](int n) { return static_cast<double>(random() % n); };
  for (int round = 0; round < 200; ++round) {
    const Vec3 u(whole(9) - 4, whole(9) - 4, 1 + whole(4)), v(1 + whole(4), whole(9) - 4, 0);
    std::vector<Vec3> points;
    for (int i = 0; i < 8; ++i) {
      points.push_back(0.02 / 3 * (Vec3(1, 2, 3) + whole(7) * u + whole(7) * v));
    }
    EXPECT_THROW(convex_hull(points), InputError) << u.transpose() << ", " << v.transpose();
  }
}

TEST(SpherePart, IsOnePoint) {
  const ConvexPart part = sphere_part({1, 2, 3}, 0.5);
  EXPECT_EQ(part.vertex_count, 1);
  EXPECT_EQ(part.x.size(), 8u);
  EXPECT_EQ(part.center, Vec3(1, 2, 3));
  EXPECT_EQ(part.bounding_radius, 0.5);
  EXPECT_THAT(part.internal_faces, testing::ElementsAre(0u));
}

TEST(Moved, TakesPlanesAndCornersAlong) {
  auto sides = box({0.03, 0.02, 0.01});
  sides[0].internal = true;
  const Pose pose = {Quat(0.8, 0.3, 0.5, 0.1).normalized().toRotationMatrix(), {1, 2, 3}};
  const ConvexPart part = moved(convex_part(sides, 1e-3), pose);
  expect_sound(part);
  EXPECT_LT((part.internal_normals[0] + pose.rotation.col(0)).norm(), 1e-15);
  EXPECT_LT((part.center - pose * Vec3(-0.0005, 0, 0)).norm(), 1e-15);
}

}  // namespace
}  // namespace firn
