// Solids of machine parts: a closed mesh for mass and drawing, convex parts for contact.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "firn/convex_part.h"
#include "firn/mesh.h"

namespace firn {

// The parts fill the same space as the mesh, without overlap. Where they meet are seams that no
// body feels; see join().
struct Solid {
  TriangleMesh mesh;  // m, closed, facing outwards
  std::vector<ConvexPart> parts;
};

// A dimension that cannot be made, with its key in a case file.
struct DimensionError : InputError {
  DimensionError(std::string named, std::string wrong)
      : InputError(named + " " + wrong), key(std::move(named)), message(std::move(wrong)) {}
  std::string key, message;
};

using Point2 = Eigen::Vector2d;  // m

// A plane figure of convex polygons. Corners that several polygons share are one point; where a
// corner lies on another polygon's edge, that edge counts as two.
class Section {
 public:
  // Corners run counter-clockwise. Returns the polygon's index.
  int add(const std::vector<Point2>& corners);

  const std::vector<Point2>& points() const { return points_; }
  const std::vector<std::vector<int>>& polygons() const { return polygons_; }
  // Loops of the polygons with every point that lies on their edges.
  std::vector<std::vector<int>> split_loops() const;

 private:
  int point(const Point2& p);

  std::vector<Point2> points_;
  std::vector<std::vector<int>> polygons_;  // corners
};

// Where the points of a section are at each station of a sweep: [station][point], m.
using Stations = std::vector<std::vector<Vec3>>;
// Which polygons there are between one station and the next: [polygon][station].
using Filling = std::vector<std::vector<bool>>;

// The section swept through its stations, its normal (the cross product of its axes) along the
// sweep. All side faces must be plane. Polygons that meet along a part of an edge only make sides
// that are seams in part: see join().
Solid extrude(const Section& section, const Stations& stations, const Filling& filling);
// The whole section everywhere.
Solid extrude(const Section& section, const Stations& stations);

// The section's axes are y and z of the solid; station i lies at x = at + slope * z.
struct Station {
  double at = 0;     // m
  double slope = 0;  // of the plane, in x over z
};
Stations stations_along_x(const Section& section, const std::vector<Station>& places);
// The section's axes are x and y, its stations at these z.
Stations stations_along_z(const Section& section, const std::vector<double>& heights);
// Along a line of points, cut square at both ends and halving the angle at the bends. The section's
// x points to the left of the first leg as seen with z up (along y for one in x), its y up. Throws
// InputError where a leg is too short for its bends.
Stations stations_along(const Section& section, const std::vector<Vec3>& line);

// Convex pieces as contact parts. A face that others cover wholly becomes an internal one, so that
// the seam rule of ConvexPart gives each contact to one side. One that is covered in part stays a
// surface: that is right where it is the bottom of a corner, such as a shaft below its blade, and
// to be avoided where others continue it, as a body that has sunk in would meet a step.
std::vector<ConvexPart> join(const std::vector<std::vector<HalfSpace>>& pieces);

// The half-space behind a plane polygon, its corners counter-clockwise seen from outside.
HalfSpace behind(const std::vector<Vec3>& corners);

// Circles are polygons with their corners on the circle: so many of them for vessels and blades
// (flats lie 0.21 % of the radius inside), and so many for wires (3.4 %).
inline constexpr int kCircle = 48;
inline constexpr int kWireCircle = 12;
std::vector<Point2> circle(double radius, int corners);

// What of a convex polygon lies above (or below) the line y = height.
std::vector<Point2> cut(const std::vector<Point2>& polygon, double height, bool above);

}  // namespace firn
