#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "solver/geometry/point_in_mesh.h"
#include "solver/shapes/shape_builder.h"

namespace firn {
namespace {

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double s = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  return (p - a - s * ab).norm();
}

// Of a point to a flat convex polygon, corners counter-clockwise about unit normal n.
template <typename Corner>
double distance_to_polygon(const Vec3& p, const Vec3& n, int count, const Corner& corner) {
  // The direction of an edge much shorter than the others is only rounding.
  constexpr double kNoEdge = 1e-4;
  double size2 = 0;
  for (int k = 1; k < count; ++k) size2 = std::max(size2, (corner(k) - corner(0)).squaredNorm());
  double nearest_edge = std::numeric_limits<double>::infinity();
  for (int k = 0; k < count; ++k) {
    const Vec3 a = corner(k), b = corner((k + 1) % count);
    if (count > 3 && (b - a).squaredNorm() < kNoEdge * kNoEdge * size2) continue;
    if (n.cross(b - a).dot(p - a) < 0) {
      nearest_edge = std::min(nearest_edge, distance_to_segment(p, a, b));
    }
  }
  return std::isfinite(nearest_edge) ? nearest_edge : std::abs(n.dot(p - corner(0)));
}

// Of a point to a swept part: negative inside, and then the depth below the nearest real surface
// face (cuts are no surface).
double signed_distance(const Vec3& p, const ConvexPart& part) {
  if (part.faces.empty()) return (p - part.vertex(0)).norm() - part.radius;
  double highest = -std::numeric_limits<double>::infinity(), surface = highest;
  for (const auto& face : part.faces) {
    const double height = face.normal.dot(p) - face.offset;
    highest = std::max(highest, height);
    if (!face.internal) surface = std::max(surface, height);
  }
  // A part may have several almost parallel faces, of which a point just above one may be far from
  // the polygon of that face but close to another one. Within the tolerance of merging, the point
  // counts as inside.
  if (highest <= 1e-6 * part.bounding_radius) return surface - part.radius;
  double distance = std::numeric_limits<double>::infinity();
  for (const auto& face : part.faces) {
    if (face.normal.dot(p) <= face.offset) continue;
    const auto corner = [&](int k) { return part.vertex(part.face_vertices[face.first + k]); };
    distance = std::min(distance, distance_to_polygon(p, face.normal, face.count, corner));
  }
  return distance - part.radius;
}

// The point of a flat convex polygon that is nearest to p, corners counter-clockwise about n.
template <typename Corner>
Vec3 nearest_on_polygon(const Vec3& p, const Vec3& n, int count, const Corner& corner) {
  Vec3 nearest = Vec3::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < count; ++k) {
    const Vec3 a = corner(k), ab = corner((k + 1) % count) - a;
    if (n.cross(ab).dot(p - a) >= 0) continue;
    const Vec3 q = a + std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) * ab;
    if ((p - q).squaredNorm() < least) {
      least = (p - q).squaredNorm();
      nearest = q;
    }
  }
  return std::isfinite(least) ? nearest : Vec3(p - n.dot(p - corner(0)) * n);
}

// Calls f(point) for points of a triangle, corners left out, no farther apart than `spacing`.
template <typename F>
void for_points(const Vec3& a, const Vec3& b, const Vec3& c, double spacing, const F& f) {
  const double longest =
      std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
  const int n = std::clamp(static_cast<int>(std::ceil(longest / spacing)), 1, 200);
  if (n == 1) return f((a + b + c) / 3);
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; i + j <= n; ++j) {
      if (i == n || j == n || i + j == 0) continue;  // a corner
      f(a + (static_cast<double>(i) / n) * (b - a) + (static_cast<double>(j) / n) * (c - a));
    }
  }
}

// Distances to a mesh, by a tree of boxes.
class MeshDistance {
 public:
  explicit MeshDistance(const TriangleMesh& mesh) {
    for (const auto& t : mesh.triangles) {
      Triangle triangle;
      for (int k = 0; k < 3; ++k) triangle.corner[k] = mesh.vertices[t[k]];
      const auto& c = triangle.corner;
      triangle.normal = (c[1] - c[0]).cross(c[2] - c[0]).normalized();
      triangles_.push_back(triangle);
    }
    if (!triangles_.empty()) build(0, triangles_.size());
  }

