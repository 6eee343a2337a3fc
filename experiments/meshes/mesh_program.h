// Mesh programs with other licenses (tools/), run as separate processes.
#pragma once

#include <array>
#include <cstring>
#include <string>
#include <string_view>

#include "firn/mesh.h"

namespace firn {

// Runs the program `name` of the installation on a file with the content `input`, and returns its
// standard output. Limits: 120 s of processor time, 4 GiB of memory. Throws InputError with the
// last line of the program when it rejects the mesh, and RunError when the program is missing.
std::string run_mesh_program(const std::string& name, const std::string& input);

// Data format of these programs: 9 numbers (x, y, z of three corners) per facet, in the byte order
// of the machine.
template <typename Number>
std::string facet_bytes(const TriangleMesh& mesh) {
  std::string bytes;
  bytes.reserve(mesh.triangles.size() * 9 * sizeof(Number));
  for (const auto& triangle : mesh.triangles) {
    for (const int vertex : triangle) {
      for (const double x : mesh.vertices[static_cast<std::size_t>(vertex)]) {
        const auto number = static_cast<Number>(x);
        bytes.append(reinterpret_cast<const char*>(&number), sizeof(Number));
      }
    }
  }
  return bytes;
}

// The inverse; corners are not merged. Throws RunError unless the size is a whole number of facets.
template <typename Number>
TriangleMesh mesh_of_facets(std::string_view bytes) {
  using Corners = std::array<Number, 9>;
  if (bytes.size() % sizeof(Corners) != 0)
    throw RunError("a mesh program gives an answer that is not whole");
  TriangleMesh mesh;
  for (; !bytes.empty(); bytes.remove_prefix(sizeof(Corners))) {
    Corners c;
    std::memcpy(c.data(), bytes.data(), sizeof(Corners));
    const int first = static_cast<int>(mesh.vertices.size());
    for (std::size_t k = 0; k < 9; k += 3) mesh.vertices.emplace_back(c[k], c[k + 1], c[k + 2]);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

}  // namespace firn
