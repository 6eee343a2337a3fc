// Two fixed scenes of 200 crescents for counting instructions (see `guard` in this folder):
//   step_counts make FOLDER    lets them fall, and keeps the states at 0.2 s (falling) and at 1 s
//                              (settled)
//   step_counts SCENE FOLDER [STATISTICS]   100 steps of one of them; prints what ran. STATISTICS:
//                              events, opposed, triangles or all
#include <fmt/format.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "solver/geometry/nearest_triangle.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

constexpr int kCubes = 200, kSteps = 100;

void keep(const Solver& solver, const std::filesystem::path& file) {
  const std::vector<std::byte> bytes = solver.save();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

std::vector<std::byte> kept(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::vector<char> text((std::istreambuf_iterator<char>(in)), {});
  std::vector<std::byte> bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  return bytes;
}

void make(const std::filesystem::path& folder) {
  const scenes::ReposeBox box = scenes::repose_box(kCubes);
  Solver solver(box.model);
  const Vec3 upper(box.upper.x(), box.upper.y(), 0.3);
  scenes::scatter(solver, 0, kCubes, box.lower, upper, 1);
  scenes::run(solver, 0.2);
  keep(solver, folder / "falling.state");
  scenes::run(solver, 0.8);
  keep(solver, folder / "settled.state");
}

// False for a word that is none of them.
bool ask_for(const std::string& what, Model& model) {
  StatisticsOptions& options = model.statistics;
  const bool all = what == "all";
  options.events = options.compressive_loads = all;
  if (what == "events") options.events = true;
  if (what == "opposed") options.compressive_loads = true;
  if (all) options.energies = {1e-9, 5, 8};
  if (all || what == "triangles") {
    for (std::size_t b = 0; b < model.boundaries.size(); ++b) {
      if (model.boundaries[b].parts.empty()) continue;
      options.monitored.push_back(
          {static_cast<int>(b), subdivided(surface_mesh(model.boundaries[b].parts[0]), 0.02)});
    }
  }
  return what.empty() || options.any();
}

void step(const std::string& scene, const std::filesystem::path& folder, const Model& model) {
  Solver solver(model);
  solver.restore(kept(folder / (scene + ".state")));
  const Diagnostics before = solver.diagnostics();
  for (int i = 0; i < kSteps; ++i) solver.step_deferred();
  const Diagnostics& after = solver.diagnostics();
  std::cout << fmt::format(
      "{{\"particle_steps\": {}, \"instructions\": \"{}\", \"patches\": {}, \"queries\": {}}}\n",
      kCubes * kSteps, instruction_set(), after.patches, after.queries - before.queries);
}

}  // namespace
}  // namespace firn

int main(int argc, char** argv) {
  const std::string what = argc >= 3 && argc <= 4 ? argv[1] : "";
  firn::Model model = firn::scenes::repose_box(firn::kCubes).model;
  if (what == "make" && argc == 3) {
    firn::make(argv[2]);
  } else if ((what == "falling" || what == "settled") &&
             firn::ask_for(argc == 4 ? argv[3] : "", model)) {
    firn::step(what, argv[2], model);
  } else {
    std::cerr << "usage: step_counts make|falling|settled FOLDER [events|opposed|triangles|all]\n";
    return 2;
  }
}
