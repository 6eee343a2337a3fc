// Narrow phase against closed forms.
#include "solver/collision/narrowphase.h"

#include <gtest/gtest.h>

#include "tests/solver/collision/brute_force_distance.h"

namespace firn {
namespace {

using testing::box;
using testing::box_planes;
using testing::Random;
using testing::slabs;

constexpr double kNarrowShell = 20e-6;  // m
constexpr double kEdgeWidth = 1e-4;     // of the pair's size: least width of an edge
constexpr double kTiny = 1e-15;         // m, rounding of a few centimeters

Pose at(const Vec3& translation, const Mat3& rotation = Mat3::Identity()) {
  return {rotation, translation};
}
Mat3 turn(double angle, const Vec3& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

Manifold meet(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a,
              double shell = kNarrowShell) {
  GjkCache cold;
  Manifold out;
  collide(a, b, b_in_a, shell, cold, out);
  return out;
}

double weight(const Manifold& m) {
  double sum = 0;
  for (const auto& p : m.points) sum += p.weight;
  return sum;
}

// Force of unit pressure per overlap over the points, and its moment about A's origin.
struct Load {
  double force = 0;
  Vec3 moment = Vec3::Zero();
};
Load load(const std::vector<Manifold>& manifolds) {
  Load out;
  for (const auto& m : manifolds) {
    for (const auto& p : m.points) {
      const double f = p.weight * std::max(0.0, -p.gap);
      out.force += f;
      out.moment += f * p.position.cross(m.normal);
    }
  }
  return out;
}

TEST(Collide, SpheresMeetOnTheLineOfTheirCenters) {
  const ConvexPart a = sphere_part(Vec3(1e-3, 0, 0), 5e-3), b = sphere_part(Vec3::Zero(), 3e-3);
  // Centers 3-4-12 mm apart, 13 mm.
  const Manifold m = meet(a, b, at({4e-3, 4e-3, 12e-3}), 6e-3);
  EXPECT_NEAR(m.gap, 5e-3, kTiny);
  EXPECT_NEAR((m.normal - Vec3(3, 4, 12) / 13).norm(), 0, 1e-15);
  ASSERT_EQ(m.points.size(), 1u);
  // Midway: A's surface is 5 mm from its center, B's 10 mm.
  EXPECT_NEAR((m.points[0].position - Vec3(1e-3, 0, 0) - 7.5e-3 * m.normal).norm(), 0, kTiny);
  EXPECT_DOUBLE_EQ(m.points[0].weight, std::pow(kEdgeWidth * 3e-3, 2));
  EXPECT_DOUBLE_EQ(m.area, m.points[0].weight);
  EXPECT_EQ(m.moments.trace(), 0);
}

TEST(Collide, ConcentricSpheresStillAnswer) {
  const ConvexPart a = sphere_part(Vec3::Zero(), 5e-3);
  const Manifold m = meet(a, a, Pose{});
  EXPECT_DOUBLE_EQ(m.gap, -10e-3);
  EXPECT_DOUBLE_EQ(m.normal.norm(), 1);
  EXPECT_EQ(m.points.size(), 1u);
}

TEST(Collide, FarApartGivesALowerBoundWithinAFifth) {
  const ConvexPart a = box({5e-3, 10e-3, 7e-3}, 1e-3);
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    const Pose pose = at(random.uniform(0.02, 0.05) * random.direction(), random.rotation());
    GjkCache cache;
    const double gap = core_distance(a, a, pose, cache) - 2e-3;
    if (gap <= kNarrowShell) continue;
    const Manifold m = meet(a, a, pose);
    EXPECT_TRUE(m.points.empty());
    EXPECT_LE(m.gap, gap + kTiny);
    EXPECT_GE(m.gap, 0.8 * gap);
  }
}

TEST(Collide, FaceOnFaceIsTheClippedRectangle) {
  // B above A, shifted by 4 mm in x: the cores' faces (18 x 16 mm) share 14 x 16 mm.
  const ConvexPart a = box({10e-3, 9e-3, 5e-3}, 1e-3);
  const Manifold m = meet(a, a, at({4e-3, 0, 10e-3 - 5e-6}));
  EXPECT_NEAR(m.gap, -5e-6, kTiny);
  EXPECT_NEAR((m.normal - Vec3::UnitZ()).norm(), 0, 1e-14);
  ASSERT_EQ(m.points.size(), 4u);
  const double lx = 14e-3, ly = 16e-3, area = lx * ly;
  EXPECT_NEAR(weight(m), area, 1e-12 * area);
  EXPECT_NEAR(m.area, area, 1e-12 * area);
  EXPECT_NEAR((m.centroid - Vec3(2e-3, 0, 5e-3 - 2.5e-6)).norm(), 0, kTiny);
  EXPECT_NEAR(m.moments.trace(), area * (lx * lx + ly * ly) / 12, 1e-12 * m.moments.trace());
  for (const auto& p : m.points) {
    EXPECT_NEAR(p.gap, -5e-6, kTiny);
    EXPECT_NEAR(p.position.z(), 5e-3 - 2.5e-6, kTiny);
  }
}

TEST(Collide, WeightsIntegrateLinearFunctionsOverAnyClip) {
  // A square turned by any angle over another one: the second vertex rule would show at once.
  const ConvexPart a = box({10e-3, 10e-3, 5e-3}, 0), b = box({6e-3, 13e-3, 5e-3}, 0);
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    const Pose pose = at({random.uniform(-8e-3, 8e-3), random.uniform(-8e-3, 8e-3), 10e-3 + 1e-6},
                         turn(random.uniform(0, 2 * M_PI), Vec3::UnitZ()));
    const Manifold m = meet(a, b, pose);
    // Area, first and second moments of the same polygon by counting lattice points would be
    // coarse; Green's theorem over the points in their order is exact.
    double area = 0, mx = 0, my = 0, second = 0;
    for (std::size_t k = 0; k < m.points.size(); ++k) {
      const Vec3 p = m.points[k].position, q = m.points[(k + 1) % m.points.size()].position;
      const double c = p.x() * q.y() - p.y() * q.x();
      area += c / 2;
      mx += c * (p.x() + q.x()) / 6;
      my += c * (p.y() + q.y()) / 6;
      second += c *
                (p.x() * p.x() + p.x() * q.x() + q.x() * q.x() + p.y() * p.y() + p.y() * q.y() +
                 q.y() * q.y()) /
                12;
    }
    double wx = 0, wy = 0;
    for (const auto& p : m.points) {
      wx += p.weight * p.position.x();
      wy += p.weight * p.position.y();
    }
    ASSERT_GE(m.points.size(), 3u);
    EXPECT_NEAR(weight(m), area, 1e-12 * 1e-4);
    EXPECT_NEAR(wx, mx, 1e-12 * 1e-6);
    EXPECT_NEAR(wy, my, 1e-12 * 1e-6);
    EXPECT_NEAR(m.area, area, 1e-12 * 1e-4);
    EXPECT_NEAR(m.centroid.x(), mx / area, 1e-12 * 1e-2);
    EXPECT_NEAR(m.moments.trace(), second - (mx * mx + my * my) / area, 1e-11 * 1e-8);
  }
}

TEST(Collide, FaceTiltedALittleKeepsItsFourCorners) {
  const ConvexPart a = box({10e-3, 10e-3, 5e-3}, 1e-3);
  const double tilt = 2e-4;  // raises one side of the 18 mm core face by 3.6 um
  const Manifold m = meet(a, a, at({0, 0, 10e-3}, turn(tilt, Vec3::UnitY())));
  ASSERT_EQ(m.points.size(), 4u);
  double lowest = 1, highest = -1;
  for (const auto& p : m.points) {
    lowest = std::min(lowest, p.gap);
    highest = std::max(highest, p.gap);
  }
  EXPECT_NEAR(lowest, m.gap, 1e-12);
  EXPECT_NEAR(highest - lowest, 18e-3 * tilt, 1e-3 * 3.6e-6);
}

TEST(Collide, EdgeOnFaceIsASegment) {
  const ConvexPart a = box({10e-3, 10e-3, 5e-3}, 1e-3), b = box({8e-3, 3e-3, 3e-3}, 1e-3);
  // B stands on an edge along x: its core's edge is sqrt(2) * 2 mm below its center, 14 mm long.
  const double height = 5e-3 + std::sqrt(2) * 2e-3 + 1e-3 - 4e-6;
  const Manifold m = meet(a, b, at({5e-3, 1e-3, height}, turn(M_PI / 4, Vec3::UnitX())));
  EXPECT_NEAR(m.gap, -4e-6, kTiny);
  ASSERT_EQ(m.points.size(), 2u);
  // From x = -2 mm to A's core border at 9 mm.
  const double length = 11e-3;
  const double width = 2 * std::sqrt(2 * 1e-3 * 4e-6);  // of a rounding of 1 mm sunk in by 4 um
  EXPECT_NEAR(weight(m), width * length, 1e-8 * width * length);
  EXPECT_NEAR(m.moments.trace(), width * std::pow(length, 3) / 12, 1e-8 * m.moments.trace());
  EXPECT_NEAR(m.centroid.x(), 3.5e-3, 1e-12);
  EXPECT_NEAR(m.centroid.y(), 1e-3, 1e-12);
}

TEST(Collide, CornerOnFaceIsAPoint) {
  const ConvexPart a = box({10e-3, 10e-3, 5e-3}, 1e-3), b = box({4e-3, 4e-3, 4e-3}, 1e-3);
  // The diagonal of B upright: its core's corner is sqrt(3) * 3 mm below the center.
  const Mat3 upright = shortest_rotation(Vec3(1, 1, 1), Vec3::UnitZ()).toRotationMatrix();
  const double height = 5e-3 + std::sqrt(3) * 3e-3 + 1e-3 - 4e-6;
  const Manifold m = meet(a, b, at({2e-3, 1e-3, height}, upright));
  EXPECT_NEAR(m.gap, -4e-6, kTiny);
  EXPECT_NEAR((m.normal - Vec3::UnitZ()).norm(), 0, 1e-12);
  ASSERT_EQ(m.points.size(), 1u);
  EXPECT_NEAR((m.points[0].position - Vec3(2e-3, 1e-3, 5e-3 - 2e-6)).norm(), 0, 1e-12);
}

TEST(Collide, CrossedEdgesMeetAtTheCrossing) {
  const ConvexPart a = box({8e-3, 3e-3, 3e-3}, 1e-3);
  const Mat3 on_edge = turn(M_PI / 4, Vec3::UnitX());
  const Mat3 across = turn(1.0, Vec3::UnitZ()) * on_edge;
  const double height = 2 * (std::sqrt(2) * 2e-3 + 1e-3) - 4e-6;
  // In A's axes, which are turned by on_edge.
  const Pose pose = at(on_edge.transpose() * Vec3(0, 0, height), on_edge.transpose() * across);
  const Manifold m = meet(a, a, pose);
  EXPECT_NEAR(m.gap, -4e-6, kTiny);
  EXPECT_NEAR((m.normal - on_edge.transpose() * Vec3::UnitZ()).norm(), 0, 1e-12);
  ASSERT_EQ(m.points.size(), 1u);
  EXPECT_NEAR((m.points[0].position - 0.5 * pose.translation).norm(), 0, 1e-12);
}

TEST(Collide, ParallelEdgesMeetOverTheirOverlapAndTurnIntoAPoint) {
  const ConvexPart a = box({8e-3, 3e-3, 3e-3}, 1e-3);
  const Mat3 on_edge = turn(M_PI / 4, Vec3::UnitX());
  const double height = 2 * (std::sqrt(2) * 2e-3 + 1e-3) - 4e-6;
  double last = 0;
  for (const double angle : {0.0, 1e-9, 1e-4, 1e-2, 3e-2, 0.1, 0.3}) {
    const Mat3 turned = turn(angle, Vec3::UnitZ()) * on_edge;
    const Pose pose = at(on_edge.transpose() * Vec3(5e-3, 0, height), on_edge.transpose() * turned);
    const Manifold m = meet(a, a, pose);
    ASSERT_FALSE(m.points.empty()) << angle;
    EXPECT_LT(m.gap, -3.9e-6) << angle;
    double nearest = 1;
    for (const auto& p : m.points) nearest = std::min(nearest, p.gap);
    EXPECT_NEAR(nearest, m.gap, 0.25 * kNarrowShell) << angle;
    // 14 mm edges shifted by 5 mm: 9 mm; from then on the overlap can only shrink.
    if (angle <= 1e-9) {
      // Two roundings of 1 mm are one of half a millimeter.
      EXPECT_NEAR(weight(m), 2 * std::sqrt(2 * 0.5e-3 * 4e-6) * 9e-3, 1e-12);
    } else {
      EXPECT_LE(weight(m), last * (1 + 1e-3)) << angle;
    }
    last = weight(m);
  }
}

TEST(Collide, SphereAgainstBoxInsideAndOut) {
  const ConvexPart a = box({10e-3, 10e-3, 5e-3}, 1e-3), b = sphere_part(Vec3::Zero(), 2e-3);
  // Outside, on the face, inside the core: one line.
  for (const double z : {9e-3, 7e-3 - 4e-6, 5e-3, 4e-3, 4e-3 - 1e-9, 3e-3, 1e-3}) {
    const Manifold m = meet(a, b, at({2e-3, 1e-3, z}), 3e-3);
    EXPECT_NEAR(m.gap, z - 7e-3, kTiny) << z;
    EXPECT_NEAR((m.normal - Vec3::UnitZ()).norm(), 0, 1e-9) << z;
    ASSERT_EQ(m.points.size(), 1u);
    EXPECT_NEAR(m.points[0].position.x(), 2e-3, 1e-12);
  }
}

TEST(Collide, DeepFacesGiveTheWholeOverlap) {
  const ConvexPart a = box({10e-3, 10e-3, 5e-3}, 0.1e-3);
  for (const double depth : {0.15e-3, 0.3e-3, 1e-3, 3e-3}) {
    const Manifold m = meet(a, a, at({1e-3, 2e-3, 10e-3 - depth}));
    EXPECT_NEAR(m.gap, -depth, kTiny);
    ASSERT_EQ(m.points.size(), 4u);
    EXPECT_NEAR(weight(m), (19.8e-3 - 1e-3) * (19.8e-3 - 2e-3), 1e-15);
  }
}

TEST(Collide, GapIsContinuousFromDistanceToDepth) {
  const ConvexPart a = box({10e-3, 8e-3, 5e-3}, 0.1e-3), b = box({4e-3, 5e-3, 6e-3}, 0.1e-3);
  Random random(11);
  for (int k = 0; k < 100; ++k) {
    const Mat3 rotation = random.rotation();
    const Vec3 away = random.direction();
    // Bisection for the touch of the cores along a random line.
    double inside = 0, outside = 0.05;
    for (int i = 0; i < 60; ++i) {
      GjkCache cache;
      const double middle = 0.5 * (inside + outside);
      (core_distance(a, b, at(middle * away, rotation), cache) > 0 ? outside : inside) = middle;
    }
    double last_gap = 0;
    for (int i = -20; i <= 20; ++i) {
      const double step = 1e-10;
      const Manifold m = meet(a, b, at((outside + i * step) * away, rotation));
      EXPECT_NEAR(m.gap, -0.2e-3, 25 * step);
      EXPECT_FALSE(m.points.empty());
      if (i > -20) {
        EXPECT_GE(m.gap, last_gap - 1e-14);
        EXPECT_LE(m.gap, last_gap + step * 1.0001 + 1e-14);
      }
      last_gap = m.gap;
    }
  }
}

// Poses from apart to deep, faces, edges and corners first.
std::vector<Pose> assorted_poses(int count) {
  Random random(17);
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) {
    const Mat3 rotation = i % 3 == 0   ? Mat3(turn(random.uniform(0, 6), Vec3::UnitZ()))
                          : i % 3 == 1 ? Mat3(turn(random.uniform(0, 6), Vec3::UnitX()))
                                       : random.rotation();
    poses.push_back(at(random.uniform(8e-3, 18e-3) * random.direction(), rotation));
  }
  return poses;
}

