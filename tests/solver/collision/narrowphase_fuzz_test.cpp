// Random pairs of every degenerate kind against a brute-force referee and libccd. What is promised
// of each: narrowphase_properties.h.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>

#include "tests/solver/collision/narrowphase_properties.h"

namespace firn {
namespace {

using testing::Random;

struct Scene {
  ConvexPart a, b;
  Pose pose;
};

// Hull of points on a coarse lattice: many coplanar, many edges parallel to those of its like.
ConvexPart lattice_hull(Random& random) {
  for (;;) {
    std::vector<Vec3> points;
    for (int i = 4 + random.below(16); i > 0; --i) {
      points.emplace_back(random.below(5) - 2, random.below(5) - 2, random.below(5) - 2);
    }
    try {
      return convex_part(convex_hull(points), 0);
    } catch (const InputError&) {
      // Flat: another one.
    }
  }
}

ConvexPart round_hull(Random& random, const Vec3& axes) {
  std::vector<Vec3> points;
  for (int i = 5 + random.below(20); i > 0; --i) {
    points.emplace_back(axes.cwiseProduct(random.uniform(0.5, 1) * random.direction()));
  }
  return convex_part(convex_hull(points), 0);
}

// Boxes, hulls, plates, needles and points, about one in size.
ConvexPart any_part(Random& random) {
  switch (random.below(8)) {
    case 0:
    case 1:
      return testing::box({random.uniform(0.1, 1), random.uniform(0.1, 1), random.uniform(0.1, 1)},
                          0);
    case 2:
      return testing::box({1, 1, 0.005}, 0);
    case 3:
      return testing::box({1, 0.01, 0.01}, 0);
    case 4:
      return round_hull(random, random.below(2) ? Vec3(1, 1, 0.01) : Vec3(1, 0.02, 0.02));
    case 5:
      return sphere_part(random.uniform(0, 0.2) * random.direction(), 0);
    default:
      return round_hull(random, Vec3::Ones());
  }
}

Mat3 axes_onto_axes(Random& random) {
  Mat3 rotation = Mat3::Identity();
  for (int i = 0; i < 3; ++i) {
    const Mat3 quarter =
        Eigen::AngleAxisd(M_PI / 2 * random.below(4), Vec3::Unit(i)).toRotationMatrix();
    rotation = quarter.array().round().matrix() * rotation;
  }
  return rotation;
}

double reach_of(const Scene& s) { return s.a.bounding_radius + s.b.bounding_radius; }

Vec3 on_a_feature(const ConvexPart& part, Random& random) {
  const Vec3 first = part.vertex(random.below(part.vertex_count));
  if (part.edges.empty()) return first;
  const auto& edge = part.edges[random.below(static_cast<int>(part.edges.size()))];
  const auto& face = part.faces[random.below(static_cast<int>(part.faces.size()))];
  Vec3 middle = Vec3::Zero();
  for (int i = 0; i < face.count; ++i) {
    middle += part.vertex(part.face_vertices[face.first + i]) / face.count;
  }
  const Vec3 choice[] = {first, 0.5 * (part.vertex(edge[0]) + part.vertex(edge[1])), middle};
  return choice[random.below(3)];
}

// Moves b along n until it is `gap` away.
void set_separation(Scene& s, const Vec3& n, double gap) {
  s.pose.translation +=
      (gap - testing::separation(testing::place(s.a, Pose{}), testing::place(s.b, s.pose), n)) * n;
}

Vec3 some_normal(const ConvexPart& part, Random& random) {
  if (part.faces.empty() || random.below(3) == 0) return random.direction();
  return part.faces[random.below(static_cast<int>(part.faces.size()))].normal;
}

double signed_power(Random& random, double least, double most) {
  return (random.below(2) ? 1 : -1) * std::pow(10, -random.uniform(least, most));
}

// The kinds of scenes, each made from the parts given.
struct Kind {
  const char* name;
  void (*arrange)(Scene&, Random&);
  // Edge against edge deep inside is libccd's: now and then its polytope leads to a neighboring
  // way out. This part of the deep overlaps at most.
  double longer = 0.02;
};
constexpr Kind kKinds[] = {
    {"anywhere",
     [](Scene& s, Random& random) {
       s.pose.rotation = random.rotation();
       s.pose.translation = random.direction() * random.uniform(0, 1) * reach_of(s);
     }},
    {"parallel axes",
     [](Scene& s, Random& random) {
       s.pose.translation = random.direction() * random.uniform(0, 1) * reach_of(s);
     }},
    {"almost parallel, almost touching",
     [](Scene& s, Random& random) {
       s.pose.rotation = Eigen::AngleAxisd(signed_power(random, 1, 14), random.direction());
       s.pose.translation = random.direction() * random.uniform(0, 0.5) * reach_of(s);
       set_separation(s, some_normal(s.a, random), signed_power(random, 1, 13));
     }},
    {"any turn, almost touching",
     [](Scene& s, Random& random) {
       s.pose.rotation = random.rotation();
       set_separation(s, some_normal(s.a, random), signed_power(random, 1, 13));
     }},
    {"grazing, 0 ± 1e-12 of the size",
     [](Scene& s, Random& random) {
       s.pose.rotation = random.below(2) ? axes_onto_axes(random) : random.rotation();
       s.pose.translation = random.direction() * random.uniform(0, 0.5) * reach_of(s);
       set_separation(s, some_normal(s.a, random), random.uniform(-1e-12, 1e-12));
     }},
    {"feature upon feature",
     [](Scene& s, Random& random) {
       s.pose.rotation = random.below(2) ? axes_onto_axes(random) : random.rotation();
       s.pose.translation = on_a_feature(s.a, random) - s.pose.rotation * on_a_feature(s.b, random);
     }},
    {"lattice hulls on the lattice",
     [](Scene& s, Random& random) {
       s.a = lattice_hull(random);
       s.b = lattice_hull(random);
       s.pose.rotation = axes_onto_axes(random);
       s.pose.translation = Vec3(random.below(9) - 4, random.below(9) - 4, random.below(9) - 4);
       if (random.below(3) == 0) s.pose.translation *= 0.5;
     }},
    {"identical, same or mirrored place",
     [](Scene& s, Random& random) {
       s.b = s.a;
       if (random.below(2)) s.pose.rotation = axes_onto_axes(random);
       if (random.below(2)) {
         s.pose.translation = random.direction() * std::pow(10, -random.uniform(0, 15));
       }
     },
     // Their difference has pairs of facets that are parallel but for rounding, and a polytope that
     // takes one of a pair for done sees nothing behind the other.
     0.05},
    {"very unequal sizes",
     [](Scene& s, Random& random) {
       s.b = testing::scaled(s.b, std::pow(10, -random.uniform(1, 3)));
       s.pose.rotation = random.rotation();
       s.pose.translation = on_a_feature(s.a, random) +
                            random.uniform(0, 2) * s.b.bounding_radius * random.direction();
     }},
    {"one inside the other",
     [](Scene& s, Random& random) {
       s.pose.rotation = random.rotation();
       s.pose.translation = random.direction() * random.uniform(0, 0.1) * reach_of(s);
     }},
};

struct PairCounts {
  int pairs = 0, apart = 0, touching = 0, deep = 0, longer = 0, ccd_differs = 0;
  double distance_error = 0, normal_error = 0;  // largest, of the reach
  double shallow_excess = 0, deep_excess = 0;   // largest, of the smaller radius
};

void count(const testing::CollideVerdict& v, PairCounts& t) {
  ++t.pairs;
  t.ccd_differs += !v.ccd_agrees;
  const double error = std::abs(v.got - v.expected) / v.reach;
  t.normal_error = std::max(t.normal_error, v.normal_error / v.reach);
  if (!v.touching) {
    ++t.apart;
    t.distance_error = std::max(t.distance_error, error);
    return;
  }
  ++t.touching;
  const double excess = std::max(0.0, v.excess - 2 * v.near) / v.size;
  if (-v.expected < 0.2 * v.size) {
    t.shallow_excess = std::max(t.shallow_excess, excess);
  } else {
    ++t.deep;
    t.longer += excess > 1e-9;
    t.deep_excess = std::max(t.deep_excess, excess);
  }
}

void fuzz(int pairs, std::uint64_t seed) {
  constexpr int kKindCount = static_cast<int>(std::size(kKinds));
  Random random(seed);
  std::array<PairCounts, kKindCount> counts;
  int broken = 0;
  for (int k = 0; k < pairs && broken < 10; ++k) {
    const int kind = k % kKindCount;
    Scene s{any_part(random), any_part(random), {}};
    kKinds[kind].arrange(s, random);
    // Most are of the size of grains; some far smaller or larger than anything sensible.
    const double scale = random.below(4) ? 0.02 : std::pow(10, random.uniform(-6, 3));
    s.a = testing::scaled(s.a, scale);
    s.b = testing::scaled(s.b, scale);
    s.pose.translation *= scale;
    const testing::CollideVerdict v = testing::judge(s.a, s.b, s.pose);
    count(v, counts[kind]);
    broken += !v.sound();
    EXPECT_TRUE(v.sound()) << "pair " << k << ", " << kKinds[kind].name << ", scale " << scale
                           << ": " << v.sentence();
  }
  std::printf("%-34s %8s %8s %8s %9s %9s %9s %7s %7s %9s %7s\n", "kind", "pairs", "apart",
              "touching", "distance", "normal", "shallow", "deep", "longer", "excess", "libccd");
  for (int kind = 0; kind < kKindCount; ++kind) {
    const PairCounts& t = counts[kind];
    std::printf("%-34s %8d %8d %8d %9.1e %9.1e %9.1e %7d %7d %9.1e %7d\n", kKinds[kind].name,
                t.pairs, t.apart, t.touching, t.distance_error, t.normal_error, t.shallow_excess,
                t.deep, t.longer, t.deep_excess, t.ccd_differs);
    EXPECT_GT(t.touching, t.pairs / 20) << kKinds[kind].name;
    EXPECT_LE(t.longer, kKinds[kind].longer * t.deep + 1) << kKinds[kind].name;
    EXPECT_LE(t.ccd_differs, 1e-3 * t.pairs + 1) << kKinds[kind].name;
  }
}

TEST(CollideFuzz, AgreesWithEveryFeaturePairAndAxis) { fuzz(20000, 1); }

TEST(CollideFuzzLong, AgreesWithEveryFeaturePairAndAxis) { fuzz(2000000, 2); }

}  // namespace
}  // namespace firn
