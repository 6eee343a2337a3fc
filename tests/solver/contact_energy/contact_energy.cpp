#include "tests/solver/contact_energy/contact_energy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "solver/convex_part.h"

namespace firn::contact_energy {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Solid angle of the spherical triangle of three unit vectors (van Oosterom and Strackee, 1983).
double solid_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  return 2 * std::atan2(std::abs(a.dot(b.cross(c))), 1 + a.dot(b) + b.dot(c) + c.dot(a));
}

// Gradient of that angle for a rotation of `a` alone: d angle = result . d phi.
Vec3 solid_angle_gradient(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double triple = a.dot(b.cross(c)), sum = 1 + a.dot(b) + b.dot(c) + c.dot(a);
  const double sign = triple < 0 ? -1 : 1;
  const Vec3 by_direction =
      2 * (sum * sign * b.cross(c) - sign * triple * (b + c)) / (triple * triple + sum * sum);
  return a.cross(by_direction);
}

double angle_at(const Solid& s, const std::vector<int>& loop, std::size_t i) {
  const Vec3& corner = s.vertices[loop[i]];
  const Vec3 to_last = s.vertices[loop[(i + loop.size() - 1) % loop.size()]] - corner;
  const Vec3 to_next = s.vertices[loop[(i + 1) % loop.size()]] - corner;
  return std::atan2(to_last.cross(to_next).norm(), to_last.dot(to_next));
}

double extent_of(const Solid& s) {
  double extent = 0;
  for (const Vec3& v : s.vertices) extent = std::max(extent, (v - s.vertices[0]).norm());
  return extent;
}

// The part of the line in which `cut` and `other` intersect that belongs to the solid without `f`.
std::optional<Solid::WedgeEdge> wedge_edge(const Solid& s, int f, int cut, int other,
                                           double extent) {
  const Solid::Face &a = s.faces[cut], &b = s.faces[other];
  Vec3 direction = a.normal.cross(b.normal);
  const double sine = direction.norm();
  if (sine < 1e-9) return std::nullopt;
  direction /= sine;
  const Vec3 origin =
      (a.offset * b.normal.cross(direction) - b.offset * a.normal.cross(direction)) /
      a.normal.dot(b.normal.cross(direction));
  Solid::WedgeEdge edge{origin, direction, -kInfinity, kInfinity, {cut, other}};
  for (int k = 0; k < static_cast<int>(s.faces.size()); ++k) {
    if (k == f || k == cut || k == other) continue;
    const double rise = s.faces[k].normal.dot(direction);
    const double room = s.faces[k].offset - s.faces[k].normal.dot(origin);
    if (std::abs(rise) < 1e-12) {
      if (room < -1e-12 * extent) return std::nullopt;
    } else if (rise > 0) {
      edge.upper = std::min(edge.upper, room / rise);
    } else {
      edge.lower = std::max(edge.lower, room / rise);
    }
  }
  if (!(edge.upper - edge.lower > 1e-9 * extent)) return std::nullopt;
  return edge;
}

// Solid angle of the cone of the normals that meet at a point of the solid without f.
double cone_at(const Solid& s, int f, const Vec3& at, double extent) {
  std::vector<Vec3> normals;
  Vec3 mean = Vec3::Zero();
  for (int k = 0; k < static_cast<int>(s.faces.size()); ++k) {
    if (k == f || std::abs(s.faces[k].normal.dot(at) - s.faces[k].offset) > 1e-7 * extent) continue;
    normals.push_back(s.faces[k].normal);
    mean += s.faces[k].normal;
  }
  mean.normalize();
  const Vec3 u = mean.unitOrthogonal(), v = mean.cross(u);
  std::ranges::sort(normals, {}, [&](const Vec3& n) { return std::atan2(v.dot(n), u.dot(n)); });
  double sum = 0;
  for (std::size_t k = 0; k < normals.size(); ++k)
    sum += solid_angle(mean, normals[k], normals[(k + 1) % normals.size()]);
  return sum;
}

