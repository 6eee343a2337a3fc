// The costly phases of a step, compiled for the baseline instruction set of the machine and, on
// x86-64, also for AVX2. Both give the same bits: no multiplication is fused with an addition, and
// vector operations perform the scalar operations in the same order. A solver selects one of them
// when it is constructed.
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
const Kernels& avx2_kernels();  // defined only in builds with AVX2 kernels

// The fastest kernels that this build and this processor support. The environment variable
// FIRN_INSTRUCTIONS (baseline or avx2) selects others. Throws InputError when those are not
// available.
const Kernels& choose_kernels();

}  // namespace firn
