#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "solver/collision/contact_region.h"
#include "solver/collision/corner_points.h"
#include "solver/collision/gjk.h"

namespace firn {
namespace {

using Feature = ContactFeature;

// The distinct vertices of one part that carry the contact.
struct SupportingFeatures {
  std::uint16_t vertex[3];
  int count = 0;

  // Places behind the last repeat one.
  explicit SupportingFeatures(std::uint16_t only) : vertex{only, only, only}, count(1) {}
  SupportingFeatures(const std::uint16_t* simplex, int simplex_count)
      : SupportingFeatures(simplex[0]) {
    for (int i = 1; i < simplex_count; ++i) {
      const bool is_new = !include(simplex[i]);
      vertex[is_new ? count : 0] = simplex[is_new ? i : 0];
      count += is_new;
    }
  }
  bool include(int i) const { return (vertex[0] == i) | (vertex[1] == i) | (vertex[2] == i); }
};

bool is_on_face(const ConvexPart& part, int vertex, std::uint16_t face) {
  const ConvexPart::VertexAdjacency& adjacent = part.adjacency[vertex];
  const auto first = part.vertex_faces.begin() + adjacent.first_face;
  return std::find(first, first + adjacent.face_count, face) != first + adjacent.face_count;
}

// Calls visit(index) for the surface faces that all carriers lie on, in ascending order.
template <class Visit>
void for_common_faces(const ConvexPart& part, const SupportingFeatures& carriers,
                      const Visit& visit) {
  if (!part.surface_faces.empty()) {
    std::uint64_t common = part.surface_faces[carriers.vertex[0]];
    common &= part.surface_faces[carriers.vertex[1]] & part.surface_faces[carriers.vertex[2]];
    for (; common != 0; common &= common - 1) visit(std::countr_zero(common));
    return;
  }
  const ConvexPart::VertexAdjacency& adjacent = part.adjacency[carriers.vertex[0]];
  for (std::uint32_t k = 0; k < adjacent.face_count; ++k) {
    const std::uint16_t index = part.vertex_faces[adjacent.first_face + k];
    bool common = !part.faces[index].internal;
    for (int i = 1; i < carriers.count; ++i)
      common = common && is_on_face(part, carriers.vertex[i], index);
    if (common) visit(index);
  }
}

// The edge of the carriers that drops least along n over the `reach` of the contact, if that is
// within `depth`: any edge of a lone carrier, or one between two of them.
void flattest_edge(const ConvexPart& part, const Vec3& n, const SupportingFeatures& carriers,
                   double depth, double reach, Feature& out) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  double least = kNever;
  int from = -1, to = -1;
  for (int c = 0; c < carriers.count; ++c) {
    const std::uint16_t near = carriers.vertex[c];
    const double height = n.dot(part.vertex(near));
    const ConvexPart::VertexEdge* edges =
        part.vertex_edges.data() + part.adjacency[near].first_edge;
    const bool alone = carriers.count == 1;
    for (std::uint32_t k = 0; k < part.adjacency[near].edge_count; ++k) {
      const std::uint16_t far = edges[k].vertex;
      const double drop = height - n.dot(part.vertex(far));
      const double over_reach = drop * std::min(1.0, reach * edges[k].inverse_length);
      const bool is_candidate = alone | ((far > near) & carriers.include(far));
      const double over = select(is_candidate & (over_reach <= depth), over_reach, kNever);
      from = select(over < least, near, from);
      to = select(over < least, far, to);
      least = std::min(over, least);
    }
  }
  if (from < 0) return;
  out.kind = Feature::Kind::edge;
  out.ends[0] = static_cast<std::uint16_t>(from);
  out.ends[1] = static_cast<std::uint16_t>(to);
}

// The feature of `part` that supports it along n (part axes): a face if it lies within `depth` of
// the support plane at three vertices, or over the whole `reach` of the contact; else such an edge.
Feature supporting_feature(const ConvexPart& part, const Vec3& n,
                           const SupportingFeatures& carriers, double depth, double reach) {
  constexpr double kLeastCosine = 0.9;
  Feature out;
  out.ends[0] = carriers.vertex[0];
  double best = kLeastCosine;
  int face = -1;
  for_common_faces(part, carriers, [&](int index) {
    const double cosine = n.dot(part.faces[index].normal);
    face = cosine > best ? index : face;
    best = cosine > best ? cosine : best;
  });
  if (face >= 0) {
    const ConvexPart::Face& f = part.faces[face];
    const double top = n.dot(part.vertex(carriers.vertex[0]));
    int near = 0;
    for (int i = 0; i < f.count; ++i)
      near += top - n.dot(part.vertex(part.face_vertices[f.first + i])) <= depth;
    if (near >= 3 || std::sqrt(std::max(0.0, 1 - best * best)) * reach <= depth) {
      out.kind = Feature::Kind::face;
      out.face = &f;
      return out;
    }
  }
  flattest_edge(part, n, carriers, depth, reach, out);
  return out;
}

// True when the contact belongs to the part beyond an internal face of this part: the normal
// (`outward`, part axes) points out through that face and the region lies entirely at it.
bool belongs_to_neighbor(const ProjectedPart& view, const SupportingFeatures& carriers,
                         const Vec3& outward, const ContactRegion& r,
                         double ClippedPoint::*height) {
  const ConvexPart& part = view.part;
  if (part.internal_normals.empty()) return false;
  std::uint64_t common = ~std::uint64_t{0};
  for (int i = 0; i < carriers.count; ++i) common &= part.internal_faces[carriers.vertex[i]];
  for (int f = 0; common != 0; ++f, common >>= 1) {
    if (!(common & 1)) continue;
    const Vec3& internal_face = part.internal_normals[f];
    if (outward.dot(internal_face) <= kInternalFaceTilt) continue;
    const double offset = internal_face.dot(part.vertex(carriers.vertex[0]));
    const bool reaches_back = std::any_of(r.points, r.points + r.count, [&](const ClippedPoint& p) {
      return internal_face.dot(view.body_point(p.at, p.*height)) < offset - kLeastExtent * r.size;
    });
    if (!reaches_back) return true;
  }
  return false;
}

void clear(Manifold& out) {
  out.points.clear();
  out.outline.clear();
  out.feature_a = out.feature_b = {};
  out.area = 0;
  out.moments.setZero();
  out.centroid.setZero();
}

// Depth below its support plane at which a feature still counts as touching: everything that
// overlaps or lies within the contact margin, plus a reserve so that features change before they
// are loaded.
double feature_depth(double gap, double contact_margin, double size) {
  return std::max(0.0, -gap) + 4 * contact_margin + kLeastExtent * size;
}

// The vertices of a feature. Where no region of it was found, those that carry the contact.
std::span<const std::uint16_t> vertices_of(const ConvexPart& part, const Feature& feature,
                                           bool found, const SupportingFeatures& carriers) {
  if (feature.face) return loop_of(part, *feature.face);
  if (found && feature.kind == Feature::Kind::edge) return feature.ends;
  return {carriers.vertex, static_cast<std::size_t>(carriers.count)};
}

// The manifold around the place where the cores meet; `out` is clear.
void fill(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a, double contact_margin,
          const CoreContact& contact, Manifold& out) {
  const double radii = a.radius + b.radius;
  out.gap = contact.distance - radii;
  out.normal = contact.normal;
  if (!(out.gap < contact_margin)) return;  // also rejects NaN

  const ContactBasis frame(contact.normal);
  const ProjectedPart view_a(a, frame), view_b(b, frame, b_in_a);
  const SupportingFeatures carriers_a(contact.simplex.a, contact.simplex.count);
  const SupportingFeatures carriers_b(contact.simplex.b, contact.simplex.count);
  const double size = characteristic_length(a, b),
               depth = feature_depth(out.gap, contact_margin, size);
  const double reach = 2 * size;
  const Feature on_a = supporting_feature(a, view_a.n, carriers_a, depth, reach);
  const Feature on_b = supporting_feature(b, -view_b.n, carriers_b, depth, reach);

  const int corners = (on_b.face ? a.vertex_count : 0) + (on_a.face ? b.vertex_count : 0);
  ContactRegion region(
      region_capacity(on_a.face ? on_a.face->count : 2, on_b.face ? on_b.face->count : 2) + corners,
      size);
  bool found = false;
  if (on_a.face && on_b.face) {
    found = clip_face_face(view_a, *on_a.face, view_b, *on_b.face, region);
  } else if (on_a.face && on_b.kind == Feature::Kind::edge) {
    found = clip_edge_face(view_b, on_b.ends, view_a, *on_a.face, false, region);
  } else if (on_b.face && on_a.kind == Feature::Kind::edge) {
    found = clip_edge_face(view_a, on_a.ends, view_b, *on_b.face, true, region);
  } else if (on_a.kind == Feature::Kind::edge && on_b.kind == Feature::Kind::edge) {
    // Swept edges d apart and y aside have opened by about y^2 / 2d.
    const double opening = 0.25 * contact_margin + kLeastExtent * size;
    const double aside =
        std::sqrt(2 * std::max(0.0, contact.distance) * opening) + kLeastExtent * size;
    found = clip_edge_edge(view_a, on_a.ends, view_b, on_b.ends, aside, region);
  }
  if (!found) {
    const double height = frame.n.dot(contact.point_a);
    region.count = 0;
    region.add(frame.flat(contact.point_a), height, height + contact.distance);
    const double radius = on_a.face   ? b.radius
                          : on_b.face ? a.radius
                                      : edge_radius(a.radius, b.radius);
    compute_point_weights(region, radius, radii);
  }
  if (belongs_to_neighbor(view_a, carriers_a, view_a.n, region, &ClippedPoint::height_a) ||
      belongs_to_neighbor(view_b, carriers_b, -view_b.n, region, &ClippedPoint::height_b)) {
    return;
  }
  const int own = region.count;
  if (on_b.face) {
    const auto is_over = [&](const PlanePoint& p, double) {
      return is_over_face(view_b, *on_b.face, true, p);
    };
    add_corners(view_a, true, vertices_of(a, on_a, found, carriers_a),
                {HeightGradient(view_b, *on_b.face), b.radius}, contact_margin, is_over, region);
  }
  if (on_a.face) {
    const auto is_over = [&](const PlanePoint& p, double) {
      return is_over_face(view_a, *on_a.face, false, p);
    };
    add_corners(view_b, false, vertices_of(b, on_b, found, carriers_b),
                {HeightGradient(view_a, *on_a.face), a.radius}, contact_margin, is_over, region);
  }
  const bool flat = found && on_a.face && on_b.face && region.count == own;
  emit_region(region, frame, a.radius, b.radius, contact_margin, flat, out);
  out.feature_a = on_a;
  out.feature_b = on_b;
}

}  // namespace

