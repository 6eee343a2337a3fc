// What a step of the drained repose experiment costs: 880 crescents settled in the box, and flowing
// out through the door. One core unless FIRN_THREADS says otherwise.
//
// The settled bed is made once by filling (about 15 s) and kept beside the program, together with
// files for other programs: bed.csv (pose of every crescent), hull_bed.csv (pose of every convex
// hull of a crescent, settled by Firn too) and crescent.json (the shape).
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "validation/verification/scenes.h"

namespace firn {
namespace {

constexpr int kCubes = 880;

std::filesystem::path program_folder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

scenes::ReposeBox box() {
  scenes::ReposeBox b = scenes::repose_box(kCubes);
  if (const char* threads = std::getenv("FIRN_THREADS"))
    b.model.numerics.threads = std::atoi(threads);
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

// Times the steps of a bed of kCubes, all of them still there.
void time_steps(benchmark::State& state, Solver& solver) {
  const auto begin = std::chrono::steady_clock::now();
  for (auto _ : state) solver.step();
  const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - begin;
  state.counters["us/particle/step"] =
      took.count() / kCubes / static_cast<double>(state.iterations());
  state.counters["patches"] = static_cast<double>(solver.health().patches);
  state.counters["points"] = static_cast<double>(solver.health().points);
  state.counters["kinetic_J"] = solver.energy().kinetic;
  state.counters["peak_MB"] = peak_memory();
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

}  // namespace
}  // namespace firn
