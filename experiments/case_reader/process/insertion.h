// What enters and leaves a simulation and when, and what is noted on the way: [[particles]],
// [[fills]], [[inlets]], [[outlets]], [[sensors]], [[tag_rules]], [[limit_switches]], [[stages]].
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// Adds to c.placed, and the particles to the model; the case's seed draws what a table leaves to
// chance.
void read_particles(const TomlTable& root, Case& c);
std::vector<Fill> read_fills(const TomlTable& root, const std::vector<Shape>& shapes);
std::vector<Inlet> read_inlets(const TomlTable& root, const std::vector<Shape>& shapes);
std::vector<Outlet> read_outlets(const TomlTable& root);
std::vector<Sensor> read_gates(const TomlTable& root);
std::vector<TagRule> read_tag_rules(const TomlTable& root);
std::vector<LimitSwitch> read_switches(const TomlTable& root,
                                       const std::vector<MotionFrame>& frames);

// The id of the first particle of each inlet. The model holds all particles.
std::vector<int> first_of_inlets(const Case& c);

// Where and how a particle of an inlet is put: place number `place` of a batch, and what chance
// does to it. Each particle has a separate random stream.
struct SourcePose {
  Vec3 position;     // m, centre of mass
  Quat orientation;  // shape axes -> world
};
SourcePose source_pose(const Inlet& source, std::size_t place, int particle, std::uint64_t seed);

// `count` of a fill.
int read_count(const TomlTable& table);

// Throws when the region cannot hold a batch, or batches have no interval between them.
void check_fill(const TomlTable& table, const Fill& fill, const Shape& shape);

}  // namespace firn
