#include "solver/state/contact_statistics_workspace.h"

namespace firn {

StatisticsWorkspace::StatisticsWorkspace(const Model& model)
    : monitored(model.boundaries.size(), -1),
      last_pressed(model.statistics.compressive_loads ? model.particles.size() : 0, -1) {
  std::uint32_t first = 0;
  for (const MonitoredBoundary& w : model.statistics.monitored) {
    monitored[w.boundary] = static_cast<std::int32_t>(monitored_index.size());
    monitored_index.emplace_back(w.mesh);
    first_of_monitored.push_back(first);
    first += static_cast<std::uint32_t>(w.mesh.triangles.size());
  }
  force.assign(first, 0);
  first = 0;
  for (const TriangleMesh& mesh : model.statistics.surfaces) {
    surface_index.emplace_back(mesh);
    first_of_shape.push_back(first);
    first += static_cast<std::uint32_t>(mesh.triangles.size());
  }
}

}  // namespace firn