void add_wedge(Solid& s, int f, double extent) {
  const int faces = static_cast<int>(s.faces.size());
  for (int a = 0; a < faces; ++a) {
    for (int b = a + 1; b < faces; ++b) {
      if (a == f || b == f) continue;
      if (const auto edge = wedge_edge(s, f, a, b, extent)) s.wedge_edges[f].push_back(*edge);
    }
  }
  for (const Solid::WedgeEdge& edge : s.wedge_edges[f]) {
    for (const double z : {edge.lower, edge.upper}) {
      if (!std::isfinite(z)) continue;
      const Vec3 at = edge.origin + z * edge.direction;
      const bool known = std::ranges::any_of(s.wedge_vertices[f], [&](const Solid::WedgeVertex& v) {
        return (v.position - at).norm() < 1e-7 * extent;
      });
      if (!known) s.wedge_vertices[f].push_back({at, cone_at(s, f, at, extent)});
    }
  }
}

}  // namespace

Solid make_solid(const std::vector<Vec3>& points) {
  const ConvexPart part = convex_part(convex_hull(points), 0);
  Solid s;
  for (int i = 0; i < part.vertex_count; ++i) s.vertices.push_back(part.vertex(i));
  for (const ConvexPart::Face& face : part.faces) {
    const auto first = part.loops.begin() + face.first;
    s.faces.push_back({face.normal, face.offset, {first, first + face.count}});
  }
  s.curvature.assign(s.vertices.size(), 2 * std::numbers::pi);
  const int faces = static_cast<int>(s.faces.size());
  for (int f = 0; f < faces; ++f) {
    const std::vector<int>& loop = s.faces[f].loop;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      s.curvature[loop[i]] -= angle_at(s, loop, i);
      const int from = loop[i], to = loop[(i + 1) % loop.size()];
      if (from > to) continue;
      for (int g = 0; g < faces; ++g) {
        const std::vector<int>& other = s.faces[g].loop;
        for (std::size_t j = 0; j < other.size(); ++j) {
          if (other[j] == to && other[(j + 1) % other.size()] == from)
            s.edges.push_back({{from, to}, {f, g}});
        }
      }
    }
  }
  s.wedge_edges.resize(s.faces.size());
  s.wedge_vertices.resize(s.faces.size());
  const double extent = extent_of(s);
  for (int f = 0; f < faces; ++f) add_wedge(s, f, extent);
  return s;
}

void Wrench::add(double factor, const Wrench& other) {
  force += factor * other.force;
  moment_a += factor * other.moment_a;
  moment_b += factor * other.moment_b;
}

namespace {

// A solid where it is, world axes.
struct Placed {
  const Solid& solid;
  Vec3 origin;
  std::vector<Vec3> vertices, normals;
  std::vector<double> offsets;

