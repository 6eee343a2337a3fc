// Plane surfaces that are not convex: their cuts have no effect. Random floors of boxes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "solver/contact/surface_contacts.h"
#include "tests/solver/collision/brute_force_distance.h"

namespace firn {
namespace {

using testing::box;
using testing::box_planes;
using testing::Random;

constexpr double kShell = 20e-6;  // m

// Cells between random lines of a square of 0.4 m about the origin, their tops at z = 0. Some are
// open.
struct CellFloor {
  static constexpr int kCells = 7;
  double x[kCells + 1], y[kCells + 1];
  int part[kCells][kCells];  // -1: open
  std::vector<ConvexPart> parts;

  explicit CellFloor(Random& random) {
    for (int i = 0; i <= kCells; ++i) {
      const double middle = 0.4 * i / kCells - 0.2;
      x[i] = middle + random.uniform(-0.02, 0.02);
      y[i] = middle + random.uniform(-0.02, 0.02);
    }
    int count = 0;
    for (auto& column : part) {
      for (int& p : column) p = random.below(4) == 0 ? -1 : count++;
    }
    for (int i = 0; i < kCells; ++i) {
      for (int k = 0; k < kCells; ++k) {
        if (part[i][k] < 0) continue;
        auto planes = box_planes({x[i], y[k], -0.01}, {x[i + 1], y[k + 1], 0});
        planes[0].internal = is_solid(i + 1, k);
        planes[1].internal = is_solid(i - 1, k);
        planes[2].internal = is_solid(i, k + 1);
        planes[3].internal = is_solid(i, k - 1);
        parts.push_back(convex_part(planes, 0));
      }
    }
  }
  bool is_solid(int i, int k) const {
    return i >= 0 && i < kCells && k >= 0 && k < kCells && part[i][k] >= 0;
  }
  // True when all cells that meet the circle are solid.
  bool is_solid_around(const Vec3& at, double radius) const {
    if (at.x() - radius < x[0] || at.x() + radius > x[kCells] || at.y() - radius < y[0] ||
        at.y() + radius > y[kCells])
      return false;
    for (int i = 0; i < kCells; ++i) {
      for (int k = 0; k < kCells; ++k) {
        const double dx = at.x() - std::clamp(at.x(), x[i], x[i + 1]);
        const double dy = at.y() - std::clamp(at.y(), y[k], y[k + 1]);
        if (part[i][k] < 0 && std::hypot(dx, dy) < radius) return false;
      }
    }
    return true;
  }
};

// A random floor and its surfaces.
struct FloorWithSurfaces {
  CellFloor floor;
  FlatSurfaces surfaces;

