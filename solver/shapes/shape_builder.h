// Common steps of the makers of shapes.
#pragma once

#include <algorithm>
#include <vector>

#include "firn/shape.h"

namespace firn {

// Everything but parts, neighbours, reach and deviation. `integrals` are those of the solid meant,
// at unit density, in shape axes; the mesh may be a drawing of it (a sphere's).
Shape begin_shape(TriangleMesh mesh, const MassProperties& integrals, const ShapeOptions& options);

// Adds the piece enclosed by half-spaces (shape axes), eroded by shape.rounding.
void add_part(Shape& shape, std::vector<HalfSpace> half_spaces);

// Sets the bounding radius from mesh and parts. Throws InputError for more than 64 parts.
void set_reach(Shape& shape);

// Neighbours by distance: parts touch when their swept surfaces do.
void find_neighbours(Shape& shape);

// Distance (m) between the surfaces of the mesh and of the union of the swept parts.
struct Deviation {
  double rounding = 0;  // largest distance of a point of the mesh that lies outside of the parts
  double surplus = 0;   // largest of one inside, and of a point of the parts' surface to the mesh
  double largest() const { return std::max(rounding, surplus); }
};
// Samples both surfaces: corners, and points on every face no farther apart than a sixtieth of the
// box diagonal. Points of a part's surface within another part do not count, nor do cuts. The
// distance of a mesh point inside the union is rounded up where its nearest face is covered.
Deviation measure_deviation(const Shape& shape);

// Default sweep radius (m) for pieces (shape axes): 2 % of `edge`, the smallest edge of the
// bounding box; no more than a quarter of the thinnest piece; and so little that no corner of the
// mesh is left outside of the parts by more than 1.8 % of `edge`.
double default_rounding(const std::vector<std::vector<HalfSpace>>& pieces, const TriangleMesh& mesh,
                        double edge);

// The frame of principal axes nearest to the given axes. Products of inertia below 1e-7 of the
// trace count as none: the axes stay as drawn.
struct PrincipalInertia {
  Quat axes = Quat::Identity();  // principal -> given axes
  Vec3 moments = Vec3::Zero();   // about the principal axes
};
PrincipalInertia principal_inertia(const Mat3& inertia);

}  // namespace firn
