// Wires and augers.
#include <algorithm>
#include <cmath>

#include "experiments/machine/dimension_checks.h"
#include "experiments/machine/parts.h"

namespace firn {
namespace {

// Stations of a blade: so many a turn, the corners of its edge and of the shaft.
constexpr int kStations = kCircle;

int station_count(double turns) {
  const double count = turns * kStations;
  require(count >= 1 - 1e-9 && std::abs(count - std::round(count)) < 1e-6, "turns",
          fmt::format("is {:.9g}; expected a multiple of 1/{}, as a turn has so many flats", turns,
                      kStations));
  return static_cast<int>(std::lround(count));
}

// A blade and its shaft, right-handed: station s is at the angle 2 pi s / kStations.
class Screw {
 public:
  explicit Screw(const Auger& a)
      : inner_(a.shaft_diameter / 2),
        outer_(a.outer_diameter / 2),
        thickness_(a.blade_thickness),
        advance_(a.pitch / kStations),
        stations_(station_count(a.turns)),
        begin_(-a.overhang),
        end_(advance_ * stations_ + thickness_ + a.overhang) {}

  TriangleMesh mesh();
  std::vector<std::vector<HalfSpace>> pieces() const;

 private:
  static Vec3 around(double radius, int station, double x) {
    const double angle = 2 * std::numbers::pi * (station % kStations) / kStations;
    return {x, radius * std::cos(angle), radius * std::sin(angle)};
  }
  // Corners of the blade's section, from below at the shaft: in, out, out, in.
  Vec3 corner(int station, int k) const {
    return around(k == 0 || k == 3 ? inner_ : outer_, station,
                  advance_ * station + (k >= 2 ? thickness_ : 0));
  }
  // Vertices of the mesh: all corners of the blade, then both ends of each edge of the shaft.
  int blade_vertex(int station, int k) const { return 4 * station + k; }
  int shaft_vertex(int edge, bool end) const { return 4 * (stations_ + 1) + 2 * edge + end; }
  void face(const std::vector<int>& loop);
  void add_blade();
  void add_shaft();
  std::vector<int> levels(int flat) const;
  std::vector<HalfSpace> wedge(int station, bool outside) const;

  double inner_, outer_, thickness_, advance_;
  int stations_;
  double begin_, end_;  // x of the shaft's ends
  TriangleMesh mesh_;
};

// A plane convex loop; more than three corners go about the middle, as some may lie on edges.
void Screw::face(const std::vector<int>& loop) {
  if (loop.size() == 3) {
    mesh_.triangles.push_back({loop[0], loop[1], loop[2]});
    return;
  }
  Vec3 middle = Vec3::Zero();
  for (const int i : loop) middle += mesh_.vertices[i];
  const int center = static_cast<int>(mesh_.vertices.size());
  mesh_.vertices.push_back(middle / static_cast<double>(loop.size()));
  for (std::size_t k = 0; k < loop.size(); ++k) {
    mesh_.triangles.push_back({center, loop[k], loop[(k + 1) % loop.size()]});
  }
}

// Flanks are split along the diagonal from the inner corner of one station to the outer one of the
// next, as the wedges are.
void Screw::add_blade() {
  const auto v = [&](int s, int k) { return blade_vertex(s, k); };
  for (int s = 0; s < stations_; ++s) {
    face({v(s, 0), v(s + 1, 1), v(s, 1)});
    face({v(s, 0), v(s + 1, 0), v(s + 1, 1)});
    face({v(s, 3), v(s, 2), v(s + 1, 2)});
    face({v(s, 3), v(s + 1, 2), v(s + 1, 3)});
    face({v(s, 1), v(s + 1, 1), v(s + 1, 2)});
    face({v(s, 1), v(s + 1, 2), v(s, 2)});
  }
  face({v(0, 0), v(0, 1), v(0, 2), v(0, 3)});
  face({v(stations_, 3), v(stations_, 2), v(stations_, 1), v(stations_, 0)});
}

// Vertices up one edge of the shaft: its begin, where the blade comes past, its end.
std::vector<int> Screw::levels(int edge) const {
  std::vector<int> result = {shaft_vertex(edge, false)};
  for (int s = edge; s <= stations_; s += kStations) {
    result.push_back(blade_vertex(s, 0));
    result.push_back(blade_vertex(s, 3));
  }
  result.push_back(shaft_vertex(edge, true));
  return result;
}

// Each flat of the shaft is cut by the blade into stretches.
void Screw::add_shaft() {
  for (int edge = 0; edge < kStations; ++edge) {
    const std::vector<int> left = levels(edge), right = levels((edge + 1) % kStations);
    // Pairs of levels, left and right, between which the flat is free.
    std::vector<std::array<int, 2>> bounds = {{left.front(), right.front()}};
    for (int s = edge; s < stations_; s += kStations) {
      bounds.push_back({blade_vertex(s, 0), blade_vertex(s + 1, 0)});
      bounds.push_back({blade_vertex(s, 3), blade_vertex(s + 1, 3)});
    }
    bounds.push_back({left.back(), right.back()});
    for (std::size_t i = 0; i + 1 < bounds.size(); i += 2) {
      const auto from = [](const std::vector<int>& all, int low, int high) {
        return std::vector<int>(std::ranges::find(all, low), std::ranges::find(all, high) + 1);
      };
      std::vector<int> loop = from(left, bounds[i][0], bounds[i + 1][0]);
      const std::vector<int> back = from(right, bounds[i][1], bounds[i + 1][1]);
      loop.insert(loop.end(), back.rbegin(), back.rend());
      std::ranges::reverse(loop);
      face(loop);
    }
  }
  std::vector<int> first, last;
  for (int edge = 0; edge < kStations; ++edge) {
    first.push_back(shaft_vertex(kStations - 1 - edge, false));
    last.push_back(shaft_vertex(edge, true));
  }
  face(first);
  face(last);
}

TriangleMesh Screw::mesh() {
  mesh_ = {};
  for (int s = 0; s <= stations_; ++s) {
    for (int k = 0; k < 4; ++k) mesh_.vertices.push_back(corner(s, k));
  }
  for (int edge = 0; edge < kStations; ++edge) {
    mesh_.vertices.push_back(around(inner_, edge, begin_));
    mesh_.vertices.push_back(around(inner_, edge, end_));
  }
  add_blade();
  add_shaft();
  return mesh_;
}

// Between two stations the flank of a helix is no plane: two wedges, each a triangle sheared along
// x, are. Their walls stand along x, so neighbors meet face to face.
std::vector<HalfSpace> Screw::wedge(int s, bool outside) const {
  const std::array<std::pair<int, int>, 3> corners =
      outside ? std::array<std::pair<int, int>, 3>{{{s, 0}, {s, 1}, {s + 1, 1}}}
              : std::array<std::pair<int, int>, 3>{{{s, 0}, {s + 1, 1}, {s + 1, 0}}};
  std::vector<Vec3> low, high;
  for (const auto& [station, k] : corners) {
    low.push_back(corner(station, k));
    high.push_back(corner(station, 3 - k));
  }
  std::vector<HalfSpace> faces = {half_space_behind({low[2], low[1], low[0]}),
                                  half_space_behind(high)};
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    faces.push_back(half_space_behind({low[k], low[next], high[next], high[k]}));
  }
  return faces;
}

std::vector<std::vector<HalfSpace>> Screw::pieces() const {
  std::vector<Vec3> first, last;
  for (int edge = 0; edge < kStations; ++edge) {
    first.push_back(around(inner_, kStations - 1 - edge, begin_));
    last.push_back(around(inner_, edge, end_));
  }
  std::vector<HalfSpace> shaft = {half_space_behind(first), half_space_behind(last)};
  for (int edge = 0; edge < kStations; ++edge) {
    shaft.push_back(
        half_space_behind({around(inner_, edge, begin_), around(inner_, edge + 1, begin_),
                           around(inner_, edge + 1, end_), around(inner_, edge, end_)}));
  }
  std::vector<std::vector<HalfSpace>> all = {shaft};
  for (int s = 0; s < stations_; ++s) {
    all.push_back(wedge(s, true));
    all.push_back(wedge(s, false));
  }
  return all;
}

// The mirror image in the plane z = 0.
void mirror(TriangleMesh& mesh) {
  for (Vec3& v : mesh.vertices) v.z() = -v.z();
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
}

}  // namespace