TEST(Collide, SwappingThePartsMirrorsTheAnswer) {
  const ConvexPart a = box({10e-3, 8e-3, 5e-3}, 0.5e-3), b = box({4e-3, 5e-3, 6e-3}, 1e-3);
  for (const Pose& pose : assorted_poses(600)) {
    const Pose back{pose.rotation.transpose(), -(pose.rotation.transpose() * pose.translation)};
    const Manifold m = meet(a, b, pose), n = meet(b, a, back);
    EXPECT_EQ(m.points.empty(), n.points.empty());
    if (m.points.empty()) continue;
    EXPECT_NEAR(m.gap, n.gap, 1e-12);
    EXPECT_NEAR(m.area, n.area, 1e-9 * m.area + 1e-15);
    // Two ways out of the same depth may both be right.
    if ((m.normal + pose.rotation * n.normal).norm() > 1e-6) continue;
    EXPECT_NEAR((m.centroid - pose * n.centroid).norm(), 0, 1e-9);
  }
}

TEST(Collide, MovingBothPartsMovesTheAnswer) {
  const ConvexPart a = box({10e-3, 8e-3, 5e-3}, 0.5e-3), b = box({4e-3, 5e-3, 6e-3}, 1e-3);
  const Pose shift = at({3e-3, -2e-3, 7e-3}, turn(0.7, Vec3(1, 2, -1)));
  // The same solid described in other axes.
  std::vector<HalfSpace> planes = box_planes(-Vec3(10e-3, 8e-3, 5e-3), Vec3(10e-3, 8e-3, 5e-3));
  for (auto& h : planes) {
    h.normal = shift.rotation * h.normal;
    h.offset += h.normal.dot(shift.translation);
  }
  const ConvexPart moved_a = convex_part(planes, 0.5e-3);
  for (const Pose& pose : assorted_poses(600)) {
    const Pose moved{shift.rotation * pose.rotation, shift * pose.translation};
    const Manifold m = meet(a, b, pose), n = meet(moved_a, b, moved);
    EXPECT_EQ(m.points.empty(), n.points.empty());
    if (m.points.empty()) continue;
    EXPECT_NEAR(m.gap, n.gap, 1e-12);
    if ((shift.rotation * m.normal - n.normal).norm() > 1e-6) continue;  // a tie
    EXPECT_NEAR((shift * m.centroid - n.centroid).norm(), 0, 1e-9);
    EXPECT_NEAR(m.area, n.area, 1e-9 * m.area + 1e-15);
  }
}

