// Cost of one narrow-phase query. Parts of about 20 mm with a sweep radius of 1.5 mm; the poses of
// a batch differ, so that branches are not learnt by heart, and drift as bodies do between steps.
#include <benchmark/benchmark.h>

#include <cmath>

#include "solver/collision/gjk.h"
#include "tests/solver/collision/brute_force_distance.h"

namespace firn {
namespace {

using testing::Random;

constexpr double kRadius = 1.5e-3;  // m
constexpr double kShell = 20e-6;    // m
constexpr int kPairs = 256;

ConvexPart hexahedron() { return testing::box(Vec3(5e-3, 10e-3, 7e-3), kRadius); }

// A prism over a dodecagon: 24 vertices, 14 faces.
ConvexPart prism() {
  std::vector<Vec3> points;
  for (int k = 0; k < 12; ++k) {
    const double angle = 2 * M_PI * k / 12;
    for (const double z : {-7e-3, 7e-3}) {
      points.emplace_back(10e-3 * std::cos(angle), 8e-3 * std::sin(angle), z);
    }
  }
  return convex_part(convex_hull(points), kRadius);
}

ConvexPart part(int vertices) { return vertices == 8 ? hexahedron() : prism(); }

// Random orientations at a wanted gap of the swept parts.
std::vector<Pose> poses_at(const ConvexPart& a, const ConvexPart& b, double gap) {
  Random random(7);
  std::vector<Pose> poses(kPairs);
  for (Pose& pose : poses) {
    const Vec3 away = random.direction();
    pose.rotation = random.rotation();
    pose.translation = 60e-3 * away;
    GjkCache cache;
    for (int i = 0; i < 50; ++i) {
      const double distance = core_distance(a, b, pose, cache);
      pose.translation -= (distance - gap - a.radius - b.radius) * away;
    }
  }
  return poses;
}

// B's bottom face flat on A's top face, turned and shifted.
std::vector<Pose> poses_flat(double height, double overlap) {
  Random random(8);
  std::vector<Pose> poses(kPairs);
  for (Pose& pose : poses) {
    pose.rotation =
        Eigen::AngleAxisd(random.uniform(0, 2 * M_PI), Vec3::UnitZ()).toRotationMatrix();
    pose.translation = {random.uniform(-4e-3, 4e-3), random.uniform(-4e-3, 4e-3), height - overlap};
  }
  return poses;
}

void query(benchmark::State& state, const ConvexPart& a, const ConvexPart& b,
           std::vector<Pose> poses, bool warm) {
  std::vector<GjkCache> caches(poses.size());
  Manifold manifold;
  std::size_t k = 0, points = 0;
  double drift = 1e-6;
  for (auto _ : state) {
    if (!warm) caches[k].count = 0;
    collide(a, b, poses[k], kShell, caches[k], manifold);
    points += manifold.points.size();
    poses[k].translation.x() += drift;
    if (++k == poses.size()) {
      k = 0;
      drift = -drift;
    }
  }
  state.counters["points"] = static_cast<double>(points) / static_cast<double>(state.iterations());
}

void gap(benchmark::State& state, bool warm) {
  const ConvexPart a = part(static_cast<int>(state.range(0))), b = a;
  query(state, a, b, poses_at(a, b, 1e-6 * static_cast<double>(state.range(1))), warm);
}
void BM_GapWarm(benchmark::State& state) { gap(state, true); }
void BM_GapCold(benchmark::State& state) { gap(state, false); }
BENCHMARK(BM_GapWarm)->ArgNames({"vertices", "gap_um"})->ArgsProduct({{8, 24}, {30, 200, 2000}});
BENCHMARK(BM_GapCold)->ArgNames({"vertices", "gap_um"})->ArgsProduct({{8, 24}, {30, 200, 2000}});

void BM_Touching(benchmark::State& state) {
  const ConvexPart a = part(static_cast<int>(state.range(0))), b = a;
  query(state, a, b, poses_at(a, b, -5e-6), true);
}
BENCHMARK(BM_Touching)->ArgName("vertices")->Arg(8)->Arg(24);

void BM_FaceManifold(benchmark::State& state) {
  const ConvexPart a = part(static_cast<int>(state.range(0))), b = a;
  query(state, a, b, poses_flat(14e-3, 5e-6), true);
}
BENCHMARK(BM_FaceManifold)->ArgName("vertices")->Arg(8)->Arg(24);

// Cores overlap: libccd.
void BM_DeepFace(benchmark::State& state) {
  const ConvexPart a = part(static_cast<int>(state.range(0))), b = a;
  query(state, a, b, poses_flat(14e-3, 3.2e-3), true);
}
BENCHMARK(BM_DeepFace)->ArgName("vertices")->Arg(8)->Arg(24);

void BM_Plane(benchmark::State& state) {
  const ConvexPart a = part(static_cast<int>(state.range(0)));
  Manifold manifold;
  double offset = -7e-3 + 5e-6;
  for (auto _ : state) {
    collide_plane(a, Vec3::UnitZ(), offset, kShell, manifold);
    benchmark::DoNotOptimize(manifold.gap);
  }
  state.counters["points"] = static_cast<double>(manifold.points.size());
}
BENCHMARK(BM_Plane)->ArgName("vertices")->Arg(8)->Arg(24);

}  // namespace
}  // namespace firn
