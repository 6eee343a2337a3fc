// A convex piece of a body for contact: a polyhedral core swept by a sphere (spheropolyhedron).
//
// The swept solid  core + ball(radius)  has the faces of the drawn piece: the core is that piece
// eroded by the radius, so that edges and corners become round.
#pragma once

#include <cstdint>
#include <vector>

#include "firn/mesh.h"

namespace firn {

// n . x <= offset; an internal one is a cut towards a neighbouring piece, not a surface.
struct HalfSpace {
  Vec3 normal;        // unit, outward
  double offset = 0;  // m
  bool internal = false;
};

// Internal faces of one part: a mask of 64 bits has one for each.
inline constexpr std::size_t kMaxSeams = 64;

struct ConvexPart {
  struct Face {
    Vec3 normal;        // unit, outward
    double offset = 0;  // m: n . x of the core's face
    int first = 0;      // loop of core vertices: loops[first .. first + count), counter-clockwise
    int count = 0;
    bool internal = false;
  };

  // Core vertices by coordinate, m, body axes. Padded with copies of the last vertex to a
  // multiple of 8 so that support searches need no remainder loop.
  std::vector<double> x, y, z;
  int vertex_count = 0;
  std::vector<Face> faces;  // flat faces, coplanar triangles merged
  std::vector<std::uint16_t> loops;
  std::vector<std::array<std::uint16_t, 2>> edges;  // each once

  // Neighbors of each vertex: far ends of its edges, and its faces, both ascending.
  struct VertexEdge {
    std::uint16_t vertex = 0;
    double inverse_length = 0;  // 1/m
  };
  struct VertexAdjacency {
    std::uint32_t first_spoke = 0, spoke_count = 0;
    std::uint32_t first_face = 0, face_count = 0;
  };
  std::vector<VertexAdjacency> stars;  // [vertex_count]
  std::vector<VertexEdge> spokes;
  std::vector<std::uint16_t> star_faces;
  // [vertex_count] bit f: face f, which is no seam, meets here. Empty if there are more than 64.
  std::vector<std::uint64_t> surface_faces;

  // Seams. A contact whose nearest feature lies wholly on internal face f and whose normal points
  // out through f belongs to the neighbour there, and is dropped by this part.
  std::vector<Vec3> internal_normals;  // at most kMaxSeams
  std::vector<std::uint64_t>
      internal_faces;  // [vertex_count] bit f: vertex lies on internal face f

  double radius = 0;           // m, sweep radius
  Vec3 center = Vec3::Zero();  // m, centre of a bounding sphere
  double bounding_radius = 0;  // m, of that sphere, sweep radius included
  double thickness = 0;        // m, least width across a face, cuts and sweep included

  Vec3 vertex(int i) const { return {x[i], y[i], z[i]}; }
};

// The piece enclosed by half-spaces, its surface faces moved inwards by `rounding`.
// Internal faces are not moved. Throws InputError when nothing is left (thinner than 2 * rounding).
ConvexPart convex_part(const std::vector<HalfSpace>& half_spaces, double rounding);

// The convex hull of points as outward half-spaces, coplanar facets merged.
// Throws InputError for fewer than four points or a flat set.
std::vector<HalfSpace> convex_hull(const std::vector<Vec3>& points);

// One point swept by `radius`: a sphere.
ConvexPart sphere_part(const Vec3& center, double radius);

// The part placed in other axes.
ConvexPart moved(const ConvexPart& part, const Pose& pose);

// The surface of the core as triangles. Empty for a sphere.
TriangleMesh surface_mesh(const ConvexPart& part);

}  // namespace firn
