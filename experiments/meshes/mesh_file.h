// Triangle meshes in files of other programs.
#pragma once

#include <string>

#include "firn/mesh.h"

namespace firn {

// What a mesh file may hold. The number of triangles is checked before they are read.
struct MeshLimits {
  std::size_t triangles = 200000;
  double smallest = 1e-12;  // m, longest edge of the bounding box
  double largest = 1e6;     // m
};
inline constexpr MeshLimits kParticleMesh{20000, 1e-6, 100};
inline constexpr MeshLimits kBoundaryMesh{200000, 1e-12, 1e4};
// The same number of triangles, of any size that can be computed with.
constexpr MeshLimits of_any_size(const MeshLimits& limits) {
  return {.triangles = limits.triangles};
}

// Reads an STL file, text or binary, or, by the ending .obj, a Wavefront OBJ file; `length_unit`:
// metres per length unit of the file. Equal corners are merged, so a text file and its binary twin
// give the same mesh. A binary file has 84 + 50 n bytes for n triangles. Normals are ignored:
// corners run counter-clockwise seen from outside. The mesh may have holes: see inspect().
// Throws InputError, one line that begins with the file's name, for a file that is missing, no
// STL, cut short, of another length than its header counts or empty, for coordinates that are no
// finite numbers or beyond 1000 km, and for a mesh beyond `limits`.
TriangleMesh read_stl(const std::string& file, double length_unit, const MeshLimits& limits = {});

// Writes a binary STL file in units of `length_unit` (m), single precision as the format has it.
// Throws InputError, one line that begins with the file's name, when it cannot be written.
void write_stl(const std::string& file, const TriangleMesh& mesh, double length_unit);

// Merges corners that differ by rounding to single precision (5e-7 of the largest coordinate), as
// the readers do; triangles that collapse are dropped.
TriangleMesh merge_equal_corners(const TriangleMesh& mesh);

// The same mesh with the hash that identifies the file's contents.
struct MeshFile {
  TriangleMesh mesh;   // m, file axes, equal corners merged
  std::string sha256;  // of the file's bytes
};
// Corners as the file has them, not merged; degenerate triangles are there, too.
TriangleMesh read_triangles(const std::string& file, double length_unit,
                            const MeshLimits& limits = {});
MeshFile read_mesh_file(const std::string& file, double length_unit, const MeshLimits& limits = {});

}  // namespace firn
