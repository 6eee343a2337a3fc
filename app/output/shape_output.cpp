#include "app/output/shape_output.h"

#include <fmt/core.h>

#include <algorithm>

#include "experiments/text/number_text.h"
#include "experiments/text/vector_json.h"
namespace firn {
namespace {

Json quaternion_json(const Quat& q) { return {q.w(), q.x(), q.y(), q.z()}; }

std::string parts_text(std::size_t count) {
  return fmt::format("{} convex part{}", count, count == 1 ? "" : "s");
}

// m, over all parts.
double thinnest_part(const Shape& s) {
  double least = s.parts.empty() ? 0 : s.parts[0].thickness;
  for (const ConvexPart& part : s.parts) least = std::min(least, part.thickness);
  return least;
}

}  // namespace

std::string defects_text(const MeshDefects& defects, const MeshConflicts& conflicts) {
  const std::string first = defects.to_message(), second = conflicts.to_message();
  if (first.empty() && second.empty()) return "none";
  return first + (first.empty() || second.empty() ? "" : ", ") + second;
}

Json defects_json(const MeshDefects& d, const MeshConflicts& c) {
  return {{"open_edges", d.open_edges},
          {"nonmanifold_edges", d.nonmanifold_edges},
          {"flipped_edges", d.flipped_edges},
          {"degenerate", d.degenerate},
          {"duplicated", d.duplicated},
          {"inside_out", d.inside_out},
          {"non_finite", d.non_finite},
          {"intersections", c.intersections},
          {"overlapping_shells", c.overlapping_shells},
          {"nested_shells", c.nested_shells},
          {"inverted_shells", c.inverted_shells}};
}

std::string shape_line(const Shape& s) {
  return fmt::format("{}, {:.2f} g, {}, {} triangles, L = {:.2f} mm, K = {:.3g} N/m",
                     mm_text(s.box), s.mass * 1e3, parts_text(s.parts.size()),
                     s.mesh.triangles.size(), s.stiffness_length * 1e3, s.stiffness);
}

std::string shape_table(const Shape& s) {
  const auto row = [](const char* name, const std::string& text) {
    return fmt::format("  {:<22}{}\n", name, text);
  };
  std::string vertices;
  for (const ConvexPart& part : s.parts) {
    vertices += (vertices.empty() ? "" : ", ") + std::to_string(part.vertex_count);
  }
  const Eigen::AngleAxisd turn(s.shape_from_body);
  std::string table;
  table += row("triangles", std::to_string(s.mesh.triangles.size()));
  table += row("defects", defects_text(inspect(s.mesh), find_conflicts(s.mesh)));
  table += row("bounding box", mm_text(s.box));
  table += row("volume", volume_text(s.volume));
  table += row("mass", fmt::format("{:.6g} g", s.mass * 1e3));
  table += row("center of mass", fmt::format("{:.4f} {:.4f} {:.4f} mm", s.centroid.x() * 1e3,
                                             s.centroid.y() * 1e3, s.centroid.z() * 1e3));
  table += row("principal inertia", fmt::format("{:.6g} {:.6g} {:.6g} kg mm^2", s.inertia.x() * 1e6,
                                                s.inertia.y() * 1e6, s.inertia.z() * 1e6));
  table += row("principal axes", fmt::format("turned {:.3f} deg about ({:.4f}, {:.4f}, {:.4f})",
                                             turn.angle() * 180 / EIGEN_PI, turn.axis().x(),
                                             turn.axis().y(), turn.axis().z()));
  table += row("bounding radius", fmt::format("{:.3f} mm", s.bounding_radius * 1e3));
  table += row("convex parts", fmt::format("{}, vertices: {}", s.parts.size(), vertices));
  table += row("edge rounding", fmt::format("{:.4g} mm", s.rounding * 1e3));
  table += row("thinnest part", fmt::format("{:.4g} mm", thinnest_part(s) * 1e3));
  table +=
      row("contact deviation",
          fmt::format(
              "{} mm, {} % of the smallest edge: {}", number_text(s.surface_deviation * 1e3),
              number_text(100 * s.surface_deviation / s.box.minCoeff(), 3), s.deviation_reason));
  table += row("L", fmt::format("{:.3f} mm, middle edge of the bounding box unless given",
                                s.stiffness_length * 1e3));
  table += row("loading stiffness", fmt::format("{:.6g} N/m", s.stiffness));
  return table;
}

Json shape_json(const Shape& s) {
  Json parts = Json::array();
  for (const ConvexPart& part : s.parts) {
    parts.push_back({{"vertices", part.vertex_count}, {"faces", part.faces.size()}});
  }
  const auto [low, high] = bounding_box(s.mesh);
  return {{"name", s.name},
          {"triangles", s.mesh.triangles.size()},
          {"vertices", s.mesh.vertices.size()},
          {"defects", defects_json(inspect(s.mesh), find_conflicts(s.mesh))},
          {"watertight", inspect(s.mesh).is_valid()},
          {"bounding_box", {{"min", vector_json(low)}, {"max", vector_json(high)}}},
          {"box", vector_json(s.box)},
          {"volume", s.volume},
          {"mass", s.mass},
          {"centroid", vector_json(s.centroid)},
          {"inertia", vector_json(s.inertia)},
          {"shape_from_body", quaternion_json(s.shape_from_body)},
          {"bounding_radius", s.bounding_radius},
          {"convex_parts", parts},
          {"rounding", s.rounding},
          {"thinnest_part", thinnest_part(s)},
          {"surface_deviation", s.surface_deviation},
          {"deviation_relative", s.surface_deviation / s.box.minCoeff()},
          {"deviation_reason", s.deviation_reason},
          {"stiffness_length", s.stiffness_length},
          {"stiffness", s.stiffness}};
}

}  // namespace firn