TEST(Collide, WarmStartChangesNothing) {
  const ConvexPart a = box({10e-3, 8e-3, 5e-3}, 0.5e-3), b = box({4e-3, 5e-3, 6e-3}, 1e-3);
  Random random(23);
  for (Pose pose : assorted_poses(200)) {
    GjkCache warm;
    Manifold m;
    for (int i = 0; i < 20; ++i) {
      collide(a, b, pose, 0.2e-3, warm, m);
      const Manifold cold = meet(a, b, pose, 0.2e-3);
      if (!cold.points.empty() || !m.points.empty()) {
        EXPECT_NEAR(m.gap, cold.gap, 1e-13);
        EXPECT_NEAR(weight(m), weight(cold), 1e-9 * weight(cold) + 1e-15);
      }
      pose.rotation = turn(random.uniform(-0.05, 0.05), random.direction()) * pose.rotation;
      pose.translation += 0.5e-3 * random.direction();
    }
  }
}

// Parts of many faces have no masks of them, and look for their faces one by one.
TEST(Collide, FacesAreFoundWithAndWithoutMasks) {
  const auto without_masks = [](ConvexPart part) {
    EXPECT_EQ(part.surface_faces.size(), static_cast<std::size_t>(part.vertex_count));
    part.surface_faces.clear();
    return part;
  };
  const ConvexPart a = box({10e-3, 8e-3, 5e-3}, 0.5e-3), plain_a = without_masks(a);
  int touching = 0;
  for (const ConvexPart& b : slabs({12e-3, 5e-3, 6e-3}, 1e-3, 3)) {
    const ConvexPart plain_b = without_masks(b);
    for (const Pose& pose : assorted_poses(500)) {
      const Manifold m = meet(a, b, pose, 0.2e-3), plain = meet(plain_a, plain_b, pose, 0.2e-3);
      EXPECT_EQ(m.gap, plain.gap);
      ASSERT_EQ(m.points.size(), plain.points.size());
      touching += !m.points.empty();
      for (std::size_t i = 0; i < m.points.size(); ++i) {
        EXPECT_EQ(m.points[i].position, plain.points[i].position);
        EXPECT_EQ(m.points[i].gap, plain.points[i].gap);
        EXPECT_EQ(m.points[i].weight, plain.points[i].weight);
      }
    }
  }
  EXPECT_GT(touching, 100);
}

