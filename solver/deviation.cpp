#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/shape_makers.h"

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
  // An edge that is next to nothing beside the others runs anywhere.
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
  // Faces that differ by next to nothing are merged: what is that little above one of them is not
  // far from all of them, though it may be far from that one's own polygon.
  if (highest <= 1e-6 * part.bounding_radius) return surface - part.radius;
  double distance = std::numeric_limits<double>::infinity();
  for (const auto& face : part.faces) {
    if (face.normal.dot(p) <= face.offset) continue;
    const auto corner = [&](int k) { return part.vertex(part.loops[face.first + k]); };
    distance = std::min(distance, distance_to_polygon(p, face.normal, face.count, corner));
  }
  return distance - part.radius;
}

double distance_to_surface(const Vec3& p, const std::vector<ConvexPart>& parts) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& part : parts) {
    if ((p - part.center).norm() - part.bounding_radius >= lowest) continue;
    lowest = std::min(lowest, signed_distance(p, part));
  }
  return std::abs(lowest);
}

// Triangles with what a distance query needs, in body axes.
class MeshDistance {
 public:
  explicit MeshDistance(const TriangleMesh& mesh) {
    for (const auto& t : mesh.triangles) {
      Triangle triangle;
      for (int k = 0; k < 3; ++k) triangle.corner[k] = mesh.vertices[t[k]];
      const auto& c = triangle.corner;
      triangle.normal = (c[1] - c[0]).cross(c[2] - c[0]).normalized();
      triangle.center = (c[0] + c[1] + c[2]) / 3;
      for (const Vec3& v : c) {
        triangle.radius = std::max(triangle.radius, (v - triangle.center).norm());
      }
      triangles_.push_back(triangle);
    }
  }

  double operator()(const Vec3& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Triangle& t : triangles_) {
      const double reach = nearest + t.radius;
      if ((p - t.center).squaredNorm() >= reach * reach) continue;
      nearest = std::min(nearest,
                         distance_to_polygon(p, t.normal, 3, [&](int k) { return t.corner[k]; }));
    }
    return nearest;
  }

 private:
  struct Triangle {
    Vec3 corner[3], normal, center;
    double radius = 0;
  };
  std::vector<Triangle> triangles_;
};

// Points of the swept body's surface straight above the corners of a part, on every real face.
std::vector<Vec3> surface_points(const std::vector<ConvexPart>& parts, std::size_t index) {
  const ConvexPart& part = parts[index];
  const auto in_another = [&](const Vec3& p) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (i != index && signed_distance(p, parts[i]) < -1e-6 * parts[i].bounding_radius) {
        return true;
      }
    }
    return false;
  };
  std::vector<Vec3> points;
  for (const auto& face : part.faces) {
    if (face.internal) continue;
    for (int k = 0; k < face.count; ++k) {
      const Vec3 p = part.vertex(part.loops[face.first + k]) + part.radius * face.normal;
      if (!in_another(p)) points.push_back(p);
    }
  }
  return points;
}

}  // namespace

double measure_deviation(const Shape& shape) {
  TriangleMesh mesh = shape.mesh;
  for (Vec3& v : mesh.vertices) v = shape.shape_from_body.conjugate() * (v - shape.centroid);

  std::vector<Vec3> samples = mesh.vertices;
  for (const auto& t : mesh.triangles) {
    samples.push_back((mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3);
  }
  double largest = 0;
  const std::size_t stride = 1 + samples.size() / 4000;
  for (std::size_t i = 0; i < samples.size(); i += stride) {
    largest = std::max(largest, distance_to_surface(samples[i], shape.parts));
  }
  const MeshDistance distance_to_mesh(mesh);
  for (std::size_t i = 0; i < shape.parts.size(); ++i) {
    for (const Vec3& p : surface_points(shape.parts, i)) {
      largest = std::max(largest, distance_to_mesh(p));
    }
  }
  return largest;
}

}  // namespace firn
