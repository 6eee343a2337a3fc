// Cost of the energy of one contact region (solver/region_energy.h) and of the points of one patch
// (solver/contact.h, one patch at a time). The regions of a batch differ.
#include <benchmark/benchmark.h>

#include <array>
#include <random>
#include <vector>

#include "solver/contact.h"
#include "solver/region_energy.h"

namespace firn {
namespace {

constexpr int kRegions = 1024;
constexpr double kStiffness = 6.1e5;  // N/m

struct Batch {
  std::vector<RegionFacet> facets;
  std::vector<RegionEdge> edges;
  std::vector<FlatRegion> flat;
  std::vector<RegionMotion> motion;
  int facets_each = 1, edges_each = 4;
};

// `facets` facets about a common corner (3), along a common edge (2) or one; 20 um deep, 10 mm
// wide.
Batch batch(int facets, double tilt) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> random(0.8, 1.2);
  Batch out;
  out.facets_each = facets;
  out.edges_each = facets == 3 ? 9 : 4 * facets;
  for (int i = 0; i < kRegions; ++i) {
    const double a = 0.01 * random(engine), b = 0.01 * random(engine);
    const double depth = 2e-5 * random(engine);
    const auto add = [&](const std::vector<std::array<double, 2>>& p, double sx, double sy) {
      out.facets.push_back({depth, sx, sy, static_cast<int>(p.size())});
      for (std::size_t k = 0; k < p.size(); ++k) {
        const auto &from = p[k], &to = p[(k + 1) % p.size()];
        out.edges.push_back({from[0], from[1], to[0], to[1]});
      }
    };
    const double s = tilt * random(engine);
    if (facets == 1) add({{0, 0}, {a, 0}, {a, b}, {0, b}}, -s, 0.3 * s);
    if (facets == 2) {
      add({{0, 0}, {a, 0}, {a, b}, {0, b}}, -s, 0);
      add({{-a, 0}, {0, 0}, {0, b}, {-a, b}}, s, 0);
    }
    if (facets == 3) {
      add({{0, 0}, {a, 0}, {-0.5 * a, 0.8 * a}}, -s, -s);
      add({{0, 0}, {-0.5 * a, 0.8 * a}, {-0.5 * a, -0.8 * a}}, 1.5 * s, 0);
      add({{0, 0}, {-0.5 * a, -0.8 * a}, {a, 0}}, -s, s);
    }
    out.flat.push_back(flat_region({out.edges.data() + out.edges.size() - 4, 4}));
    out.motion.push_back({1e-6 * random(engine), 1e-5 * random(engine), 0});
  }
  return out;
}

void general(benchmark::State& state) {
  const Batch b =
      batch(static_cast<int>(state.range(0)), 1e-6 * static_cast<double>(state.range(1)));
  const auto facets = static_cast<std::size_t>(b.facets_each);
  const auto edges = static_cast<std::size_t>(b.edges_each);
  for (auto _ : state) {
    for (std::size_t i = 0; i < kRegions; ++i) {
      benchmark::DoNotOptimize(region_energy(kStiffness, {b.facets.data() + i * facets, facets},
                                             {b.edges.data() + i * edges, edges}, b.motion[i]));
    }
  }
  state.counters["each"] = benchmark::Counter(
      kRegions, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
// Facets, slope in 1e-6: flat, a tilted face, an edge, a corner.
BENCHMARK(general)->Args({1, 100})->Args({1, 10000})->Args({2, 500000})->Args({3, 500000});

void flat(benchmark::State& state) {
  const Batch b = batch(1, 1e-4);
  for (auto _ : state) {
    for (std::size_t i = 0; i < kRegions; ++i) {
      RegionFacet f = b.facets[i];
      f.depth += b.motion[i].depth;
      f.slope_x += b.motion[i].slope_x;
      f.slope_y += b.motion[i].slope_y;
      if (is_below({b.edges.data() + 4 * i, 4}, f))
        benchmark::DoNotOptimize(flat_region_energy(kStiffness, b.flat[i], f));
    }
  }
  state.counters["each"] = benchmark::Counter(
      kRegions, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(flat);

void points(benchmark::State& state) {
  const auto count = static_cast<std::uint16_t>(state.range(0));
  PairLaw law;
  law.stiffness = kStiffness;
  law.unloading_ratio = 4;
  std::vector<ContactPoint> all(kRegions * count);
  std::vector<Patch> patches(kRegions);
  for (std::size_t i = 0; i < kRegions; ++i) {
    patches[i].point_count = count;
    for (std::size_t k = 0; k < count; ++k) {
      all[i * count + k].gap = -2e-5;
      all[i * count + k].share = 1.0 / count;
      all[i * count + k].offset = Vec3(0.01 * static_cast<double>(k), 0, 0);
    }
  }
  double sign = 1;
  for (auto _ : state) {
    sign = -sign;
    for (std::size_t i = 0; i < kRegions; ++i) {
      const Approach way =
          approach(plain(patches[i].normal), {0, 0, sign * 1e-3}, {0, 1e-3 * sign, 0}, 1e-5);
      benchmark::DoNotOptimize(advance_points(law, patches[i], all.data() + i * count, way));
    }
  }
  state.counters["each"] = benchmark::Counter(
      kRegions, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(points)->Arg(2)->Arg(4);

}  // namespace
}  // namespace firn
