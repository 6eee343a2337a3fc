#include "tests/benchmark/kept_beds.h"

#include <fmt/format.h>

#include <cstring>
#include <fstream>
#include <iostream>

namespace firn::beds {

namespace {

std::vector<std::byte> read_bytes(const std::filesystem::path& file) {
  std::vector<std::byte> bytes(std::filesystem::file_size(file));
  std::ifstream(file, std::ios::binary)
      .read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return bytes;
}

// False when there is no file that fits.
bool take_up(Solver& solver, const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return false;
  try {
    solver.restore(read_bytes(file));
    return true;
  } catch (const RunError& e) {
    std::cerr << "making " << file.filename() << " again: " << e.what() << '\n';
    return false;
  }
}

void keep(const Solver& solver, const std::filesystem::path& file) {
  const std::vector<std::byte> bytes = solver.save();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

// One box with a stirrer.
Solver stirred(const Tile& tile) {
  const std::filesystem::path file = program_folder() / "stirred_bed.state";
  Solver solver(tile.box.model);
  if (take_up(solver, file)) return solver;
  solver = filled(tile);
  keep(solver, file);
  return solver;
}

}  // namespace

const char* name_of(Bed bed) {
  const char* const names[] = {"settled", "discharging", "stirred"};
  return names[static_cast<int>(bed)];
}

std::filesystem::path program_folder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

std::filesystem::path settled_file() { return program_folder() / "settled_bed.state"; }

Solver settled(const scenes::ReposeBox& box) {
  Solver solver(box.model);
  if (take_up(solver, settled_file())) return solver;
  scenes::scatter(solver, 0, kCubes, box.lower, box.upper, 1);
  scenes::run(solver, 1.2);
  keep(solver, settled_file());
  return solver;
}

Solver kept(Bed bed, int along, int across, int threads) {
  const std::filesystem::path file =
      program_folder() / fmt::format("{}_{}x{}.state", name_of(bed), along, across);
  const Tile one = tile(bed == Bed::stirred);
  Solver state = bed == Bed::stirred ? stirred(one) : settled(one.box);
  Tiled many = tiled(one, state, along, across);
  Solver solver = start(many, threads);
  if (take_up(solver, file)) return solver;
  if (bed == Bed::discharging) {
    state.remove_boundary(one.box.door);
    scenes::run(state, 0.3);
    many = tiled(one, state, along, across);
    solver = start(many, threads);
    for (const int door : many.doors) solver.remove_boundary(door);
  }
  // The contacts' memory; a bed at rest stirs itself once more until it has it again.
  scenes::run(solver, bed == Bed::settled ? 0.1 : 0.01);
  keep(solver, file);
  return solver;
}

}  // namespace firn::beds