  double operator()(const Vec3& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    if (!nodes_.empty()) search(0, p, nearest);
    return nearest;
  }

  // Sum of the unit normals of the triangles within `reach` (m) of p.
  Vec3 normals_near(const Vec3& p, double reach) const {
    Vec3 sum = Vec3::Zero();
    std::vector<std::size_t> open;
    if (!nodes_.empty()) open.push_back(0);
    while (!open.empty()) {
      const std::size_t index = open.back();
      const Node& node = nodes_[index];
      open.pop_back();
      if (squared_gap(index, p) > reach * reach) continue;
      if (node.right != 0) {
        open.insert(open.end(), {node.right, index + 1});
        continue;
      }
      for (std::size_t i = node.first; i < node.last; ++i) {
        const Triangle& t = triangles_[i];
        const auto corner = [&t](int k) { return t.corner[k]; };
        if (distance_to_polygon(p, t.normal, 3, corner) <= reach) sum += t.normal;
      }
    }
    return sum;
  }

 private:
  struct Triangle {
    Vec3 corner[3], normal;
  };
  struct Node {
    Vec3 low, high;
    std::size_t first = 0, last = 0;  // triangles
    std::size_t right = 0;            // second child; the first one follows the node. 0: a leaf
  };

  std::size_t build(std::size_t first, std::size_t last) {
    constexpr std::size_t kLeaf = 4;
    Node node;
    node.low = node.high = triangles_[first].corner[0];
    for (std::size_t i = first; i < last; ++i) {
      for (const Vec3& c : triangles_[i].corner) {
        node.low = node.low.cwiseMin(c);
        node.high = node.high.cwiseMax(c);
      }
    }
    node.first = first;
    node.last = last;
    const std::size_t index = nodes_.size();
    nodes_.push_back(node);
    if (last - first <= kLeaf) return index;
    int axis = 0;
    (node.high - node.low).maxCoeff(&axis);
    const auto at = [this](std::size_t i) { return triangles_.begin() + static_cast<long>(i); };
    const std::size_t middle = (first + last) / 2;
    std::nth_element(at(first), at(middle), at(last), [axis](const auto& a, const auto& b) {
      return a.corner[0](axis) + a.corner[1](axis) + a.corner[2](axis) <
             b.corner[0](axis) + b.corner[1](axis) + b.corner[2](axis);
    });
    build(first, middle);
    nodes_[index].right = build(middle, last);
    return index;
  }

  double squared_gap(std::size_t node, const Vec3& p) const {
    const Node& n = nodes_[node];
    return (p - p.cwiseMax(n.low).cwiseMin(n.high)).squaredNorm();
  }

  void search(std::size_t index, const Vec3& p, double& nearest) const {
    const Node& node = nodes_[index];
    if (squared_gap(index, p) >= nearest * nearest) return;
    if (node.right == 0) {
      for (std::size_t i = node.first; i < node.last; ++i) {
        const Triangle& t = triangles_[i];
        nearest = std::min(nearest,
                           distance_to_polygon(p, t.normal, 3, [&](int k) { return t.corner[k]; }));
      }
      return;
    }
    const bool left_first = squared_gap(index + 1, p) <= squared_gap(node.right, p);
    search(left_first ? index + 1 : node.right, p, nearest);
    search(left_first ? node.right : index + 1, p, nearest);
  }

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

// Of points in one cell of a lattice, the first.
class Thinning {
 public:
  explicit Thinning(double cell) : cell_(cell) {}
  bool fresh(const Vec3& p) {
    const Vec3 at = (p / cell_).array().floor();
    return cells_.insert({at.x(), at.y(), at.z()}).second;
  }

 private:
  double cell_;
  std::set<std::array<double, 3>> cells_;
};

// Distance to the nearest part, below zero within one.
double height_above(const std::vector<ConvexPart>& parts, const Vec3& p) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& part : parts) {
    const double gap = (p - part.center).norm() - part.bounding_radius;
    if (gap >= lowest || (lowest <= 0 && gap > 0)) continue;
    lowest = std::min(lowest, signed_distance(p, part));
  }
  return lowest;
}

