#include "experiments/responses/contact_statistics_responses.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "experiments/results/contact_statistics_results.h"

namespace firn {
namespace {

void add(std::vector<Response>& out, const std::string& name, double value, const std::string& unit,
         const std::string& method) {
  out.push_back({response_name(name), {value}, {}, unit, method, 1});
}

void add_contacts(const Recording& recording, std::vector<Response>& out) {
  const std::size_t particles = recording.particle_count();
  const std::vector<std::string> boundaries = recording.strings("/statistics/boundary_name");
  std::vector<double> count(1 + boundaries.size(), 0), largest = count;
  std::vector<std::map<int, double>> of_particle(count.size());
  for (const ContactEvent& e : contact_events(recording)) {
    const auto other = static_cast<std::size_t>(e.b);
    const std::size_t kind = other < particles ? 0 : 1 + other - particles;
    count.at(kind) += 1;
    largest.at(kind) = std::max(largest[kind], e.peak_normal_force);
    double& one = of_particle[kind][e.a];
    one = std::max(one, e.peak_normal_force);
  }
  for (std::size_t kind = 0; kind < count.size(); ++kind) {
    const std::string where = kind == 0 ? "between_particles" : "on_" + boundaries[kind - 1];
    add(out, "contacts_" + where, count[kind], "1",
        "contacts whose peak normal force reaches the threshold of the case");
    if (count[kind] > 0)
      add(out, "largest_contact_" + where, largest[kind], "N",
          "largest peak normal force of a contact over every step");
    if (kind == 0 || count[kind] == 0) continue;
    std::vector<double> peaks;
    for (const auto& [particle, peak] : of_particle[kind]) peaks.push_back(peak);
    std::ranges::sort(peaks);
    out.push_back({response_name("largest_contacts_" + where),
                   std::move(peaks),
                   {},
                   "N",
                   "largest peak normal force of each particle that touches it with the threshold "
                   "of the case or more, ascending",
                   1});
  }
}

void add_opposed(const Recording& recording, std::vector<Response>& out) {
  const std::vector<CompressiveLoad> all = compressive_loads(recording);
  if (all.empty()) return;
  // Particles that were never inserted have no load.
  const std::vector<double> inserted = recording.insert_time();
  std::vector<double> loads;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (std::isfinite(inserted[i])) loads.push_back(all[i].load);
  if (loads.empty()) return;
  add(out, "largest_compressive_load", *std::ranges::max_element(loads), "N",
      "largest load from two sides on any particle over every step");
  std::ranges::sort(loads);
  add(out, "compressive_load_median", loads[(loads.size() - 1) / 2], "N",
      "median over the inserted particles of the largest load from two sides on each");
  out.push_back(
      {"compressive_loads",
       loads,
       {},
       "N",
       "largest load from two sides over every step, one value for each inserted particle, "
       "ascending",
       1});
}

void add_triangles(const Recording& recording, std::vector<Response>& out) {
  for (const BoundaryLoads& loads : boundary_loads(recording)) {
    if (loads.end.empty()) continue;
    const std::size_t triangles = loads.area.size();
    for (const TriangleField& field : loads.fields) {
      if (field.name == "peak_stress") {
        add(out, "peak_stress_on_" + loads.boundary, *std::ranges::max_element(field.values), "Pa",
            "largest normal force on a triangle in any step over its area");
      }
      if (field.name != "wear_depth") continue;
      std::vector<double> depth(triangles, 0);
      double volume = 0;
      for (std::size_t k = 0; k < field.values.size(); ++k) {
        depth[k % triangles] += field.values[k];
        volume += field.values[k] * loads.area[k % triangles];
      }
      add(out, "wear_volume_on_" + loads.boundary, volume, "m^3",
          "Archard: specific wear rate times normal force times way of sliding");
      add(out, "wear_depth_on_" + loads.boundary, *std::ranges::max_element(depth), "m",
          "deepest triangle");
    }
  }
}

}  // namespace

bool statistics_began(const Recording& recording, const Case& c) {
  return c.statistics_stage < 0 ||
         static_cast<std::size_t>(c.statistics_stage) < recording.stages().size();
}

std::vector<Response> statistics_responses(const Recording& recording, const Case& c) {
  std::vector<Response> out;
  if (!statistics_began(recording, c)) return out;
  const StatisticsOptions& options = c.model.statistics;
  if (options.events) add_contacts(recording, out);
  if (options.compressive_loads) add_opposed(recording, out);
  if (!options.monitored.empty()) add_triangles(recording, out);
  return out;
}

}  // namespace firn
