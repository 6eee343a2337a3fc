// Shapes of particles: mesh, mass, and convex parts for contact.
#pragma once

#include <string>
#include <vector>

#include "firn/convex_part.h"
#include "firn/mesh.h"

namespace firn {

struct Shape {
  std::string name;
  int material = 0;               // index into Model::materials
  TriangleMesh mesh;              // m, shape axes
  std::vector<ConvexPart> parts;  // m, body axes (see below)
  // [parts] bit j: part j touches this part; a part touches itself.
  std::vector<std::uint64_t> part_neighbors;

  // Body axes are the principal axes about the center of mass:
  //   x_shape = centroid + shape_from_body * x_body.
  // Of all such axes, those nearest to the shape axes; equal to the shape axes if these are
  // principal axes (box, sphere, crescent).
  Vec3 centroid = Vec3::Zero();  // m, shape axes
  Quat shape_from_body = Quat::Identity();
  double volume = 0;             // m^3
  double mass = 0;               // kg
  Vec3 inertia = Vec3::Zero();   // kg m^2, principal, body axes
  double bounding_radius = 0;    // m, about the center of mass
  Vec3 box = Vec3::Zero();       // m, bounding box edges in shape axes
  double rounding = 0;           // m, rounding radius (of a sphere: its radius)
  double stiffness_length = 0;   // m, L of equation (6): middle edge of the bounding box
  double stiffness = 0;          // N/m, loading stiffness K of equation (6), or given
  double surface_deviation = 0;  // m, surface deviation: mesh to swept parts, sampled
  std::string deviation_reason;  // cause of surface_deviation, a few words
};

// Input of the make_*() functions in addition to the geometry. These throw InputError for wrong
// input.
struct ShapeOptions {
  std::string name;
  int material = 0;
  double density = 0;           // kg/m^3
  double young_modulus = 0;     // Pa
  double mass = 0;              // kg; 0: density * volume
  double rounding = -1;         // m; below 0: default, see default_rounding()
  double stiffness_length = 0;  // m; 0: the middle bounding-box edge
  double stiffness = 0;         // N/m; 0: young_modulus * stiffness_length
  int max_parts = 64;           // for the decomposition of a concave mesh
};

Shape make_sphere(double radius, const ShapeOptions& options);  // m, about the origin
Shape make_box(const Vec3& size, const ShapeOptions& options);  // edge lengths, m, about the origin
Shape make_convex(const std::vector<Vec3>& points, const ShapeOptions& options);  // hull of them, m
// A watertight mesh of at most 20000 triangles. A mesh whose hull deviates by at most 1.6 % of the
// smallest edge of its bounding box becomes one part. Others are divided into convex pieces of that
// accuracy, at most max_parts. The surface deviation is measured and stored with its cause. Throws
// InputError that lists the defects of a mesh.
Shape make_mesh(const TriangleMesh& mesh, const ShapeOptions& options);
// Rigid union of non-overlapping shapes in common axes, with the sums of mass and inertia. Density
// and rounding of the options are not used. `rounding` is the smallest of the components,
// surface_deviation the largest.
struct Component {
  Shape shape;
  Pose pose;  // shape axes of the component -> shape axes of the compound
};
Shape make_compound(const std::vector<Component>& components, const ShapeOptions& options);

// The parametric crescent of an icemaker. Axes: x chord, y width, z up; the water line is at z = 0,
// the bottom of the arc at z = -depth. docs/shapes.md has the drawing.
struct CrescentParameters {
  enum class Half { none, left, right };  // left: x < 0

  double chord = 60.96e-3;            // m, along x
  double width = 20.574e-3;           // m, along y, at the water line
  double depth = 13.716e-3;           // m, along z
  double tip_height = 2e-3;           // m, of the vertical wall at each tip
  double top_concavity_depth = 1e-3;  // m, of the concave top in the middle
  double draft = 0.0523598776;        // rad, inclination of the sides, inwards towards the bottom
  int facets = 1272;                  // number of triangles of the mesh, rounded to an even number
  int parts = 4;                      // convex pieces along the chord, for contact
  int arc_segments = 12;              // flat pieces of the outer arc, for contact
  Half half = Half::none;             // of the crescent above, cut at x = 0; none: all of it

  bool operator==(const CrescentParameters&) const = default;
};
TriangleMesh crescent_mesh(const CrescentParameters& p);  // m, axes as above; throws InputError
Shape make_crescent(const CrescentParameters& p, const ShapeOptions& options);

// "table1", "mass-matched" (13.7 g at 916.7 kg/m^3 by its depth, solved for the mesh in use) or
// "table1-mass-override" (table1's box, 13.7 g by mass override). Throws InputError for others.
struct NamedCrescent {
  CrescentParameters parameters;
  double mass = 0;  // kg, override; 0: none
};
NamedCrescent named_crescent(const std::string& name, const CrescentParameters& base);

}  // namespace firn