void emit_region(const ContactRegion& r, const ContactBasis& frame, double radius_a,
                 double radius_b, double contact_margin, bool flat, Manifold& out) {
  out.area = r.area;
  out.moments = frame.moments(r.moments);
  for (int i = 0; i < r.count; ++i) {
    const ClippedPoint& p = r.points[i];
    const double surface_a = p.height_a + radius_a, surface_b = p.height_b - radius_b;
    const Vec3 position = frame.point(p.at, 0.5 * (surface_a + surface_b));
    out.centroid += p.weight / r.area * position;
    if (flat) out.outline.push_back({position, surface_b - surface_a, p.weight});
    if (surface_b - surface_a >= contact_margin) continue;
    out.points.push_back({position, surface_b - surface_a, p.weight});
  }
}

void collide(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a, double contact_margin,
             GjkCache& cache, Manifold& out) {
  clear(out);
  const CoreContact contact = core_contact(a, b, b_in_a, contact_margin, cache);
  if (!contact.converged) {
    out.gap = contact.lower - (a.radius + b.radius);
    out.normal = contact.normal;
    return;
  }
  if (contact.distance <= contact_tolerance(a, b)) {
    fill(a, b, b_in_a, contact_margin, penetration(a, b, b_in_a), out);
  } else {
    fill(a, b, b_in_a, contact_margin, contact, out);
  }
}

