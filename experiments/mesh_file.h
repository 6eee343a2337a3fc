// Triangle meshes in files of other programs.
#pragma once

#include <string>

#include "solver/mesh.h"

namespace firn {

// Reads an STL file, text or binary, or, by the ending .obj, a Wavefront OBJ file; `length_unit`:
// metres per length unit of the file. Equal corners are merged, so a text file and its binary twin
// give the same mesh. Bytes that follow the triangles of a binary file are ignored, as are the
// normals: corners run counter-clockwise seen from outside. The mesh may have holes: see inspect().
// Throws InputError, one line that begins with the file's name, for a file that is missing, no
// STL, cut short or empty, and for coordinates that are no finite numbers or beyond 1000 km.
TriangleMesh read_stl(const std::string& file, double length_unit);

// Writes a binary STL file in units of `length_unit` (m), single precision as the format has it.
// Throws InputError, one line that begins with the file's name, when it cannot be written.
void write_stl(const std::string& file, const TriangleMesh& mesh, double length_unit);

// The same mesh with the hash that identifies the file's contents.
struct MeshFile {
  TriangleMesh mesh;   // m, file axes, equal corners merged
  std::string sha256;  // of the file's bytes
};
// Corners as the file has them, not merged; degenerate triangles are there, too.
TriangleMesh read_triangles(const std::string& file, double length_unit);
MeshFile read_mesh_file(const std::string& file, double length_unit);

}  // namespace firn
