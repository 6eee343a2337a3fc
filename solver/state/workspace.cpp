#include "solver/state/workspace.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

namespace firn {

namespace {

constexpr double kThinnest = 0.2;  // of the thickness of a part, its largest rounding in a contact

PairCoefficients base_law(const Model& model, const Interaction& i, double stiffness,
                          double rounding, double box_edge) {
  PairCoefficients law;
  law.stiffness = stiffness;
  law.unloading_stiffness_ratio = 1 / (i.restitution * i.restitution);
  law.minimum_unloading_ratio = i.minimum_unloading_ratio;
  law.tangential_stiffness = i.tangential_stiffness_ratio * stiffness;
  law.static_friction = i.static_friction;
  law.dynamic_friction = i.dynamic_friction;
  law.restick_velocity = i.restick_velocity;
  law.contact_margin =
      std::min(model.numerics.contact_margin * rounding, model.numerics.contact_margin_limit);
  law.contact_update_distance = model.numerics.contact_update_fraction * law.contact_margin;
  law.merge_distance = 0.01 * rounding;
  law.match_distance = 2 * rounding;
  law.late_overlap = 0.01 * rounding;
  law.overlap_limit = model.numerics.overlap_limit * box_edge;
  law.adhesion_force = i.adhesion_force;
  law.adhesion_fraction = i.adhesion_stiffness_fraction;
  law.has_only_base_law =
      i.rolling_resistance == 0 && i.adhesion_force == 0 && i.adhesion_stiffness_fraction == 0;
  return law;
}

Aabb part_box(const ConvexPart& part) {
  Aabb box{part.vertex(0), part.vertex(0)};
  for (int i = 1; i < part.vertex_count; ++i) {
    box.lower = box.lower.cwiseMin(part.vertex(i));
    box.upper = box.upper.cwiseMax(part.vertex(i));
  }
  box.lower.array() -= part.radius;
  box.upper.array() += part.radius;
  return box;
}

double farthest_vertex(const std::vector<ConvexPart>& parts) {
  double r = 0;
  for (const ConvexPart& p : parts) {
    for (int i = 0; i < p.vertex_count; ++i) r = std::max(r, p.vertex(i).norm() + p.radius);
  }
  return r;
}

double thinnest_part(const std::vector<ConvexPart>& parts) {
  double t = std::numeric_limits<double>::infinity();
  for (const ConvexPart& p : parts) t = std::min(t, p.thickness);
  return t;
}

// The part with rounded edges and corners; one that is rounded more already stays as it is.
std::vector<ConvexPart> rounded(const std::vector<ConvexPart>& parts, double rounding) {
  std::vector<ConvexPart> out;
  for (const ConvexPart& part : parts) {
    if (part.radius >= rounding) {
      out.push_back(part);
      continue;
    }
    std::vector<HalfSpace> faces;
    for (const ConvexPart::Face& f : part.faces)
      faces.push_back({f.normal, f.offset + (f.internal ? 0 : part.radius), f.internal});
    out.push_back(convex_part(faces, std::min(rounding, kThinnest * part.thickness)));
  }
  return out;
}

BoundaryContactTable contact_table(const Model& model, const BoundaryContact& contact) {
  const Boundary& a = model.boundaries[static_cast<std::size_t>(contact.a)];
  const Boundary& b = model.boundaries[static_cast<std::size_t>(contact.b)];
  BoundaryContactTable table;
  table.parts_a = rounded(a.parts, contact.rounding);
  table.parts_b = rounded(b.parts, contact.rounding);
  table.surfaces_a = find_flat_surfaces(table.parts_a);
  table.surfaces_b = find_flat_surfaces(table.parts_b);
  table.connected.assign(a.parts.size(), ~std::uint64_t{0});
  table.reach_a = farthest_vertex(a.parts);
  double rounding = std::numeric_limits<double>::infinity();
  for (const auto* parts : {&table.parts_a, &table.parts_b})
    for (const ConvexPart& part : *parts) rounding = std::min(rounding, part.radius);
  // The side on which two parts have met is certain up to half of the thickness of both together.
  const double thick_b = b.parts.empty() ? 0 : thinnest_part(b.parts);
  table.law = base_law(model, contact.law, contact.stiffness, rounding, 0);
  table.law.overlap_limit = 0.25 * (thinnest_part(a.parts) + thick_b);
  const auto extents = [&](const std::vector<ConvexPart>& parts, bool is_a) {
    Aabb box = part_box(parts[0]);
    for (const ConvexPart& part : parts) {
      const Aabb one = part_box(part);
      box.lower = box.lower.cwiseMin(one.lower);
      box.upper = box.upper.cwiseMax(one.upper);
    }
    const double radius = 0.5 * (box.upper - box.lower).norm();
    if (!is_a && radius >= table.radius) return;
    table.smaller_is_a = is_a;
    table.center = 0.5 * (box.lower + box.upper);
    table.radius = radius;
  };
  extents(a.parts, true);
  if (!b.parts.empty()) extents(b.parts, false);
  return table;
}

}  // namespace

Workspace::Workspace(const Model& model, int threads_or_0)
    : threads(threads_or_0 > 0 ? threads_or_0 : model.numerics.threads),
      bonds(model),
      statistics(model) {
  mechanism_of.assign(model.frames.size(), -1);
  for (MechanismMembers& members : find_mechanisms(model.frames, model.couplings)) {
    for (const int f : members.frames)
      mechanism_of[static_cast<std::size_t>(f)] = static_cast<int>(mechanisms.size());
    mechanisms.emplace_back(model.frames, model.couplings, std::move(members));
  }
  shapes = static_cast<int>(model.shapes.size());
  columns = shapes + static_cast<int>(model.boundaries.size());
  laws.resize(static_cast<std::size_t>(shapes) * columns);
  double smallest_radius = std::numeric_limits<double>::infinity();
  for (int i = 0; i < shapes; ++i) {
    const Shape& a = model.shapes[i];
    rigid.push_back({a.mass, 1 / a.mass, a.inertia.cwiseInverse()});
    reach.push_back(a.bounding_radius);
    // Of boundaries alone: where two concave particles meet, the flattest of their contacts changes
    // from one pair of parts to another during an impact, and the energy would change with it.
    surfaces.emplace_back();
    thinnest.push_back(thinnest_part(a.parts));
    smallest_part.push_back(std::numeric_limits<double>::infinity());
    for (const ConvexPart& p : a.parts)
      smallest_part.back() = std::min(smallest_part.back(), p.bounding_radius);
    const double edge = a.box.minCoeff();
    smallest_radius = std::min(smallest_radius, a.bounding_radius);
    for (int j = 0; j < shapes; ++j) {
      const Shape& b = model.shapes[j];
      const Interaction& law = model.interaction(a.material, b.material);
      PairCoefficients& out = laws[law_index(i, j)];
      out = base_law(model, law, particle_pair_stiffness(a, b), std::min(a.rounding, b.rounding),
                     std::min(edge, b.box.minCoeff()));
      out.rolling_limit = law.rolling_resistance * std::min(a.stiffness_length, b.stiffness_length);
    }
    for (std::size_t j = 0; j < model.boundaries.size(); ++j) {
      const Boundary& b = model.boundaries[j];
      const Interaction& law = model.interaction(a.material, b.material);
      PairCoefficients& out = laws[law_index_boundary(i, static_cast<int>(j))];
      out = base_law(model, law, boundary_pair_stiffness(model, a, b), a.rounding, edge);
      out.rolling_limit = law.rolling_resistance * a.stiffness_length;
    }
  }
  least_overlap_limit = std::numeric_limits<double>::infinity();
  for (const PairCoefficients& law : laws)
    least_overlap_limit = std::min(least_overlap_limit, law.overlap_limit);
  skin = model.numerics.skin > 0 ? model.numerics.skin : 0.16 * smallest_radius;
  for (const Boundary& b : model.boundaries) {
    reach.push_back(farthest_vertex(b.parts));
    surfaces.push_back(find_flat_surfaces(b.parts));
    thinnest.push_back(thinnest_part(b.parts));
    if (b.kind == Boundary::Kind::solid) {
      std::vector<Aabb> boxes;
      for (const ConvexPart& p : b.parts) boxes.push_back(part_box(p));
      trees.emplace_back(AabbTree(std::move(boxes)));
    } else {
      trees.emplace_back(std::nullopt);
    }
  }
  for (const BoundaryContact& contact : model.boundary_contacts)
    boundary_contacts.push_back(contact_table(model, contact));
}

std::string name_of_body(const Model& model, int body) {
  const int n = static_cast<int>(model.particles.size());
  return body < n ? fmt::format("particle {}", body)
                  : fmt::format("boundary \"{}\"", model.boundaries[body - n].name);
}

}  // namespace firn
