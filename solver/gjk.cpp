#include "solver/gjk.h"

#include <cassert>
#include <cmath>
#include <limits>

#include "solver/vec.h"

namespace firn {
namespace {

constexpr int kMaxIterations = 128;
constexpr int kMaxStalls = 4;

inline Vec vertex(const ConvexPart& part, int i) { return {part.x[i], part.y[i], part.z[i]}; }

struct Placement {
  double r[9];  // row by row
  Vec t;

  explicit Placement(const Pose& pose)
      : t{pose.translation.x(), pose.translation.y(), pose.translation.z()} {
    for (int i = 0; i < 9; ++i) r[i] = pose.rotation(i / 3, i % 3);
  }
  Vec place(const Vec& p) const {
    return {r[0] * p.x + r[1] * p.y + r[2] * p.z + t.x, r[3] * p.x + r[4] * p.y + r[5] * p.z + t.y,
            r[6] * p.x + r[7] * p.y + r[8] * p.z + t.z};
  }
  Vec turn_back(const Vec& p) const {
    return {r[0] * p.x + r[3] * p.y + r[6] * p.z, r[1] * p.x + r[4] * p.y + r[7] * p.z,
            r[2] * p.x + r[5] * p.y + r[8] * p.z};
  }
};

// Corners of the Minkowski difference B - A and the two vertices that each comes from.
struct Simplex {
  Vec w[4];  // m
  std::uint16_t a[4], b[4];
  int count = 0;

  bool contains(int ia, int ib) const {
    for (int i = 0; i < count; ++i) {
      if (a[i] == ia && b[i] == ib) return true;
    }
    return false;
  }
  // Keeps the corners whose bits are set, in their order.
  void reduce(unsigned corners) {
    int kept = 0;
    for (int i = 0; i < count; ++i) {
      if (!(corners >> i & 1u)) continue;
      if (kept != i) {
        w[kept] = w[i];
        a[kept] = a[i];
        b[kept] = b[i];
      }
      ++kept;
    }
    count = kept;
  }
};

constexpr unsigned kInside = 15;

// The point of a simplex nearest to the origin and the fewest corners that carry it, as bits.
struct Nearest {
  Vec point;
  double squared;
  unsigned corners;
};

inline void keep_nearer(const Nearest& candidate, Nearest& best) {
  if (candidate.squared < best.squared) best = candidate;
}

inline Nearest nearest_on_segment(const Simplex& s, int i, int j) {
  const Vec p = s.w[i], q = s.w[j], e = q - p;
  const double along = -dot(p, e), length2 = square(e);
  if (along <= 0) return {p, square(p), 1u << i};
  if (along >= length2) return {q, square(q), 1u << j};
  const Vec point = p + (along / length2) * e;
  return {point, square(point), 1u << i | 1u << j};
}

// Barycentric coordinates of the origin's foot in the plane of a triangle, times normal^2.
struct Foot {
  Vec normal;
  double at[3];
  bool needle;

  Foot(const Vec& p, const Vec& q, const Vec& r) {
    const Vec pq = q - p, qr = r - q, rp = p - r;
    const double pq2 = square(pq), qr2 = square(qr), rp2 = square(rp);
    // The two shorter sides make the most exact normal.
    const double longest = std::max(std::max(pq2, qr2), rp2);
    normal = longest == pq2 ? cross(qr, rp) : longest == qr2 ? cross(rp, pq) : cross(pq, qr);
    // A needle has no usable plane (sine below 1e-10): one of its sides is as good.
    needle = square(normal) <= 1e-20 * longest * (pq2 + qr2 + rp2 - longest);
    at[0] = dot(normal, cross(q, r));
    at[1] = dot(normal, cross(r, p));
    at[2] = dot(normal, cross(p, q));
  }
};

Nearest nearest_on_triangle(const Simplex& s, int i, int j, int k) {
  const Foot foot(s.w[i], s.w[j], s.w[k]);
  if (!foot.needle && foot.at[0] > 0 && foot.at[1] > 0 && foot.at[2] > 0) {
    // Along the plane's normal: a direction good to rounding however short the distance.
    const double n2 = square(foot.normal), height = dot(foot.normal, s.w[i]);
    return {(height / n2) * foot.normal, height * height / n2, 1u << i | 1u << j | 1u << k};
  }
  // Only sides that face the foot can carry the nearest point.
  Nearest out{{0, 0, 0}, std::numeric_limits<double>::infinity(), 0};
  if (foot.needle || foot.at[0] <= 0) keep_nearer(nearest_on_segment(s, j, k), out);
  if (foot.needle || foot.at[1] <= 0) keep_nearer(nearest_on_segment(s, k, i), out);
  if (foot.needle || foot.at[2] <= 0) keep_nearer(nearest_on_segment(s, i, j), out);
  return out;
}

Nearest nearest_on_tetrahedron(const Simplex& s) {
  static constexpr int kFace[4][4] = {{0, 1, 2, 3}, {0, 3, 1, 2}, {0, 2, 3, 1}, {1, 3, 2, 0}};
  Nearest out{{0, 0, 0}, std::numeric_limits<double>::infinity(), kInside};
  for (const auto& f : kFace) {
    const Vec p = s.w[f[0]], q = s.w[f[1]] - p, r = s.w[f[2]] - p, up = s.w[f[3]] - p;
    const Vec n = cross(q, r);
    const double height = dot(n, up), depth = -dot(n, p);
    // Signs drowned in rounding say nothing. A flat tetrahedron has no inside: without this test
    // rounding can put the origin there.
    const double noise = 1e-28 * square(q) * square(r);
    const bool certain = height * height > noise * square(up) && depth * depth > noise * square(p);
    if (certain && (height > 0) == (depth > 0)) continue;  // the origin is on the inner side
    keep_nearer(nearest_on_triangle(s, f[0], f[1], f[2]), out);
  }
  return out;
}

Nearest nearest(const Simplex& s) {
  switch (s.count) {
    case 1:
      return {s.w[0], square(s.w[0]), 1};
    case 2:
      return nearest_on_segment(s, 0, 1);
    case 3:
      return nearest_on_triangle(s, 0, 1, 2);
    default:
      return nearest_on_tetrahedron(s);
  }
}

struct Query {
  const ConvexPart& a;
  const ConvexPart& b;
  const Placement b_in_a;
  Simplex s;

