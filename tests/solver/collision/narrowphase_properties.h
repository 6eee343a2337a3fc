// What the narrow phase promises of one pair of parts, checked against the slow referee and libccd.
// Shared by the random tests and the fuzz target.
#pragma once

#include <ccd/ccd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "solver/collision/gjk.h"
#include "tests/solver/collision/brute_force_distance.h"

namespace firn::testing {

// The same part in another size.
inline ConvexPart scaled(ConvexPart part, double factor) {
  for (auto* coordinate : {&part.x, &part.y, &part.z}) {
    for (double& value : *coordinate) value *= factor;
  }
  for (auto& face : part.faces) face.offset *= factor;
  for (auto& edge : part.vertex_edges) edge.inverse_length /= factor;
  part.center *= factor;
  part.bounding_radius *= factor;
  part.radius *= factor;
  return part;
}

inline void ccd_support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* out) {
  const auto& vertices = static_cast<const InitialParticle*>(object)->vertices;
  const Vec3 d(direction->v[0], direction->v[1], direction->v[2]);
  const Vec3* best = &vertices[0];
  for (const Vec3& v : vertices) {
    if (d.dot(v) > d.dot(*best)) best = &v;
  }
  ccdVec3Set(out, best->x(), best->y(), best->z());
}

// libccd's word on placed vertices in units of `size`: its tolerances expect sizes about one.
inline bool ccd_overlap(InitialParticle a, InitialParticle b, double size) {
  for (Vec3& v : a.vertices) v /= size;
  for (Vec3& v : b.vertices) v /= size;
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = ccd.support2 = ccd_support;
  ccd.max_iterations = 200;
  return ccdGJKIntersect(&a, &b, &ccd) == 1;
}

struct CollideVerdict {
  double expected = 0, got = 0;  // m; negative: depth
  double size = 0;               // m, of the smaller part
  double near = 0;               // m, touching distance of the pair
  double reach = 0;              // m, largest length that enters: rounding comes in parts of this
  bool touching = false;
  bool ccd_agrees = true;   // on whether they overlap; it is wrong now and then
  double normal_error = 0;  // m: what the normal separates, against the distance
  double excess = 0;        // m: how much longer than the shortest the way out is
  std::string fault;        // empty: every promise is kept

  bool sound() const { return fault.empty(); }
  std::string sentence() const {
    return fault + "; expected " + std::to_string(expected / size) + ", got " +
           std::to_string(got / size) + " of the smaller part's radius";
  }
  void expect(bool kept, const char* promise) {
    if (!kept && fault.empty()) fault = promise;
  }
};

// Rounding of a few operations on numbers of the pair's size, and of a distance through a feature
// whose direction comes from differences of such numbers.
inline constexpr double kRounding = 1e-13;

inline void judge_manifold(const ConvexPart& a, const ConvexPart& b, const Pose& pose,
                           CollideVerdict& verdict) {
  // At most the shell that the solver uses for parts of this size; none where that is rounding.
  const double shell = 2e-3 * verdict.size, slack = kRounding * verdict.reach + verdict.near;
  GjkCache cache;
  Manifold m;
  for (const bool warm : {false, true}) {
    collide(a, b, pose, shell, cache, m);
    const double gap = verdict.got;
    const auto expect = [&](bool kept, const char* cold_promise, const char* warm_promise) {
      verdict.expect(kept, warm ? warm_promise : cold_promise);
    };
    expect(std::abs(m.normal.norm() - 1) < 1e-9, "a normal has unit length",
           "a normal has unit length, warm");
    if (m.gap >= shell) {
      expect(m.points.empty(), "apart means no points", "apart means no points, warm");
      expect(gap >= shell - slack && m.gap <= gap + slack && m.gap >= 0.8 * gap - slack,
             "a lower bound is within a fifth", "a lower bound is within a fifth, warm");
      continue;
    }
    expect(!m.points.empty(), "near means points", "near means points, warm");
    expect(std::abs(m.gap - gap) <= slack, "the gap is the distance",
           "the gap is the distance, warm");
    double nearest = std::numeric_limits<double>::infinity(), weight = 0;
    for (const ManifoldPoint& p : m.points) {
      expect(p.position.allFinite() && std::isfinite(p.gap), "points are finite",
             "points are finite, warm");
      expect(p.weight >= -1e-12 * verdict.reach * verdict.reach, "weights are not negative",
             "weights are not negative, warm");
      nearest = std::min(nearest, p.gap);
      weight += p.weight;
    }
    expect(nearest >= m.gap - slack - 1e-6 * shell && nearest <= m.gap + 0.3 * shell + slack,
           "the nearest point is at the gap", "the nearest point is at the gap, warm");
    expect(weight > 0 && weight <= m.area * (1 + 1e-9) + 1e-18, "weights add up to the area",
           "weights add up to the area, warm");
    expect(m.moments.trace() >= 0 && m.moments.allFinite(), "the second moment is not negative",
           "the second moment is not negative, warm");
  }
}

