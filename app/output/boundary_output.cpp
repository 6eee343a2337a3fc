#include "app/output/boundary_output.h"

#include <fmt/core.h>

#include <map>

#include "app/output/shape_output.h"
#include "experiments/text/toml_document.h"
#include "experiments/text/vector_json.h"
namespace firn {
namespace {

// The kinds that the case names; what an experiment has built is not in the file.
std::map<std::string, std::string> named_kinds(const Case& c) {
  TomlDocument document(c.resolved, c.source, TomlFormat::case_file, OldNames::accept);
  std::map<std::string, std::string> kinds;
  for (const TomlTable& t : TomlTable::root(document).tables("boundaries")) {
    kinds[t.string("name")] = t.string("kind");
  }
  return kinds;
}

TriangleMesh placed(const Boundary& b) {
  TriangleMesh mesh = b.mesh;
  for (Vec3& v : mesh.vertices) v = b.orientation * v + b.origin;
  return mesh;
}

std::string from_to(const Vec3& lower, const Vec3& upper) {
  std::string text;
  for (int k = 0; k < 3; ++k) {
    text += fmt::format("{}{} {:.2f} ... {:.2f}", k == 0 ? "" : ", ", "xyz"[k], 1e3 * lower[k],
                        1e3 * upper[k]);
  }
  return text + " mm";
}

// A wall may be open, or a closed one that faces inwards: a container.
std::string surface_text(const MeshDefects& defects) {
  if (defects.is_valid()) return "closed";
  MeshDefects others = defects;
  others.inside_out = false;
  if (others.is_valid()) return "closed, faces inwards: bodies are inside";
  others.inside_out = defects.inside_out && defects.open_edges == 0;
  others.open_edges = 0;
  const std::string open = defects.open_edges > 0
                               ? fmt::format("open, {} free edges", defects.open_edges)
                               : std::string("closed");
  return others.is_valid() ? open : open + ", " + others.to_message();
}

}  // namespace

BoundaryProperties boundary_properties(const Boundary& b, const std::string& kind, double density) {
  BoundaryProperties facts;
  facts.name = b.name;
  facts.kind = kind;
  facts.parts = b.parts.size();
  facts.triangles = b.mesh.triangles.size();
  if (facts.triangles == 0) return facts;
  facts.defects = inspect(b.mesh);
  facts.conflicts = find_conflicts(b.mesh);
  std::tie(facts.lower, facts.upper) = std::pair(bounding_box(b.mesh)[0], bounding_box(b.mesh)[1]);
  const auto [low, high] = bounding_box(placed(b));
  facts.world_lower = low;
  facts.world_upper = high;
  if (!facts.defects.is_valid()) return facts;
  facts.volume = mass_properties(b.mesh).volume;
  if (density > 0) facts.mass = density * *facts.volume;
  return facts;
}

std::vector<BoundaryProperties> boundary_properties(const Case& c) {
  const std::map<std::string, std::string> kinds = named_kinds(c);
  std::vector<BoundaryProperties> all;
  for (const Boundary& b : c.model.boundaries) {
    const auto kind = kinds.find(b.name);
    all.push_back(boundary_properties(b,
                                      kind != kinds.end()               ? kind->second
                                      : b.kind == Boundary::Kind::plane ? "plane"
                                                                        : "box",
                                      c.model.materials[b.material].density));
  }
  return all;
}

std::string boundary_table(const BoundaryProperties& facts) {
  const auto row = [](const char* name, const std::string& text) {
    return fmt::format("  {:<22}{}\n", name, text);
  };
  std::string table = row("kind", facts.kind);
  if (facts.triangles == 0) return table;
  table += row("triangles", std::to_string(facts.triangles));
  table += row("surface", surface_text(facts.defects));
  if (!facts.conflicts.none()) table += row("conflicts", facts.conflicts.to_message());
  table += row("bounding box", mm_text(facts.upper - facts.lower));
  table += row("at the start", from_to(facts.world_lower, facts.world_upper));
  table += row("convex parts", std::to_string(facts.parts));
  if (facts.volume) table += row("volume", volume_text(*facts.volume));
  if (facts.mass) table += row("mass", fmt::format("{:.6g} g", *facts.mass * 1e3));
  return table;
}

Json boundary_json(const BoundaryProperties& facts) {
  Json json = {{"name", facts.name}, {"kind", facts.kind}};
  if (facts.triangles == 0) return json;
  json["triangles"] = facts.triangles;
  json["convex_parts"] = facts.parts;
  json["closed"] = facts.defects.is_valid();
  json["defects"] = defects_json(facts.defects, facts.conflicts);
  json["bounding_box"] = {{"min", vector_json(facts.lower)}, {"max", vector_json(facts.upper)}};
  json["at_start"] = {{"min", vector_json(facts.world_lower)},
                      {"max", vector_json(facts.world_upper)}};
  if (facts.volume) json["volume"] = *facts.volume;
  if (facts.mass) json["mass"] = *facts.mass;
  return json;
}

}  // namespace firn
