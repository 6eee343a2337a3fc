// Triangle meshes of bodies for the verification suite, m.
#pragma once

#include <cstdint>

#include "solver/mesh.h"

namespace firn::verification::meshes {

// A ring about z: radius 10 mm, 4 mm thick radius; 2 around * across triangles.
TriangleMesh torus(int around, int across);
// A ball of radius 10 mm by meridians and parallels, 2 around (up - 1) triangles, with dents and
// bumps of `roughness` times the radius.
TriangleMesh ball(int around, int up, double roughness);
// An L of 20 x 20 x 10 mm and a U of the same size, 5 mm thick; z is their length.
TriangleMesh angle_bar();
TriangleMesh channel();
// A cube about the origin with each side cut into cells * cells * 2 triangles.
TriangleMesh cube(double edge, int cells);
// The square of `size` (m) about the origin in z = 0, cut into cells of two triangles. Inner
// corners are moved at random by up to a quarter of a cell, and diagonals are chosen at random.
TriangleMesh irregular_floor(double size, int cells, std::uint64_t seed);
TriangleMesh scaled(TriangleMesh mesh, const Vec3& factors);

}  // namespace firn::verification::meshes
