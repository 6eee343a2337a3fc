#include "experiments/export/scene_extent.h"

#include <algorithm>
#include <cmath>

namespace firn {

double drawn_plane_extent(const Recording& recording, const Model& model, std::size_t every) {
  double center = 0, size = 0;
  for (std::size_t i = 0; i < recording.frame_count(); i += every)
    for (const auto& p : recording.frame(i).position)
      if (!std::isnan(p[0])) center = std::max(center, std::hypot(p[0], p[1], p[2]));
  for (const Shape& shape : model.shapes) size = std::max(size, shape.bounding_radius);
  return 1.5 * (center + size);
}

}  // namespace firn
