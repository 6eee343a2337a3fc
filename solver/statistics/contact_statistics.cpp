#include "firn/contact_statistics.h"

#include <algorithm>
#include <cmath>

#include "solver/state/workspace.h"

namespace firn {

int EnergyBins::of(double energy) const {
  if (!(energy >= lowest)) return 0;
  const double k = 1 + std::floor(per_decade * std::log10(energy / lowest));
  return static_cast<int>(std::min<double>(k, count() - 1));
}

double EnergyBins::lower_bound(int k) const {
  return k > 0 ? lowest * std::pow(10.0, static_cast<double>(k - 1) / per_decade) : 0;
}

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

StatisticsState empty_statistics(const Model& model) {
  const StatisticsOptions& options = model.statistics;
  StatisticsState stats;
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

void update_statistics(const Model& model, Workspace& w, State& s) {
  const StatisticsOptions& options = model.statistics;
  if (options.contacts()) update_contact_events(model, w, s);
  if (options.compressive_loads) record_compressive_loads(model, w, s);
  if (!options.monitored.empty()) sum_triangle_loads(model, w, s);
}

}  // namespace firn
