#include "solver/geometry/half_space_intersection.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace firn {

Polyhedron::Polyhedron(const Vec3& lower, const Vec3& upper, double tolerance)
    : tolerance_(tolerance) {
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
    facets_.push_back({kStart, loop});
  }
}

bool Polyhedron::cut(int plane, const Vec3& n, double offset) {
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

std::vector<int> Polyhedron::clip(const std::vector<int>& loop) {
  std::vector<int> result;
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const int a = loop[k], b = loop[(k + 1) % loop.size()];
    if (height_[a] <= tolerance_) result.push_back(a);
    const auto [low, high] = std::minmax(height_[a], height_[b]);
    if (low < -tolerance_ && high > tolerance_) result.push_back(crossing(a, b));
  }
  return result;
}

int Polyhedron::crossing(int a, int b) {
  const auto [low, high] = std::minmax(a, b);
  const auto [entry, fresh] = crossings_.try_emplace({low, high}, static_cast<int>(points_.size()));
  if (fresh) {
    const double s = height_[low] / (height_[low] - height_[high]);
    live_.push_back(entry->second);
    points_.push_back(points_[low] + s * (points_[high] - points_[low]));
    height_.push_back(0);
  }
  return entry->second;
}

void Polyhedron::count_edges(const std::vector<int>& loop, int sign) {
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const int a = loop[k], b = loop[(k + 1) % loop.size()];
    rim_[std::minmax(a, b)] += a < b ? sign : -sign;
  }
}

void Polyhedron::add_caps(int plane) {
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

namespace {

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

}  // namespace

SolidCorners solid_corners(const Polyhedron& solid, const std::vector<HalfSpace>& half_spaces) {
  SolidCorners result;
  result.facets = solid.facets();
  if (std::any_of(result.facets.begin(), result.facets.end(),
                  [](const auto& facet) { return facet.plane == Polyhedron::kStart; })) {
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

std::array<Vec3, 2> solid_extents(const std::vector<HalfSpace>& half_spaces) {
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
    if (facet.plane == Polyhedron::kStart) {
      throw InputError("the faces leave a side open; expected a closed solid");
    }
    for (const int i : facet.loop) {
      lower = lower.cwiseMin(solid.points()[i]);
      upper = upper.cwiseMax(solid.points()[i]);
    }
  }
  return {lower, upper};
}

}  // namespace firn
