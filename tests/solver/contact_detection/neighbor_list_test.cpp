// The neighbor list against lists that try everything, for scenes and boxes thrown at random.
#include "solver/contact_detection/neighbor_list.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>

#include "solver/contact_detection/bounding_spheres.h"
#include "solver/state/workspace.h"
#include "solver/step/initial_state.h"
#include "tests/support/dice.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

// Sizes of many magnitudes, some boxes alike, some without extent, some touching, some beyond the
// farthest cell.
std::vector<Aabb> random_boxes(Dice& dice, int count, double room, double size) {
  std::vector<Aabb> boxes;
  for (int i = 0; i < count; ++i) {
    const Vec3 center = dice.vector(room), half = dice.vector(0.5 * size).cwiseAbs();
    boxes.push_back({center - half, center + half});
    if (i % 7 == 1) boxes.back() = boxes[static_cast<std::size_t>(i) / 2];
    if (i % 7 == 2) boxes.back().upper = boxes.back().lower;
    if (i % 7 == 3) {
      const Aabb& other = boxes[static_cast<std::size_t>(i) / 3];
      boxes.back() = {other.upper, other.upper + half};
    }
    if (i % 50 == 4) {
      boxes.back().lower *= 1e8;
      boxes.back().upper = boxes.back().lower + half;
    }
  }
  return boxes;
}

TEST(Neighbors, BoxesMeetThoseThatTheyMeetWhenEachIsTried) {
  Dice dice(7);
  for (const double size : {1e-3, 0.1, 1.0, 30.0}) {
    const std::vector<Aabb> boxes = random_boxes(dice, 900, 1, size);
    for (const int threads : {1, 3}) {
      const AabbOverlaps near = find_aabb_overlaps(boxes, threads);
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        std::vector<std::int32_t> expected;
        for (std::size_t j = i + 1; j < boxes.size(); ++j)
          if (boxes[i].overlaps(boxes[j])) expected.push_back(static_cast<std::int32_t>(j));
        const std::span<const std::int32_t> found = near.of(i);
        ASSERT_EQ(std::vector(found.begin(), found.end()), expected) << i << " of size " << size;
      }
    }
  }
  EXPECT_NO_THROW(find_aabb_overlaps({}, 2));
  EXPECT_TRUE(find_aabb_overlaps({Aabb{}}, 2).of(0).empty());
}

// Up to nine spheres: none, one, and three groups, the last of them not full.
TEST(Neighbors, PartsAreNearAsWhenEachPairIsTried) {
  Dice dice(7);
  constexpr std::uint32_t kSize = SphereGroup::size;
  int near = 0, far = 0;
  for (int n = 0; n < 4000; ++n) {
    struct Body {
      Vec3 center;
      double reach = 0;
      std::vector<Vec3> centers;
      std::vector<double> radii;
      std::vector<SphereGroup> groups;
    };
    const auto body = [&](const Vec3& place) {
      Body b;
      b.center = place;
      const auto parts = static_cast<std::size_t>(dice(1, 9.999));
      b.groups.resize((parts + kSize - 1) / kSize);
      for (std::size_t p = 0; p < kSize * b.groups.size(); ++p) {
        const Vec3 from = dice.vector(0.7);
        const double radius = p < parts ? dice(0, 0.5) : 0;
        const Vec3 c = p < parts ? Vec3(place + from)
                                 : Vec3::Constant(std::numeric_limits<double>::infinity());
        SphereGroup& g = b.groups[p / kSize];
        (&g.x.x)[p % kSize] = c.x();
        (&g.y.x)[p % kSize] = c.y();
        (&g.z.x)[p % kSize] = c.z();
        (&g.radius.x)[p % kSize] = radius;
        if (p >= parts) continue;
        b.reach = std::max(b.reach, from.norm() + radius);
        b.centers.push_back(c);
        b.radii.push_back(radius);
      }
      return b;
    };
    const Body a = body(dice.vector(1)), b = body(a.center + dice.vector(2));
    const double margins = dice(0, 0.1);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> expected, listed;
    for (std::uint32_t k = 0; k < a.centers.size(); ++k) {
      for (std::uint32_t l = 0; l < b.centers.size(); ++l) {
        const double reach = a.radii[k] + b.radii[l] + margins;
        if ((a.centers[k] - b.centers[l]).squaredNorm() < reach * reach) expected.push_back({k, l});
      }
    }
    std::vector<PartNumbers> found(a.centers.size() * b.centers.size() + kSize);
    const int count =
        find_close_parts(a.groups, b.groups, b.center, b.reach, margins, found.data());
    for (int k = 0; k < count; ++k) listed.push_back({found[k].a, found[k].b});
    ASSERT_EQ(listed, expected);
    ++(expected.empty() ? far : near);
  }
  EXPECT_GT(near, 500);
  EXPECT_GT(far, 500);
}

