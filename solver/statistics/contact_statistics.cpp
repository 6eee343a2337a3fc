#include "solver/statistics/contact_statistics.h"

#include <algorithm>
#include <cmath>

#include "firn/contact_statistics.h"
#include "solver/statistics/compressive_loads.h"
#include "solver/statistics/contact_events.h"
#include "solver/statistics/triangle_loads.h"

namespace firn {

int EnergyBins::of(double energy) const {
  if (!(energy >= lowest)) return 0;
  const double k = 1 + std::floor(per_decade * std::log10(energy / lowest));
  return static_cast<int>(std::min<double>(k, count() - 1));
}

double EnergyBins::lower_bound(int k) const {
  return k > 0 ? lowest * std::pow(10.0, static_cast<double>(k - 1) / per_decade) : 0;
}

void update_statistics(const Model& model, Workspace& w, State& s) {
  const StatisticsOptions& options = model.statistics;
  if (options.contacts()) update_contact_events(model, w, s);
  if (options.compressive_loads) record_compressive_loads(model, w, s);
  if (!options.monitored.empty()) sum_triangle_loads(model, w, s);
}

}  // namespace firn