  explicit FloorWithSurfaces(Random& random)
      : floor(random), surfaces(find_flat_surfaces(floor.parts)) {}
};

// The face of a part whose normal is +z.
int top_face(const ConvexPart& part) {
  for (std::size_t f = 0; f < part.faces.size(); ++f) {
    if (part.faces[f].normal.z() > 0.99) return static_cast<int>(f);
  }
  return -1;
}

TEST(FlatSurface, IsTheCellsThatAdjoinEachOther) {
  Random random(11);
  for (int member = 0; member < 50; ++member) {
    const CellFloor floor(random);
    const FlatSurfaces found = find_flat_surfaces(floor.parts);
    ASSERT_FALSE(found.empty());
    // Reference: fill from each cell to its four neighbors.
    std::vector<int> set(floor.parts.size(), -1);
    int sets = 0;
    for (int i = 0; i < CellFloor::kCells; ++i) {
      for (int k = 0; k < CellFloor::kCells; ++k) {
        if (!floor.is_solid(i, k) || set[static_cast<std::size_t>(floor.part[i][k])] >= 0) continue;
        std::vector<std::pair<int, int>> stack{{i, k}};
        while (!stack.empty()) {
          const auto [u, v] = stack.back();
          stack.pop_back();
          if (!floor.is_solid(u, v)) continue;
          int& own = set[static_cast<std::size_t>(floor.part[u][v])];
          if (own >= 0) continue;
          own = sets;
          stack.insert(stack.end(), {{u + 1, v}, {u - 1, v}, {u, v + 1}, {u, v - 1}});
        }
        ++sets;
      }
    }
    const auto surface_of = [&](std::size_t p) {
      return found.of_face[p][static_cast<std::size_t>(top_face(floor.parts[p]))];
    };
    for (std::size_t p = 0; p < set.size(); ++p) {
      EXPECT_EQ(surface_of(p) < 0, std::ranges::count(set, set[p]) == 1)
          << "member " << member << ", part " << p;
      for (std::size_t q = 0; q < p; ++q) {
        if (surface_of(p) < 0 || surface_of(q) < 0) continue;
        EXPECT_EQ(surface_of(p) == surface_of(q), set[p] == set[q])
            << "member " << member << ", parts " << p << " and " << q;
      }
    }
  }
}

// Body A of one part against the parts of B: contacts as a step finds them.
std::vector<PartContact> contacts_of(const ConvexPart& a, const std::vector<ConvexPart>& parts_b,
                                     const FlatSurfaces& surfaces_b, const Pose& b_in_a) {
  std::vector<PartContact> contacts;
  for (std::size_t b = 0; b < parts_b.size(); ++b) {
    PartContact c;
    c.b = static_cast<int>(b);
    GjkCache cold;
    collide(a, parts_b[b], b_in_a, kShell, cold, c.manifold);
    if (!c.manifold.points.empty()) contacts.push_back(c);
  }
  const FlatSurfaces none;
  const std::size_t kept = join_surface_contacts(
      {std::span(&a, 1), parts_b, none, surfaces_b, b_in_a, 0, kShell}, contacts, contacts.size());
  contacts.resize(kept);
  return contacts;
}

TEST(FlatSurface, ABoxOnACutFloorHasTheRegionOfAnUncutOne) {
  Random random(12);
  const ConvexPart cube = box({12e-3, 10e-3, 8e-3}, 0.1e-3);
  const std::vector<ConvexPart> uncut{
      convex_part(box_planes({-0.5, -0.5, -0.01}, {0.5, 0.5, 0}), 0)};
  int several = 0;  // members on more than one part
  for (int member = 0; member < 2000;) {
    const CellFloor floor(random);
    const FlatSurfaces surfaces = find_flat_surfaces(floor.parts);
    const Vec3 place(random.uniform(-0.18, 0.18), random.uniform(-0.18, 0.18), 0);
    if (!floor.is_solid_around(place, 20e-3)) continue;
    ++member;
    // Flat, near flat, and any way up.
    const double tilt = member % 4 == 0 ? 0 : member % 4 == 1 ? M_PI : 0.03;
    const Mat3 turn = Eigen::AngleAxisd(random.uniform(0, 2 * M_PI), Vec3::UnitZ()) *
                      Eigen::AngleAxisd(random.uniform(-tilt, tilt), random.direction()) *
                      Mat3::Identity();
    double lowest = 0;
    for (int i = 0; i < cube.vertex_count; ++i)
      lowest = std::min(lowest, (turn * cube.vertex(i)).z() - cube.radius);
    const Vec3 center = place + Vec3(0, 0, -lowest - random.uniform(1e-6, 60e-6));
    const Pose b_in_a{turn.transpose(), -(turn.transpose() * center)};
    const auto got = contacts_of(cube, floor.parts, surfaces, b_in_a);
    const auto wanted = contacts_of(cube, uncut, {}, b_in_a);
    ASSERT_EQ(wanted.size(), 1u) << "member " << member;
    ASSERT_EQ(got.size(), 1u) << "member " << member;
    const Manifold &m = got[0].manifold, &w = wanted[0].manifold;
    several += got[0].other_b != 0;
    EXPECT_NEAR((m.normal - w.normal).norm(), 0, 1e-9) << "member " << member;
    EXPECT_NEAR(m.area, w.area, 1e-9 * w.area) << "member " << member;
    EXPECT_NEAR((m.centroid - w.centroid).norm(), 0, 1e-10) << "member " << member;
    ASSERT_EQ(m.points.size(), w.points.size()) << "member " << member;
    for (const ManifoldPoint& p : w.points) {
      const bool found = std::ranges::any_of(m.points, [&](const ManifoldPoint& q) {
        return (p.position - q.position).norm() < 1e-10 && std::abs(p.gap - q.gap) < 1e-12 &&
               std::abs(p.weight - q.weight) < 1e-9 * w.area;
      });
      EXPECT_TRUE(found) << "member " << member;
    }
  }
  EXPECT_GT(several, 500);
}

// A box cut by random planes: with large faces, or round with many small ones.
ConvexPart random_part(Random& random) {
  auto planes = box_planes({-6e-3, -5e-3, -4e-3}, {6e-3, 5e-3, 4e-3});
  const bool is_round = random.below(2) == 0;
  const int cuts = is_round ? 40 : random.below(12);
  for (int i = 0; i < cuts; ++i)
    planes.push_back({random.direction(), random.uniform(4e-3, is_round ? 4.2e-3 : 7e-3), false});
  return convex_part(planes, random.uniform(0.2e-3, 0.8e-3));
}

bool has_point(const Manifold& m, const ManifoldPoint& wanted, double area) {
  return std::ranges::any_of(m.points, [&](const ManifoldPoint& p) {
    return (p.position - wanted.position).norm() < 1e-9 && std::abs(p.gap - wanted.gap) < 1e-10 &&
           std::abs(p.weight - wanted.weight) < 1e-6 * area;
  });
}

// As deep as the rounding, and tilted: what is in the shell bears, on an endless plane, a box and a
// cut floor.
TEST(FlatSurface, APlaneABoxAndACutFloorHaveTheSamePoints) {
  Random random(13);
  const std::vector<ConvexPart> uncut{
      convex_part(box_planes({-0.5, -0.5, -0.1}, {0.5, 0.5, 0}), 0)};
  constexpr int kMembers = 3000, kOfOneFloor = 20;
  int many = 0;  // members with a corner besides their feature
  FloorWithSurfaces current(random);
  for (int member = 0; member < kMembers;) {
    if (random.below(kOfOneFloor) == 0) current = FloorWithSurfaces(random);
    const auto& [floor, surfaces] = current;
    const Vec3 place(random.uniform(-0.18, 0.18), random.uniform(-0.18, 0.18), 0);
    if (!floor.is_solid_around(place, 20e-3)) continue;
    ++member;
    const ConvexPart part = random_part(random);
    // Any way up, or near flat on one of its faces.
    const Vec3 down = member % 2 == 0 ? random.direction()
                                      : part.faces[static_cast<std::size_t>(random.below(
                                                       static_cast<int>(part.faces.size())))]
                                            .normal;
    const Mat3 turn =
        Eigen::AngleAxisd(random.uniform(-0.1, 0.1), random.direction()).toRotationMatrix() *
        shortest_rotation(down, -Vec3::UnitZ()).toRotationMatrix();
    double lowest = 0;
    for (int i = 0; i < part.vertex_count; ++i)
      lowest = std::min(lowest, (turn * part.vertex(i)).z() - part.radius);
    const double depth = part.radius * std::pow(10, random.uniform(-2, 0));  // m
    const Vec3 center = place + Vec3(0, 0, -lowest - depth);
    const Pose b_in_a{turn.transpose(), -(turn.transpose() * center)};
    Manifold plane;
    collide_plane(part, turn.transpose() * Vec3::UnitZ(), -center.z(), kShell, plane);
    const ContactFeature& lowest_feature = plane.feature_a;
    const std::size_t own = lowest_feature.face
                                ? static_cast<std::size_t>(lowest_feature.face->count)
                            : lowest_feature.kind == ContactFeature::Kind::edge ? 2
                                                                                : 1;
    many += plane.points.size() > own;
    for (const bool is_cut : {false, true}) {
      const auto got = is_cut ? contacts_of(part, floor.parts, surfaces, b_in_a)
                              : contacts_of(part, uncut, {}, b_in_a);
      ASSERT_EQ(got.size(), 1u) << "member " << member << ", cut " << is_cut;
      const Manifold& m = got[0].manifold;
      EXPECT_NEAR((m.normal - plane.normal).norm(), 0, 1e-9) << "member " << member;
      EXPECT_NEAR(m.area, plane.area, 1e-6 * plane.area)
          << "member " << member << ", cut " << is_cut;
      EXPECT_EQ(m.points.size(), plane.points.size()) << "member " << member << ", cut " << is_cut;
      for (const ManifoldPoint& p : plane.points)
        EXPECT_TRUE(has_point(m, p, plane.area)) << "member " << member << ", cut " << is_cut;
    }
  }
  EXPECT_GT(many, 200);
}

// m, smallest gap of the points; infinite without any.
double least_gap(const Manifold& m) {
  double least = std::numeric_limits<double>::infinity();
  for (const ManifoldPoint& p : m.points) least = std::min(least, p.gap);
  return least;
}

// The contacts of a body on a floor are as deep as its parts are, and make patches that can be
// computed. Returns the number of contacts.
std::size_t expect_sound_contacts(const ConvexPart& part, const FloorWithSurfaces& on,
                                  const Pose& b_in_a, int member) {
  const std::vector<ConvexPart>& parts = on.floor.parts;
  double deepest = std::numeric_limits<double>::infinity();
  for (const ConvexPart& b : parts) {
    GjkCache cold;
    Manifold m;
    collide(part, b, b_in_a, kShell, cold, m);
    if (!m.points.empty()) deepest = std::min(deepest, least_gap(m));
  }
  const std::vector<PartContact> contacts = contacts_of(part, parts, on.surfaces, b_in_a);
  if (contacts.empty()) return 0;
  double joined = std::numeric_limits<double>::infinity();
  for (const PartContact& c : contacts) {
    EXPECT_FALSE(c.manifold.points.empty()) << "member " << member;
    joined = std::min(joined, least_gap(c.manifold));
  }
  EXPECT_LE(joined, deepest + 1e-3 * kShell) << "member " << member;
  PairCoefficients law;
  law.stiffness = 1e5;
  law.contact_margin = kShell;
  law.match_distance = law.merge_distance = 1e-6;
  law.late_overlap = law.overlap_limit = 1;
  const std::vector<std::uint64_t> alone{1};
  PatchScratch scratch;
  PatchBuffer found;
  build_patches({.law = law,
                 .rotation_a = Mat3::Identity(),
                 .contacts = contacts,
                 .neighbors_a = alone,
                 .neighbors_b = {},
                 .old_patches = {}},
                scratch, found);
  EXPECT_FALSE(found.patches.empty()) << "member " << member;
  for (const ContactPatch& patch : found.patches) {
    EXPECT_GT(patch.point_count, 0) << "member " << member;
    EXPECT_NEAR(patch.normal.norm(), 1, 1e-12) << "member " << member;
    EXPECT_TRUE(patch.arm.allFinite()) << "member " << member;
    EXPECT_TRUE(std::isfinite(patch.torsion_radius)) << "member " << member;
    for (std::uint32_t k = 0; k < patch.point_count; ++k)
      EXPECT_GT(found.points[patch.first_point + k].stiffness_fraction, 0) << "member " << member;
  }
  return contacts.size();
}

// At rims, holes and corners of a floor, from above and from the side, any way up.
TEST(FlatSurface, ContactsAtBordersKeepTheirDepth) {
  Random random(14);
  constexpr int kMembers = 6000, kOfOneFloor = 200;
  std::size_t contacts = 0;
  FloorWithSurfaces current(random);
  for (int member = 0; member < kMembers; ++member) {
    if (member % kOfOneFloor == 0) current = FloorWithSurfaces(random);
    const CellFloor& floor = current.floor;
    const ConvexPart part = random_part(random);
    const auto at_line = [&](const double(&lines)[CellFloor::kCells + 1]) {
      return random.below(2) == 0
                 ? random.uniform(-0.2, 0.2)
                 : lines[random.below(CellFloor::kCells + 1)] + random.uniform(-8e-3, 8e-3);
    };
    Vec3 center(at_line(floor.x), at_line(floor.y), random.uniform(0, 20e-3));
    const Vec3 down =
        part.faces[static_cast<std::size_t>(random.below(static_cast<int>(part.faces.size())))]
            .normal;
    const Mat3 tilted =
        Eigen::AngleAxisd(random.uniform(-0.5, 0.5), random.direction()).toRotationMatrix() *
        shortest_rotation(down, -Vec3::UnitZ()).toRotationMatrix();
    const Mat3 turn = member % 4 == 0 ? random.rotation() : tilted;
    // Moved along the normal of the nearest part until they overlap by so much.
    const double depth = random.uniform(0, member % 2 == 0 ? 5e-6 : 50e-6);
    Pose b_in_a;
    for (int pass = 0; pass < 4; ++pass) {
      b_in_a = {turn.transpose(), -(turn.transpose() * center)};
      Manifold nearest;
      nearest.gap = std::numeric_limits<double>::infinity();
      for (const ConvexPart& b : floor.parts) {
        GjkCache cold;
        Manifold m;
        collide(part, b, b_in_a, 1, cold, m);
        if (m.gap < nearest.gap) nearest = m;
      }
      if (pass < 3) center += (nearest.gap + depth) * (turn * nearest.normal);
    }
    contacts += expect_sound_contacts(part, current, b_in_a, member);
  }
  EXPECT_GT(contacts, 5000u);
}

// A flat prism on the rim of a hole: its lowest corner hardly misses the floor, and its face leans
// over the hole to what is beyond.
TEST(FlatSurface, ACornerAtTheRimOfAHoleBears) {
  Random random(15);
  constexpr int kMembers = 20000, kOfOneFloor = 500;
  std::size_t contacts = 0;
  FloorWithSurfaces current(random);
  for (int member = 0; member < kMembers; ++member) {
    if (member % kOfOneFloor == 0) current = FloorWithSurfaces(random);
    const CellFloor& floor = current.floor;
    const int i = random.below(CellFloor::kCells - 1), k = random.below(CellFloor::kCells);
    const bool left = floor.is_solid(i, k), right = floor.is_solid(i + 1, k);
    if (left == right) continue;
    std::vector<HalfSpace> planes{{Vec3::UnitZ(), 3e-3, false}, {-Vec3::UnitZ(), 3e-3, false}};
    const int sides = 5 + random.below(20);
    const double radius = random.uniform(10e-3, 50e-3);
    for (int side = 0; side < sides; ++side) {
      const double angle = 2 * M_PI * (side + random.uniform(-0.2, 0.2)) / sides;
      planes.push_back({Vec3(std::cos(angle), std::sin(angle), 0), radius, false});
    }
    const ConvexPart part = convex_part(planes, random.uniform(0.2e-3, 1e-3));
    const double tilt = random.uniform(0.01, 0.42), yaw = random.uniform(0, 2 * M_PI);
    const Mat3 turn = (Eigen::AngleAxisd(random.uniform(0, 2 * M_PI), Vec3::UnitZ()) *
                       Eigen::AngleAxisd(tilt, Vec3(std::cos(yaw), std::sin(yaw), 0)))
                          .toRotationMatrix();
    Vec3 corner = turn * part.vertex(0);
    for (int v = 1; v < part.vertex_count; ++v) {
      const Vec3 other = turn * part.vertex(v);
      if (other.z() < corner.z()) corner = other;
    }
    // m: the corner's distance from the rim, and its height over it.
    const double aside = std::pow(10, random.uniform(-9, -5)), depth = random.uniform(0, 5e-6);
    const double height = std::sqrt(std::pow(part.radius - depth, 2) - aside * aside);
    const Vec3 place(floor.x[i + 1] + (left ? aside : -aside),
                     random.uniform(floor.y[k], floor.y[k + 1]), height);
    const Vec3 center = place - corner;
    contacts += expect_sound_contacts(part, current,
                                      {turn.transpose(), -(turn.transpose() * center)}, member);
  }
  EXPECT_GT(contacts, 4000u);
}

}  // namespace
}  // namespace firn