TEST(Collide, SlabsAddUpToTheWholeFace) {
  const Vec3 half(12e-3, 8e-3, 5e-3);
  const ConvexPart whole = box(half, 1e-3), b = box({9e-3, 9e-3, 3e-3}, 1e-3);
  for (const double tilt : {0.0, 1e-9, 1e-4, -1e-4}) {
    const Pose pose =
        at({2e-3, 1e-3, 8e-3 - 6e-6}, turn(tilt, Vec3(0.3, 1, 0)) * turn(0.3, Vec3::UnitZ()));
    const Manifold one = meet(whole, b, pose);
    const Load expected = load({one});
    for (int count = 2; count <= 12; ++count) {
      std::vector<Manifold> pieces;
      double area = 0;
      for (const ConvexPart& slab : slabs(half, 1e-3, count)) {
        pieces.push_back(meet(slab, b, pose));
        if (!pieces.back().points.empty()) area += pieces.back().area;
      }
      // A slab may take A's face normal where the whole takes B's: the outline moves by the tilt
      // times the sweep.
      const double tolerance = 1e-9 + std::abs(tilt);
      EXPECT_NEAR(area, one.area, tolerance * one.area) << count << " " << tilt;
      const Load got = load(pieces);
      EXPECT_NEAR(got.force, expected.force, tolerance * expected.force) << count << " " << tilt;
      // Under tilt, overlap times arm is quadratic: the weights overrate it by up to three times
      // for one rectangle, less for narrow ones. Exact when flat.
      if (std::abs(tilt) > 1e-8) continue;
      EXPECT_NEAR((got.moment - expected.moment).norm(), 0, 1e-8 * expected.force) << count;
    }
  }
}