Solid make_wire(const Wire& w) {
  require_above_zero(w.diameter, "diameter");
  require(w.points.size() >= 2, "points", "are less than two; expected at least two");
  for (std::size_t i = 1; i < w.points.size(); ++i) {
    require((w.points[i] - w.points[i - 1]).norm() > 1e-3 * w.diameter, "points",
            fmt::format("{} and {} are one place; expected different ones", i, i + 1));
  }
  Section section;
  section.add(circle(w.diameter / 2, kWireCircle));
  try {
    return extrude(section, stations_along(section, w.points));
  } catch (const InputError& error) {
    throw DimensionError("points", error.what());
  }
}

Solid make_auger(const Auger& a) {
  require_above_zero(a.shaft_diameter, "shaft_diameter");
  require(a.outer_diameter > a.shaft_diameter, "shaft_diameter",
          fmt::format("is {}; expected less than the outer diameter of {}", in_mm(a.shaft_diameter),
                      in_mm(a.outer_diameter)));
  require_above_zero(a.overhang, "overhang");
  require(a.blade_thickness > 0 && a.blade_thickness < a.pitch, "blade_thickness",
          fmt::format("is {}; expected more than zero and less than the pitch of {}",
                      in_mm(a.blade_thickness), in_mm(a.pitch)));
  Screw screw(a);
  Solid solid{screw.mesh(), {}};
  std::vector<std::vector<HalfSpace>> pieces = screw.pieces();
  if (a.left_handed) {
    mirror(solid.mesh);
    for (auto& faces : pieces) {
      for (HalfSpace& face : faces) face.normal.z() = -face.normal.z();
    }
  }
  solid.parts = contact_parts(pieces);
  return solid;
}

Solid make_wire_auger(const WireAuger& a) {
  require(a.wire_diameter > 0 && 2 * a.wire_diameter < a.outer_diameter, "wire_diameter",
          fmt::format("is {}; expected more than zero and less than half the outer diameter of {}",
                      in_mm(a.wire_diameter), in_mm(a.outer_diameter)));
  require(a.pitch > a.wire_diameter, "pitch",
          fmt::format("is {}; expected more than the wire's {}", in_mm(a.pitch),
                      in_mm(a.wire_diameter)));
  const int stations = station_count(a.turns);
  const double radius = (a.outer_diameter - a.wire_diameter) / 2;
  Wire wire{a.wire_diameter, {}};
  for (int s = 0; s <= stations; ++s) {
    const double angle = (a.left_handed ? -2 : 2) * std::numbers::pi * s / kStations;
    wire.points.emplace_back(a.pitch * s / kStations, radius * std::cos(angle),
                             radius * std::sin(angle));
  }
  return make_wire(wire);
}

}  // namespace firn
