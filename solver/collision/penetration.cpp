// Penetration of overlapping cores. libccd gives a direction; support functions then measure the
// depth along it exactly.
#include <ccd/ccd.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/collision/gjk.h"

namespace firn {
namespace {

// An iteration of libccd calls two supports. Its distance query takes up to a hundred iterations,
// and few overlaps need more than fifty to expand the polytope.
constexpr int kMaxSupportCalls = 800;

// A core for libccd: in A's axes, lengths in units of the pair's size.
struct Placed {
  const ConvexPart* part;
  const Pose* pose;  // part -> A's axes
  double per_meter;
  int* support_calls_left;  // calls that libccd may still make
};

void ccd_support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* out) {
  const auto& o = *static_cast<const Placed*>(object);
  if (--*o.support_calls_left < 0) {
    // The expansion of libccd has no iteration limit and may cycle on flat or parallel features. A
    // support at the origin lies inside the polytope, so libccd stops with its best result.
    ccdVec3Set(out, 0, 0, 0);
    return;
  }
  const Vec3 d(direction->v[0], direction->v[1], direction->v[2]);
  const Vec3 v =
      o.per_meter *
      (*o.pose * o.part->vertex(support(*o.part, o.pose->rotation.transpose() * d).vertex));
  ccdVec3Set(out, v.x(), v.y(), v.z());
}

struct Pair {
  const ConvexPart& a;
  const ConvexPart& b;
  const Pose& b_in_a;
};

struct MinimumTranslation {
  Vec3 normal = Vec3::UnitZ();  // A's axes, from A to B
  double depth = std::numeric_limits<double>::infinity();
};

// Distance that B must move along n to separate from A, m.
double width(const Pair& p, const Vec3& n) {
  const Vec3 m = p.b_in_a.rotation.transpose() * n;
  return support(p.a, n).height + support(p.b, -m).height - n.dot(p.b_in_a.translation);
}

bool is_own_contact(const Pair& p, const Vec3& n) {
  return !normal_exits_internal_face(p.a, n) &&
         !normal_exits_internal_face(p.b, -(p.b_in_a.rotation.transpose() * n));
}

void consider_direction(const Pair& p, const Vec3& n, MinimumTranslation& best,
                        MinimumTranslation& best_internal_face) {
  const double depth = width(p, n);
  if (depth < best.depth && is_own_contact(p, n)) best = {n, depth};
  if (depth < best_internal_face.depth) best_internal_face = {n, depth};
}

// Selects the direction through an internal face if the direction through the surface of this part
// is far longer. The contact then belongs to the adjacent part, which finds the short direction.
void yield_to_neighbor_part(const Pair& p, const MinimumTranslation& best_internal_face,
                            MinimumTranslation& best) {
  const double farther = 2 * (p.a.radius + p.b.radius);
  if (!std::isfinite(best.depth) || best.depth > best_internal_face.depth + farther)
    best = best_internal_face;
}

// Direction of libccd's expanding polytope; false when it finds no overlap or fails.
bool ccd_direction(const Pair& p, Vec3& n) {
  const Pose identity;
  const double per_meter = 1 / std::min(p.a.bounding_radius, p.b.bounding_radius);
  int support_calls_left = kMaxSupportCalls;
  const Placed a{&p.a, &identity, per_meter, &support_calls_left};
  const Placed b{&p.b, &p.b_in_a, per_meter, &support_calls_left};
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = ccd_support;
  ccd.support2 = ccd_support;
  ccd.max_iterations = 100;
  ccd.epa_tolerance = 1e-9;
  ccd_real_t depth = 0;
  ccd_vec3_t direction, position;
  if (ccdGJKPenetration(&a, &b, &ccd, &depth, &direction, &position) != 0) return false;
  n = Vec3(direction.v[0], direction.v[1], direction.v[2]);
  const double length = n.norm();
  if (!(length > 0.5)) return false;
  n /= length;
  return true;
}

// Contact after B was moved along the translation and by `clearance` (m) farther.
CoreContact contact_outside(const Pair& p, const MinimumTranslation& translation,
                            double clearance) {
  Pose moved = p.b_in_a;
  moved.translation += (translation.depth + clearance) * translation.normal;
  GjkCache cold;
  return core_contact(p.a, p.b, moved, std::numeric_limits<double>::infinity(), cold);
}

// Refines an approximate direction to a local minimum of the depth. B is moved just out of A, and
// the normal of the distance query there can be a direction with a smaller depth. This is repeated
// until the depth no longer decreases.
template <class Allowed>
CoreContact refined_contact(const Pair& p, MinimumTranslation best, const Allowed& allowed) {
  CoreContact contact;
  for (int i = 0; i < 8; ++i) {
    const double clearance = std::max(1e-3 * std::min(p.a.bounding_radius, p.b.bounding_radius),
                                      0.1 * std::abs(best.depth));
    contact = contact_outside(p, best, clearance);
    if (contact.distance <= contact_tolerance(p.a, p.b)) break;
    const MinimumTranslation nearer{contact.normal, width(p, contact.normal)};
    if (!(nearer.depth < best.depth - 1e-13 * characteristic_length(p.a, p.b)) ||
        !allowed(nearer.normal))
      break;
    best = nearer;
  }
  if (contact.simplex.count == 0 || contact.normal.dot(best.normal) < 1 - 1e-12) {
    const Vec3 in_b = -(p.b_in_a.rotation.transpose() * best.normal);
    contact.simplex.count = 1;
    contact.simplex.a[0] = static_cast<std::uint16_t>(support(p.a, best.normal).vertex);
    contact.simplex.b[0] = static_cast<std::uint16_t>(support(p.b, in_b).vertex);
    contact.point_a = p.a.vertex(contact.simplex.a[0]);
  }
  contact.normal = best.normal;
  contact.distance = -best.depth;
  return contact;
}

}  // namespace