TEST(Collide, CornerNextToASeamTouchesOnlyItsOwnSlab) {
  const Vec3 half(12e-3, 8e-3, 5e-3);
  const Mat3 upright = shortest_rotation(Vec3(1, 1, 1), Vec3::UnitZ()).toRotationMatrix();
  const ConvexPart b = box({4e-3, 4e-3, 4e-3}, 1e-3);
  const double height = 5e-3 + std::sqrt(3) * 3e-3 + 1e-3 - 10e-6;
  for (const double x : {-50e-6, -5e-6, -1e-9, 1e-9, 5e-6, 50e-6}) {
    const auto parts = slabs(half, 1e-3, 2);  // seam at x = 0
    int touching = 0;
    for (const ConvexPart& slab : parts) {
      const Manifold m = meet(slab, b, at({x, 1e-3, height}, upright));
      if (m.points.empty()) continue;
      ++touching;
      EXPECT_NEAR((m.normal - Vec3::UnitZ()).norm(), 0, 1e-9);
      EXPECT_NEAR(m.gap, -10e-6, 1e-12);
    }
    EXPECT_EQ(touching, 1) << x;
  }
}

TEST(Collide, FlatFaceOnAPieceThatLeansToItsSeamStays) {
  // A ridge at x = 0: two pieces whose tops fall away by 0.1 rad, cut at the ridge.
  const double lean = 0.1;
  auto planes = box_planes({-10e-3, -8e-3, -5e-3}, {0, 8e-3, 10e-3});
  planes[0].internal = true;
  planes.push_back({Vec3(-std::sin(lean), 0, std::cos(lean)), 0, false});
  const ConvexPart left = convex_part(planes, 0.5e-3);
  const ConvexPart b = box({3e-3, 3e-3, 2e-3}, 0.5e-3);
  // B lies on the left slope with its right side exactly over the ridge.
  const Mat3 slope = turn(-lean, Vec3::UnitY());
  const Manifold m = meet(left, b, at(slope * Vec3(-2e-3, 0, 2e-3 - 5e-6), slope));
  EXPECT_NEAR(m.gap, -5e-6, 1e-12);
  EXPECT_GE(m.points.size(), 4u);
}

