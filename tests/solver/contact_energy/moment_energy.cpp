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
        rim.emplace_back(from + first / (first - last) * (to - from));
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
  Plane base;
  bool base_of_a = false;
  Vec3 along;  // unit, of an edge of the base, world axes
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
  for (const bool of_a : {false, true}) {
    const Solid& solid = (of_a ? r.a : r.b)->solid;
    const Pose& pose = of_a ? pose_a : pose_b;
    const std::vector<Plane> planes = planes_of(solid, pose);
    for (std::size_t k = 0; k < planes.size(); ++k) {
      double sum = 0;
      for (const Polytope& p : r.volume) {
        for (const Facet& f : p)
          sum -=
              planes[k].normal.dot(f.normal) * integrate(f, planes[k], Vec3::Zero()).power[3] / 3;
      }
      if (sum >= least) continue;
      least = sum;
      r.base = planes[k];
      r.base_of_a = of_a;
      const std::vector<int>& loop = solid.faces[k].loop;
      r.along = (pose.rotation * (solid.vertices[loop[1]] - solid.vertices[loop[0]])).normalized();
    }
  }
  const double factor = 1.5 * stiffness;
  r.moment = factor * least;
  r.size = size_of(r.volume, r.base);
  r.by_moment.add(factor, surface_wrench(r.volume, !r.base_of_a, r.base, true, pose_a.translation,
                                         pose_b.translation));
  r.by_size = surface_wrench(r.volume, true, r.base, false, pose_a.translation, pose_b.translation);
  for (const Polytope& p : r.volume) {
    for (const Facet& f : p) {
      for (const Vec3& x : f.loop) r.deepest = std::max(r.deepest, r.base.depth(x));
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

namespace {

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;

// The surface of the mover in an overlap, projected onto the base plane. Seams cancel.
struct Footprint {
  Vec3 origin, u, v;  // axes in the base plane
  double area = 0;
  Vec2 center = Vec2::Zero();
  Mat2 second = Mat2::Zero();  // m^2, mean of d d^T, d from the center
  Vec2 slope = Vec2::Zero();   // of the plane that fits the depth best
  double depth = 0;            // m, at the center, of such a plane that supports the mover

  Vec2 at(const Vec3& x) const { return {u.dot(x - origin), v.dot(x - origin)}; }
  Vec3 point(const Vec2& y) const { return origin + y.x() * u + y.y() * v; }
};
Footprint footprint(const Region& r) {
  // Slopes beyond this (1) belong to edges and corners rather than to tilted faces.
  constexpr double kSteep = 0.1;
  Footprint out;
  const Vec3& n = r.base.normal;
  out.u = r.along;
  out.v = n.cross(r.along);
  out.origin = r.volume[0][0].loop[0];
  out.origin += r.base.depth(out.origin) * n;
  double depth = 0;
  Vec2 first = Vec2::Zero(), depth_first = Vec2::Zero();
  const auto for_mover = [&](const auto& visit) {
    for (const Polytope& p : r.volume) {
      for (const Facet& f : p) {
        if (f.of_a != r.base_of_a) visit(f);
      }
    }
  };
  for_mover([&](const Facet& f) {
    for (std::size_t i = 1; i + 1 < f.loop.size(); ++i) {
      const Vec3 x[3] = {f.loop[0], f.loop[i], f.loop[i + 1]};
      const double area = -0.5 * n.dot(f.normal) * f.normal.dot((x[1] - x[0]).cross(x[2] - x[0]));
      Vec2 sum = Vec2::Zero(), product = Vec2::Zero();
      Mat2 square = Mat2::Zero();
      double depths = 0;
      for (const Vec3& y : x) {
        const Vec2 q = out.at(y);
        sum += q;
        depths += r.base.depth(y);
        square += q * q.transpose();
        product += r.base.depth(y) * q;
      }
      out.area += area;
      depth += area / 3 * depths;
      first += area / 3 * sum;
      out.second += area / 12 * (sum * sum.transpose() + square);
      depth_first += area / 12 * (depths * sum + product);
    }
  });
  if (!(out.area > 0)) return out;
  out.center = first / out.area;
  out.second = out.second / out.area - out.center * out.center.transpose();
  const Vec2 covariance = depth_first / out.area - out.center * (depth / out.area);
  if (out.second.determinant() > 1e-14 * std::pow(out.second.trace(), 2))
    out.slope = out.second.inverse() * covariance;
  out.slope *= std::exp(-out.slope.squaredNorm() / (kSteep * kSteep));
  for_mover([&](const Facet& f) {
    for (const Vec3& x : f.loop)
      out.depth = std::max(out.depth, r.base.depth(x) - out.slope.dot(out.at(x) - out.center));
  });
  return out;
}

// The slack after a step, at four points with the second moments of the footprint, made linear
// again: points with more load count more.
MomentMemory advance(const Footprint& print, double kappa, const auto& before,
                     const auto& approach) {
  constexpr double kFloor = 0.001;
  const double root = std::sqrt(std::max(0.0, print.second.determinant()));
  const Mat2 reach =
      std::sqrt(3 / (print.second.trace() + 2 * root)) * (print.second + root * Mat2::Identity());
  Mat3 left = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (const double i : {-1.0, 1.0}) {
    for (const double j : {-1.0, 1.0}) {
      const Vec2 away = reach * Vec2(i, j);
      const Vec3 x = print.point(print.center + away);
      const double depth = print.depth + print.slope.dot(away);  // negative: not yet in contact
      const double most = (1 - kFloor) * depth / kappa;
      const double slack =
          std::clamp(before(x) - approach(x), std::min(0.0, most), std::max(0.0, most));
      const double load = std::max(0.0, depth / print.depth);
      const double weight = load * load + 1e-3;
      const Vec3 place(1, i, j);
      left += weight * place * place.transpose();
      right += weight * slack * place;
    }
  }
  const Vec3 fit = left.inverse() * right;
  MomentMemory out{true, print.point(print.center), Vec3::Zero(), fit.x()};
  if (std::abs(reach.determinant()) > 0) {
    const Vec2 gradient = reach.inverse() * fit.tail<2>();
    out.gradient = gradient.x() * print.u + gradient.y() * print.v;
  }
  return out;
}

}  // namespace

MomentContact hysteretic_moment_contact(double stiffness, double restitution, const PiecedSolid& a,
                                        const Pose& pose_a, const PiecedSolid& b,
                                        const Pose& pose_b, const MomentMemory& before,
                                        const Vec3& velocity, const Vec3& spin, double dt) {
  const double e2 = restitution * restitution, kappa = (1 - e2) / e2;
  MomentContact out;
  Region r;
  r.a = &a;
  r.b = &b;
  r.volume = overlaps(a, pose_a, b, pose_b);
  if (r.volume.empty()) return out;
  find_base(stiffness, pose_a, pose_b, r);
  const Footprint print = footprint(r);
  if (!(print.area > 0) || !(print.depth > 0)) return out;
  out.regions = 1;
  out.deepest = r.deepest;
  const double sign = r.base_of_a ? 1 : -1;
  const Mat3& turn = pose_b.rotation;
  MomentMemory memory = advance(
      print, kappa,
      [&](const Vec3& x) {
        const Vec3 local = turn.transpose() * (x - pose_b.translation);
        return before.is_set ? before.slack + before.gradient.dot(local - before.place) : 0;
      },
      [&](const Vec3& x) {
        return sign * dt * r.base.normal.dot(velocity + spin.cross(x - pose_a.translation));
      });
  // The base gives way by kappa times the slack.
  Plane plane{r.base.normal + kappa * memory.gradient,
              r.base.offset - kappa * (memory.slack - memory.gradient.dot(memory.place))};
  const double scale = plane.normal.norm();
  plane.normal /= scale;
  plane.offset /= scale;
  memory.place = turn.transpose() * (memory.place - pose_b.translation);
  memory.gradient = turn.transpose() * memory.gradient;
  out.memory = memory;
  for (Polytope& p : r.volume) cut(p, plane, r.base_of_a);
  const double size = size_of(r.volume, plane);
  if (!(size > 0)) return out;
  double moment = 0;
  for (const Polytope& p : r.volume) {
    for (const Facet& f : p)
      moment -= plane.normal.dot(f.normal) * integrate(f, plane, Vec3::Zero()).power[3] / 3;
  }
  const double factor = 1.5 * stiffness * scale * scale / size;
  out.energy = e2 * factor * moment;
  for (const bool by_square : {true, false}) {
    out.wrench.add(by_square ? factor : -factor * moment / size,
                   surface_wrench(r.volume, !r.base_of_a, plane, by_square, pose_a.translation,
                                  pose_b.translation));
  }
  return out;
}

}  // namespace firn::contact_energy
