// Loads on the triangles of boundaries, over every step (see TriangleSums).
#pragma once

#include <cstdint>

#include "firn/model.h"

namespace firn {

struct State;
struct StatisticsState;
struct Workspace;

// Part of the phase: adds the loads of this step.
void sum_triangle_loads(const Model& model, Workspace& workspace, State& state);

// Moves the sums up to this step to the finished intervals.
void end_load_interval(const Model& model, std::uint64_t step, StatisticsState& statistics);

}  // namespace firn