void collide_with_side_hint(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a,
                            const Vec3& side, double contact_margin, Manifold& out) {
  clear(out);
  fill(a, b, b_in_a, contact_margin, penetration_from(a, b, b_in_a, side), out);
}

void collide_plane(const ConvexPart& a, const Vec3& n, double offset, double contact_margin,
                   Manifold& out) {
  clear(out);
  const ContactBasis frame(-n);
  const ProjectedPart view(a, frame);
  const std::uint16_t lowest = static_cast<std::uint16_t>(support(a, frame.n).vertex);
  out.normal = frame.n;
  out.gap = -offset - view.height(lowest) - a.radius;
  if (!(out.gap < contact_margin)) return;  // also rejects NaN

  const double depth = feature_depth(out.gap, contact_margin, a.bounding_radius);
  const Feature feature =
      supporting_feature(a, frame.n, SupportingFeatures(lowest), depth, 2 * a.bounding_radius);
  ContactRegion region(a.vertex_count, a.bounding_radius);
  const auto add = [&](int i) { region.add(view.flat(i), view.height(i), -offset); };
  const std::uint16_t* loop = feature.ends;
  int loop_count = 0;
  if (feature.face) {
    loop = &a.face_vertices[feature.face->first];
    loop_count = feature.face->count;
  } else if (feature.kind == Feature::Kind::edge &&
             (leaning_internal_faces(a, frame.n, feature.ends[0]) &
              leaning_internal_faces(a, frame.n, feature.ends[1])) == 0) {
    loop_count = 2;
  }
  for (int i = 0; i < loop_count; ++i) add(loop[i]);
  const bool flat = loop_count > 2;
  if (flat) compute_polygon_weights(region);
  if (loop_count == 2) compute_segment_weights(region, a.radius, a.radius);
  add_corners(
      view, true, {loop, static_cast<std::size_t>(loop_count)}, {HeightGradient(-offset), 0},
      contact_margin, [](const PlanePoint&, double) { return true; }, region);
  emit_region(region, frame, a.radius, 0, contact_margin, flat && region.count == loop_count, out);
  if (loop_count > 0) out.feature_a = feature;
}

}  // namespace firn