  Placed(const Solid& s, const Pose& pose) : solid(s), origin(pose.translation) {
    for (const Vec3& v : s.vertices) vertices.push_back(pose * v);
    for (const Solid::Face& f : s.faces) {
      normals.push_back(pose.rotation * f.normal);
      offsets.push_back(f.offset + normals.back().dot(origin));
    }
  }
  double height(int face, const Vec3& x) const { return normals[face].dot(x) - offsets[face]; }
};

// A vertex of (mover without nothing) cut by (base without the face): how deep it is below the
// face, and how depth and curvature change as the mover moves against the base.
struct Atom {
  double depth = 0;      // m
  double curvature = 0;  // solid angle
  Vec3 gradient;         // d depth = gradient . displacement of the mover at `place`
  Vec3 place;            // m, world
  Vec3 turning;          // d curvature = turning . rotation of the base against the mover, rad
};

// The vertices of the mover's solid cut by the half-spaces of all faces of the base but `face`.
std::vector<Atom> find_atoms(const Placed& base, const Pose& base_pose, int face,
                             const Placed& mover) {
  std::vector<Atom> atoms;
  const Vec3& n = base.normals[face];
  const int faces = static_cast<int>(base.normals.size());
  const auto inside = [&](const Vec3& x, int except) {
    for (int k = 0; k < faces; ++k) {
      if (k != face && k != except && base.height(k, x) > 0) return false;
    }
    return true;
  };
  const auto depth = [&](const Vec3& x) { return -base.height(face, x); };
  // Vertices of the mover.
  for (std::size_t i = 0; i < mover.vertices.size(); ++i) {
    const Vec3& x = mover.vertices[i];
    if (inside(x, face)) atoms.push_back({depth(x), mover.solid.curvature[i], -n, x, Vec3::Zero()});
  }
  // Edges of the mover with faces of the base.
  for (const Solid::Edge& e : mover.solid.edges) {
    const Vec3 &from = mover.vertices[e.vertex[0]], &to = mover.vertices[e.vertex[1]];
    for (int k = 0; k < faces; ++k) {
      if (k == face) continue;
      const double first = base.height(k, from), last = base.height(k, to);
      if ((first < 0) == (last < 0)) continue;
      const Vec3 x = from + first / (first - last) * (to - from);
      if (!inside(x, k)) continue;
      const Vec3 along = (to - from).normalized(), &wall = base.normals[k];
      const Vec3 &side0 = mover.normals[e.face[0]], &side1 = mover.normals[e.face[1]];
      atoms.push_back({depth(x), solid_angle(side0, side1, wall),
                       wall * (n.dot(along) / wall.dot(along)) - n, x,
                       solid_angle_gradient(wall, side0, side1)});
    }
  }
  // Faces of the mover with edges of what the base is without the face.
  for (const Solid::WedgeEdge& e : base.solid.wedge_edges[face]) {
    const Vec3 origin = base_pose * e.origin, along = base_pose.rotation * e.direction;
    for (std::size_t h = 0; h < mover.normals.size(); ++h) {
      const Vec3& side = mover.normals[h];
      const double rise = side.dot(along);
      if (std::abs(rise) < 1e-9) continue;
      const double z = -mover.height(static_cast<int>(h), origin) / rise;
      if (z < e.lower || z > e.upper) continue;
      const Vec3 x = origin + z * along;
      bool on_face = true;
      for (std::size_t k = 0; k < mover.normals.size() && on_face; ++k)
        on_face = k == h || mover.height(static_cast<int>(k), x) <= 0;
      if (!on_face) continue;
      const Vec3 &wall0 = base.normals[e.face[0]], &wall1 = base.normals[e.face[1]];
      atoms.push_back({depth(x), solid_angle(side, wall0, wall1), -side * (n.dot(along) / rise), x,
                       -solid_angle_gradient(side, wall0, wall1)});
    }
  }
  // Vertices of what the base is without the face.
  for (const Solid::WedgeVertex& v : base.solid.wedge_vertices[face]) {
    const Vec3 x = base_pose * v.position;
    bool covered = true;
    for (std::size_t k = 0; k < mover.normals.size() && covered; ++k)
      covered = mover.height(static_cast<int>(k), x) <= 0;
    if (covered) atoms.push_back({depth(x), v.curvature, Vec3::Zero(), x, Vec3::Zero()});
  }
  return atoms;
}

// The atoms of one face with their weights.
struct FaceContact {
  bool face_of_a = false;
  Vec3 normal;  // unit, from b to a
  double deepest = 0;
  double energy = 0;
  std::vector<Atom> atoms;
  std::vector<double> weight;  // [atoms] sum is 1
  Wrench wrench;
};

// Adds the wrench of an energy with the given derivatives by depth and by curvature of one atom.
void add_atom(const FaceContact& c, const Atom& atom, double by_depth, double by_curvature,
              const Vec3& origin_a, const Vec3& origin_b, Wrench& sum) {
  const double sign = c.face_of_a ? -1 : 1;  // a is the mover, or b
  const Vec3 force = -sign * by_depth * atom.gradient;
  const Vec3 couple = sign * by_curvature * atom.turning;
  sum.force += force;
  sum.moment_a += (atom.place - origin_a).cross(force) + couple;
  sum.moment_b -= (atom.place - origin_b).cross(force) + couple;
}

double elastic_energy(const Law& law, double depth) {
  return depth > 0 ? 0.5 * law.stiffness * depth * depth : 0;
}

// Contact below one face; nothing when the solids are apart.
std::optional<FaceContact> face_contact(const Law& law, const Placed& a, const Pose& pose_a,
                                        const Placed& b, const Pose& pose_b, bool face_of_a,
                                        int face) {
  FaceContact c;
  c.face_of_a = face_of_a;
  c.normal = face_of_a ? Vec3(-a.normals[face]) : b.normals[face];
  c.atoms = face_of_a ? find_atoms(a, pose_a, face, b) : find_atoms(b, pose_b, face, a);
  c.deepest = -kInfinity;
  for (const Atom& atom : c.atoms) c.deepest = std::max(c.deepest, atom.depth);
  if (!(c.deepest > 0)) return std::nullopt;
  double sum = 0;
  for (const Atom& atom : c.atoms) {
    c.weight.push_back(atom.curvature * std::exp((atom.depth - c.deepest) / law.smoothing));
    sum += c.weight.back();
  }
  if (!(sum > 0)) return std::nullopt;
  for (double& w : c.weight) w /= sum;
  for (std::size_t k = 0; k < c.atoms.size(); ++k)
    c.energy += c.weight[k] * elastic_energy(law, c.atoms[k].depth);
  for (std::size_t k = 0; k < c.atoms.size(); ++k) {
    const Atom& atom = c.atoms[k];
    const double excess = elastic_energy(law, atom.depth) - c.energy;
    add_atom(c, atom,
             c.weight[k] * (law.stiffness * std::max(0.0, atom.depth) + excess / law.smoothing),
             c.weight[k] / atom.curvature * excess, a.origin, b.origin, c.wrench);
  }
  return c;
}

// True when a face of one solid separates it from the other: quick, before anything is cut.
bool separated(const Placed& a, const Placed& b) {
  const auto splits = [](const Placed& base, const Placed& other) {
    for (int f = 0; f < static_cast<int>(base.normals.size()); ++f) {
      if (std::ranges::all_of(other.vertices, [&](const Vec3& v) { return base.height(f, v) > 0; }))
        return true;
    }
    return false;
  };
  return splits(a, b) || splits(b, a);
}

// Contacts below all faces of both solids; empty when the solids are apart.
std::vector<FaceContact> face_contacts(const Law& law, const Placed& a, const Pose& pose_a,
                                       const Placed& b, const Pose& pose_b) {
  std::vector<FaceContact> out;
  if (separated(a, b)) return out;
  for (const bool face_of_a : {false, true}) {
    const std::size_t faces = (face_of_a ? a : b).normals.size();
    for (std::size_t f = 0; f < faces; ++f) {
      auto c = face_contact(law, a, pose_a, b, pose_b, face_of_a, static_cast<int>(f));
      if (!c) return {};
      out.push_back(std::move(*c));
    }
  }
  return out;
}

// Two convex solids of two bodies.
struct Region {
  std::vector<FaceContact> contacts;
  const FaceContact* least = nullptr;  // of least energy
  Vec3 normal;                         // mean of those of nearly the least energy
  double normal_sum = 0;

