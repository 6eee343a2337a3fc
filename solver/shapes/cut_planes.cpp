#include "solver/shapes/cut_planes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace firn {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// A facet and its deepest point below the hull's outer faces.
struct DeepFacet {
  double depth = 0;  // m
  std::size_t facet = 0;
  Vec3 point = Vec3::Zero();  // m
};

// Surface facets by depth, deepest first. At most about 4000 are sampled.
std::vector<DeepFacet> facets_by_depth(const CutPiece& piece, const CutSettings& s) {
  std::vector<DeepFacet> result;
  const std::size_t stride = 1 + piece.boundary.size() / 4000;
  for (std::size_t i = 0; i < piece.boundary.size(); i += stride) {
    const Facet& f = piece.boundary[i];
    if (f.cap || is_in_cut(f, piece, s)) continue;
    DeepFacet deepest{-1, i, Vec3::Zero()};
    for (const Vec3& p : {facet_centroid(f), f.corners[0], f.corners[1], f.corners[2]}) {
      const double depth = depth_below_hull(p, piece, deepest.depth);
      if (depth > deepest.depth) deepest = {depth, i, p};
    }
    result.push_back(deepest);
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const DeepFacet& a, const DeepFacet& b) { return a.depth > b.depth; });
  return result;
}

// Principal axes (columns) of the area of the surface, by ascending second moment.
Mat3 principal_axes(const CutPiece& piece) {
  double total = 0;
  Vec3 mean = Vec3::Zero();
  for (const auto& f : piece.boundary) {
    if (f.cap) continue;
    const double a = facet_area(f);
    total += a;
    mean += a * facet_centroid(f);
  }
  mean /= total;
  Mat3 second = Mat3::Zero();
  for (const auto& f : piece.boundary) {
    if (f.cap) continue;
    for (const Vec3& p : f.corners) {
      second += facet_area(f) / 3 * (p - mean) * (p - mean).transpose();
    }
  }
  return Eigen::SelfAdjointEigenSolver<Mat3>(second).eigenvectors();
}

// Up to three normals, those of the largest areas of the surface.
std::vector<Vec3> normals_of_largest_areas(const CutPiece& piece) {
  std::vector<std::pair<double, Vec3>> groups;
  for (const auto& f : piece.boundary) {
    if (f.cap) continue;
    const auto group = std::find_if(groups.begin(), groups.end(), [&f](const auto& g) {
      return std::abs(g.second.dot(f.normal)) > 0.9999;
    });
    if (group != groups.end()) {
      group->first += facet_area(f);
    } else if (groups.size() < 200) {
      groups.emplace_back(facet_area(f), f.normal);
    }
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Vec3> result;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, groups.size()); ++i) {
    result.push_back(groups[i].second);
  }
  return result;
}

// In the planes of deep facets.
template <typename Add>
void add_facet_planes(const CutPiece& piece, const std::vector<DeepFacet>& deep,
                      const CutSettings& s, const Add& add) {
  constexpr int kMaxPlanes = 14;
  int added = 0;
  for (const auto& deepest : deep) {
    if (deepest.depth < std::max(piece.deviation / 5, s.options.tolerance / 2) ||
        added == kMaxPlanes) {
      break;
    }
    const Facet& f = piece.boundary[deepest.facet];
    added += add(f.normal, f.normal.dot(facet_centroid(f)));
  }
}

