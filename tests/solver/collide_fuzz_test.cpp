// Random, parallel, grazing and nearly touching pairs against a brute-force referee and libccd.
#include <ccd/ccd.h>
#include <gtest/gtest.h>

#include <cstdio>

#include "solver/gjk.h"
#include "tests/solver/collide_referee.h"

namespace firn {
namespace {

using testing::Random;

std::vector<ConvexPart> make_parts(Random& random) {
  std::vector<ConvexPart> parts;
  for (int k = 0; k < 12; ++k) {
    const Vec3 half(random.uniform(2e-3, 2e-2), random.uniform(2e-3, 2e-2),
                    random.uniform(2e-3, 2e-2));
    parts.push_back(testing::box(half, 0));
  }
  for (int k = 0; k < 12; ++k) {
    std::vector<Vec3> points;
    for (int i = 5 + random.below(20); i > 0; --i) {
      points.push_back(random.uniform(0.5, 1) * 10e-3 * random.direction());
    }
    parts.push_back(convex_part(convex_hull(points), 0));
  }
  parts.push_back(sphere_part(Vec3(1e-3, 0, 0), 0));
  parts.push_back(testing::box({10e-3, 10e-3, 0.1e-3}, 0));  // plate
  parts.push_back(testing::box({30e-3, 1e-3, 1e-3}, 0));     // needle
  return parts;
}

// One of: any, parallel axes, almost parallel and almost touching, any and almost touching.
Pose make_pose(const ConvexPart& a, const ConvexPart& b, Random& random) {
  const int kind = random.below(4);
  Pose pose;
  pose.rotation = random.rotation();
  if (kind == 1) pose.rotation.setIdentity();
  if (kind == 2) {
    const double angle = random.uniform(-1, 1) * std::pow(10, -random.uniform(1, 10));
    pose.rotation = Eigen::AngleAxisd(angle, random.direction()).toRotationMatrix();
  }
  pose.translation =
      random.direction() * random.uniform(0, 1) * (a.bounding_radius + b.bounding_radius);
  if (kind < 2) return pose;
  const auto faces = static_cast<int>(a.faces.size());
  const Vec3 n =
      faces > 0 && random.below(2) ? a.faces[random.below(faces)].normal : random.direction();
  const double wanted = (random.below(2) ? 1 : -1) * std::pow(10, -random.uniform(2, 14));
  const double now = testing::separation(testing::place(a, Pose{}), testing::place(b, pose), n);
  pose.translation += (wanted - now) * n;
  return pose;
}

void ccd_support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* out) {
  const auto& vertices = static_cast<const testing::Placed*>(object)->vertices;
  const Vec3 d(direction->v[0], direction->v[1], direction->v[2]);
  const Vec3* best = &vertices[0];
  for (const Vec3& v : vertices) {
    if (d.dot(v) > d.dot(*best)) best = &v;
  }
  const Vec3 scaled = 100 * *best;  // about unit size, which libccd's tolerances expect
  ccdVec3Set(out, scaled.x(), scaled.y(), scaled.z());
}

bool ccd_overlap(const testing::Placed& a, const testing::Placed& b) {
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = ccd.support2 = ccd_support;
  ccd.max_iterations = 200;
  return ccdGJKIntersect(&a, &b, &ccd) == 1;
}

struct Tally {
  int apart = 0, overlapping = 0;
  double distance_error = 0;     // m, largest
  double normal_error = 0;       // m, largest: what the normal separates against the distance
  double shallow_error = 0;      // m, largest, overlaps up to a fifth of the smaller radius
  int deep = 0, deep_wrong = 0;  // deeper ones, and those whose way out is not the shortest
  double deep_excess = 0;        // largest excess of those, of the smaller radius
  int ccd_asked = 0, ccd_differs = 0;
};

void check_manifold(const ConvexPart& a, const ConvexPart& b, const Pose& pose) {
  constexpr double kShell = 20e-6;
  GjkCache cold;
  Manifold m;
  collide(a, b, pose, kShell, cold, m);
  if (m.gap >= kShell) {
    EXPECT_TRUE(m.points.empty());
    return;
  }
  ASSERT_FALSE(m.points.empty());
  double nearest = 1, weight = 0;
  for (const auto& p : m.points) {
    EXPECT_GT(p.weight, -1e-18);
    nearest = std::min(nearest, p.gap);
    weight += p.weight;
  }
  EXPECT_GE(nearest, m.gap - 1e-9);
  EXPECT_LE(nearest, m.gap + 0.3 * kShell);
  EXPECT_GT(weight, 0);
  EXPECT_LE(weight, m.area * (1 + 1e-9) + 1e-18);
  EXPECT_GE(m.polar, 0);
}

Tally fuzz(int pairs, std::uint64_t seed) {
  Random random(seed);
  const auto parts = make_parts(random);
  Tally tally;
  for (int k = 0; k < pairs && !::testing::Test::HasFatalFailure(); ++k) {
    const ConvexPart& a = parts[random.below(static_cast<int>(parts.size()))];
    const ConvexPart& b = parts[random.below(static_cast<int>(parts.size()))];
    const Pose pose = make_pose(a, b, random);
    const double expected = testing::referee(a, b, pose);
    GjkCache cold;
    CoreContact got = core_contact(a, b, pose, std::numeric_limits<double>::infinity(), cold);
    const double near = touching_distance(a, b);
    const bool touching = got.distance <= near;
    EXPECT_EQ(touching, expected <= near) << expected;
    if (touching) got = penetration(a, b, pose);

    const auto pa = testing::place(a, Pose{}), pb = testing::place(b, pose);
    tally.normal_error = std::max(tally.normal_error,
                                  std::abs(testing::separation(pa, pb, got.normal) - got.distance));
    const double error = std::abs(got.distance - expected);
    const double size = std::min(a.bounding_radius, b.bounding_radius);
    if (!touching) {
      ++tally.apart;
      tally.distance_error = std::max(tally.distance_error, error);
    } else if (expected > -near) {
      // Too near for a direction: either side of zero counts as touching.
      EXPECT_LE(error, 2 * near);
    } else if (-expected < 0.2 * size) {
      ++tally.overlapping;
      tally.shallow_error = std::max(tally.shallow_error, error);
    } else {
      ++tally.overlapping;
      ++tally.deep;
      tally.deep_wrong += error > 1e-9;
      if (size > 0) tally.deep_excess = std::max(tally.deep_excess, error / size);
    }
    if (std::abs(expected) > 1e-6) {
      ++tally.ccd_asked;
      tally.ccd_differs += ccd_overlap(pa, pb) != touching;
    }
    check_manifold(a, b, pose);
  }
  std::printf(
      "%d apart: distance within %.1e m, normal within %.1e m; %d overlapping: depth within %.1e m "
      "up to a fifth of the radius; deeper %d, not the shortest way out %d, by up to %.0f %% of "
      "the radius; libccd disagrees in %d of %d\n",
      tally.apart, tally.distance_error, tally.normal_error, tally.overlapping, tally.shallow_error,
      tally.deep, tally.deep_wrong, 100 * tally.deep_excess, tally.ccd_differs, tally.ccd_asked);
  return tally;
}

void expect_sound(const Tally& t) {
  EXPECT_GT(t.apart, 1000);
  EXPECT_GT(t.overlapping, 1000);
  EXPECT_LE(t.distance_error, 1e-15);
  EXPECT_LE(t.normal_error, 1e-12);
  EXPECT_LE(t.shallow_error, 1e-12);
  // libccd's polytope now and then leads to a neighbouring way out.
  EXPECT_LE(t.deep_wrong, 0.02 * t.deep);
  EXPECT_LE(t.ccd_differs, 1e-3 * t.ccd_asked);
}

TEST(CollideFuzz, AgreesWithEveryFeaturePairAndAxis) { expect_sound(fuzz(20000, 1)); }

TEST(CollideFuzzLong, AgreesWithEveryFeaturePairAndAxis) { expect_sound(fuzz(2000000, 2)); }

}  // namespace
}  // namespace firn
