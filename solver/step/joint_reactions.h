// Reactions in the joints of free bodies: impulses by their parents.
#pragma once

#include <vector>

#include "firn/model.h"
#include "solver/dynamics/mechanism.h"
#include "solver/state/state.h"

namespace firn {

// Impulse on a free body over the step by everything except contacts and gravity, N s, and N m s
// about the body's origin. Computed from the change of the momenta since the step before, with the
// loads and poses at the start of the step.
JointLoad other_impulse(const Model& model, const FreeBody& body, const Vec3& origin,
                        const BodyLoad& load, const FrameMotion& before, const FrameMotion& now,
                        JointReaction& joint);

// Stores the reaction in a joint. `parent`: impulse of the parent over a step of dt s.
void record_reaction(const JointLoad& parent, double dt, JointReaction& joint);

// Records the reactions in the joints of a mechanism, from the last bodies to the first. The
// reaction in a joint is the impulse on its body, without that of couplings, plus the reactions in
// the joints of the bodies that are attached to it.
void record_reactions(const Model& model, State& s, const std::vector<FrameMotion>& before,
                      const std::vector<BodyLoad>& loads, const Mechanism& mechanism);

// Sets the reactions before the first step: joints bear the weights of their bodies as drawn.
void estimate_reactions(const Model& model, State& s);

}  // namespace firn
