// Triangles of the surface of a solid that is decomposed.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "firn/mesh.h"

namespace firn {

// A triangle of the boundary of a piece. Corners are counter-clockwise seen from outside.
struct Facet {
  std::array<Vec3, 3> corners;  // m
  Vec3 normal = Vec3::Zero();   // unit, outward
  bool cap = false;             // on a cut, not on the surface of the solid
};

double facet_area(const Facet& f);  // m^2
Vec3 facet_centroid(const Facet& f);

// The triangles of `mesh` in an order that depends on their geometry alone: not on the order of
// vertices and triangles in the mesh.
std::vector<Facet> sorted_facets(const TriangleMesh& mesh);

// About `max_facets` facets of nearly the same surface, by edge collapse. The surface stays closed.
// Its corners are corners of `facets`. Facets of an area below 5e-13 `size`^2 are left out. `size`
// (m): diagonal of the bounding box.
std::vector<Facet> simplify_facets(const std::vector<Facet>& facets, std::size_t max_facets,
                                   double size);

// An edge at which the surface is concave.
struct ReflexEdge {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();    // m, ends
  Vec3 n1 = Vec3::Zero(), n2 = Vec3::Zero();  // normals of its two facets
};

// Edges at which the angle between the facets has a sine of more than 0.1. Edges of at most a
// millionth of `size` (m) are left out.
std::vector<ReflexEdge> find_reflex_edges(const std::vector<Facet>& facets, double size);

}  // namespace firn
