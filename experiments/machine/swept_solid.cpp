#include "experiments/machine/swept_solid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace firn {
namespace {

using Loop = std::vector<int>;

// Nearer than this (of the figure's size) is the same point, or on the line.
constexpr double kSame = 1e-9;

double extent_of(const std::vector<Point2>& points) {
  double size = 0;
  for (const Point2& p : points) size = std::max(size, p.cwiseAbs().maxCoeff());
  return size;
}

double cross(const Point2& a, const Point2& b) { return a.x() * b.y() - a.y() * b.x(); }

// Twice the area, as a vector along the normal.
Vec3 area_vector(const std::vector<Vec3>& loop) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
    sum += (loop[i] - loop[0]).cross(loop[i + 1] - loop[0]);
  }
  return sum;
}

// Collects faces; points that no face uses are left out in the end.
class MeshMaker {
 public:
  explicit MeshMaker(const Stations& stations) : count_(stations[0].size()) {
    for (const auto& station : stations) {
      mesh_.vertices.insert(mesh_.vertices.end(), station.begin(), station.end());
    }
  }

  void side(int from, int to, std::size_t station) {
    const int a = index(station, from), b = index(station, to);
    const int c = index(station + 1, to), d = index(station + 1, from);
    mesh_.triangles.push_back({a, b, c});
    mesh_.triangles.push_back({a, c, d});
  }

  // About the middle, so that points along an edge do no harm.
  void cap(const Loop& loop, std::size_t station, bool forward) {
    Vec3 middle = Vec3::Zero();
    for (const int i : loop) middle += mesh_.vertices[index(station, i)];
    const int center = static_cast<int>(mesh_.vertices.size());
    mesh_.vertices.push_back(middle / static_cast<double>(loop.size()));
    for (std::size_t k = 0; k < loop.size(); ++k) {
      int a = index(station, loop[k]), b = index(station, loop[(k + 1) % loop.size()]);
      if (!forward) std::swap(a, b);
      mesh_.triangles.push_back({center, a, b});
    }
  }

  TriangleMesh finish() {
    std::vector<int> number(mesh_.vertices.size(), -1);
    TriangleMesh used;
    for (auto& triangle : mesh_.triangles) {
      for (int& i : triangle) {
        if (number[i] < 0) {
          number[i] = static_cast<int>(used.vertices.size());
          used.vertices.push_back(mesh_.vertices[i]);
        }
        i = number[i];
      }
    }
    used.triangles = std::move(mesh_.triangles);
    return used;
  }

 private:
  int index(std::size_t station, int point) const {
    return static_cast<int>(station * count_) + point;
  }

  std::size_t count_;
  TriangleMesh mesh_;
};

TriangleMesh mesh_of(const Section& section, const Stations& stations, const Filling& filling) {
  const std::vector<Loop> loops = section.split_loops();
  MeshMaker mesh(stations);
  for (std::size_t j = 0; j + 1 < stations.size(); ++j) {
    std::set<std::pair<int, int>> edges;
    for (std::size_t p = 0; p < loops.size(); ++p) {
      if (!filling[p][j]) continue;
      for (std::size_t k = 0; k < loops[p].size(); ++k) {
        edges.emplace(loops[p][k], loops[p][(k + 1) % loops[p].size()]);
      }
    }
    for (const auto& [a, b] : edges) {
      if (!edges.contains({b, a})) mesh.side(a, b, j);
    }
  }
  for (std::size_t j = 0; j < stations.size(); ++j) {
    for (std::size_t p = 0; p < loops.size(); ++p) {
      const bool before = j > 0 && filling[p][j - 1];
      const bool behind = j + 1 < stations.size() && filling[p][j];
      if (before != behind) mesh.cap(loops[p], j, before);
    }
  }
  return mesh.finish();
}

// True when the sides of the polygon run straight on through this station.
bool straight(const Loop& polygon, const Stations& stations, std::size_t at) {
  return std::ranges::all_of(polygon, [&](int i) {
    const Vec3 in = stations[at][i] - stations[at - 1][i];
    const Vec3 out = stations[at + 1][i] - stations[at][i];
    return in.cross(out).norm() <= kSame * in.norm() * out.norm();
  });
}

std::vector<HalfSpace> piece(const Loop& polygon, const std::vector<Vec3>& begin,
                             const std::vector<Vec3>& end) {
  std::vector<Vec3> first, last;
  for (const int i : polygon) last.push_back(end[i]);
  for (auto i = polygon.rbegin(); i != polygon.rend(); ++i) first.push_back(begin[*i]);
  std::vector<HalfSpace> faces = {half_space_behind(first), half_space_behind(last)};
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const int a = polygon[k], b = polygon[(k + 1) % polygon.size()];
    faces.push_back(half_space_behind({begin[a], begin[b], end[b], end[a]}));
  }
  return faces;
}