  double share(const FaceContact& c) const {  // of a contact in the mean normal
    constexpr double kPower = 8;
    return std::pow(least->energy / c.energy, kPower);
  }
  explicit Region(std::vector<FaceContact> all) : contacts(std::move(all)) {
    least = &*std::ranges::min_element(contacts, {}, &FaceContact::energy);
    Vec3 sum = Vec3::Zero();
    for (const FaceContact& c : contacts) sum += share(c) * c.normal;
    normal_sum = sum.norm();
    normal = sum / normal_sum;
  }
  double energy() const { return least->energy; }
  // The gradient of h . normal, added to the sum as a wrench.
  void add_normal_gradient(const Vec3& h, Wrench& sum) const {
    constexpr double kPower = 8;
    const Vec3 across = (h - normal * normal.dot(h)) / normal_sum;
    for (const FaceContact& c : contacts) {
      const double part = share(c);
      if (part < 1e-9) continue;
      const double by_share = part * kPower * across.dot(c.normal);
      sum.add(by_share / energy(), least->wrench);
      sum.add(-by_share / c.energy, c.wrench);
      const Vec3 couple = -part * c.normal.cross(across);
      (c.face_of_a ? sum.moment_a : sum.moment_b) += couple;
    }
  }
};

}  // namespace

Contact elastic_contact(const Law& law, const Body& a, const Pose& pose_a, const Body& b,
                        const Pose& pose_b) {
  std::vector<Placed> placed_a, placed_b;
  for (const Solid& s : a) placed_a.emplace_back(s, pose_a);
  for (const Solid& s : b) placed_b.emplace_back(s, pose_b);
  std::vector<Region> regions;
  regions.reserve(a.size() * b.size());
  for (const Placed& p : placed_a) {
    for (const Placed& q : placed_b) {
      auto contacts = face_contacts(law, p, pose_a, q, pose_b);
      if (!contacts.empty()) regions.emplace_back(std::move(contacts));
    }
  }
  Contact out;
  const std::size_t n = regions.size();
  const auto coupling = [&](std::size_t p, std::size_t q) {
    if (p == q) return 1.0;
    return std::exp(-(1 - regions[p].normal.dot(regions[q].normal)) / law.coupling);
  };
  std::vector<double> sum(n, 0), part(n);
  for (std::size_t p = 0; p < n; ++p) {
    for (std::size_t q = 0; q < n; ++q) sum[p] += coupling(p, q) * regions[q].energy();
    part[p] = regions[p].energy() / sum[p];
    out.energy += part[p] * regions[p].energy();
    out.deepest = std::max(out.deepest, regions[p].least->deepest);
  }
  for (std::size_t p = 0; p < n; ++p) {
    double by_energy = 2 * part[p];
    Vec3 by_normal = Vec3::Zero();
    for (std::size_t q = 0; q < n; ++q) {
      const double c = coupling(p, q);
      by_energy -= c * part[q] * part[q];
      if (p == q) continue;
      const double by_coupling =
          -(part[p] * part[p] * regions[q].energy() + part[q] * part[q] * regions[p].energy());
      by_normal += by_coupling * c / law.coupling * regions[q].normal;
    }
    out.wrench.add(by_energy, regions[p].least->wrench);
    regions[p].add_normal_gradient(by_normal, out.wrench);
  }
  return out;
}

