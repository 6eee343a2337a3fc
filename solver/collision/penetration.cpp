// Depth of overlapping cores. libccd finds where to look; supports measure the depth exactly.
#include <ccd/ccd.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/collision/gjk.h"

namespace firn {
namespace {

// Two for each iteration, of which its distance query takes up to a hundred; few overlaps need more
// than fifty to expand.
constexpr int kMaxQuestions = 800;

// A core for libccd: in A's axes, lengths in units of the pair's size.
struct Placed {
  const ConvexPart* part;
  const Pose* pose;  // part -> A's axes
  double per_meter;
  int* questions;  // how often libccd may still ask
};

void ccd_support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* out) {
  const auto& o = *static_cast<const Placed*>(object);
  if (--*o.questions < 0) {
    // Its expansion has no iteration limit and may cycle on flat or parallel features. A support at
    // the origin says that nothing is left to expand: it ends with the best it has.
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

// How far B must move along n to leave A.
double width(const Pair& p, const Vec3& n) {
  const Vec3 m = p.b_in_a.rotation.transpose() * n;
  return support(p.a, n).height + support(p.b, -m).height - n.dot(p.b_in_a.translation);
}

bool ours(const Pair& p, const Vec3& n) {
  return !normal_exits_internal_face(p.a, n) &&
         !normal_exits_internal_face(p.b, -(p.b_in_a.rotation.transpose() * n));
}

void offer(const Pair& p, const Vec3& n, MinimumTranslation& best, MinimumTranslation& best_seam) {
  const double depth = width(p, n);
  if (depth < best.depth && ours(p, n)) best = {n, depth};
  if (depth < best_seam.depth) best_seam = {n, depth};
}

// A way out through this piece's own surface that is far longer than the one through a seam is no
// contact of this piece: the neighbor has the short one.
void leave_to_neighbor(const Pair& p, const MinimumTranslation& best_seam,
                       MinimumTranslation& best) {
  const double farther = 2 * (p.a.radius + p.b.radius);
  if (!std::isfinite(best.depth) || best.depth > best_seam.depth + farther) best = best_seam;
}

// Direction of libccd's expanding polytope; false when it finds no overlap or fails.
bool ccd_direction(const Pair& p, Vec3& n) {
  const Pose identity;
  const double per_meter = 1 / std::min(p.a.bounding_radius, p.b.bounding_radius);
  int questions = kMaxQuestions;
  const Placed a{&p.a, &identity, per_meter, &questions};
  const Placed b{&p.b, &p.b_in_a, per_meter, &questions};
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

// B moved out along the way and a little farther, and the contact found there.
CoreContact contact_outside(const Pair& p, const MinimumTranslation& translation,
                            double clearance) {
  Pose moved = p.b_in_a;
  moved.translation += (translation.depth + clearance) * translation.normal;
  GjkCache cold;
  return core_contact(p.a, p.b, moved, std::numeric_limits<double>::infinity(), cold);
}

// From just outside, the distance query sees the nearest way in: an ever shallower one until it is
// the one come by. This turns an approximate direction into an exact one.
template <class Allowed>
CoreContact refined(const Pair& p, MinimumTranslation best, const Allowed& allowed) {
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
    if ((common >> f & 1) && direction.dot(part.internal_normals[f]) > kSeamTilt) return true;
  }
  return false;
}

CoreContact penetration(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a) {
  const Pair p{a, b, b_in_a};
  MinimumTranslation best, best_seam;
  for (const ConvexPart::Face& f : a.faces) {
    if (!f.internal) offer(p, f.normal, best, best_seam);
  }
  for (const ConvexPart::Face& f : b.faces) {
    if (!f.internal) offer(p, -(b_in_a.rotation * f.normal), best, best_seam);
  }
  // Edge against edge. One point against a polyhedron needs none of it: faces are all there is.
  Vec3 n;
  if (a.vertex_count > 1 && b.vertex_count > 1 && ccd_direction(p, n)) offer(p, n, best, best_seam);
  leave_to_neighbor(p, best_seam, best);
  if (!std::isfinite(best.depth)) best = {Vec3::UnitZ(), width(p, Vec3::UnitZ())};

  return refined(p, best, [&](const Vec3& n) { return ours(p, n); });
}

CoreContact penetration_from(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a,
                             const Vec3& side) {
  constexpr double kCone =
      0.7;  // cosine: as far as a patch hands on its memory (patch_builder.cpp)
  const Pair p{a, b, b_in_a};
  MinimumTranslation best, best_seam;
  const auto offer_from = [&](const Vec3& n) {
    if (n.dot(side) > kCone) offer(p, n, best, best_seam);
  };
  for (const ConvexPart::Face& f : a.faces) {
    if (!f.internal) offer_from(f.normal);
  }
  for (const ConvexPart::Face& f : b.faces) {
    if (!f.internal) offer_from(-(b_in_a.rotation * f.normal));
  }
  offer_from(side);
  leave_to_neighbor(p, best_seam, best);
  return refined(p, best, [&](const Vec3& n) { return n.dot(side) > kCone && ours(p, n); });
}

}  // namespace firn
