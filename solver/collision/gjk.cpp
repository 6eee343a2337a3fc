#include "solver/collision/gjk.h"

#include <cassert>
#include <cmath>
#include <limits>

#include "solver/core/simd.h"

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
  Vec rotate_inverse(const Vec& p) const {
    return {r[0] * p.x + r[3] * p.y + r[6] * p.z, r[1] * p.x + r[4] * p.y + r[7] * p.z,
            r[2] * p.x + r[5] * p.y + r[8] * p.z};
  }
};

// Corners of the Minkowski difference B - A, side by side, and the two vertices that each comes
// from.
struct Simplex {
  alignas(32) double x[4], y[4], z[4];  // m
  std::uint16_t a[4], b[4];
  int count = 0;

  Vec corner(int i) const { return {x[i], y[i], z[i]}; }
  // Most often the last support is one of the corners, but which one is unpredictable.
  bool contains(int ia, int ib) const {
    bool found = false;
    for (int i = 0; i < count; ++i) found |= (a[i] == ia) & (b[i] == ib);
    return found;
  }
  // Keeps the corners whose bits are set, in their order.
  void reduce(unsigned corners) {
    if (corners == (1u << count) - 1) return;  // all of them, most often
    int kept = 0;
    for (int i = 0; i < count; ++i) {
      if (!(corners >> i & 1u)) continue;
      if (kept != i) {
        x[kept] = x[i];
        y[kept] = y[i];
        z[kept] = z[i];
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
  const Vec p = s.corner(i), q = s.corner(j), e = q - p;
  const double along = -dot(p, e), length2 = square(e);
  if (along <= 0) return {p, square(p), 1u << i};
  if (along >= length2) return {q, square(q), 1u << j};
  const Vec point = p + (along / length2) * e;
  return {point, square(point), 1u << i | 1u << j};
}

// Three vectors side by side; the fourth lanes are of no meaning.
struct Three {
  Simd4d x, y, z;
};
[[gnu::always_inline]] inline void next(const Three& v, Three& out) {
  out.x = __builtin_shufflevector(v.x, v.x, 1, 2, 0, 3);
  out.y = __builtin_shufflevector(v.y, v.y, 1, 2, 0, 3);
  out.z = __builtin_shufflevector(v.z, v.z, 1, 2, 0, 3);
}
[[gnu::always_inline]] inline void cross(const Three& a, const Three& b, Three& out) {
  out.x = a.y * b.z - a.z * b.y;
  out.y = a.z * b.x - a.x * b.z;
  out.z = a.x * b.y - a.y * b.x;
}

// Barycentric coordinates of the origin's foot in the plane of a triangle, times normal^2.
struct SimplexProjection {
  Vec normal;
  double at[4];
  bool needle;

  SimplexProjection() = default;
  SimplexProjection(const Simplex& s, int i, int j, int k)
      : SimplexProjection(Three{{s.x[i], s.x[j], s.x[k], s.x[k]},
                                {s.y[i], s.y[j], s.y[k], s.y[k]},
                                {s.z[i], s.z[j], s.z[k], s.z[k]}}) {}
  // p, q and r.
  [[gnu::always_inline]] explicit SimplexProjection(const Three& corners) {
    Three following, last, sides, following_sides, last_sides, crosses;
    next(corners, following);
    next(following, last);
    sides = {following.x - corners.x, following.y - corners.y, following.z - corners.z};
    double length2[4];
    put(sides.x * sides.x + sides.y * sides.y + sides.z * sides.z, length2);
    const double pq2 = length2[0], qr2 = length2[1], rp2 = length2[2];
    // The two shorter sides make the most exact normal.
    const double longest = std::max(std::max(pq2, qr2), rp2);
    const int opposite = (longest != pq2) << static_cast<int>(longest != qr2);
    next(sides, following_sides);
    next(following_sides, last_sides);
    cross(following_sides, last_sides, crosses);
    double normals[3][4];
    put(crosses.x, normals[0]);
    put(crosses.y, normals[1]);
    put(crosses.z, normals[2]);
    normal = {normals[0][opposite], normals[1][opposite], normals[2][opposite]};
    // A needle has no usable plane (sine below 1e-10): one of its sides is as good.
    needle = square(normal) <= 1e-20 * longest * (pq2 + qr2 + rp2 - longest);
    cross(following, last, crosses);
    put(normal.x * crosses.x + normal.y * crosses.y + normal.z * crosses.z, at);
  }
};

Nearest nearest_on_triangle(const Simplex& s, const SimplexProjection& foot, int i, int j, int k) {
  if (!foot.needle & (foot.at[0] > 0) & (foot.at[1] > 0) & (foot.at[2] > 0)) {
    // Along the plane's normal: a direction good to rounding however short the distance.
    const double n2 = square(foot.normal), height = dot(foot.normal, s.corner(i));
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
    const Vec p = s.corner(f[0]), q = s.corner(f[1]) - p, r = s.corner(f[2]) - p;
    const Vec up = s.corner(f[3]) - p;
    const Vec n = cross(q, r);
    const double height = dot(n, up), depth = -dot(n, p);
    // Signs below the rounding error are not used. A flat tetrahedron has no interior, but without
    // this test a rounding error could place the origin in it.
    const double noise = 1e-28 * square(q) * square(r);
    const bool certain = height * height > noise * square(up) && depth * depth > noise * square(p);
    if (certain && (height > 0) == (depth > 0)) continue;  // the origin is on the inner side
    keep_nearer(nearest_on_triangle(s, SimplexProjection(s, f[0], f[1], f[2]), f[0], f[1], f[2]),
                out);
  }
  return out;
}

// Of a simplex that is a triangle.
[[gnu::always_inline]] inline SimplexProjection project_on_simplex(const Simplex& s) {
  Three corners;
  get(s.x, corners.x);
  get(s.y, corners.y);
  get(s.z, corners.z);
  return SimplexProjection(corners);
}

Nearest nearest(const Simplex& s) {
  switch (s.count) {
    case 1:
      return {s.corner(0), square(s.corner(0)), 1};
    case 2:
      return nearest_on_segment(s, 0, 1);
    default:
      return nearest_on_tetrahedron(s);
  }
}

struct Query {
  const ConvexPart& a;
  const ConvexPart& b;
  const Placement b_in_a;
  Simplex s;  // not cleared: that would take as long as a support

  Query(const ConvexPart& part_a, const ConvexPart& part_b, const Pose& pose)
      : a(part_a), b(part_b), b_in_a(pose) {}
  void append(int ia, int ib) {
    const Vec w = b_in_a.place(vertex(b, ib)) - vertex(a, ia);
    s.x[s.count] = w.x;
    s.y[s.count] = w.y;
    s.z[s.count] = w.z;
    s.a[s.count] = static_cast<std::uint16_t>(ia);
    s.b[s.count] = static_cast<std::uint16_t>(ib);
    ++s.count;
  }
  // The corners of the last query, as append() would place them.
  void restore_simplex(const GjkCache& cache) {
    for (int i = 0; i < 4; ++i) {
      const int k = std::min<int>(i, cache.count - 1);
      assert(cache.a[k] < a.vertex_count && cache.b[k] < b.vertex_count);
      s.a[i] = cache.a[k];
      s.b[i] = cache.b[k];
    }
    const auto four = [](const std::vector<double>& all, const std::uint16_t* at, Simd4d& out) {
      out = Simd4d{all[at[0]], all[at[1]], all[at[2]], all[at[3]]};
    };
    Simd4d ax, ay, az, bx, by, bz;
    four(a.x, s.a, ax);
    four(a.y, s.a, ay);
    four(a.z, s.a, az);
    four(b.x, s.b, bx);
    four(b.y, s.b, by);
    four(b.z, s.b, bz);
    const double* const r = b_in_a.r;
    put(r[0] * bx + r[1] * by + r[2] * bz + b_in_a.t.x - ax, s.x);
    put(r[3] * bx + r[4] * by + r[5] * bz + b_in_a.t.y - ay, s.y);
    put(r[6] * bx + r[7] * by + r[8] * bz + b_in_a.t.z - az, s.z);
    s.count = cache.count;
  }
  void start(const GjkCache& cache) {
    if (cache.count > 0) {
      restore_simplex(cache);
      return;
    }
    const Vec away = b_in_a.place({b.center.x(), b.center.y(), b.center.z()}) -
                     Vec{a.center.x(), a.center.y(), a.center.z()};
    const Vec back = b_in_a.rotate_inverse(away);
    append(support(a, away.x, away.y, away.z).vertex, support(b, -back.x, -back.y, -back.z).vertex);
  }
  void store(GjkCache& cache) const {
    cache.count = static_cast<std::uint8_t>(s.count);
    for (int i = 0; i < s.count; ++i) {
      cache.a[i] = s.a[i];
      cache.b[i] = s.b[i];
    }
  }
  // A's nearest point: the mean of its vertices with the weights of the nearest point. `foot`: of
  // the corners, if there are three.
  Vec3 point_a(const SimplexProjection& foot) const {
    double weight[3] = {1, 0, 0};
    if (s.count == 2) {
      const Vec e = s.corner(1) - s.corner(0);
      weight[1] = -dot(s.corner(0), e) / square(e);
      weight[0] = 1 - weight[1];
    } else if (s.count == 3) {
      for (int i = 0; i < 3; ++i) weight[i] = foot.at[i] / (foot.at[0] + foot.at[1] + foot.at[2]);
    }
    Vec3 out = Vec3::Zero();
    for (int i = 0; i < s.count; ++i) out += weight[i] * a.vertex(s.a[i]);
    return out;
  }
};

}  // namespace

CoreContact core_contact(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a,
                         double contact_margin, GjkCache& cache) {
  const double radii = a.radius + b.radius, touching = contact_tolerance(a, b);
  Query query(a, b, b_in_a);
  Simplex& s = query.s;
  query.start(cache);
  CoreContact out;
  Vec separation{0, 0, 0};
  unsigned corners = 0;
  SimplexProjection foot;
  bool foot_is_known = false;  // of the vertices in the mask `corners`
  double previous = std::numeric_limits<double>::infinity();
  int stalls = 0;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const bool is_triangle = s.count == 3;
    if (is_triangle) foot = project_on_simplex(s);
    const Nearest near = is_triangle ? nearest_on_triangle(s, foot, 0, 1, 2) : nearest(s);
    if (near.corners == kInside || near.squared <= touching * touching) {
      query.store(cache);
      out.distance = 0;
      return out;
    }
    s.reduce(near.corners);
    foot_is_known = is_triangle && s.count == 3;
    corners = (1u << s.count) - 1;
    separation = near.point;
    out.distance = std::sqrt(near.squared);
    // On nearly flat facets the direction can still turn while the distance has settled; but after
    // several such iterations only rounding is left.
    stalls += out.distance >= previous;
    if (stalls > kMaxStalls) break;
    previous = out.distance;

    const Vec back = query.b_in_a.rotate_inverse(separation);
    const Support far_a = support(a, separation.x, separation.y, separation.z);
    const Support far_b = support(b, -back.x, -back.y, -back.z);
    const double between = dot(separation, query.b_in_a.t);
    const double bound = (between - far_a.height - far_b.height) / out.distance;
    const double noise = 1e-15 *
                         (std::abs(between) + std::abs(far_a.height) + std::abs(far_b.height)) /
                         out.distance;
    out.lower = std::max(out.lower, bound);
    if ((out.distance - bound <= noise) | s.contains(far_a.vertex, far_b.vertex)) break;
    query.append(far_a.vertex, far_b.vertex);
    if (out.lower - radii > contact_margin && out.lower - radii >= 0.8 * (out.distance - radii)) {
      out.converged = false;
      break;
    }
  }
  out.normal = Vec3(separation.x, separation.y, separation.z) / out.distance;
  if (out.converged) {
    s.reduce(corners);  // less a corner that came too late
    if (s.count == 3 && !foot_is_known) foot = project_on_simplex(s);
    out.point_a = query.point_a(foot);
  }
  query.store(cache);
  query.store(out.simplex);  // not copied: short writes are slow to read again as wide ones
  return out;
}

double core_distance(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a,
                     GjkCache& cache) {
  return core_contact(a, b, b_in_a, std::numeric_limits<double>::infinity(), cache).distance;
}

}  // namespace firn
