#include "experiments/meshes/mesh_repair.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "experiments/meshes/mesh_file.h"
#include "experiments/meshes/mesh_program.h"

namespace firn {
namespace {

constexpr double kFlat = 1e-6;  // of the box's diagonal, cubed: no volume to speak of

std::string facets(int count) { return fmt::format("{} facet{}", count, count == 1 ? "" : "s"); }

}  // namespace

MeshRepair repair(const TriangleMesh& mesh) {
  MeshRepair result;
  if (mesh.triangles.empty()) {
    result.left = inspect(mesh);
    result.flat = true;
    return result;
  }
  const std::string bytes = run_mesh_program("firn-repair-mesh", facet_bytes<float>(mesh));
  std::array<std::int32_t, 7> counts;
  if (bytes.size() < sizeof(counts))
    throw RunError("firn-repair-mesh: an answer that is not whole");
  std::memcpy(counts.data(), bytes.data(), sizeof(counts));
  result.degenerate = counts[0];
  result.disconnected_edges = counts[1];
  result.joined = counts[2];
  result.removed = counts[3];
  result.added = counts[4];
  result.reversed = counts[5];
  result.parts = counts[6];
  result.mesh = mesh_of_facets<float>(std::string_view(bytes).substr(sizeof(counts)));
  const auto [low, high] = bounding_box(result.mesh);
  if (!result.mesh.triangles.empty()) result.mesh = merge_equal_corners(result.mesh);
  result.left = inspect(result.mesh);
  result.flat = result.mesh.triangles.empty() ||
                mass_properties(result.mesh).volume < kFlat * std::pow((high - low).norm(), 3);
  return result;
}

std::string repair_advice(const TriangleMesh& mesh, MeshUse use, const std::string& file,
                          const std::string& length_unit) {
  const MeshDefects found = inspect(mesh);
  const bool is_boundary = use == MeshUse::boundary;
  const bool hinders =
      is_boundary ? found.flipped_edges || found.degenerate || found.duplicated : !found.is_valid();
  if (!hinders || found.non_finite) return "";
  return fmt::format("; firn shape {}{} --repair-to FIXED.stl repairs what it can{}", file,
                     length_unit == "mm" ? "" : " --length-unit " + length_unit,
                     is_boundary ? ", and closes openings" : "");
}

std::string MeshRepair::failure_reason() const {
  if (!left.is_valid()) return left.to_message();
  return flat ? "it encloses no volume" : "";
}

std::string MeshRepair::sentence() const {
  std::vector<std::string> steps;
  const auto step = [&](int count, const std::string& text) {
    if (count > 0) steps.push_back(text);
  };
  step(degenerate, fmt::format("drops {} without area", facets(degenerate)));
  step(joined, fmt::format("joins {} edges", joined));
  step(removed, fmt::format("drops {} that touch nothing", facets(removed)));
  step(added, fmt::format("fills holes with {}", facets(added)));
  step(reversed, fmt::format("turns {} round", facets(reversed)));
  if (steps.empty() && is_repairable()) return "nothing to repair";
  std::string text;
  for (const std::string& one : steps) text += (text.empty() ? "" : ", ") + one;
  if (text.empty()) text = "finds nothing that it could change";
  return text +
         (is_repairable() ? "; then it is closed" : "; no repair is possible: " + failure_reason());
}

}  // namespace firn