// The outer surface of the union of swept parts. Voids within the body, where the edges of covered
// faces are round, do not count.
class Union {
 public:
  Union(const std::vector<ConvexPart>& parts, const TriangleMesh& mesh, double spacing)
      : parts_(parts), interior_(mesh), to_mesh_(mesh) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const ConvexPart& part = parts[i];
      Thinning thinning(0.25 * spacing);
      if (part.faces.empty()) add_sphere(i);
      for (const auto& face : part.faces) {
        if (face.internal) continue;
        const auto corner = [&](int k) {
          return Vec3(part.vertex(part.face_vertices[face.first + k]) + part.radius * face.normal);
        };
        const auto add = [&](const Vec3& p) {
          if (thinning.fresh(p) && exposed(p, i)) points_.push_back(p);
        };
        for (int k = 0; k < face.count; ++k) add(corner(k));
        for (int k = 1; k + 1 < face.count; ++k) {
          for_points(corner(0), corner(k), corner(k + 1), spacing, add);
        }
      }
    }
  }

  // How far the surface stands out of the mesh at most.
  double highest() const {
    double most = 0;
    for (const Vec3& p : points_) {
      const double distance = to_mesh_(p);
      if (distance > most && !interior_.contains(p)) most = distance;
    }
    return most;
  }

  // Upper bound of the distance of a point in the union from the surface of the union.
  double depth(const Vec3& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    // The rounded edges of internal faces belong to no face, but protrude at concave edges.
    const Vec3 outward = to_mesh_.normals_near(p, 0.5 * parts_[0].radius);
    if (outward.norm() > 0.1) nearest = way_out(p, outward.normalized(), 0);
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const ConvexPart& part = parts_[i];
      if ((p - part.center).norm() - part.bounding_radius >= nearest) continue;
      if (part.faces.empty() && p != part.center) {
        const Vec3 q = part.center + part.radius * (p - part.center).normalized();
        if ((p - q).norm() < nearest && exposed(q, i)) nearest = (p - q).norm();
      }
      for (const auto& face : part.faces) {
        if (face.internal) continue;
        if (std::abs(face.normal.dot(p) - face.offset - part.radius) >= nearest) continue;
        const Vec3 q = nearest_on_polygon(p, face.normal, face.count, [&](int k) {
          return Vec3(part.vertex(part.face_vertices[face.first + k]) + part.radius * face.normal);
        });
        const double distance = (p - q).norm();
        if (distance >= nearest) continue;
        if (exposed(q, i)) {
          nearest = distance;
        } else if (distance > 0) {
          nearest = std::min(nearest, way_out(p, (q - p) / distance, distance));
        }
      }
    }
    // If the nearest point of a face is covered, another point of that face may be exposed.
    double squared = nearest * nearest;
    for (const Vec3& q : points_) squared = std::min(squared, (p - q).squaredNorm());
    return std::sqrt(squared);
  }

 private:
  // Distance along a unit direction to the first point at or beyond `from` that is in no part.
  double way_out(const Vec3& p, const Vec3& direction, double from) const {
    double reached = from;
    for (std::size_t tries = 0; tries <= 2 * parts_.size(); ++tries) {
      const Vec3 q = p + reached * direction;
      const auto cover = std::find_if(parts_.begin(), parts_.end(), [&q](const ConvexPart& part) {
        return (q - part.center).squaredNorm() < part.bounding_radius * part.bounding_radius &&
               signed_distance(q, part) < -1e-6 * part.bounding_radius;
      });
      if (cover == parts_.end()) {
        const bool in_void = to_mesh_(q) > 2 * parts_[0].radius && interior_.contains(q);
        return in_void ? std::numeric_limits<double>::infinity() : reached;
      }
      double leave = std::numeric_limits<double>::infinity();
      for (const auto& face : cover->faces) {
        const double speed = face.normal.dot(direction);
        if (speed <= 1e-12) continue;
        const double outer = face.offset + (face.internal ? 0 : cover->radius);
        leave = std::min(leave, (outer - face.normal.dot(p)) / speed);
      }
      // Beyond an internal face, the part extends by at most its rounding radius.
      const double least = 1e-6 * cover->bounding_radius;
      reached = leave > reached ? leave + least : reached + std::max(least, 0.25 * cover->radius);
    }
    return std::numeric_limits<double>::infinity();
  }

  // Points along a spiral, evenly spread.
  void add_sphere(std::size_t index) {
    constexpr int kPoints = 400;
    const ConvexPart& part = parts_[index];
    for (int k = 0; k < kPoints; ++k) {
      const double z = (2 * k + 1.0) / kPoints - 1, angle = 2.399963229728653 * k;
      const double r = std::sqrt(1 - z * z);
      const Vec3 p = part.center + part.radius * Vec3(r * std::cos(angle), r * std::sin(angle), z);
      if (exposed(p, index)) points_.push_back(p);
    }
  }

  bool exposed(const Vec3& p, std::size_t owner) const {
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const ConvexPart& part = parts_[i];
      if (i == owner ||
          (p - part.center).squaredNorm() > part.bounding_radius * part.bounding_radius) {
        continue;
      }
      if (signed_distance(p, part) < -1e-6 * part.bounding_radius) return false;
    }
    // Grooves at the surface are about as deep as the rounding radius, voids are deeper.
    return to_mesh_(p) <= 2 * parts_[owner].radius || !interior_.contains(p);
  }

  const std::vector<ConvexPart>& parts_;
  PointInMesh interior_;
  MeshDistance to_mesh_;
  std::vector<Vec3> points_;  // of the faces
};

