// The costly phases of a step, compiled once for every x86-64 processor (or whatever machine this
// is) and, where the compiler can, once more for those with AVX2. Both give the same bits: none of
// them fuses a multiplication with an addition, and vectors only do side by side what one number
// would do. Which one runs is decided when a solver is made.
#pragma once

#include "firn/model.h"

namespace firn {

struct State;
struct Workspace;

struct Kernels {
  const char* name;
  void (*integrate_positions)(const Model&, Workspace&, State&, bool both_kicks);
  void (*update_neighbor_list)(const Model&, Workspace&, State&);
  void (*find_contacts)(const Model&, Workspace&, State&);
  void (*contact_forces)(const Model&, Workspace&, State&);
  void (*finish_velocities)(const Model&, const Workspace&, State&);
};

const Kernels& baseline_kernels();
const Kernels& avx2_kernels();  // defined only in builds that have them

// The best ones that this build and this processor have; the environment may ask for others:
// FIRN_INSTRUCTIONS=baseline or avx2. Throws InputError when it asks for what is not there.
const Kernels& choose_kernels();

}  // namespace firn
