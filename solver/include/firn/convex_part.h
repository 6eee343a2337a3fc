// A convex part of a body for contact: a core polyhedron swept by a sphere (spheropolyhedron).
//
// The core is the convex piece eroded by the radius. The swept solid core + ball(radius) has the
// faces of the piece, and rounded edges and corners.
#pragma once

#include <cstdint>
#include <vector>

#include "firn/mesh.h"

namespace firn {

// Error of a rounding radius that is too large for its convex part.
struct RoundingError : InputError {
  using InputError::InputError;
};

// The half-space n . x <= offset.
struct HalfSpace {
  Vec3 normal = Vec3::Zero();  // unit, outward
  double offset = 0;           // m
  bool internal = false;       // bounds a neighboring piece, not the surface of the body
};

// Internal faces of a part: one bit each in a mask of 64 bits.
inline constexpr std::size_t kMaxInternalFaces = 64;

struct ConvexPart {
  struct Face {
    Vec3 normal = Vec3::Zero();  // unit, outward
    double offset = 0;           // m: n . x of the core's face
    // Core vertices in counter-clockwise order: face_vertices[first .. first + count).
    int first = 0;
    int count = 0;
    bool internal = false;  // as in HalfSpace
  };

  // Core vertices by coordinate, m, body axes. Padded with copies of the last vertex to a multiple
  // of 8 so that support searches need no remainder loop.
  std::vector<double> x, y, z;
  int vertex_count = 0;
  std::vector<Face> faces;  // flat faces, coplanar triangles merged
  std::vector<std::uint16_t> face_vertices;
  std::vector<std::array<std::uint16_t, 2>> edges;  // each once

  // Edges of each vertex, in ascending order of their other ends, and its faces, ascending.
  struct VertexEdge {
    std::uint16_t vertex = 0;   // at the other end
    double inverse_length = 0;  // 1/m
  };
  struct VertexAdjacency {
    std::uint32_t first_edge = 0, edge_count = 0;  // in vertex_edges
    std::uint32_t first_face = 0, face_count = 0;  // in vertex_faces
  };
  std::vector<VertexAdjacency> adjacency;  // [vertex_count]
  std::vector<VertexEdge> vertex_edges;
  std::vector<std::uint16_t> vertex_faces;
  // [vertex_count] bit f: surface face f has this vertex. Empty for more than 64 faces.
  std::vector<std::uint64_t> surface_faces;

  // Internal faces. A contact whose nearest feature is completely on internal face f and whose
  // normal points out through f belongs to the neighboring part and is discarded for this part
  // (ghost collision).
  std::vector<Vec3> internal_normals;  // at most kMaxInternalFaces
  // [vertex_count] bit f: the vertex is on internal face f.
  std::vector<std::uint64_t> internal_faces;

  double radius = 0;           // m, rounding radius
  Vec3 center = Vec3::Zero();  // m, center of a bounding sphere
  double bounding_radius = 0;  // m, of that sphere, with rounding
  // m, least width normal to a face, internal faces included, with rounding.
  double thickness = 0;

  Vec3 vertex(int i) const { return {x[i], y[i], z[i]}; }
};

// The part that fills the intersection of half-spaces. Surface faces are moved inwards by
// `rounding` (m), internal faces are not. Throws InputError if nothing remains (thickness below 2 *
// rounding).
ConvexPart convex_part(const std::vector<HalfSpace>& half_spaces, double rounding);

// The convex hull of points as outward half-spaces, coplanar facets merged.
// Throws InputError for fewer than four points or a flat set.
std::vector<HalfSpace> convex_hull(const std::vector<Vec3>& points);

// One point swept by `radius`: a sphere.
ConvexPart sphere_part(const Vec3& center, double radius);

// The part in other axes: `pose` takes its axes to the new ones.
ConvexPart moved(const ConvexPart& part, const Pose& pose);

// The surface of the core as triangles. Empty for a sphere.
TriangleMesh surface_mesh(const ConvexPart& part);

}  // namespace firn