TEST(CollidePlane, FaceEdgeAndCorner) {
  const ConvexPart a = box({10e-3, 8e-3, 5e-3}, 1e-3);
  Manifold m;
  collide_plane(a, Vec3::UnitZ(), -5e-3 + 4e-6, kNarrowShell, m);
  EXPECT_NEAR(m.gap, -4e-6, kTiny);
  EXPECT_NEAR((m.normal + Vec3::UnitZ()).norm(), 0, 1e-15);
  ASSERT_EQ(m.points.size(), 4u);
  EXPECT_NEAR(weight(m), 18e-3 * 14e-3, 1e-15);
  EXPECT_NEAR(m.points[0].position.z(), -5e-3 + 2e-6, kTiny);
  EXPECT_NEAR(m.moments.trace(), m.area * (18e-3 * 18e-3 + 14e-3 * 14e-3) / 12,
              1e-12 * m.moments.trace());

  const Vec3 edge_up = Vec3(0, 1, 1).normalized();  // lowest: the edge along x at -y, -z
  const double reach = (7e-3 + 4e-3) / std::sqrt(2) + 1e-3;
  collide_plane(a, edge_up, -reach + 4e-6, kNarrowShell, m);
  EXPECT_NEAR(m.gap, -4e-6, kTiny);
  ASSERT_EQ(m.points.size(), 2u);
  EXPECT_NEAR(weight(m), 2 * std::sqrt(2 * 1e-3 * 4e-6) * 18e-3, 1e-12);

  const Vec3 corner_up = Vec3(1, 1, 1).normalized();
  collide_plane(a, corner_up, -(9e-3 + 7e-3 + 4e-3) / std::sqrt(3) - 1e-3 + 4e-6, kNarrowShell, m);
  EXPECT_NEAR(m.gap, -4e-6, kTiny);
  ASSERT_EQ(m.points.size(), 1u);

  collide_plane(a, Vec3::UnitZ(), -6e-3, kNarrowShell, m);
  EXPECT_NEAR(m.gap, 1e-3, kTiny);
  EXPECT_TRUE(m.points.empty());
}