#ifdef FIRN_FUZZ
constexpr double kSpacing = 1.0 / 6;  // coarser, for speed: a hundredth of the samples
#else
constexpr double kSpacing = 1.0 / 60;  // of samples, over the box diagonal
#endif

}  // namespace

Deviation measure_deviation(const Shape& shape) {
  TriangleMesh mesh = shape.mesh;
  for (Vec3& v : mesh.vertices) v = shape.shape_from_body.conjugate() * (v - shape.centroid);
  const double size = shape.box.norm(), spacing = kSpacing * size;
  const Union parts(shape.parts, mesh, spacing);
  Deviation deviation;
  const auto sample = [&](const Vec3& p) {
    const double height = height_above(shape.parts, p);
    deviation.rounding = std::max(deviation.rounding, height);
    if (-height > std::max(deviation.surplus, 1e-9 * size)) {
      deviation.surplus = std::max(deviation.surplus, parts.depth(p));
    }
  };
  for (const Vec3& v : mesh.vertices) sample(v);
  Thinning thinning(0.25 * spacing);
  for (const auto& t : mesh.triangles) {
    for_points(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]], spacing,
               [&](const Vec3& p) {
                 if (thinning.fresh(p)) sample(p);
               });
  }
  deviation.surplus = std::max(deviation.surplus, parts.highest());
  return deviation;
}

double default_rounding(const std::vector<std::vector<HalfSpace>>& pieces, const TriangleMesh& mesh,
                        double edge) {
  constexpr double kRounding = 0.02, kOfThinnest = 0.25;  // of the smallest edge, of a piece
  constexpr double kAllowed = 0.018;                      // of the smallest edge
  double rounding = kRounding * edge;
  for (const auto& piece : pieces) {
    rounding = std::min(rounding, kOfThinnest * convex_part(piece, 0).thickness);
  }
  // The distance of a corner is proportional to the rounding as long as no face vanishes.
  for (int i = 0; i < 8; ++i) {
    std::vector<ConvexPart> parts;
    for (const auto& piece : pieces) parts.push_back(convex_part(piece, rounding));
    double farthest = 0;
    for (const Vec3& v : mesh.vertices) farthest = std::max(farthest, height_above(parts, v));
    if (farthest <= kAllowed * edge) break;
    rounding *= std::clamp(0.98 * kAllowed * edge / farthest, 0.3, 0.9);
  }
  return rounding;
}

}  // namespace firn
