#include "solver/shapes/facets.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <map>
#include <tuple>

namespace firn {
namespace {

bool precedes(const Vec3& a, const Vec3& b) {
  return std::tie(a.x(), a.y(), a.z()) < std::tie(b.x(), b.y(), b.z());
}

}  // namespace

double facet_area(const Facet& f) {
  return 0.5 * (f.corners[1] - f.corners[0]).cross(f.corners[2] - f.corners[0]).norm();
}

Vec3 facet_centroid(const Facet& f) { return (f.corners[0] + f.corners[1] + f.corners[2]) / 3; }

std::vector<Facet> sorted_facets(const TriangleMesh& mesh) {
  std::vector<Facet> facets;
  for (const auto& t : mesh.triangles) {
    Facet f;
    for (int k = 0; k < 3; ++k) f.corners[k] = mesh.vertices[t[k]];
    const auto first = std::min_element(f.corners.begin(), f.corners.end(), precedes);
    std::rotate(f.corners.begin(), first, f.corners.end());
    f.normal = (f.corners[1] - f.corners[0]).cross(f.corners[2] - f.corners[0]).normalized();
    facets.push_back(f);
  }
  std::sort(facets.begin(), facets.end(), [](const Facet& a, const Facet& b) {
    return std::lexicographical_compare(a.corners.begin(), a.corners.end(), b.corners.begin(),
                                        b.corners.end(), precedes);
  });
  return facets;
}

std::vector<Facet> simplify_facets(const std::vector<Facet>& facets, std::size_t max_facets,
                                   double size) {
  const auto less = [](const Vec3& a, const Vec3& b) { return precedes(a, b); };
  std::map<Vec3, unsigned, decltype(less)> known(less);
  std::vector<Vec3> corners;
  std::vector<float> scaled;  // meshoptimizer takes single precision
  std::vector<unsigned> indices;
  for (const auto& f : facets) {
    for (const Vec3& p : f.corners) {
      const auto [at, added] = known.emplace(p, static_cast<unsigned>(corners.size()));
      indices.push_back(at->second);
      if (!added) continue;
      corners.push_back(p);
      for (int k = 0; k < 3; ++k) scaled.push_back(static_cast<float>(p(k) / size));
    }
  }
  constexpr float kAnyError = 1;  // of the size
  std::vector<unsigned> kept(indices.size());
  kept.resize(meshopt_simplify(kept.data(), indices.data(), indices.size(), scaled.data(),
                               corners.size(), 3 * sizeof(float), 3 * max_facets, kAnyError));
  std::vector<Facet> result;
  for (std::size_t i = 0; i + 2 < kept.size(); i += 3) {
    Facet f{{corners[kept[i]], corners[kept[i + 1]], corners[kept[i + 2]]}, Vec3::Zero()};
    const Vec3 n = (f.corners[1] - f.corners[0]).cross(f.corners[2] - f.corners[0]);
    if (n.norm() <= 1e-12 * size * size) continue;
    f.normal = n.normalized();
    result.push_back(f);
  }
  return result;
}

std::vector<ReflexEdge> find_reflex_edges(const std::vector<Facet>& facets, double size) {
  constexpr double kMinSine = 0.1;  // sine of the angle between the facets
  const auto less = [](const std::array<Vec3, 2>& x, const std::array<Vec3, 2>& y) {
    return precedes(x[0], y[0]) || (!precedes(y[0], x[0]) && precedes(x[1], y[1]));
  };
  std::map<std::array<Vec3, 2>, Vec3, decltype(less)> sides(less);
  std::vector<ReflexEdge> result;
  for (const auto& f : facets) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 &a = f.corners[k], &b = f.corners[(k + 1) % 3];
      const auto other = sides.find({b, a});
      if (other == sides.end()) {
        sides[{a, b}] = f.normal;
        continue;
      }
      // Seen along the edge of this facet, the other facet rises when the edge is concave.
      const Vec3 along = b - a;
      const double sine = f.normal.cross(other->second).dot(along) / along.norm();
      if (sine < -kMinSine && along.norm() > 1e-6 * size) {
        result.push_back({a, b, f.normal, other->second});
      }
      sides.erase(other);
    }
  }
  return result;
}

}  // namespace firn
