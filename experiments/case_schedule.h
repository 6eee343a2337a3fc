// What enters and leaves a simulation and when: [[particles]], [[fills]], [[outlets]], [[stages]].
#pragma once

#include <vector>

#include "experiments/case.h"
#include "experiments/toml_reader.h"

namespace firn {

// Adds the particles to the model as well. `seed` draws what a table leaves to chance.
std::vector<Case::Placed> read_particles(const TomlTable& root, Model& model, std::uint64_t seed);
std::vector<Fill> read_fills(const TomlTable& root, const std::vector<Shape>& shapes);
std::vector<Outlet> read_outlets(const TomlTable& root);
std::vector<Stage> read_stages(const TomlTable& root, const std::vector<Boundary>& boundaries);

// `count` of a fill.
int read_count(const TomlTable& table);

// Throws when the region cannot hold a batch, or batches have no interval between them.
void check_fill(const TomlTable& table, const Fill& fill, const Shape& shape);

}  // namespace firn
