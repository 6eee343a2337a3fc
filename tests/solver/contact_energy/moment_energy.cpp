#include "tests/solver/contact_energy/moment_energy.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace firn::contact_energy {

namespace {

// m. Points nearer to a plane than this are on it.
constexpr double kOnPlane = 1e-13;

struct Plane {
  Vec3 normal;  // unit, outward
  double offset = 0;
  double depth(const Vec3& x) const { return offset - normal.dot(x); }  // m, below the plane
};

// A face of an overlap: a part of a face of a or of b.
struct Facet {
  bool of_a = false;
  Vec3 normal;             // unit, outward
  std::vector<Vec3> loop;  // counter-clockwise seen from outside
};
using Polytope = std::vector<Facet>;

std::vector<Plane> planes_of(const Solid& s, const Pose& pose) {
  std::vector<Plane> out;
  for (const Solid::Face& f : s.faces) {
    const Vec3 n = pose.rotation * f.normal;
    out.push_back({n, f.offset + n.dot(pose.translation)});
  }
  return out;
}

Polytope placed(const Solid& s, const Pose& pose) {
  Polytope out;
  for (const Solid::Face& f : s.faces) {
    Facet facet{true, pose.rotation * f.normal, {}};
    for (const int v : f.loop) facet.loop.push_back(pose * s.vertices[v]);
    out.push_back(std::move(facet));
  }
  return out;
}

// Cuts away what is above the plane. The cut becomes a facet of a or of b.
void cut(Polytope& p, const Plane& plane, bool of_a) {
  const auto height = [&](const Vec3& x) {
    const double h = -plane.depth(x);
    return std::abs(h) < kOnPlane ? 0 : h;
  };
  bool any_above = false, any_below = false;
  for (const Facet& f : p) {
    for (const Vec3& x : f.loop) {
      any_above |= height(x) > 0;
      any_below |= height(x) < 0;
    }
  }
  if (!any_above) return;
  Polytope out;
  std::vector<Vec3> rim;
  for (Facet& f : p) {
    std::vector<Vec3> loop;
    for (std::size_t i = 0; i < f.loop.size(); ++i) {
      const Vec3 &from = f.loop[i], &to = f.loop[(i + 1) % f.loop.size()];
      const double first = height(from), last = height(to);
      if (first <= 0) loop.push_back(from);
      if (first == 0) rim.push_back(from);
      if (first * last < 0) {
        rim.push_back(from + first / (first - last) * (to - from));
        loop.push_back(rim.back());
      }
    }
    if (loop.size() >= 3) out.push_back({f.of_a, f.normal, std::move(loop)});
  }
  if (any_below && rim.size() >= 3) {
    Vec3 centre = Vec3::Zero();
    for (const Vec3& x : rim) centre += x / static_cast<double>(rim.size());
    const Vec3 u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
    std::ranges::sort(
        rim, {}, [&](const Vec3& x) { return std::atan2(v.dot(x - centre), u.dot(x - centre)); });
    out.push_back({of_a, plane.normal, std::move(rim)});
  }
  p = any_below && out.size() >= 4 ? std::move(out) : Polytope{};
}

// Integrals over a facet of powers of the depth u below a plane.
struct Sums {
  double power[4] = {0, 0, 0, 0};  // of u^k
  Vec3 first0 = Vec3::Zero();      // of x - origin
  Vec3 first2 = Vec3::Zero();      // of u^2 (x - origin)
};
Sums integrate(const Facet& f, const Plane& plane, const Vec3& origin) {
  Sums sums;
  for (std::size_t i = 1; i + 1 < f.loop.size(); ++i) {
    const Vec3 x[3] = {f.loop[0], f.loop[i], f.loop[i + 1]};
    const double area = 0.5 * f.normal.dot((x[1] - x[0]).cross(x[2] - x[0]));
    const double a = plane.depth(x[0]), b = plane.depth(x[1]), c = plane.depth(x[2]);
    const double h1 = a + b + c, squares = a * a + b * b + c * c;
    const double h2 = 0.5 * (squares + h1 * h1);
    sums.power[0] += area;
    sums.power[1] += area / 3 * h1;
    sums.power[2] += area / 6 * h2;
    sums.power[3] += area / 10 * (h1 * squares + a * b * c);
    for (const Vec3& y : x) {
      const double u = plane.depth(y);
      sums.first0 += area / 3 * (y - origin);
      sums.first2 += area / 30 * (h2 + u * (h1 + u)) * (y - origin);
    }
  }
  return sums;
}

// The negative gradient of a quantity that grows by `density` (u^0 or u^2) times the volume that
// the mover's surface gains.
Wrench surface_wrench(const std::vector<Polytope>& volume, bool mover_is_a, const Plane& plane,
                      bool by_square, const Vec3& origin_a, const Vec3& origin_b) {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();  // on the mover, about origin_b
  for (const Polytope& p : volume) {
    for (const Facet& f : p) {
      if (f.of_a != mover_is_a) continue;
      const Sums s = integrate(f, plane, origin_b);
      force -= (by_square ? s.power[2] : s.power[0]) * f.normal;
      moment -= (by_square ? s.first2 : s.first0).cross(f.normal);
    }
  }
  if (!mover_is_a) {
    force = -force;
    moment = -moment;
  }
  return {force, moment + (origin_b - origin_a).cross(force), -moment};
}

// The overlap of a solid of a with a solid of b.
struct Region {
  const PiecedSolid *a = nullptr, *b = nullptr;
  std::vector<Polytope> volume;  // disjoint
  double size = 0;               // m^3
  double moment = 0;             // J m^3: the integral of 3 K / 2 u^2
  double deepest = 0;            // m
  double weight = 1;
  Wrench by_size, by_moment;  // negative gradients
};

double size_of(const std::vector<Polytope>& volume, const Plane& plane) {
  double size = 0;
  for (const Polytope& p : volume) {
    for (const Facet& f : p)
      size -= plane.normal.dot(f.normal) * integrate(f, plane, Vec3::Zero()).power[1];
  }
  return size;
}

std::vector<Polytope> overlaps(const PiecedSolid& a, const Pose& pose_a, const PiecedSolid& b,
                               const Pose& pose_b) {
  std::vector<Polytope> out;
  const auto count = [](const PiecedSolid& s) { return std::max<std::size_t>(1, s.pieces.size()); };
  const auto piece = [](const PiecedSolid& s, std::size_t i) -> const Solid& {
    return s.pieces.empty() ? s.solid : s.pieces[i];
  };
  for (std::size_t i = 0; i < count(a); ++i) {
    for (std::size_t j = 0; j < count(b); ++j) {
      Polytope p = placed(piece(a, i), pose_a);
      for (const Plane& plane : planes_of(piece(b, j), pose_b)) {
        if (!p.empty()) cut(p, plane, false);
      }
      if (!p.empty()) out.push_back(std::move(p));
    }
  }
  return out;
}

// The face of either solid below which the second moment is least.
void find_base(double stiffness, const Pose& pose_a, const Pose& pose_b, Region& r) {
  double least = std::numeric_limits<double>::infinity();
  Plane base;
  bool base_of_a = false;
  for (const bool of_a : {false, true}) {
    for (const Plane& plane : planes_of((of_a ? r.a : r.b)->solid, of_a ? pose_a : pose_b)) {
      double sum = 0;
      for (const Polytope& p : r.volume) {
        for (const Facet& f : p)
          sum -= plane.normal.dot(f.normal) * integrate(f, plane, Vec3::Zero()).power[3] / 3;
      }
      if (sum >= least) continue;
      least = sum;
      base = plane;
      base_of_a = of_a;
    }
  }
  const double factor = 1.5 * stiffness;
  r.moment = factor * least;
  r.size = size_of(r.volume, base);
  r.by_moment.add(factor, surface_wrench(r.volume, !base_of_a, base, true, pose_a.translation,
                                         pose_b.translation));
  r.by_size = surface_wrench(r.volume, true, base, false, pose_a.translation, pose_b.translation);
  for (const Polytope& p : r.volume) {
    for (const Facet& f : p) {
      for (const Vec3& x : f.loop) r.deepest = std::max(r.deepest, base.depth(x));
    }
  }
}

// What two regions have in common.
struct Common {
  double size = 0;  // m^3
  Wrench by_size;
};
Common common(const Region& p, const Region& q, const Pose& pose_a, const Pose& pose_b) {
  std::vector<Polytope> volume = p.volume;
  const auto cut_all = [&](const Solid& s, const Pose& pose, bool of_a) {
    for (const Plane& plane : planes_of(s, pose)) {
      for (Polytope& v : volume) cut(v, plane, of_a);
    }
  };
  if (p.a != q.a) cut_all(q.a->solid, pose_a, true);
  if (p.b != q.b) cut_all(q.b->solid, pose_b, false);
  const Plane plane{Vec3::UnitZ(), 0};
  return {size_of(volume, plane),
          surface_wrench(volume, true, plane, false, pose_a.translation, pose_b.translation)};
}

}  // namespace