bool normal_exits_internal_face(const ConvexPart& part, const Vec3& direction) {
  if (part.internal_normals.empty()) return false;
  const double top = support(part, direction).height;
  std::uint64_t common = ~std::uint64_t{0};
  for (int i = 0; i < part.vertex_count; ++i) {
    if (direction.dot(part.vertex(i)) > top - kContactTolerance * part.bounding_radius)
      common &= part.internal_faces[i];
  }
  for (std::size_t f = 0; f < part.internal_normals.size(); ++f) {
    if ((common >> f & 1) && direction.dot(part.internal_normals[f]) > kInternalFaceTilt)
      return true;
  }
  return false;
}

CoreContact penetration(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a) {
  const Pair p{a, b, b_in_a};
  MinimumTranslation best, best_internal_face;
  for (const ConvexPart::Face& f : a.faces) {
    if (!f.internal) consider_direction(p, f.normal, best, best_internal_face);
  }
  for (const ConvexPart::Face& f : b.faces) {
    if (!f.internal) consider_direction(p, -(b_in_a.rotation * f.normal), best, best_internal_face);
  }
  // Directions of two edges. If one part is a point, the minimum is always at a face normal.
  Vec3 n;
  if (a.vertex_count > 1 && b.vertex_count > 1 && ccd_direction(p, n))
    consider_direction(p, n, best, best_internal_face);
  yield_to_neighbor_part(p, best_internal_face, best);
  if (!std::isfinite(best.depth)) best = {Vec3::UnitZ(), width(p, Vec3::UnitZ())};

  return refined_contact(p, best, [&](const Vec3& n) { return is_own_contact(p, n); });
}

CoreContact penetration_from(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a,
                             const Vec3& side) {
  constexpr double kCone = 0.7;  // cosine, kSameHistory of patch_history.cpp
  const Pair p{a, b, b_in_a};
  MinimumTranslation best, best_internal_face;
  // Ignores directions outside the cone around `side`.
  const auto consider_direction_near_side = [&](const Vec3& n) {
    if (n.dot(side) > kCone) consider_direction(p, n, best, best_internal_face);
  };
  for (const ConvexPart::Face& f : a.faces) {
    if (!f.internal) consider_direction_near_side(f.normal);
  }
  for (const ConvexPart::Face& f : b.faces) {
    if (!f.internal) consider_direction_near_side(-(b_in_a.rotation * f.normal));
  }
  consider_direction_near_side(side);
  yield_to_neighbor_part(p, best_internal_face, best);
  return refined_contact(
      p, best, [&](const Vec3& n) { return n.dot(side) > kCone && is_own_contact(p, n); });
}

}  // namespace firn
