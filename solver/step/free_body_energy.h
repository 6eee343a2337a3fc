// Energy account of free bodies and of the contacts between boundaries.
#pragma once

#include <cstddef>
#include <vector>

#include "firn/diagnostics.h"
#include "firn/model.h"
#include "solver/dynamics/joint_loads.h"
#include "solver/state/state.h"

namespace firn {

struct Workspace;

// Adds the work of contacts over half of a step: the present loads on boundaries at the velocities
// of the step, which began at the frames `before`. A step calls it twice, once its bodies have
// moved and once its new loads are known: the trapezoidal rule.
void add_contact_work(const Model& model, const std::vector<FrameMotion>& before, State& s);

// Adds the work of a prescribed frame `carrier` (-1: the world) on the free frame f over a step.
// `impulse`: on the body between the velocities of the last two steps, by everything except
// contacts and gravity, N s, and N m s about its origin in `before`. Impulses between the bodies of
// a mechanism cancel in the sum over them.
void add_carrier_work(const std::vector<FrameMotion>& before, std::size_t f, int carrier,
                      const JointLoad& impulse, State& s);
// That impulse in the first step, from the momenta at the start to those in `joint`, which
// other_impulse() has set in this step.
JointLoad starting_impulse(const Model& model, const std::vector<FrameMotion>& before,
                           std::size_t f, const JointReaction& joint);

// Of the present state; zero without free frames.
FreeBodyEnergy free_body_energy(const Model& model, const Workspace& workspace, const State& s);

}  // namespace firn