// Bodies of two shapes in numbers that say nothing of their places, some not there, some fast;
// turned boundaries of many parts near and far, one taken away, and a tilted plane.
struct Scene {
  Model model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.1, 0.3));
  State state;

  explicit Scene(int threads) {
    constexpr int kBodies = 300, kSolids = 25;
    Dice dice(7);
    model.numerics.threads = threads;
    model.timestep = 1e-5;
    scenes::add_shape(model, scenes::crescent({}));
    scenes::add_shape(model, make_box({0.02, 0.03, 0.01}, scenes::ice_options(0.02, 1e5, 1e-3)));
    for (int i = 0; i < kBodies; ++i) scenes::add_particles(model, i % 3 == 0 ? 1 : 0);
    scenes::add_plane(model, {0, 0, -0.05}, Vec3(0.3, 0.2, 1).normalized());
    for (int b = 0; b < kSolids; ++b) {
      Boundary solid;
      solid.name = "solid";
      solid.material = scenes::kPlastic;
      solid.kind = Boundary::Kind::solid;
      solid.parts = model.shapes[0].parts;
      solid.origin = dice.vector(b % 5 == 0 ? 1 : 0.12);
      solid.orientation = dice.turn();
      model.boundaries.push_back(solid);
    }
    validate(model);
    const std::size_t n = kBodies, bodies = n + model.boundaries.size();
    State& s = state;
    s.motion.resize(bodies);
    s.orientation.resize(bodies, Quat::Identity());
    s.translation_bound.resize(bodies, 0);
    s.rotation_bound.resize(bodies, 0);
    s.skin.resize(bodies, 0);
    s.rebuild_distance.resize(bodies, 0);
    s.presence.resize(n, Presence::present);
    s.boundary_present.resize(model.boundaries.size(), 1);
    s.boundary_present[3] = 0;
    for (std::size_t i = 0; i < n; ++i) {
      if (i % 11 == 5) s.presence[i] = Presence::removed;
      s.motion[i].position = dice.vector(0.1);
      s.motion[i].velocity = dice.vector(i % 17 == 0 ? 5 : 0.1);
      s.orientation[i] = dice.turn();
    }
    place_boundaries(model, s);
  }
};

using Parts = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
using List = std::map<std::pair<int, int>, Parts>;

List list_of(const State& s) {
  List out;
  for (const Pair& pair : s.pairs) {
    Parts& parts = out[{pair.a, pair.b}];
    EXPECT_TRUE(parts.empty()) << "listed twice";
    for (std::uint32_t k = 0; k < pair.part_count; ++k) {
      const PartPair& p = s.part_pairs[pair.first_part + k];
      parts.push_back({p.a, p.b});
    }
  }
  return out;
}

// Part k of the body as a sphere.
struct Sphere {
  Vec3 center;
  double radius;
};
Sphere sphere_of(const Model& model, const State& s, int body, std::size_t k) {
  const ConvexPart& part = model.shapes[model.particles[body].shape].parts[k];
  return {s.motion[body].position + rotation_of(s, body) * part.center, part.bounding_radius};
}

