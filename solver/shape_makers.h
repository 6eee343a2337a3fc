// Steps that the makers of shapes share.
#pragma once

#include <vector>

#include "solver/shape.h"

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

// Largest distance (m) between the mesh and the swept parts' surface: mesh vertices and triangle
// centres against the parts, corners of the parts pushed outwards by the sweep radius against the
// mesh. Meshes of more than about 4000 points are sampled evenly.
double measure_deviation(const Shape& shape);

// The frame of principal axes nearest to the given axes. Products of inertia below 1e-7 of the
// trace count as none: the axes stay as drawn.
struct PrincipalInertia {
  Quat axes = Quat::Identity();  // principal -> given axes
  Vec3 moments = Vec3::Zero();   // about the principal axes
};
PrincipalInertia principal_inertia(const Mat3& inertia);

}  // namespace firn