  void append(int ia, int ib) {
    s.w[s.count] = b_in_a.place(vertex(b, ib)) - vertex(a, ia);
    s.a[s.count] = static_cast<std::uint16_t>(ia);
    s.b[s.count] = static_cast<std::uint16_t>(ib);
    ++s.count;
  }
  void start(const GjkCache& cache) {
    for (int i = 0; i < cache.count; ++i) {
      assert(cache.a[i] < a.vertex_count && cache.b[i] < b.vertex_count);
      append(cache.a[i], cache.b[i]);
    }
    if (cache.count > 0) return;
    const Vec away = b_in_a.place({b.center.x(), b.center.y(), b.center.z()}) -
                     Vec{a.center.x(), a.center.y(), a.center.z()};
    const Vec back = b_in_a.turn_back(away);
    append(support(a, away.x, away.y, away.z).vertex, support(b, -back.x, -back.y, -back.z).vertex);
  }
  void store(GjkCache& cache) const {
    cache.count = static_cast<std::uint8_t>(s.count);
    for (int i = 0; i < s.count; ++i) {
      cache.a[i] = s.a[i];
      cache.b[i] = s.b[i];
    }
  }
  // A's nearest point: the mean of its vertices with the weights of the nearest point.
  Vec3 point_a() const {
    double weight[3] = {1, 0, 0};
    if (s.count == 2) {
      const Vec e = s.w[1] - s.w[0];
      weight[1] = -dot(s.w[0], e) / square(e);
      weight[0] = 1 - weight[1];
    } else if (s.count == 3) {
      const Foot foot(s.w[0], s.w[1], s.w[2]);
      for (int i = 0; i < 3; ++i) weight[i] = foot.at[i] / (foot.at[0] + foot.at[1] + foot.at[2]);
    }
    Vec3 out = Vec3::Zero();
    for (int i = 0; i < s.count; ++i) out += weight[i] * a.vertex(s.a[i]);
    return out;
  }
};

}  // namespace

CoreContact core_contact(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a, double shell,
                         GjkCache& cache) {
  const double radii = a.radius + b.radius, touching = touching_distance(a, b);
  Query query{a, b, Placement(b_in_a), {}};
  Simplex& s = query.s;
  query.start(cache);
  CoreContact out;
  Vec way{0, 0, 0};
  unsigned corners = 0;
  double previous = std::numeric_limits<double>::infinity();
  int stalls = 0;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Nearest near = nearest(s);
    if (near.corners == kInside || near.squared <= touching * touching) {
      query.store(cache);
      out.distance = 0;
      return out;
    }
    s.reduce(near.corners);
    corners = (1u << s.count) - 1;
    way = near.point;
    out.distance = std::sqrt(near.squared);
    // On nearly flat facets the direction can still turn while the distance has settled; but only
    // rounding is left once that goes on.
    stalls += out.distance >= previous;
    if (stalls > kMaxStalls) break;
    previous = out.distance;

    const Vec back = query.b_in_a.turn_back(way);
    const Support far_a = support(a, way.x, way.y, way.z);
    const Support far_b = support(b, -back.x, -back.y, -back.z);
    const double between = dot(way, query.b_in_a.t);
    const double bound = (between - far_a.height - far_b.height) / out.distance;
    const double noise = 1e-15 *
                         (std::abs(between) + std::abs(far_a.height) + std::abs(far_b.height)) /
                         out.distance;
    out.lower = std::max(out.lower, bound);
    if (out.distance - bound <= noise || s.contains(far_a.vertex, far_b.vertex)) break;
    query.append(far_a.vertex, far_b.vertex);
    if (out.lower - radii > shell && out.lower - radii >= 0.8 * (out.distance - radii)) {
      out.converged = false;
      break;
    }
  }
  out.normal = Vec3(way.x, way.y, way.z) / out.distance;
  if (out.converged) {
    s.reduce(corners);  // less a corner that came too late
    out.point_a = query.point_a();
  }
  query.store(cache);
  out.simplex = cache;
  return out;
}

double core_distance(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a,
                     GjkCache& cache) {
  return core_contact(a, b, b_in_a, std::numeric_limits<double>::infinity(), cache).distance;
}

}  // namespace firn
