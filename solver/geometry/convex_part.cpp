#include "firn/convex_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

namespace firn {
namespace {

constexpr int kStartFacet = -1;

// A convex polyhedron that is cut by one plane after another. Points within `tolerance` of a plane
// count as lying on it, so slivers thinner than that never arise.
class Polyhedron {
 public:
  struct Facet {
    int plane = kStartFacet;  // index of the plane that made it
    std::vector<int> loop;    // points, counter-clockwise seen from outside
  };

  Polyhedron(const Vec3& lower, const Vec3& upper, double tolerance) : tolerance_(tolerance) {
    for (int i = 0; i < 8; ++i) {
      points_.emplace_back((i & 1 ? upper : lower).x(), (i & 2 ? upper : lower).y(),
                           (i & 4 ? upper : lower).z());
    }
    for (const auto& loop : {std::vector<int>{0, 4, 6, 2},
                             {1, 3, 7, 5},
                             {0, 1, 5, 4},
                             {2, 6, 7, 3},
                             {0, 2, 3, 1},
                             {4, 5, 7, 6}}) {
      facets_.push_back({kStartFacet, loop});
    }
  }

  // Keeps the side n . x <= offset. False when nothing is left.
  bool cut(int plane, const Vec3& n, double offset) {
    height_.resize(points_.size());
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    for (const int i : live_) {
      height_[i] = n.dot(points_[i]) - offset;
      lowest = std::min(lowest, height_[i]);
      highest = std::max(highest, height_[i]);
    }
    if (highest <= tolerance_) return true;
    if (lowest >= -tolerance_) return false;
    std::erase_if(live_, [this](int i) { return height_[i] > tolerance_; });
    crossings_.clear();
    rim_.clear();
    for (auto& facet : facets_) {
      const bool above = std::any_of(facet.loop.begin(), facet.loop.end(),
                                     [this](int i) { return height_[i] > tolerance_; });
      if (!above) continue;
      count_edges(facet.loop, 1);
      facet.loop = clip(facet.loop);
      if (facet.loop.size() < 3) facet.loop.clear();
      count_edges(facet.loop, -1);
    }
    std::erase_if(facets_, [](const Facet& facet) { return facet.loop.empty(); });
    add_caps(plane);
    return true;
  }

  const std::vector<Vec3>& points() const { return points_; }
  const std::vector<Facet>& facets() const { return facets_; }
  double tolerance() const { return tolerance_; }

 private:
  std::vector<int> clip(const std::vector<int>& loop) {
    std::vector<int> result;
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const int a = loop[k], b = loop[(k + 1) % loop.size()];
      if (height_[a] <= tolerance_) result.push_back(a);
      const auto [low, high] = std::minmax(height_[a], height_[b]);
      if (low < -tolerance_ && high > tolerance_) result.push_back(crossing(a, b));
    }
    return result;
  }

  // The intersection of edge a-b and the plane. The two facets at the edge share this point.
  int crossing(int a, int b) {
    const auto [low, high] = std::minmax(a, b);
    const auto [entry, fresh] =
        crossings_.try_emplace({low, high}, static_cast<int>(points_.size()));
    if (fresh) {
      const double s = height_[low] / (height_[low] - height_[high]);
      live_.push_back(entry->second);
      points_.push_back(points_[low] + s * (points_[high] - points_[low]));
      height_.push_back(0);
    }
    return entry->second;
  }

  // Adds the directed edges of a loop to the rim; opposite ones cancel.
  void count_edges(const std::vector<int>& loop, int sign) {
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const int a = loop[k], b = loop[(k + 1) % loop.size()];
      rim_[std::minmax(a, b)] += a < b ? sign : -sign;
    }
  }

  // Closes the hole of a cut with new facets. The rim contains the edges of the removed loops minus
  // those of the clipped loops. Closing it edge by edge keeps the surface closed, whatever the
  // rounding errors.
  void add_caps(int plane) {
    std::map<int, int> next;
    for (const auto& [edge, count] : rim_) {
      if (count > 0) next[edge.first] = edge.second;
      if (count < 0) next[edge.second] = edge.first;
    }
    while (!next.empty()) {
      Facet cap{plane, {}};
      for (auto it = next.begin(); it != next.end(); it = next.find(cap.loop.back())) {
        cap.loop.push_back(it->second);
        next.erase(it);
      }
      if (cap.loop.size() >= 3) facets_.push_back(std::move(cap));
    }
  }

  double tolerance_;
  std::vector<Vec3> points_;
  std::vector<int> live_ = {0, 1, 2, 3, 4, 5, 6, 7};  // points not cut away
  std::vector<Facet> facets_;
  std::vector<double> height_;                    // m, [points] over the plane of the present cut
  std::map<std::pair<int, int>, int> crossings_;  // edge -> point
  std::map<std::pair<int, int>, int> rim_;        // edge, low to high -> uses
};

// The outcome of all cuts: points that three facets share, numbered without gaps.
struct Corners {
  std::vector<Vec3> points;
  std::vector<Polyhedron::Facet> facets;  // by index into points
};

