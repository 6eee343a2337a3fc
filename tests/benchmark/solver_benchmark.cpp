// What a step of the drained repose experiment costs: 880 crescents settled in the box, and flowing
// out through the door; and the same states, and a stirred one, of 1, 12 and 114 such boxes side by
// side: 880, 10 560 and 100 320 crescents. One core unless FIRN_THREADS says otherwise.
//
// The settled bed is made once by filling (about 15 s) and kept next to the program, together with
// files for other programs: bed.csv (pose of every crescent), hull_bed.csv (pose of every convex
// hull of a crescent, settled by Firn too) and crescent.json (the shape).
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <malloc.h>

#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/benchmark/kept_beds.h"

namespace firn {
namespace {

constexpr int kCubes = beds::kCubes;

int threads() {
  const char* const wish = std::getenv("FIRN_THREADS");
  return wish ? std::atoi(wish) : 1;
}

scenes::ReposeBox box() {
  scenes::ReposeBox b = scenes::repose_box(kCubes);
  b.model.numerics.threads = threads();
  return b;
}

nlohmann::json triple(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

// The convex hull of the crescent, as heavy.
Shape convex_hull_of(double stiffness, double rounding) {
  const NamedCrescent named = named_crescent("mass-matched", {});
  std::vector<Vec3> corners;
  for (const ConvexPart& part :
       make_crescent(named.parameters, scenes::ice_options(0, 0, 1e-6)).parts) {
    for (int i = 0; i < part.vertex_count; ++i) corners.push_back(part.vertex(i));
  }
  return make_convex(corners, scenes::ice_options(named.mass, stiffness, rounding));
}

// Corners of the crescent's convex hull as drawn (edges not rounded), in the hull's body axes, and
// the parameters of the crescent.
void export_crescent(const std::filesystem::path& file, const scenes::ReposeBox& b) {
  const CrescentParameters p = named_crescent("mass-matched", {}).parameters;
  nlohmann::json out = {{"chord", p.chord},
                        {"width", p.width},
                        {"depth", p.depth},
                        {"tip", p.tip_height},
                        {"dish", p.top_concavity_depth},
                        {"draft", p.draft},
                        {"mass", b.model.shapes[0].mass},
                        {"box", triple(b.upper - b.lower)}};
  const Shape hull = convex_hull_of(0, 1e-6);
  for (int i = 0; i < hull.parts[0].vertex_count; ++i)
    out["hull"].push_back(triple(hull.parts[0].vertex(i)));
  std::ofstream(file) << out.dump(1) << '\n';
}

void export_bed(const std::filesystem::path& file, const ParticleState& p) {
  std::ofstream out(file);
  out << "x,y,z,w,qx,qy,qz\n";
  for (std::size_t i = 0; i < p.position.size(); ++i) {
    const Vec3& x = p.position[i];
    const Quat& q = p.orientation[i];
    out << fmt::format("{},{},{},{},{},{},{}\n", x.x(), x.y(), x.z(), q.w(), q.x(), q.y(), q.z());
  }
}

// Programs that know convex bodies only could not start from bed.csv: hulls of crescents that lie
// in each other's dishes overlap.
void export_hull_bed(const std::filesystem::path& file, scenes::ReposeBox b) {
  Shape& shape = b.model.shapes[0];
  shape = convex_hull_of(shape.stiffness, shape.rounding);
  Solver solver(b.model);
  scenes::scatter(solver, 0, kCubes, b.lower, b.upper, 1);
  scenes::run(solver, 1.2);
  export_bed(file, solver.particles());
}

// The settled bed, and files of it for other programs, unless it had them already.
Solver settled(const scenes::ReposeBox& b) {
  Solver solver = beds::settled(b);
  const std::filesystem::path folder = beds::program_folder(), last = folder / "hull_bed.csv";
  if (std::filesystem::exists(last) && std::filesystem::last_write_time(last) >=
                                           std::filesystem::last_write_time(beds::settled_file())) {
    return solver;
  }
  export_bed(folder / "bed.csv", solver.particles());
  export_crescent(folder / "crescent.json", b);
  export_hull_bed(last, b);
  return solver;
}

// A line of what the system knows of this process, MB: "VmHWM:", its largest memory so far, or
// "VmRSS:", its present one.
double memory(std::string_view line) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0;
    if (word == line && status >> kilobytes) return kilobytes / 1024;
  }
  return 0;
}
// Present memory without what has been given back to the heap, bytes.
double taken() {
  malloc_trim(0);
  return 1024 * 1024 * memory("VmRSS:");
}

// Time that this process has used, us: of the processor for one thread, which other work on the
// machine hardly changes; of the clock on the wall for more.
double time_used() {
  timespec t{};
  clock_gettime(threads() > 1 ? CLOCK_MONOTONIC : CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

void add_counters(benchmark::State& state, Solver& solver) {
  solver.complete_step();
  state.counters["patches"] = static_cast<double>(solver.diagnostics().patches);
  state.counters["points"] = static_cast<double>(solver.diagnostics().points);
  state.counters["kinetic_J"] = solver.energy().kinetic;
  state.counters["peak_MB"] = memory("VmHWM:");
}

// Times the steps of a bed, all of its cubes still there.
void time_steps(benchmark::State& state, Solver& solver) {
  const auto cubes = static_cast<double>(solver.model().particles.size());
  const double begin = time_used();
  for (auto _ : state) solver.step_deferred();
  state.counters["us/particle/step"] =
      (time_used() - begin) / cubes / static_cast<double>(state.iterations());
  add_counters(state, solver);
}

void SettledBox(benchmark::State& state) {
  Solver solver = settled(box());
  scenes::run(solver, 0.004);  // caches warm, lists made
  time_steps(state, solver);
}
BENCHMARK(SettledBox)->Unit(benchmark::kMicrosecond)->UseRealTime();

// The first half second after the door is gone: every particle is still there, most of them move.
void Discharging(benchmark::State& state) {
  const scenes::ReposeBox b = box();
  Solver solver = settled(b);
  solver.remove_boundary(b.door);
  scenes::run(solver, 0.3);
  time_steps(state, solver);
}
BENCHMARK(Discharging)->Unit(benchmark::kMicrosecond)->Iterations(20000)->UseRealTime();

// Steps of a round: 200 (4 ms), or as many as FIRN_STEPS says (few, to count them with valgrind).
int steps_of_round() {
  const char* const wish = std::getenv("FIRN_STEPS");
  return wish ? std::atoi(wish) : 200;
}

// A separate function, so that valgrind can count in it alone.
[[gnu::noinline]] void take_steps(Solver& solver, int steps) {
  for (int k = 0; k < steps; ++k) solver.step_deferred();
}

// Arguments: tiles along and across. `least` is that of the fastest round.
void tiles(benchmark::State& state, beds::Bed bed) {
  const double before = taken();
  Solver solver = beds::kept(bed, static_cast<int>(state.range(0)),
                             static_cast<int>(state.range(1)), threads());
  const int steps = steps_of_round();
  const std::vector<std::byte> beginning = solver.save();
  const auto cubes = static_cast<double>(solver.model().particles.size());
  double least = std::numeric_limits<double>::infinity(), all = 0;
  for (auto _ : state) {
    solver.restore(beginning);
    for (int k = 0; k < 2; ++k) solver.step_deferred();  // tables and caches
    const double begin = time_used();
    take_steps(solver, steps);
    const double took = time_used() - begin;
    state.SetIterationTime(1e-6 * took / steps);
    least = std::min(least, took);
    all += took;
  }
  state.counters["us/particle/step"] =
      all / (cubes * steps * static_cast<double>(state.iterations()));
  state.counters["least"] = least / (cubes * steps);
  state.counters["cubes"] = cubes;
  state.counters["bytes/particle"] =
      (taken() - before - static_cast<double>(beginning.size())) / cubes;
  add_counters(state, solver);
}
void TiledSettled(benchmark::State& state) { tiles(state, beds::Bed::settled); }
void TiledDischarging(benchmark::State& state) { tiles(state, beds::Bed::discharging); }
void TiledStirred(benchmark::State& state) { tiles(state, beds::Bed::stirred); }

// Every size takes the same steps from the same state, several times over.
void sizes(benchmark::internal::Benchmark* b, int tiles_along, int tiles_across, int rounds) {
  b->Args({tiles_along, tiles_across})->Iterations(rounds);
}
void small(benchmark::internal::Benchmark* b) { sizes(b, 1, 1, 30); }
void medium(benchmark::internal::Benchmark* b) { sizes(b, 4, 3, 5); }
void large(benchmark::internal::Benchmark* b) { sizes(b, 6, 19, 2); }
#define FIRN_TILED(name, size) \
  BENCHMARK(name)->Apply(size)->Unit(benchmark::kMicrosecond)->UseManualTime()
FIRN_TILED(TiledSettled, small);
FIRN_TILED(TiledSettled, medium);
FIRN_TILED(TiledSettled, large);
FIRN_TILED(TiledDischarging, small);
FIRN_TILED(TiledDischarging, medium);
FIRN_TILED(TiledDischarging, large);
FIRN_TILED(TiledStirred, small);
FIRN_TILED(TiledStirred, medium);
FIRN_TILED(TiledStirred, large);

}  // namespace
}  // namespace firn