// Through reflex edges: in the plane of either facet, and between the two.
template <typename Add>
void add_planes_through_edges(const CutPiece& piece, const std::vector<ReflexEdge>& reflex_edges,
                              const CutSettings& s, const Add& add) {
  constexpr std::size_t kMaxEdges = 8;
  std::vector<std::pair<double, const ReflexEdge*>> edges;
  for (const auto& e : reflex_edges) {
    double from = 0, to = 1;
    for (const auto& cut : piece.cuts) {
      const double a = cut.normal.dot(e.a) - cut.offset, b = cut.normal.dot(e.b) - cut.offset;
      if (a > s.snap && b > s.snap) to = -1;
      if (a > s.snap && b <= s.snap) from = std::max(from, a / (a - b));
      if (b > s.snap && a <= s.snap) to = std::min(to, a / (a - b));
    }
    if (to - from < 1e-6) continue;
    const Vec3 point = e.a + 0.5 * (from + to) * (e.b - e.a);
    const double weight =
        depth_below_hull(point, piece) * (to - from) * (e.b - e.a).norm() * e.n1.cross(e.n2).norm();
    if (weight > 0) edges.emplace_back(weight, &e);
  }
  std::stable_sort(edges.begin(), edges.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::size_t edges_used = 0;
  for (const auto& [weight, e] : edges) {
    const Vec3 along = (e->b - e->a).normalized();
    const Vec3 between = along.cross(e->n1 + e->n2);
    bool added = add(e->n1, e->n1.dot(e->a));
    added |= add(e->n2, e->n2.dot(e->a));
    if (between.norm() > 1e-6) {
      added |= add(between.normalized(), between.normalized().dot(e->a));
    }
    edges_used += added;
    if (edges_used == kMaxEdges) break;
  }
}

}  // namespace

std::vector<HalfSpace> candidate_planes(const CutPiece& piece,
                                        const std::vector<ReflexEdge>& reflex_edges,
                                        bool middle_only, const CutSettings& s) {
  std::vector<HalfSpace> result;
  const auto add = [&](const Vec3& normal, double offset) {
    for (const auto& h : result) {
      const double cosine = h.normal.dot(normal);
      const double other = cosine < 0 ? -h.offset : h.offset;
      if (std::abs(cosine) > 0.9995 && std::abs(other - offset) < 0.005 * s.size) return false;
    }
    result.push_back({normal, offset, false});
    return true;
  };
  const std::vector<DeepFacet> deep = facets_by_depth(piece, s);
  if (deep.empty()) return result;
  if (!middle_only) {
    add_facet_planes(piece, deep, s, add);
    add_planes_through_edges(piece, reflex_edges, s, add);
  }
  std::vector<Vec3> axes;
  const Mat3 principal = principal_axes(piece);
  for (int k = 0; k < 3; ++k) axes.push_back(principal.col(2 - k));
  for (const Vec3& n : normals_of_largest_areas(piece)) {
    if (std::none_of(axes.begin(), axes.end(),
                     [&n](const Vec3& a) { return std::abs(a.dot(n)) > 0.9995; })) {
      axes.push_back(n);
    }
  }
  // Across the deepest facets.
  int across = 0;
  std::vector<Vec3> known;
  for (const auto& deepest : deep) {
    if (across == 3 || deepest.depth < piece.deviation / 2) break;
    const Vec3& n = piece.boundary[deepest.facet].normal;
    const Vec3 point = facet_centroid(piece.boundary[deepest.facet]);
    if (std::any_of(known.begin(), known.end(), [&n](const Vec3& k) { return k.dot(n) > 0.97; })) {
      continue;
    }
    known.push_back(n);
    ++across;
    for (const Vec3& axis : axes) {
      const Vec3 normal = n.cross(axis);
      if (normal.norm() > 0.3) add(normal.normalized(), normal.normalized().dot(point));
    }
  }
  for (const Vec3& axis : axes) {
    double low = kUnbounded, high = -low;
    for (const Vec3& p : piece.corners) {
      low = std::min(low, axis.dot(p));
      high = std::max(high, axis.dot(p));
    }
    const auto at = [&](double fraction) { return low + fraction * (high - low); };
    add(axis, at(0.5));
    if (middle_only) continue;
    add(axis, axis.dot(deep[0].point));
    for (const double fraction : {0.25, 0.75, 1.0 / 3, 2.0 / 3}) add(axis, at(fraction));
  }
  return result;
}

}  // namespace firn