// The polygons on the other side of each polygon's edges.
std::vector<std::set<std::size_t>> neighbors(const std::vector<Loop>& loops) {
  std::map<std::pair<int, int>, std::vector<std::size_t>> owners;
  for (std::size_t p = 0; p < loops.size(); ++p) {
    for (std::size_t k = 0; k < loops[p].size(); ++k) {
      owners[{loops[p][k], loops[p][(k + 1) % loops[p].size()]}].push_back(p);
    }
  }
  std::vector<std::set<std::size_t>> result(loops.size());
  for (const auto& [edge, these] : owners) {
    const auto others = owners.find({edge.second, edge.first});
    if (others == owners.end()) continue;
    for (const std::size_t p : these)
      result[p].insert(others->second.begin(), others->second.end());
  }
  return result;
}

// A piece ends where it bends, and where a neighbor begins or ends: a side that is only partly
// an internal face would act as an edge on bodies that slide over it with a large overlap.
std::vector<std::vector<HalfSpace>> pieces_of(const Section& section, const Stations& stations,
                                              const Filling& filling) {
  const std::vector<std::set<std::size_t>> adjacent = neighbors(section.split_loops());
  std::vector<std::vector<HalfSpace>> pieces;
  const std::size_t layers = stations.size() - 1;
  for (std::size_t p = 0; p < section.polygons().size(); ++p) {
    const Loop& polygon = section.polygons()[p];
    const auto continues = [&](std::size_t at) {
      return filling[p][at] && straight(polygon, stations, at) &&
             std::ranges::all_of(
                 adjacent[p], [&](std::size_t q) { return filling[q][at - 1] == filling[q][at]; });
    };
    for (std::size_t begin = 0; begin < layers; ++begin) {
      if (!filling[p][begin]) continue;
      std::size_t end = begin + 1;
      while (end < layers && continues(end)) ++end;
      pieces.push_back(piece(polygon, stations[begin], stations[end]));
      begin = end - 1;
    }
  }
  return pieces;
}

std::vector<Vec3> corners_of(const ConvexPart& part, const ConvexPart::Face& face) {
  std::vector<Vec3> loop;
  for (int k = 0; k < face.count; ++k)
    loop.push_back(part.vertex(part.face_vertices[face.first + k]));
  return loop;
}

// What of a plane polygon lies in a solid.
std::vector<Vec3> clipped(std::vector<Vec3> loop, const ConvexPart& solid) {
  for (const auto& face : solid.faces) {
    std::vector<Vec3> kept;
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const Vec3 &a = loop[k], &b = loop[(k + 1) % loop.size()];
      const double height_a = face.normal.dot(a) - face.offset;
      const double height_b = face.normal.dot(b) - face.offset;
      if (height_a <= 0) kept.push_back(a);
      if ((height_a < 0) != (height_b < 0) && height_a != height_b) {
        kept.push_back(a + height_a / (height_a - height_b) * (b - a));
      }
    }
    loop = std::move(kept);
  }
  return loop;
}

bool covered(const std::vector<ConvexPart>& parts, std::size_t own, const ConvexPart::Face& face) {
  constexpr double kOut = 1e-6;      // of the part's size: a place just outside the face
  constexpr double kWhole = 0.9995;  // of the face's area
  std::vector<Vec3> loop = corners_of(parts[own], face);
  const double area = area_vector(loop).norm();
  for (Vec3& p : loop) p += kOut * parts[own].bounding_radius * face.normal;
  double found = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const double apart = (parts[i].center - parts[own].center).norm();
    if (i == own || apart > parts[i].bounding_radius + 1.01 * parts[own].bounding_radius) continue;
    found += area_vector(clipped(loop, parts[i])).norm();
  }
  return found > kWhole * area;
}

}  // namespace

int Section::point(const Point2& p) {
  const double same = kSame * std::max(extent_of(points_), p.cwiseAbs().maxCoeff());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if ((points_[i] - p).norm() <= same) return static_cast<int>(i);
  }
  points_.push_back(p);
  return static_cast<int>(points_.size()) - 1;
}

int Section::add(const std::vector<Point2>& corners) {
  Loop polygon;
  for (const Point2& p : corners) {
    const int i = point(p);
    if (polygon.empty() || (polygon.back() != i && polygon.front() != i)) polygon.push_back(i);
  }
  polygons_.push_back(std::move(polygon));
  return static_cast<int>(polygons_.size()) - 1;
}