TEST(CollidePlane, HoldsEveryVertexBelowHoweverDeepAndTilted) {
  const ConvexPart a = box({10e-3, 8e-3, 5e-3}, 1e-3);
  Random random(31);
  Manifold m;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 n = random.direction();
    const double offset = random.uniform(-15e-3, 15e-3);
    collide_plane(a, n, offset, kNarrowShell, m);
    double lowest = 1;
    std::size_t below = 0;
    for (int v = 0; v < a.vertex_count; ++v) {
      const double gap = n.dot(a.vertex(v)) - offset - 1e-3;
      lowest = std::min(lowest, gap);
      below += gap < kNarrowShell;
    }
    EXPECT_NEAR(m.gap, lowest, kTiny);
    EXPECT_EQ(m.points.size(), below);
    for (const auto& p : m.points) {
      EXPECT_GT(p.weight, 0);
      EXPECT_NEAR(n.dot(p.position) - offset, 0.5 * p.gap, kTiny);
    }
  }
}

TEST(CollidePlane, SlabsAddUpToTheWholeFace) {
  const Vec3 half(12e-3, 8e-3, 5e-3);
  const ConvexPart whole = box(half, 1e-3);
  for (const double tilt : {0.0, 1e-4}) {
    const Vec3 n = turn(tilt, Vec3::UnitY()) * Vec3::UnitZ();
    const double offset = -5e-3 + 10e-6;
    Manifold one;
    collide_plane(whole, n, offset, kNarrowShell, one);
    const Load expected = load({one});
    for (int count = 2; count <= 12; ++count) {
      std::vector<Manifold> pieces;
      double area = 0;
      for (const ConvexPart& slab : slabs(half, 1e-3, count)) {
        collide_plane(slab, n, offset, kNarrowShell, pieces.emplace_back());
        if (!pieces.back().points.empty()) area += pieces.back().area;
      }
      const Load got = load(pieces);
      EXPECT_NEAR(area, one.area, 1e-6 * one.area);
      EXPECT_NEAR(got.force, expected.force, 1e-9 * expected.force);
      if (tilt == 0) {
        EXPECT_NEAR((got.moment - expected.moment).norm(), 0, 1e-8 * expected.force);
      }
    }
  }
}

TEST(CollidePlane, InternalFaceIsNeverTheContact) {
  const auto parts = slabs({12e-3, 8e-3, 5e-3}, 1e-3, 3);
  Manifold m;
  // The middle slab stands on its cut; the slab below it is the one that touches.
  collide_plane(parts[1], Vec3::UnitX(), -4e-3 + 5e-6, kNarrowShell, m);
  EXPECT_TRUE(m.points.empty());
  EXPECT_NEAR(m.gap, -1e-3 - 5e-6, kTiny);  // a seam's sweep reaches beyond it
}

}  // namespace
}  // namespace firn
