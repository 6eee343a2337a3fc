// Properties of boundaries as text and JSON.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/output/response_output.h"
#include "experiments/case/case.h"
#include "firn/mesh_conflicts.h"

namespace firn {

struct BoundaryProperties {
  std::string name;
  std::string kind;  // as the case file calls it
  std::size_t triangles = 0, parts = 0;
  MeshConflicts conflicts;
  MeshDefects defects;                                          // none: a closed surface
  Vec3 lower = Vec3::Zero(), upper = Vec3::Zero();              // m, own axes
  Vec3 world_lower = Vec3::Zero(), world_upper = Vec3::Zero();  // m, where it is at the start
  std::optional<double> volume;                                 // m^3, of a closed one
  std::optional<double> mass;  // kg, when its material has a density, too
};

// `density` (kg/m^3): of its material; 0: not known.
BoundaryProperties boundary_properties(const Boundary& boundary, const std::string& kind,
                                       double density);

// In order of the model. A half-space has its kind alone.
std::vector<BoundaryProperties> boundary_properties(const Case& c);

// A paragraph, one fact a line.
std::string boundary_table(const BoundaryProperties& facts);
Json boundary_json(const BoundaryProperties& facts);

}  // namespace firn