std::vector<Loop> Section::split_loops() const {
  const double near = kSame * extent_of(points_);
  std::vector<Loop> loops;
  for (const Loop& polygon : polygons_) {
    Loop loop;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const int a = polygon[k], b = polygon[(k + 1) % polygon.size()];
      const Point2 edge = points_[b] - points_[a];
      std::vector<std::pair<double, int>> on_edge = {{0, a}};
      for (int i = 0; i < static_cast<int>(points_.size()); ++i) {
        const Point2 to = points_[i] - points_[a];
        const double along = to.dot(edge) / edge.squaredNorm();
        if (i == a || i == b || along <= 0 || along >= 1) continue;
        if (std::abs(cross(edge, to)) <= near * edge.norm()) on_edge.emplace_back(along, i);
      }
      std::ranges::sort(on_edge);
      for (const auto& [along, i] : on_edge) loop.push_back(i);
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

Solid extrude(const Section& section, const Stations& stations, const Filling& filling) {
  return {mesh_of(section, stations, filling),
          contact_parts(pieces_of(section, stations, filling))};
}

Solid extrude(const Section& section, const Stations& stations) {
  return extrude(section, stations,
                 Filling(section.polygons().size(), std::vector<bool>(stations.size() - 1, true)));
}

Stations stations_along_x(const Section& section, const std::vector<Station>& places) {
  Stations stations;
  for (const Station& place : places) {
    std::vector<Vec3>& station = stations.emplace_back();
    for (const Point2& p : section.points()) {
      station.emplace_back(place.at + place.slope * p.y(), p.x(), p.y());
    }
  }
  return stations;
}

Stations stations_along_z(const Section& section, const std::vector<double>& heights) {
  Stations stations;
  for (const double z : heights) {
    std::vector<Vec3>& station = stations.emplace_back();
    for (const Point2& p : section.points()) station.emplace_back(p.x(), p.y(), z);
  }
  return stations;
}

Stations stations_along(const Section& section, const std::vector<Vec3>& line) {
  std::vector<Vec3> legs;
  for (std::size_t i = 1; i < line.size(); ++i)
    legs.push_back((line[i] - line[i - 1]).normalized());
  const Vec3 steep = std::abs(legs[0].z()) > 0.999 ? Vec3::UnitX() : Vec3::UnitZ();
  const Vec3 left = steep.cross(legs[0]).normalized(), up = legs[0].cross(left);
  Stations stations(line.size());
  for (const Point2& p : section.points()) {
    stations[0].push_back(line[0] + p.x() * left + p.y() * up);
  }
  for (std::size_t j = 1; j < line.size(); ++j) {
    const Vec3& in = legs[j - 1];
    const Vec3 across = j < legs.size() ? Vec3(in + legs[j]) : in;
    for (const Vec3& from : stations[j - 1]) {
      const double distance = across.dot(line[j] - from) / across.dot(in);
      if (!(distance > 0)) {
        throw InputError(
            fmt::format("has no room for the bend at point {}; expected longer legs or "
                        "gentler bends",
                        distance == distance && j < legs.size() ? j + 1 : j));
      }
      stations[j].push_back(from + distance * in);
    }
  }
  return stations;
}

std::vector<ConvexPart> contact_parts(const std::vector<std::vector<HalfSpace>>& pieces) {
  std::vector<ConvexPart> bare, parts;
  for (const auto& faces : pieces) bare.push_back(convex_part(faces, 0));
  for (std::size_t i = 0; i < bare.size(); ++i) {
    std::vector<HalfSpace> faces;
    for (const auto& face : bare[i].faces) {
      faces.push_back({face.normal, face.offset, covered(bare, i, face)});
    }
    parts.push_back(convex_part(faces, 0));
  }
  return parts;
}

HalfSpace half_space_behind(const std::vector<Vec3>& corners) {
  const Vec3 normal = area_vector(corners).normalized();
  double offset = 0;
  for (const Vec3& p : corners) offset += normal.dot(p) / static_cast<double>(corners.size());
  return {normal, offset, false};
}

std::vector<Point2> circle(double radius, int corners) {
  std::vector<Point2> points;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return points;
}

std::vector<Point2> clip_polygon(const std::vector<Point2>& polygon, double height, bool above) {
  std::vector<Point2> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double over_a = a.y() - height, over_b = b.y() - height;
    if (above ? over_a >= 0 : over_a <= 0) kept.push_back(a);
    if (over_a * over_b < 0) kept.push_back(a + over_a / (over_a - over_b) * (b - a));
  }
  return kept;
}

}  // namespace firn