Contact hysteretic_contact(const Law& law, const Solid& a, const Pose& pose_a, const Solid& b,
                           const Pose& pose_b, const std::vector<Memory>& before,
                           const Vec3& velocity, const Vec3& spin, double dt) {
  const Placed placed_a(a, pose_a), placed_b(b, pose_b);
  auto contacts = face_contacts(law, placed_a, pose_a, placed_b, pose_b);
  Contact out;
  if (contacts.empty()) return out;
  const Region region(std::move(contacts));
  const FaceContact& c = *region.least;
  const double e2 = law.restitution * law.restitution, kappa = (1 - e2) / e2;
  const std::size_t n = c.atoms.size();
  std::vector<double> spring(n), energy(n);  // m, J
  for (std::size_t k = 0; k < n; ++k) {
    const Atom& atom = c.atoms[k];
    const Vec3 place = pose_a.rotation.transpose() * (atom.place - pose_a.translation);
    double slack = 0, nearest = kInfinity;
    for (const Memory& m : before) {
      const double distance = (m.place - place).norm();
      if (distance < nearest) slack = m.slack;
      nearest = std::min(nearest, distance);
    }
    const Vec3 motion = velocity + spin.cross(atom.place - pose_a.translation);
    const double approach = (c.face_of_a ? -1 : 1) * atom.gradient.dot(motion) * dt;
    const double depth = std::max(0.0, atom.depth);
    if (kappa > 0) slack = std::clamp(slack - approach, 0.0, (1 - law.floor) * depth / kappa);
    spring[k] = depth - kappa * slack;
    energy[k] = 0.5 * e2 * law.stiffness * spring[k] * spring[k];
    out.energy += c.weight[k] * energy[k];
    if (c.weight[k] > 1e-9) out.memory.push_back({place, slack});
  }
  for (std::size_t k = 0; k < n; ++k) {
    const double excess = energy[k] - out.energy;
    add_atom(c, c.atoms[k], c.weight[k] * (law.stiffness * spring[k] + excess / law.smoothing),
             c.weight[k] / c.atoms[k].curvature * excess, placed_a.origin, placed_b.origin,
             out.wrench);
  }
  out.deepest = c.deepest;
  return out;
}

}  // namespace firn::contact_energy
