#include "experiments/mesh_repair.h"

#include <admesh/stl.h>
#include <fmt/format.h>

#include <cmath>
#include <vector>

namespace firn {
namespace {

constexpr float kCrack = 1e-5F;  // of the mesh's diameter: corners so near are one
constexpr double kFlat = 1e-6;   // of the box's diagonal, cubed: no volume to speak of

// Owns what admesh allocates.
class Admesh {
 public:
  explicit Admesh(const TriangleMesh& mesh) {
    stl_initialize(&stl_);
    stl_.stats.type = inmemory;
    stl_.stats.number_of_facets = stl_.stats.original_num_facets =
        static_cast<int>(mesh.triangles.size());
    stl_allocate(&stl_);
    if (stl_get_error(&stl_)) throw InputError("admesh has no memory for this mesh");
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      stl_facet& facet = stl_.facet_start[i];
      facet = {};
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& p = mesh.vertices[static_cast<std::size_t>(mesh.triangles[i][k])];
        facet.vertex[k] = {static_cast<float>(p.x()), static_cast<float>(p.y()),
                           static_cast<float>(p.z())};
      }
      stl_facet_stats(&stl_, facet, i == 0 ? 1 : 0);
    }
    stl_get_size(&stl_);
  }
  Admesh(const Admesh&) = delete;
  Admesh& operator=(const Admesh&) = delete;
  ~Admesh() { stl_close(&stl_); }

  void check() { stl_check_facets_exact(&stl_); }
  // All that admesh does by itself, but for the distance of corners that it joins: its own, the
  // shortest edge, would pull coarse meshes together.
  void repair_all() {
    constexpr int kRounds = 2;
    const float crack = kCrack * stl_.stats.bounding_diameter;
    stl_repair(&stl_, 0, 1, 1, crack, 1, crack, 1, kRounds, 1, 1, 1, 1, 0, 0);
    if (stl_get_error(&stl_)) throw InputError("admesh cannot work on this mesh");
    stl_calculate_volume(&stl_);
    if (stl_.stats.volume >= 0) return;
    stl_reverse_all_facets(&stl_);
    stl_.stats.facets_reversed = stl_.stats.number_of_facets - stl_.stats.facets_reversed;
  }
  const stl_stats& stats() const { return stl_.stats; }
  TriangleMesh mesh() const {
    TriangleMesh result;
    for (int i = 0; i < stl_.stats.number_of_facets; ++i) {
      for (const stl_vertex& p : stl_.facet_start[i].vertex)
        result.vertices.emplace_back(p.x, p.y, p.z);
      result.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return result;
  }

 private:
  stl_file stl_{};
};

std::string facets(int count) { return fmt::format("{} facet{}", count, count == 1 ? "" : "s"); }

}  // namespace

MeshRepair repair(const TriangleMesh& mesh) {
  MeshRepair result;
  Admesh admesh(mesh);
  admesh.check();
  result.disconnected_edges = 3 * admesh.stats().number_of_facets - admesh.stats().connected_edges;
  // Nothing but facets without area was left.
  if (admesh.stats().number_of_facets > 0) admesh.repair_all();
  const stl_stats& stats = admesh.stats();
  result.degenerate = stats.degenerate_facets;
  result.joined = stats.edges_fixed;
  result.removed = stats.facets_removed - stats.degenerate_facets;
  result.added = stats.facets_added;
  result.reversed = stats.facets_reversed;
  result.parts = stats.number_of_parts;
  result.mesh = admesh.mesh();
  const auto [low, high] = bounding_box(result.mesh);
  constexpr double kSame = 5e-7;  // as corners of a file are merged
  if (!result.mesh.triangles.empty())
    result.mesh = weld(result.mesh, kSame * (high - low).maxCoeff());
  result.left = inspect(result.mesh);
  result.flat = result.mesh.triangles.empty() ||
                mass_properties(result.mesh).volume < kFlat * std::pow((high - low).norm(), 3);
  return result;
}

std::string MeshRepair::why_hopeless() const {
  if (!left.sound()) return left.sentence();
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
  if (steps.empty() && !hopeless()) return "nothing to repair";
  std::string text;
  for (const std::string& one : steps) text += (text.empty() ? "" : ", ") + one;
  if (text.empty()) text = "finds nothing that it could change";
  return text + (hopeless() ? "; hopeless: " + why_hopeless() : "; then it is closed");
}

}  // namespace firn
