// Reads and writes triangle meshes: STL and Wavefront OBJ.
#pragma once

#include <string>

#include "firn/mesh.h"

namespace firn {

// Limits of a mesh. The number of triangles is checked before they are read.
struct MeshLimits {
  std::size_t triangles = 200000;
  double smallest = 1e-12;  // m, longest edge of the bounding box
  double largest = 1e6;     // m
};
inline constexpr MeshLimits kParticleMesh{20000, 1e-6, 100};
inline constexpr MeshLimits kBoundaryMesh{200000, 1e-12, 1e4};
// The same limit of triangles, with the default limits of size.
constexpr MeshLimits without_size_limits(const MeshLimits& limits) {
  return {.triangles = limits.triangles};
}

// Reads an STL file, text or binary, or a Wavefront OBJ file (extension .obj). `length_unit`: m per
// length unit of the file. Equal corners are merged, so that equal text and binary files give equal
// meshes. A binary file has 84 + 50 n bytes for n triangles. Normals in the file are ignored;
// corners must be counter-clockwise seen from outside. The mesh may be defective: see inspect().
// Throws InputError `FILE: ...` (one line) for a file that is missing, not STL, truncated, empty or
// of another length than its header states, for coordinates that are not finite or exceed 1000 km,
// and for a mesh beyond `limits`.
TriangleMesh read_stl(const std::string& file, double length_unit, const MeshLimits& limits = {});

// Writes a binary STL file in units of `length_unit` (m), in single precision. Throws as
// OutputFile.
void write_stl(const std::string& file, const TriangleMesh& mesh, double length_unit);

// Merges corners that differ by at most the rounding of single precision (5e-7 of the largest
// coordinate), as the readers do. Degenerate triangles are removed.
TriangleMesh merge_equal_corners(const TriangleMesh& mesh);

// A mesh and the hash of its file.
struct MeshFile {
  TriangleMesh mesh;   // m, file axes, equal corners merged
  std::string sha256;  // of the bytes of the file
};
// As read_stl(), without merged corners and with degenerate triangles.
TriangleMesh read_triangles(const std::string& file, double length_unit,
                            const MeshLimits& limits = {});
// As read_stl(), with the hash.
MeshFile read_mesh_file(const std::string& file, double length_unit, const MeshLimits& limits = {});

}  // namespace firn
