// Swept solids of machine parts: a closed mesh for mass and display, convex parts for contact.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "firn/convex_part.h"
#include "firn/mesh.h"

namespace firn {

// The convex parts fill the volume of the mesh without overlap. Faces between them are internal
// faces; see contact_parts().
struct Solid {
  TriangleMesh mesh;  // m, watertight, facing outwards
  std::vector<ConvexPart> parts;
};

// A dimension without a valid solid, and its key in a case file.
struct DimensionError : InputError {
  DimensionError(std::string named, std::string wrong)
      : InputError(named + " " + wrong), key(std::move(named)), message(std::move(wrong)) {}
  std::string key, message;
};

using Point2 = Eigen::Vector2d;  // m

// A plane section of convex polygons. A corner of several polygons is stored once. A corner on the
// edge of another polygon divides that edge.
class Section {
 public:
  // Adds a polygon with its corners counter-clockwise. Returns its index.
  int add(const std::vector<Point2>& corners);

  const std::vector<Point2>& points() const { return points_; }
  const std::vector<std::vector<int>>& polygons() const { return polygons_; }
  // [polygons] point indices of the corners and of all points on the edges.
  std::vector<std::vector<int>> split_loops() const;

 private:
  int point(const Point2& p);

  std::vector<Point2> points_;
  std::vector<std::vector<int>> polygons_;  // point indices of the corners
};

// Positions of the points of a section at the stations of a sweep: [station][point], m.
using Stations = std::vector<std::vector<Vec3>>;
// Whether a polygon is solid between a station and the next one: [polygon][station].
using Filling = std::vector<std::vector<bool>>;

// Sweeps a section through its stations. The normal of the section (cross product of its axes) must
// point along the sweep. All side faces must be plane. Polygons that share a part of an edge only
// give side faces that are internal in part: see contact_parts().
Solid extrude(const Section& section, const Stations& stations, const Filling& filling);
// The same with all polygons solid.
Solid extrude(const Section& section, const Stations& stations);

// Stations in planes x = at + slope * z. The axes of the section are y and z.
struct Station {
  double at = 0;     // m
  double slope = 0;  // of the plane, in x over z
};
Stations stations_along_x(const Section& section, const std::vector<Station>& places);
// Stations at these z (m). The axes of the section are x and y.
Stations stations_along_z(const Section& section, const std::vector<double>& heights);
// Stations along a polyline (m): normal to it at both ends, in the bisecting plane at the bends.
// The x axis of the section points to the left of the first leg seen with z up (y for a leg along
// x), its y axis upwards. Throws InputError if a leg is too short for its bends.
Stations stations_along(const Section& section, const std::vector<Vec3>& line);

// Convex parts of convex pieces. A face that other pieces cover completely becomes an internal
// face, so that each contact belongs to one part (ConvexPart). A face covered in part stays a
// surface face. That is correct at a concave corner, such as a shaft below its blade. It must be
// avoided where a coplanar face continues it: a penetrating body would collide with the covered
// part.
std::vector<ConvexPart> contact_parts(const std::vector<std::vector<HalfSpace>>& pieces);

// The half-space bounded by the plane of a polygon with corners counter-clockwise seen from
// outside.
HalfSpace half_space_behind(const std::vector<Vec3>& corners);

// Number of corners of the polygons that replace circles: of vessels and blades (largest deviation
// 0.21 % of the radius), and of wires (3.4 %). The corners are on the circle.
inline constexpr int kCircle = 48;
inline constexpr int kWireCircle = 12;
std::vector<Point2> circle(double radius, int corners);

// The part of a convex polygon above (or below) the line y = height (m).
std::vector<Point2> clip_polygon(const std::vector<Point2>& polygon, double height, bool above);

}  // namespace firn