// Representative of each point once edges shorter than the tolerance are collapsed.
std::vector<int> collapse_short_edges(const Polyhedron& solid) {
  std::vector<int> same(solid.points().size());
  for (std::size_t i = 0; i < same.size(); ++i) same[i] = static_cast<int>(i);
  const auto root = [&same](int i) {
    while (same[i] != i) i = same[i];
    return i;
  };
  for (const auto& facet : solid.facets()) {
    for (std::size_t k = 0; k < facet.loop.size(); ++k) {
      const int a = root(facet.loop[k]), b = root(facet.loop[(k + 1) % facet.loop.size()]);
      if ((solid.points()[a] - solid.points()[b]).norm() <= solid.tolerance()) {
        same[std::max(a, b)] = std::min(a, b);
      }
    }
  }
  for (auto& i : same) i = root(i);
  return same;
}

void drop_repeats(std::vector<int>& loop) {
  loop.erase(std::unique(loop.begin(), loop.end()), loop.end());
  while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
}

// Moves a point to where its planes meet, in the least-squares sense: cutting edge after edge
// leaves rounding errors that this removes. The point lies within the tolerance of its planes. It
// does not move by more than that along any axis: planes that are nearly parallel do not determine
// its place along them.
Vec3 sharpen(const Vec3& point, const std::vector<int>& planes, const std::vector<HalfSpace>& all,
             double tolerance) {
  Mat3 squares = Mat3::Zero();
  Vec3 residual = Vec3::Zero();
  for (const int i : planes) {
    const HalfSpace& h = all[i];
    squares += h.normal * h.normal.transpose();
    residual += (h.offset - h.normal.dot(point)) * h.normal;
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(squares);
  Vec3 result = point;
  for (int k = 0; k < 3; ++k) {
    const Vec3 axis = axes.eigenvectors().col(k);
    if (!(axes.eigenvalues()(k) > 1e-12)) continue;
    const double step = axis.dot(residual) / axes.eigenvalues()(k);
    if (std::abs(step) <= tolerance) result += step * axis;
  }
  return result;
}

// Throws InputError for a solid that its planes leave open, or so thin that rounding closes it.
Corners corners_of(const Polyhedron& solid, const std::vector<HalfSpace>& half_spaces) {
  Corners result;
  result.facets = solid.facets();
  if (std::any_of(result.facets.begin(), result.facets.end(),
                  [](const auto& facet) { return facet.plane == kStartFacet; })) {
    throw InputError("a convex solid is too flat for its length; expected a thicker one");
  }
  const auto same = collapse_short_edges(solid);
  for (auto& facet : result.facets) {
    for (auto& i : facet.loop) i = same[i];
  }
  // Removes collapsed facets and points that fewer than three facets share, until none is left.
  std::vector<std::vector<int>> planes;
  for (std::size_t before = 0; before != result.facets.size();) {
    before = result.facets.size();
    for (auto& facet : result.facets) drop_repeats(facet.loop);
    std::erase_if(result.facets, [](const auto& facet) { return facet.loop.size() < 3; });
    planes.assign(same.size(), {});
    for (const auto& facet : result.facets) {
      for (const int i : facet.loop) planes[i].push_back(facet.plane);
    }
    for (auto& facet : result.facets) {
      std::erase_if(facet.loop, [&planes](int i) { return planes[i].size() < 3; });
    }
  }
  std::vector<int> number(same.size(), -1);
  for (auto& facet : result.facets) {
    for (auto& i : facet.loop) {
      if (number[i] < 0) {
        number[i] = static_cast<int>(result.points.size());
        result.points.push_back(
            sharpen(solid.points()[i], planes[i], half_spaces, solid.tolerance()));
      }
      i = number[i];
    }
  }
  if (result.facets.size() < 4) {
    throw InputError("a convex solid is thinner than rounding; expected some thickness");
  }
  return result;
}

bool cut_by_all(Polyhedron& solid, const std::vector<HalfSpace>& half_spaces) {
  for (std::size_t i = 0; i < half_spaces.size(); ++i) {
    if (!solid.cut(static_cast<int>(i), half_spaces[i].normal, half_spaces[i].offset)) return false;
  }
  return true;
}

// Corners of the box around the drawn solid, before erosion.
std::array<Vec3, 2> extents(const std::vector<HalfSpace>& half_spaces) {
  double reach = 0;
  for (const auto& h : half_spaces) reach = std::max(reach, std::abs(h.offset));
  // Corners of a wedge lie far beyond its planes' distances; this allows for one of 1e-4 rad.
  const Vec3 far = Vec3::Constant(1e4 * reach);
  Polyhedron solid(-far, far, 1e-9 * reach);
  if (!cut_by_all(solid, half_spaces)) {
    throw InputError("the faces enclose nothing; expected a solid");
  }
  Vec3 lower = Vec3::Constant(std::numeric_limits<double>::infinity()), upper = -lower;
  for (const auto& facet : solid.facets()) {
    if (facet.plane == kStartFacet) {
      throw InputError("the faces leave a side open; expected a closed solid");
    }
    for (const int i : facet.loop) {
      lower = lower.cwiseMin(solid.points()[i]);
      upper = upper.cwiseMax(solid.points()[i]);
    }
  }
  return {lower, upper};
}

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
  const auto [lower, upper] = extents(half_spaces);
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
  Corners corners = corners_of(solid, eroded);
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
  for (const Vec3& v : corners_of(solid, dual).points) {
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
