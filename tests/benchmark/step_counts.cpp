// Two fixed scenes of 200 crescents for counting instructions (see `guard` beside this file):
//   step_counts make FOLDER    lets them fall, and keeps the states at 0.2 s (falling) and at 1 s
//                              (settled)
//   step_counts SCENE FOLDER   100 steps of one of them; prints what ran
#include <fmt/format.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "validation/verification/scenes.h"

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

void step(const std::string& scene, const std::filesystem::path& folder) {
  Solver solver(scenes::repose_box(kCubes).model);
  solver.restore(kept(folder / (scene + ".state")));
  const Health before = solver.health();
  for (int i = 0; i < kSteps; ++i) solver.step();
  const Health& after = solver.health();
  std::cout << fmt::format(
      "{{\"particle_steps\": {}, \"instructions\": \"{}\", \"patches\": {}, \"queries\": {}}}\n",
      kCubes * kSteps, instruction_set(), after.patches, after.queries - before.queries);
}

}  // namespace
}  // namespace firn

int main(int argc, char** argv) {
  const std::string what = argc == 3 ? argv[1] : "";
  if (what == "make") {
    firn::make(argv[2]);
  } else if (what == "falling" || what == "settled") {
    firn::step(what, argv[2]);
  } else {
    std::cerr << "usage: step_counts make|falling|settled FOLDER\n";
    return 2;
  }
}
