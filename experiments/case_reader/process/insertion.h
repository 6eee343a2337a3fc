// Insertion, removal and counting of particles: [[particles]], [[fills]], [[inlets]], [[outlets]],
// [[sensors]], [[tag_rules]], [[limit_switches]].
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// Adds the particles to c.placed and to the model. Random positions depend on the seed of the case.
void read_particles(const TomlTable& root, Case& c);
std::vector<Fill> read_fills(const TomlTable& root, const std::vector<Shape>& shapes);
std::vector<Inlet> read_inlets(const TomlTable& root, const std::vector<Shape>& shapes);
std::vector<Outlet> read_outlets(const TomlTable& root);
std::vector<Sensor> read_sensors(const TomlTable& root);
std::vector<TagRule> read_tag_rules(const TomlTable& root);
std::vector<LimitSwitch> read_limit_switches(const TomlTable& root,
                                             const std::vector<MotionFrame>& frames);

// [inlets] id of the first particle. The model must have all particles.
std::vector<int> first_inlet_particles(const Case& c);

// Initial pose of a particle of an inlet.
struct InletPose {
  Vec3 position = Vec3::Zero();         // m, center of mass, world
  Quat orientation = Quat::Identity();  // shape axes -> world
};
// `number`: of the particle in its batch, place by place; `particle`: its id. Jitter is drawn from
// a separate random stream for each place.
InletPose inlet_pose(const Inlet& source, std::size_t number, int particle, std::uint64_t seed);

// The key `count` of a fill.
int read_count(const TomlTable& table);

// Throws if a batch does not fit into the region, or if several batches have no interval.
void check_fill(const TomlTable& table, const Fill& fill, const Shape& shape);

}  // namespace firn
