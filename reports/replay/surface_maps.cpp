#include "reports/replay/surface_maps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "experiments/results/contact_statistics_results.h"
#include "experiments/text/number_text.h"

namespace firn {
namespace {

using Corners = std::array<int, 3>;

Vec3 area_vector(const TriangleMesh& mesh, const Corners& t) {
  const Vec3& a = mesh.vertices[t[0]];
  return 0.5 * (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
}
Vec3 middle(const TriangleMesh& mesh, const Corners& t) {
  return (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3;
}

// Corners that lie in the same cube of a lattice and face the same way, as one of them: the
// sharpest. The two sides of a thin wall stay two, and edges keep to themselves, so that they stay
// where they are.
class Clusters {
 public:
  Clusters(const TriangleMesh& mesh, double edge) : of_(mesh.vertices.size()) {
    std::vector<Vec3> facing(mesh.vertices.size(), Vec3::Zero());
    std::vector<double> area(mesh.vertices.size(), 0), sharpness;
    for (const Corners& t : mesh.triangles) {
      const Vec3 a = area_vector(mesh, t);
      for (const int v : t) {
        facing[v] += a;
        area[v] += a.norm();
      }
    }
    std::map<std::array<long, 6>, std::size_t> known;  // the sharpest of each cluster
    std::vector<std::array<long, 6>> key;
    for (std::size_t v = 0; v < of_.size(); ++v) {
      sharpness.push_back(area[v] > 0 ? 1 - facing[v].norm() / area[v] : 0);
      key.push_back(key_of(mesh.vertices[v] / edge, facing[v].normalized(), sharpness[v]));
      std::size_t& best = known.emplace(key[v], v).first->second;
      if (sharpness[v] > sharpness[best] + 1e-9) best = v;
    }
    for (std::size_t v = 0; v < of_.size(); ++v) of_[v] = static_cast<int>(known.at(key[v]));
  }
  Corners of(const Corners& t) const { return {of_[t[0]], of_[t[1]], of_[t[2]]}; }

 private:
  // The cube, and which way: on an edge by the signs of the direction, elsewhere along which axis.
  static std::array<long, 6> key_of(const Vec3& place, const Vec3& facing, double sharpness) {
    std::array<long, 6> key{};
    for (int k = 0; k < 3; ++k) key[k] = std::lround(place[k]);
    int axis = 0;
    facing.cwiseAbs().maxCoeff(&axis);
    for (int k = 0; k < 3; ++k)
      if (sharpness > 0.1 ? std::abs(facing[k]) > 0.2 : k == axis)
        key[3 + k] = (sharpness > 0.1 ? 2 : 1) * (facing[k] < 0 ? -1 : 1);
    return key;
  }

  std::vector<int> of_;
};

// By the corner of the lowest number, in the same sense of rotation.
Corners turned(Corners c) {
  std::rotate(c.begin(), std::ranges::min_element(c), c.end());
  return c;
}

// What is left of a mesh with an area.
std::vector<Corners> surviving(const TriangleMesh& mesh, const Clusters& clusters, double edge) {
  std::set<Corners> known;
  std::vector<Corners> left;
  for (const Corners& t : mesh.triangles) {
    const Corners c = turned(clusters.of(t));
    const bool flat = area_vector(mesh, c).norm() < 1e-3 * edge * edge;
    if (!flat && known.insert(c).second) left.push_back(c);
  }
  return left;
}

// For each triangle of the mesh the one of `left` that it has become; for one that has lost its
// area the nearest, among its neighbors if it has any.
std::vector<std::size_t> heirs(const TriangleMesh& mesh, const Clusters& clusters,
                               const std::vector<Corners>& left) {
  std::map<Corners, std::size_t> known;
  std::map<int, std::vector<std::size_t>> around;
  std::vector<std::size_t> all(left.size());
  for (std::size_t i = 0; i < left.size(); ++i) {
    all[i] = i;
    known[left[i]] = i;
    for (const int v : left[i]) around[v].push_back(i);
  }
  std::vector<std::size_t> heir;
  for (const Corners& t : mesh.triangles) {
    if (const auto same = known.find(turned(clusters.of(t))); same != known.end()) {
      heir.push_back(same->second);
      continue;
    }
    const Vec3 from = middle(mesh, t), facing = area_vector(mesh, t);
    std::size_t best = 0;
    double nearest = std::numeric_limits<double>::infinity();
    const auto look = [&](const std::vector<std::size_t>& among) {
      for (const std::size_t i : among) {
        const bool behind = facing.dot(area_vector(mesh, left[i])) < 0;
        const double far = (middle(mesh, left[i]) - from).norm() * (behind ? 10 : 1);
        if (far < nearest) {
          nearest = far;
          best = i;
        }
      }
    };
    for (const int v : clusters.of(t))
      if (const auto found = around.find(v); found != around.end()) look(found->second);
    if (!std::isfinite(nearest)) look(all);
    heir.push_back(best);
  }
  return heir;
}

MapField inherited(const MapField& field, const std::vector<double>& area,
                   const std::vector<std::size_t>& heir, std::size_t count) {
  MapField out = field;
  out.values.assign(count, 0);
  std::vector<double> whole(count, 0);
  for (std::size_t t = 0; t < heir.size(); ++t) {
    double& value = out.values[heir[t]];
    if (field.merge == MapMerge::largest)
      value = std::max(value, field.values[t]);
    else
      value += field.values[t] * (field.merge == MapMerge::mean ? area[t] : 1);
    whole[heir[t]] += area[t];
  }
  if (field.merge == MapMerge::mean)
    for (std::size_t i = 0; i < count; ++i)
      if (whole[i] > 0) out.values[i] /= whole[i];
  return out;
}

// Only the corners that are used.
TriangleMesh packed(const TriangleMesh& mesh, const std::vector<Corners>& triangles) {
  TriangleMesh out;
  std::vector<int> index(mesh.vertices.size(), -1);
  for (Corners t : triangles) {
    for (int& v : t) {
      if (index[v] < 0) {
        index[v] = static_cast<int>(out.vertices.size());
        out.vertices.push_back(mesh.vertices[v]);
      }
      v = index[v];
    }
    out.triangles.push_back(t);
  }
  return out;
}

// Over the intervals; per area where the plain sum depends on the size of triangles.
MapField over_run(const BoundaryLoads& loads, const TriangleField& field) {
  const std::size_t triangles = loads.mesh.triangles.size();
  MapField out;
  out.key = field.name;
  out.name = field.name;
  std::ranges::replace(out.name, '_', ' ');
  out.unit = field.unit;
  const bool mean = field.name == "normal_force" || field.name == "frictional_power";
  if (field.name == "peak_stress") out.merge = MapMerge::largest;
  if (field.name == "wear_depth" || mean) out.merge = MapMerge::mean;
  if (mean) {
    out.name = field.name == "normal_force" ? "mean normal stress" : "mean frictional power";
    out.unit = field.name == "normal_force" ? "Pa" : "W/m^2";
  }
  out.values.assign(triangles, 0);
  double time = 0;
  for (std::size_t i = 0; i < loads.end.size(); ++i) {
    const double length = loads.end[i] - loads.start[i];
    time += length;
    for (std::size_t t = 0; t < triangles; ++t) {
      const double value = field.values[i * triangles + t];
      if (out.merge == MapMerge::largest)
        out.values[t] = std::max(out.values[t], value);
      else
        out.values[t] += mean ? value * length : value;
    }
  }
  for (std::size_t t = 0; mean && t < triangles; ++t) {
    const double over = time * loads.area[t];
    out.values[t] = over > 0 ? out.values[t] / over : 0;
  }
  return out;
}

// The smallest first: what they leave is for the others.
std::vector<SurfaceMap> within(std::vector<SurfaceMap> maps, std::size_t most) {
  std::vector<SurfaceMap*> order;
  for (SurfaceMap& map : maps) {
    map.computed = map.mesh.triangles.size();
    order.push_back(&map);
  }
  std::ranges::stable_sort(order, {}, [](const SurfaceMap* map) { return map->computed; });
  for (std::size_t i = 0; i < order.size(); ++i) {
    *order[i] = simplified_map(*order[i], most / (order.size() - i));
    most -= std::min(most, order[i]->mesh.triangles.size());
  }
  return maps;
}

}  // namespace

SurfaceMap simplified_map(const SurfaceMap& map, std::size_t most) {
  if (map.mesh.triangles.size() <= most) return map;
  std::vector<double> area;
  double whole = 0;
  for (const Corners& t : map.mesh.triangles) {
    area.push_back(area_vector(map.mesh, t).norm());
    whole += area.back();
  }
  double edge = std::sqrt(whole / static_cast<double>(std::max<std::size_t>(most, 1)));
  for (int tries = 0; whole > 0 && tries < 100; ++tries, edge *= 1.15) {
    const Clusters clusters(map.mesh, edge);
    const std::vector<Corners> left = surviving(map.mesh, clusters, edge);
    if (left.empty()) break;
    if (left.size() > most) continue;
    const std::vector<std::size_t> heir = heirs(map.mesh, clusters, left);
    SurfaceMap out{map.body, packed(map.mesh, left), {}, map.computed};
    for (const MapField& field : map.fields)
      out.fields.push_back(inherited(field, area, heir, left.size()));
    return out;
  }
  return map;  // nothing fewer keeps an area
}

std::vector<SurfaceMap> boundary_maps(const Recording& recording, std::size_t most) {
  std::vector<SurfaceMap> maps;
  for (const BoundaryLoads& loads : boundary_loads(recording)) {
    if (loads.end.empty()) continue;
    SurfaceMap& map = maps.emplace_back(SurfaceMap{loads.boundary, loads.mesh, {}, 0});
    for (const char* shown :
         {"peak_stress", "normal_force", "sliding_distance", "frictional_power", "wear_depth"}) {
      const auto field = std::ranges::find(loads.fields, shown, &TriangleField::name);
      if (field != loads.fields.end()) map.fields.push_back(over_run(loads, *field));
    }
  }
  return within(std::move(maps), most);
}

std::vector<SurfaceMap> shape_maps(const Recording& recording, std::size_t most) {
  std::vector<SurfaceMap> maps;
  for (const SurfaceLoads& loads : surface_loads(recording)) {
    SurfaceMap& map = maps.emplace_back(SurfaceMap{loads.shape, loads.mesh, {}, 0});
    for (const TriangleField& field : loads.fields) {
      MapField& out = map.fields.emplace_back();
      out.key = out.name = field.name;
      std::ranges::replace(out.name, '_', ' ');
      out.unit = unit_text(field.unit);
      if (field.name == "peak_normal_force") out.merge = MapMerge::largest;
      out.values = field.values;
    }
  }
  return within(std::move(maps), most);
}

}  // namespace firn
