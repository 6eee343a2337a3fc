// Common steps of the construction of shapes.
#pragma once

#include <algorithm>
#include <vector>

#include "firn/shape.h"

namespace firn {

// A shape without parts, neighbors, bounding radius and surface deviation. `integrals`: of the
// exact solid at unit density, in shape axes. The mesh may approximate the solid, e.g. of a sphere.
Shape begin_shape(TriangleMesh mesh, const MassProperties& integrals, const ShapeOptions& options);

// Adds the convex part of the piece enclosed by half-spaces (shape axes), eroded by shape.rounding.
void add_part(Shape& shape, std::vector<HalfSpace> half_spaces);

// Sets the bounding radius of the mesh and the parts. Throws InputError for more than 64 parts.
void compute_bounding_radius(Shape& shape);

// Finds neighboring parts: those whose swept surfaces touch.
void find_neighboring_parts(Shape& shape);

// Distances (m) between the surface of the mesh and that of the union of the swept parts.
struct Deviation {
  double rounding = 0;  // largest, of points of the mesh outside of the parts
  double surplus = 0;   // largest, of points of the mesh inside, and of points on the parts
  double largest() const { return std::max(rounding, surplus); }
};
// Samples corners and points on the faces of both surfaces, at distances of at most a sixtieth of
// the diagonal of the box. Points of a part inside another part and on internal faces do not count.
// For a point of the mesh inside the union whose nearest face is covered, the distance is an upper
// bound.
Deviation measure_deviation(const Shape& shape);

// Default rounding radius (m) of pieces (shape axes): 2 % of `edge`, the smallest edge of the
// bounding box. It is at most a quarter of the least thickness of a piece. Corners of the mesh are
// at most 1.8 % of `edge` outside of the parts.
double default_rounding(const std::vector<std::vector<HalfSpace>>& pieces, const TriangleMesh& mesh,
                        double edge);

// Principal axes and moments, axes nearest to the given ones. Products of inertia below 1e-7 of the
// trace count as zero, so that the given axes are kept.
struct PrincipalInertia {
  Quat axes = Quat::Identity();  // principal -> given axes
  Vec3 moments = Vec3::Zero();   // about the principal axes
};
PrincipalInertia principal_inertia(const Mat3& inertia);

}  // namespace firn
