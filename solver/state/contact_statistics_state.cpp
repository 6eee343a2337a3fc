#include "solver/state/contact_statistics_state.h"

namespace firn {

StatisticsState empty_statistics(const Model& model) {
  const StatisticsOptions& options = model.statistics;
  StatisticsState stats;
  stats.recording = options.deferred ? 0 : 1;
  std::size_t triangles = 0, surfaces = 0;
  for (const MonitoredBoundary& w : options.monitored) triangles += w.mesh.triangles.size();
  for (const TriangleMesh& mesh : options.surfaces) surfaces += mesh.triangles.size();
  stats.triangles.resize(triangles);
  stats.surfaces.resize(surfaces);
  stats.energies.resize((1 + model.boundaries.size()) *
                        static_cast<std::size_t>(options.energies.count()));
  if (options.compressive_loads) stats.opposed.resize(model.particles.size());
  return stats;
}

}  // namespace firn
