#include "experiments/case_reader/process/contact_statistics.h"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/case_reader/model/boundaries.h"
#include "experiments/case_reader/process/stages.h"
#include "firn/mesh.h"

namespace firn {
namespace {

// The mesh in triangles of no longer edges than the table asks for; as it is where it does not.
TriangleMesh read_edge(const TomlTable& t, const TriangleMesh& mesh) {
  constexpr std::size_t kMost = 1'000'000;  // triangles
  const auto edge = t.optional_quantity("edge", dimension::length, Sign::positive);
  if (!edge) return mesh;
  // At least so many, as none of them is larger than an equilateral one.
  double area = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) area += 0.5 * area_normal(mesh, i).norm();
  if (area / (0.433 * *edge * *edge) > kMost)
    t.fail("edge", fmt::format("is {:.4g} m, which makes more than {} triangles; expected more",
                               *edge, kMost));
  return subdivided(mesh, *edge);
}

double read_wear_rate(const TomlTable& t) {
  const auto rate =
      t.optional_quantity("specific_wear_rate", dimension::pressure.power(-1), Sign::non_negative);
  if (!t.has("wear_coefficient") && !t.has("hardness")) return rate.value_or(0);
  if (rate)
    t.fail("specific_wear_rate",
           "is given together with wear_coefficient or hardness; expected it or both of them");
  const double coefficient = t.number("wear_coefficient");
  if (!(coefficient >= 0))
    t.fail("wear_coefficient", fmt::format("is {}; expected no less than 0", coefficient));
  return coefficient / t.quantity("hardness", dimension::pressure, Sign::positive);
}

std::vector<MonitoredBoundary> read_monitored(const TomlTable& t, const Model& model) {
  std::vector<MonitoredBoundary> monitored;
  for (const std::string& name : t.strings("boundaries")) {
    const int index = boundary_index(t, "boundaries", name, model.boundaries);
    if (std::ranges::find(monitored, index, &MonitoredBoundary::boundary) != monitored.end())
      t.fail("boundaries", fmt::format("names \"{}\" twice; expected it once", name));
    const Boundary& boundary = model.boundaries[static_cast<std::size_t>(index)];
    if (boundary.mesh.triangles.empty())
      t.fail(
          "boundaries",
          fmt::format("\"{}\" is a plane, which has no triangles; expected a box or a mesh", name));
    monitored.push_back({index, read_edge(t, boundary.mesh)});
  }
  if (monitored.empty()) t.fail("boundaries", "is missing; expected names of boundaries");
  return monitored;
}

EnergyBins read_energies(const TomlTable& t) {
  t.allow({"lowest", "decades", "per_decade"});
  EnergyBins classes;
  classes.lowest = t.quantity("lowest", dimension::energy, Sign::positive);
  classes.decades = t.integer("decades", 1, 8);
  classes.per_decade = t.integer("per_decade", 1, 5);
  return classes;
}

}  // namespace

void read_statistics(const TomlTable& root, Case& c) {
  Model& model = c.model;
  StatisticsOptions& options = model.statistics;
  if (!root.has("statistics")) return;
  const TomlTable t = root.required_table("statistics");
  t.allow({"merge_gap", "from_stage", "events", "compressive_loads", "boundary_maps",
           "particle_maps", "energy_spectrum"});
  options.merge_gap = t.quantity("merge_gap", dimension::time, Sign::non_negative, "0 s");
  c.statistics_stage = optional_stage(t, "from_stage", c.stages);
  options.deferred = c.statistics_stage >= 0;
  options.compressive_loads = t.boolean("compressive_loads", false);
  if (t.has("events")) {
    const TomlTable events = t.required_table("events");
    events.allow({"threshold"});
    options.events = true;
    options.threshold = events.quantity("threshold", dimension::force, Sign::non_negative);
  }
  if (t.has("boundary_maps")) {
    const TomlTable triangles = t.required_table("boundary_maps");
    triangles.allow(
        {"boundaries", "edge", "interval", "wear_coefficient", "hardness", "specific_wear_rate"});
    options.monitored = read_monitored(triangles, model);
    options.interval =
        triangles.optional_quantity("interval", dimension::time, Sign::positive).value_or(0);
    c.wear_rate = read_wear_rate(triangles);
  }
  if (t.has("particle_maps")) {
    const TomlTable surfaces = t.required_table("particle_maps");
    surfaces.allow({"edge"});
    for (const Shape& shape : model.shapes)
      options.surfaces.push_back(read_edge(surfaces, shape.mesh));
  }
  if (t.has("energy_spectrum"))
    options.energies = read_energies(t.required_table("energy_spectrum"));
}

}  // namespace firn
