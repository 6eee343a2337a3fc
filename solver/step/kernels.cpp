// Compiled with each set of kernels; FIRN_KERNELS is its function and FIRN_KERNELS_NAME its name.
#include "solver/step/kernels.h"

#include "solver/state/workspace.h"

namespace firn {

const Kernels& FIRN_KERNELS() {
  static constexpr Kernels kernels{FIRN_KERNELS_NAME, integrate_positions, update_neighbor_list,
                                   find_contacts,     contact_forces,      finish_velocities};
  return kernels;
}

}  // namespace firn
