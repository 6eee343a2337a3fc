// Triangle meshes: the geometry of a body for mass, measurements and display.
#pragma once

#include <array>
#include <vector>

#include "firn/math.h"

namespace firn {

struct TriangleMesh {
  std::vector<Vec3> vertices;                 // m
  std::vector<std::array<int, 3>> triangles;  // counter-clockwise seen from outside
};

// Defects that prevent the use of a mesh as a solid. All zero for a closed, outward-facing
// manifold.
struct MeshDefects {
  int open_edges = 0;         // edges with one triangle
  int nonmanifold_edges = 0;  // edges with more than two
  int flipped_edges = 0;      // edges with two triangles of opposite orientation
  int degenerate = 0;         // triangles of no area
  int duplicated = 0;         // the same three corners twice
  bool inside_out = false;    // signed volume below zero
  bool non_finite = false;    // a coordinate is NaN or infinite
  bool is_valid() const {
    return !(open_edges || nonmanifold_edges || flipped_edges || degenerate || duplicated ||
             inside_out || non_finite);
  }
  std::string to_message() const;  // lists and counts the defects; empty without defects
};
MeshDefects inspect(const TriangleMesh& mesh);

// Volume integrals at unit density (divergence theorem; exact for a closed polyhedron).
struct MassProperties {
  double volume = 0;             // m^3
  Vec3 centroid = Vec3::Zero();  // m, mesh axes
  Mat3 inertia = Mat3::Zero();   // m^5: integral of (|x|^2 I - x x^T) dV about the centroid
};
MassProperties mass_properties(const TriangleMesh& mesh);

// Axis-aligned extents, m: {lower corner, upper corner}.
std::array<Vec3, 2> bounding_box(const TriangleMesh& mesh);

// A box centered at the origin with the edge lengths `size` (m).
TriangleMesh box_mesh(const Vec3& size);

// Merges vertices within `tolerance` (m) and removes degenerate triangles.
TriangleMesh weld(const TriangleMesh& mesh, double tolerance);

// Outward normal with twice the area of the triangle as its length, m^2.
Vec3 area_normal(const TriangleMesh& mesh, std::size_t triangle);

// Subdivides triangles until no edge is longer than `edge` (m): a longer edge is divided at its
// middle, in both triangles that share it. The triangles of one original triangle are consecutive,
// in the original order.
TriangleMesh subdivided(const TriangleMesh& mesh, double edge);

}  // namespace firn
