// Shapes that are in use.
#pragma once

#include <vector>

#include "firn/model.h"

namespace firn {

// [shapes] 1: a particle of the model has the shape.
inline std::vector<char> used_shapes(const Model& model) {
  std::vector<char> used(model.shapes.size(), 0);
  for (const Particle& p : model.particles) used[p.shape] = 1;
  return used;
}

}  // namespace firn