List everything_tried(const Model& model, const State& s) {
  List out;
  const int n = static_cast<int>(model.particles.size());
  const auto parts_of = [&](int i) { return model.shapes[model.particles[i].shape].parts.size(); };
  for (int a = 0; a < n; ++a) {
    if (s.presence[a] != Presence::present) continue;
    for (std::size_t k = 0; k < parts_of(a); ++k) {
      const Sphere mine = sphere_of(model, s, a, k);
      for (int b = a + 1; b < n; ++b) {
        if (s.presence[b] != Presence::present) continue;
        for (std::size_t l = 0; l < parts_of(b); ++l) {
          const Sphere other = sphere_of(model, s, b, l);
          const double reach = mine.radius + other.radius + (s.skin[a] + s.skin[b]);
          if ((mine.center - other.center).squaredNorm() < reach * reach)
            out[{a, b}].push_back({k, l});
        }
      }
      for (std::size_t b = 0; b < model.boundaries.size(); ++b) {
        if (!s.boundary_present[b]) continue;
        const int body = n + static_cast<int>(b);
        const Vec3 c = rotation_of(s, body).transpose() * (mine.center - s.motion[body].position);
        const double reach = mine.radius + s.skin[a] + s.skin[body];
        const std::vector<ConvexPart>& parts = model.boundaries[b].parts;
        if (parts.empty() && c.z() < reach) out[{a, body}].push_back({k, 0});
        for (std::size_t l = 0; l < parts.size(); ++l) {
          Aabb box{Vec3::Constant(1), Vec3::Constant(-1)};
          for (int v = 0; v < parts[l].vertex_count; ++v) {
            const Vec3 p = parts[l].vertex(v), r = Vec3::Constant(parts[l].radius);
            box.lower = v == 0 ? Vec3(p - r) : Vec3(box.lower.cwiseMin(p - r));
            box.upper = v == 0 ? Vec3(p + r) : Vec3(box.upper.cwiseMax(p + r));
          }
          if (box.overlaps({c - Vec3::Constant(reach), c + Vec3::Constant(reach)}))
            out[{a, body}].push_back({k, l});
        }
      }
    }
  }
  return out;
}

TEST(Neighbors, ListHoldsWhatIsNearWhenEverythingIsTried) {
  for (const int threads : {1, 3}) {
    Scene scene(threads);
    Workspace w(scene.model);
    update_neighbor_list(scene.model, w, scene.state);
    const List list = list_of(scene.state), expected = everything_tried(scene.model, scene.state);
    ASSERT_GT(expected.size(), 1000u);
    int at_boundaries = 0;
    for (const auto& [bodies, parts] : expected)
      at_boundaries += bodies.second >= static_cast<int>(scene.model.particles.size());
    EXPECT_GT(at_boundaries, 200);
    EXPECT_EQ(list, expected);
  }
}

// Boundaries are sorted out for many bodies at once, and most closely for one alone.
TEST(Neighbors, ListOfALonelyBodyHoldsWhatIsNearIt) {
  Dice dice(7);
  int near = 0, far = 0;
  for (int n = 0; n < 300; ++n) {
    Scene scene(1);
    State& s = scene.state;
    std::ranges::fill(s.presence, Presence::removed);
    const std::size_t body = n % 2, solid = scene.model.particles.size() + 1 + (n % 25);
    s.presence[body] = Presence::present;
    const double reach = 1.6 * scene.model.shapes[0].bounding_radius;
    s.motion[body].position = s.motion[solid].position + dice.vector(reach);
    Workspace w(scene.model);
    update_neighbor_list(scene.model, w, s);
    const List expected = everything_tried(scene.model, s);
    ASSERT_EQ(list_of(s), expected);
    ++(expected.contains({static_cast<int>(body), static_cast<int>(solid)}) ? near : far);
  }
  EXPECT_GT(near, 50);
  EXPECT_GT(far, 50);
}

