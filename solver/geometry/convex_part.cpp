#include "firn/convex_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "solver/geometry/half_space_intersection.h"

namespace firn {
namespace {

void set_vertices(const std::vector<Vec3>& points, ConvexPart& part) {
  if (points.size() > std::numeric_limits<std::uint16_t>::max()) {
    throw InputError("a convex part has " + std::to_string(points.size()) +
                     " corners; expected at most 65535");
  }
  part.vertex_count = static_cast<int>(points.size());
  const std::size_t padded = (points.size() + 7) / 8 * 8;
  for (std::size_t i = 0; i < padded; ++i) {
    const Vec3& p = points[std::min(i, points.size() - 1)];
    part.x.push_back(p.x());
    part.y.push_back(p.y());
    part.z.push_back(p.z());
  }
  Vec3 lower = points[0], upper = points[0];
  for (const Vec3& p : points) {
    lower = lower.cwiseMin(p);
    upper = upper.cwiseMax(p);
  }
  part.center = (lower + upper) / 2;
  for (const Vec3& p : points) {
    part.bounding_radius = std::max(part.bounding_radius, (p - part.center).norm());
  }
  part.bounding_radius += part.radius;
}

void set_edges(ConvexPart& part) {
  for (const auto& face : part.faces) {
    for (int k = 0; k < face.count; ++k) {
      const auto [a, b] = std::minmax(part.face_vertices[face.first + k],
                                      part.face_vertices[face.first + (k + 1) % face.count]);
      part.edges.push_back({a, b});
    }
  }
  std::sort(part.edges.begin(), part.edges.end());
  part.edges.erase(std::unique(part.edges.begin(), part.edges.end()), part.edges.end());
}

void set_adjacency(ConvexPart& part) {
  std::vector<std::vector<ConvexPart::VertexEdge>> edges_of(part.vertex_count);
  std::vector<std::vector<std::uint16_t>> faces(part.vertex_count);
  for (const auto& [a, b] : part.edges) {
    const double inverse = 1 / (part.vertex(b) - part.vertex(a)).norm();
    edges_of[a].push_back({b, inverse});
    edges_of[b].push_back({a, inverse});
  }
  for (std::size_t f = 0; f < part.faces.size(); ++f) {
    for (int k = 0; k < part.faces[f].count; ++k) {
      faces[part.face_vertices[part.faces[f].first + k]].push_back(static_cast<std::uint16_t>(f));
    }
  }
  for (int i = 0; i < part.vertex_count; ++i) {
    const auto count = [](const auto& list) { return static_cast<std::uint32_t>(list.size()); };
    std::sort(edges_of[i].begin(), edges_of[i].end(),
              [](const auto& p, const auto& q) { return p.vertex < q.vertex; });
    part.adjacency.push_back(
        {count(part.vertex_edges), count(edges_of[i]), count(part.vertex_faces), count(faces[i])});
    part.vertex_edges.insert(part.vertex_edges.end(), edges_of[i].begin(), edges_of[i].end());
    part.vertex_faces.insert(part.vertex_faces.end(), faces[i].begin(), faces[i].end());
  }
  if (part.faces.size() > 64) return;
  part.surface_faces.assign(part.vertex_count, 0);
  for (int i = 0; i < part.vertex_count; ++i) {
    for (const std::uint16_t f : faces[i])
      part.surface_faces[i] |= std::uint64_t{!part.faces[f].internal} << f;
  }
}

void set_internal_faces(ConvexPart& part) {
  part.internal_faces.assign(part.vertex_count, 0);
  for (const auto& face : part.faces) {
    if (!face.internal) continue;
    const auto bit = part.internal_normals.size();
    if (bit == kMaxInternalFaces) {
      throw InputError("a convex part has more than " + std::to_string(kMaxInternalFaces) +
                       " internal faces; expected fewer");
    }
    part.internal_normals.push_back(face.normal);
    for (int k = 0; k < face.count; ++k) {
      part.internal_faces[part.face_vertices[face.first + k]] |= std::uint64_t{1} << bit;
    }
  }
}

void set_thickness(ConvexPart& part) {
  double least = part.faces.empty() ? 0 : std::numeric_limits<double>::infinity();
  for (const auto& face : part.faces) {
    double deepest = 0;
    for (int i = 0; i < part.vertex_count; ++i) {
      deepest = std::max(deepest, face.offset - face.normal.dot(part.vertex(i)));
    }
    least = std::min(least, deepest);
  }
  part.thickness = least + 2 * part.radius;
}

}  // namespace

ConvexPart convex_part(const std::vector<HalfSpace>& half_spaces, double rounding) {
  if (!(rounding >= 0)) throw InputError("the rounding is negative; expected zero or more");
  const auto [lower, upper] = solid_extents(half_spaces);
  // Cut again near the solid, about its own middle, so that the tolerance scales with its size.
  const Vec3 middle = (lower + upper) / 2;
  const Vec3 half = 0.6 * (upper - lower);
  std::vector<HalfSpace> eroded = half_spaces;
  for (auto& h : eroded) h.offset -= h.normal.dot(middle) + (h.internal ? 0 : rounding);
  Polyhedron solid(-half, half, 1e-9 * (upper - lower).norm());
  if (!cut_by_all(solid, eroded)) {
    throw RoundingError(fmt::format(
        "nothing is left of a convex part rounded by {:.4g} mm; expected less than half "
        "of its thickness; left out, the rounding follows from the shape",
        1e3 * rounding));
  }
  SolidCorners corners = solid_corners(solid, eroded);
  for (Vec3& p : corners.points) p += middle;

  ConvexPart part;
  part.radius = rounding;
  set_vertices(corners.points, part);
  for (const auto& facet : corners.facets) {
    const HalfSpace& h = eroded[facet.plane];
    part.faces.push_back({h.normal, h.offset + h.normal.dot(middle),
                          static_cast<int>(part.face_vertices.size()),
                          static_cast<int>(facet.loop.size()), h.internal});
    part.face_vertices.insert(part.face_vertices.end(), facet.loop.begin(), facet.loop.end());
  }
  set_edges(part);
  set_adjacency(part);
  set_internal_faces(part);
  set_thickness(part);
  return part;
}

// By duality: seen from an inner point, the points of a solid are the planes of its dual, and the
// corners of the dual are the planes of the solid.
std::vector<HalfSpace> convex_hull(const std::vector<Vec3>& points) {
  if (points.size() < 4) {
    throw InputError("a convex solid has " + std::to_string(points.size()) +
                     " corners; expected at least four");
  }
  const double count = static_cast<double>(points.size());
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / count;
  Mat3 covariance = Mat3::Zero();
  for (const Vec3& p : points) covariance += (p - mean) * (p - mean).transpose() / count;
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(covariance);
  // Squares of thickness: sums of squares are good to 1e-16 of the largest, so that points of one
  // plane, as rounded, must not pass. Thinner than 1e-7 of its length is no solid.
  if (!(axes.eigenvalues()(0) > 1e-14 * axes.eigenvalues()(2))) {
    throw InputError("the corners of a convex solid lie in one plane; expected a solid");
  }
  // Points of unit covariance: however flat the solid, its hull holds a ball of radius n^-1/2 about
  // the mean. Points inside that ball are no corners, and the dual lies within n^1/2.
  const Mat3 whiten = axes.operatorInverseSqrt();
  const double bound = std::sqrt(count);
  std::vector<HalfSpace> dual;
  for (const Vec3& p : points) {
    const Vec3 q = whiten * (p - mean);
    if (q.norm() * bound > 0.5) dual.push_back({q.normalized(), 1 / q.norm(), false});
  }
  // Facets whose planes differ by less than this count as one. Single-precision files need it.
  constexpr double kCoplanar = 1e-6;
  Polyhedron solid(Vec3::Constant(-1.5 * bound), Vec3::Constant(1.5 * bound), kCoplanar);
  cut_by_all(solid, dual);
  std::vector<HalfSpace> hull;
  for (const Vec3& v : solid_corners(solid, dual).points) {
    const Vec3 n = whiten * v;
    hull.push_back({n.normalized(), (1 + n.dot(mean)) / n.norm(), false});
  }
  return hull;
}

ConvexPart sphere_part(const Vec3& center, double radius) {
  ConvexPart part;
  part.radius = radius;
  set_vertices({center}, part);
  set_adjacency(part);
  set_internal_faces(part);
  set_thickness(part);
  return part;
}

ConvexPart moved(const ConvexPart& part, const Pose& pose) {
  ConvexPart result = part;
  for (std::size_t i = 0; i < part.x.size(); ++i) {
    const Vec3 p = pose * part.vertex(static_cast<int>(i));
    result.x[i] = p.x();
    result.y[i] = p.y();
    result.z[i] = p.z();
  }
  for (auto& face : result.faces) {
    face.normal = pose.rotation * face.normal;
    face.offset += face.normal.dot(pose.translation);
  }
  for (Vec3& n : result.internal_normals) n = pose.rotation * n;
  result.center = pose * part.center;
  return result;
}

TriangleMesh surface_mesh(const ConvexPart& part) {
  TriangleMesh mesh;
  for (int i = 0; i < part.vertex_count; ++i) mesh.vertices.push_back(part.vertex(i));
  for (const auto& face : part.faces) {
    const auto* loop = &part.face_vertices[face.first];
    for (int k = 1; k + 1 < face.count; ++k) {
      mesh.triangles.push_back({loop[0], loop[k], loop[k + 1]});
    }
  }
  return mesh;
}

}  // namespace firn
