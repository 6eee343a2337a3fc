// What a step of the drained repose experiment costs: 880 crescents settled in the box, and flowing
// out through the door; and the same states, and a stirred one, of 1, 12 and 114 such boxes side by
// side: 880, 10 560 and 100 320 crescents. One core unless FIRN_THREADS says otherwise.
//
// The settled bed is made once by filling (about 15 s) and kept beside the program, together with
// files for other programs: bed.csv (pose of every crescent), hull_bed.csv (pose of every convex
// hull of a crescent, settled by Firn too) and crescent.json (the shape).
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <malloc.h>

#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/benchmark/beds.h"

namespace firn {
namespace {

constexpr int kCubes = beds::kCubes;

std::filesystem::path program_folder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

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
                        {"tip", p.tip},
                        {"dish", p.dish},
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

std::vector<std::byte> read_bytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::vector<char> text((std::istreambuf_iterator<char>(in)), {});
  std::vector<std::byte> bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  return bytes;
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

// A solver over the settled bed, from the kept file or by filling anew.
Solver settled(const scenes::ReposeBox& b) {
  const std::filesystem::path folder = program_folder(), file = folder / "settled_bed.state";
  Solver solver(b.model);
  if (std::filesystem::exists(file)) {
    try {
      solver.restore(read_bytes(file));
      return solver;
    } catch (const RunError& e) {
      std::cerr << "making the bed anew: " << e.what() << '\n';
      solver = Solver(b.model);
    }
  }
  scenes::scatter(solver, 0, kCubes, b.lower, b.upper, 1);
  scenes::run(solver, 1.2);
  const std::vector<std::byte> bytes = solver.save();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  export_bed(folder / "bed.csv", solver.particles());
  export_crescent(folder / "crescent.json", b);
  export_hull_bed(folder / "hull_bed.csv", b);
  return solver;
}

// Largest memory of this process so far, MB.
double peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0;
    if (word == "VmHWM:" && status >> kilobytes) return kilobytes / 1024;
  }
  return 0;
}

// Time that this process has used, us: of the processor for one thread, which other work on the
// machine hardly changes; of the clock on the wall for more.
double time_used() {
  timespec t{};
  clock_gettime(threads() > 1 ? CLOCK_MONOTONIC : CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

void tell(benchmark::State& state, const Solver& solver) {
  state.counters["patches"] = static_cast<double>(solver.health().patches);
  state.counters["points"] = static_cast<double>(solver.health().points);
  state.counters["kinetic_J"] = solver.energy().kinetic;
  state.counters["peak_MB"] = peak_memory();
}

// Times the steps of a bed, all of its cubes still there.
void time_steps(benchmark::State& state, Solver& solver) {
  const auto cubes = static_cast<double>(solver.model().particles.size());
  const double begin = time_used();
  for (auto _ : state) solver.step();
  state.counters["us/particle/step"] =
      (time_used() - begin) / cubes / static_cast<double>(state.iterations());
  tell(state, solver);
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

// Memory that is taken, bytes.
double taken() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

// Takes the state up from the kept file; false when there is none that fits.
bool take_up(Solver& solver, const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return false;
  try {
    solver.restore(read_bytes(file));
    return true;
  } catch (const RunError& e) {
    std::cerr << "making " << file.filename() << " anew: " << e.what() << '\n';
    return false;
  }
}

void keep(const Solver& solver, const std::filesystem::path& file) {
  const std::vector<std::byte> bytes = solver.save();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

// The stirred tile, from the kept file or by filling anew.
Solver stirred(const beds::Tile& tile) {
  const std::filesystem::path file = program_folder() / "stirred_bed.state";
  Solver solver(tile.box.model);
  if (take_up(solver, file)) return solver;
  solver = beds::filled(tile);
  keep(solver, file);
  return solver;
}

enum class Bed { settled, discharging, stirred };

// Steps of a round: 200 (4 ms), or as many as FIRN_STEPS says (few, to count them with valgrind).
int steps_of_round() {
  const char* const wish = std::getenv("FIRN_STEPS");
  return wish ? std::atoi(wish) : 200;
}

// By itself, so that valgrind can be told to count here alone.
[[gnu::noinline]] void take_steps(Solver& solver, int steps) {
  for (int k = 0; k < steps; ++k) solver.step();
}

// Arguments: tiles along and across. `least` is that of the fastest round. The beginning is kept
// beside the program.
void tiles(benchmark::State& state, Bed kind) {
  const int along = static_cast<int>(state.range(0)), across = static_cast<int>(state.range(1));
  const char* const names[] = {"settled", "discharging", "stirred"};
  const std::filesystem::path file =
      program_folder() /
      fmt::format("{}_{}x{}.state", names[static_cast<int>(kind)], along, across);
  const beds::Tile tile = beds::tile(kind == Bed::stirred);
  Solver one = kind == Bed::stirred ? stirred(tile) : settled(tile.box);
  if (kind == Bed::discharging && !std::filesystem::exists(file)) {
    one.remove_boundary(tile.box.door);
    scenes::run(one, 0.3);
  }
  const beds::Tiled bed = beds::tiled(tile, one, along, across);
  const double before = taken();
  Solver solver = beds::start(bed, threads());
  if (!take_up(solver, file)) {
    if (kind == Bed::discharging) {
      for (const int door : bed.doors) solver.remove_boundary(door);
    }
    // The contacts' memory; a bed at rest stirs itself once more until it has it again.
    scenes::run(solver, kind == Bed::settled ? 0.1 : 0.01);
    keep(solver, file);
  }
  const int steps = steps_of_round();
  const std::vector<std::byte> beginning = solver.save();
  const auto cubes = static_cast<double>(bed.position.size());
  double least = std::numeric_limits<double>::infinity(), all = 0;
  for (auto _ : state) {
    solver.restore(beginning);
    for (int k = 0; k < 2; ++k) solver.step();  // tables and caches
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
      (taken() - before - static_cast<double>(beginning.capacity())) / cubes;
  tell(state, solver);
}
void TiledSettled(benchmark::State& state) { tiles(state, Bed::settled); }
void TiledDischarging(benchmark::State& state) { tiles(state, Bed::discharging); }
void TiledStirred(benchmark::State& state) { tiles(state, Bed::stirred); }

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