// What the list knows of a pair goes where the pair goes, when bodies have moved and left.
TEST(Neighbors, NewListTakesOverWhatTheOldOneKnew) {
  for (const int threads : {1, 3}) {
    Scene scene(threads);
    State& s = scene.state;
    Workspace w(scene.model);
    update_neighbor_list(scene.model, w, s);
    // Marks that identify their pairs. Every third pair has patches, of one to three points.
    const auto mark = [](const Pair& p) { return 1000.0 * p.a + p.b; };
    for (std::size_t k = 0; k < s.pairs.size(); ++k) {
      Pair& pair = s.pairs[k];
      s.next_test_distance[k] = mark(pair);
      s.motion_bound[k].moved = 0.5 * mark(pair);
      s.motion_bound[k].test_distance = mark(pair);
      for (std::uint32_t p = pair.first_part; p < pair.first_part + pair.part_count; ++p)
        s.part_pairs[p].next_test_distance =
            mark(pair) + s.part_pairs[p].a + 0.01 * s.part_pairs[p].b;
      if (k % 3 != 0) continue;
      pair.first_patch = static_cast<std::uint32_t>(s.patches.size());
      pair.first_point = static_cast<std::uint32_t>(s.points.size());
      for (std::uint32_t patch = 0; patch <= k % 2; ++patch) {
        ContactPatch& one = s.patches.emplace_back();
        one.normal_force = mark(pair) + patch;
        one.first_point = static_cast<std::uint32_t>(s.points.size());
        one.point_count = static_cast<std::uint32_t>(1 + (k + patch) % 3);
        for (std::uint32_t point = 0; point < one.point_count; ++point)
          s.points.emplace_back().force = mark(pair) + 0.1 * patch + 0.01 * point;
        s.patch_details.push_back({Vec3::Constant(one.normal_force), 0});
        ++pair.patch_count;
      }
      s.points.resize(s.points.size() + k % 4);  // holes
    }
    const List before = list_of(s);
    Dice dice(7);
    for (std::size_t i = 0; i < scene.model.particles.size(); ++i)
      s.motion[i].position += dice.vector(2e-3);
    s.presence[20] = Presence::removed;
    s.neighbor_list_invalid = true;
    update_neighbor_list(scene.model, w, s);
    const List list = list_of(s);
    EXPECT_EQ(list, everything_tried(scene.model, s));
    int kept = 0, added = 0, patches = 0;
    for (std::size_t k = 0; k < s.pairs.size(); ++k) {
      const Pair& pair = s.pairs[k];
      SCOPED_TRACE(testing::Message() << "bodies " << pair.a << " and " << pair.b);
      const auto old = before.find({pair.a, pair.b});
      if (old == before.end()) {
        ++added;
        EXPECT_EQ(s.next_test_distance[k],
                  s.translation_bound[pair.a] + s.translation_bound[pair.b]);
        EXPECT_EQ(pair.patch_count, 0u);
        continue;
      }
      ++kept;
      bool is_new = false;
      for (std::uint32_t p = pair.first_part; p < pair.first_part + pair.part_count; ++p) {
        const PartPair& part = s.part_pairs[p];
        const bool known = std::ranges::count(old->second, std::pair<std::uint32_t, std::uint32_t>(
                                                               part.a, part.b)) > 0;
        is_new |= !known;
        EXPECT_EQ(part.next_test_distance,
                  known ? mark(pair) + part.a + 0.01 * part.b : 0.5 * mark(pair));
      }
      EXPECT_EQ(s.motion_bound[k].test_distance, is_new ? 0.5 * mark(pair) : mark(pair));
      EXPECT_EQ(s.next_test_distance[k],
                is_new ? s.translation_bound[pair.a] + s.translation_bound[pair.b] : mark(pair));
      for (std::uint32_t patch = 0; patch < pair.patch_count; ++patch) {
        const ContactPatch& one = s.patches[pair.first_patch + patch];
        ++patches;
        EXPECT_EQ(one.normal_force, mark(pair) + patch);
        EXPECT_EQ(s.patch_details[pair.first_patch + patch].rolling,
                  Vec3::Constant(one.normal_force));
        for (std::uint32_t point = 0; point < one.point_count; ++point)
          EXPECT_EQ(s.points[one.first_point + point].force,
                    mark(pair) + 0.1 * patch + 0.01 * point);
      }
    }
    EXPECT_GT(kept, 1000);
    EXPECT_GT(added, 20);
    EXPECT_GT(patches, 400);
    EXPECT_EQ(static_cast<std::size_t>(patches), s.patches.size());  // no holes
  }
}

TEST(Neighbors, KeysAreSortedAlikeByAnyNumberOfThreads) {
  Dice dice(7);
  std::vector<KeyIndex> one;
  for (std::int32_t k = 0; k < 30000; ++k)
    one.push_back({static_cast<std::uint64_t>(dice(0, 5000)), k});
  std::ranges::reverse(one);  // numbers of like keys descend
  std::vector<KeyIndex> many = one;
  sort_by_key(1, one);
  sort_by_key(4, many);
  EXPECT_TRUE(std::is_sorted(one.begin(), one.end()));
  EXPECT_EQ(one, many);
}

}  // namespace
}  // namespace firn
