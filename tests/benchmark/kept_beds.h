// Beds in three states, made once and kept as files next to the program. A file whose state has
// another layout is made again.
#pragma once

#include <filesystem>

#include "tests/benchmark/beds.h"

namespace firn::beds {

enum class Bed { settled, discharging, stirred };
const char* name_of(Bed bed);

std::filesystem::path program_folder();

// The box of the drained repose experiment after 1.2 s of filling (about 15 s of work), in
// settled_bed.state.
std::filesystem::path settled_file();
Solver settled(const scenes::ReposeBox& box);

// Such boxes side by side (see beds.h), in settled_4x3.state and so on: at rest; 0.3 s after the
// doors are gone; with stirrers that turn. Their contacts have their memory. The largest take
// minutes to make.
Solver kept(Bed bed, int along, int across, int threads);

}  // namespace firn::beds