MomentContact moment_contact(double stiffness, const PiecedBody& a, const Pose& pose_a,
                             const PiecedBody& b, const Pose& pose_b) {
  std::vector<Region> regions;
  for (const PiecedSolid& s : a) {
    for (const PiecedSolid& t : b) {
      Region r;
      r.a = &s;
      r.b = &t;
      r.weight = s.weight * t.weight;
      r.volume = overlaps(s, pose_a, t, pose_b);
      if (r.volume.empty()) continue;
      find_base(stiffness, pose_a, pose_b, r);
      if (r.size > 0 && r.moment > 0) regions.push_back(std::move(r));
    }
  }
  MomentContact out;
  out.regions = static_cast<int>(regions.size());
  // W = sum_p a_p N_p / S_p,  S_p = sum_q a_q D_q D_pq / min(D_p, D_q)
  for (const Region& p : regions) {
    out.deepest = std::max(out.deepest, p.deepest);
    double sum = p.weight * p.size;
    Wrench by_sum;
    by_sum.add(p.weight, p.by_size);
    for (const Region& q : regions) {
      if (&p == &q) continue;
      const Common c = common(p, q, pose_a, pose_b);
      const double ratio = std::max(1.0, q.size / p.size);  // D_q / min(D_p, D_q)
      sum += q.weight * ratio * c.size;
      by_sum.add(q.weight * ratio, c.by_size);
      if (q.size > p.size) {
        by_sum.add(q.weight * c.size / p.size, q.by_size);
        by_sum.add(-q.weight * c.size * q.size / (p.size * p.size), p.by_size);
      }
    }
    const double energy = p.weight * p.moment / sum;
    out.energy += energy;
    out.wrench.add(p.weight / sum, p.by_moment);
    out.wrench.add(-energy / sum, by_sum);
  }
  return out;
}

}  // namespace firn::contact_energy