// Parts without sweep radius and seams.
inline CollideVerdict judge(const ConvexPart& a, const ConvexPart& b, const Pose& pose) {
  CollideVerdict v;
  v.size = std::min(a.bounding_radius, b.bounding_radius);
  if (v.size == 0) v.size = std::max(a.bounding_radius, b.bounding_radius);
  v.near = contact_tolerance(a, b);
  v.reach = a.bounding_radius + b.bounding_radius + a.center.norm() + b.center.norm() +
            pose.translation.norm();
  if (v.size == 0) v.size = v.reach;
  const InitialParticle pa = place(a, Pose{}), pb = place(b, pose);
  v.expected = referee(a, b, pose);
  GjkCache cold;
  CoreContact contact = core_contact(a, b, pose, std::numeric_limits<double>::infinity(), cold);
  v.touching = contact.distance <= v.near;
  if (v.touching) contact = penetration(a, b, pose);
  v.got = contact.distance;
  v.normal_error = std::abs(separation(pa, pb, contact.normal) - v.got);
  const double rounding = kRounding * v.reach;
  v.expect(std::isfinite(v.got) && contact.normal.allFinite() && contact.point_a.allFinite(),
           "every number is finite");
  v.expect(std::abs(contact.normal.norm() - 1) < 1e-9, "the normal has unit length");
  if (std::abs(v.expected - v.near) > rounding) {
    v.expect(v.touching == (v.expected <= v.near), "touching is touching");
  }
  if (!v.touching) {
    // Edges that are parallel but for 1e-11 hide the last turn of the direction in rounding: the
    // search ends a little early. A hundredth of an atom for grains.
    v.expect(std::abs(v.got - v.expected) <= 100 * rounding, "the distance is the referee's");
    // The direction is a difference of places over the distance, good to some 1e-15 of the reach
    // over it; turned by that, it moves supports by no more than the smaller part's size times the
    // same.
    v.expect(v.normal_error <= 100 * rounding + 2e-15 * v.reach * v.size / v.got,
             "the normal separates by the distance");
  } else {
    v.excess = v.expected - v.got;
    v.expect(v.normal_error <= rounding, "the depth is the way out along the normal");
    v.expect(v.excess >= -2 * v.near - rounding, "no way out is shorter than the least");
    double faces = std::numeric_limits<double>::infinity();
    for (const Vec3& n : pa.normals) faces = std::min(faces, -separation(pa, pb, n));
    for (const Vec3& n : pb.normals) faces = std::min(faces, -separation(pa, pb, -n));
    v.expect(-v.got <= faces + rounding, "no face leads out on a shorter way");
  }
  const double ccd_margin = 1e-4 * v.size + v.near + rounding;  // libccd's tolerance, and ours
  if (std::abs(v.expected) > ccd_margin && v.size > 1e-3 * v.reach) {
    v.ccd_agrees = ccd_overlap(pa, pb, v.size) == v.touching;
  }
  judge_manifold(a, b, pose, v);
  return v;
}

}  // namespace firn::testing
