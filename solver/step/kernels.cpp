// Compiled with each set of kernels; FIRN_KERNELS is its function and FIRN_KERNELS_NAME its name.
#include "solver/step/kernels.h"

#include "solver/contact_detection/find_contacts.h"
#include "solver/contact_detection/neighbor_list.h"
#include "solver/step/contact_forces.h"
#include "solver/step/integrate_particles.h"

namespace firn {

const Kernels& FIRN_KERNELS() {
  static constexpr Kernels kernels{FIRN_KERNELS_NAME, integrate_positions, update_neighbor_list,
                                   find_contacts,     contact_forces,      finish_velocities};
  return kernels;
}

}  // namespace firn
