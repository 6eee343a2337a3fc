// SPDX-License-Identifier: GPL-3.0-or-later
//
// firn-unite-mesh FILE: the union of closed shells, by CGAL (https://www.cgal.org).
//
// A separate program because CGAL's mesh processing is under the GNU General Public License, and
// Firn is not. experiments/meshes/mesh_union.cpp starts it.
//
// FILE: 9 doubles (x, y, z of three corners, one unit throughout) for each facet, in the byte order
// of the machine; corners of neighboring facets are equal to the last bit. Standard output: the
// facets of the union as in FILE. Exit status 1 and a line on standard error when there is none.
//
// A shell is a set of facets connected by edges. A shell that faces inwards is a cavity of the
// smallest shell around it; without a shell around it, it is reversed.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/copy_face_graph.h>

#include <array>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
namespace pmp = CGAL::Polygon_mesh_processing;

using Corners = std::array<double, 9>;

struct Solid {
  Mesh mesh;  // the shell, and its cavities
  double shell_volume = 0;
};

Mesh mesh_of(const std::string& bytes) {
  std::vector<Kernel::Point_3> points;
  std::vector<std::array<std::size_t, 3>> facets;
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(Corners)) {
    Corners c;
    bytes.copy(reinterpret_cast<char*>(c.data()), sizeof(Corners), at);
    const std::size_t first = points.size();
    for (std::size_t k = 0; k < 9; k += 3) points.emplace_back(c[k], c[k + 1], c[k + 2]);
    facets.push_back({first, first + 1, first + 2});
  }
  pmp::repair_polygon_soup(points, facets);
  if (!pmp::is_polygon_soup_a_polygon_mesh(facets))
    throw std::runtime_error("shells touch along an edge, or facets of a shell face both ways");
  Mesh mesh;
  pmp::polygon_soup_to_polygon_mesh(points, facets, mesh);
  if (!CGAL::is_closed(mesh)) throw std::runtime_error("a shell has a hole");
  return mesh;
}

// A shell that crosses `outer` has corners on both sides of it.
bool encloses(const Mesh& outer, const Mesh& inner) {
  const CGAL::Side_of_triangle_mesh<Mesh, Kernel> side(outer);
  bool inside = false;
  for (const auto vertex : inner.vertices()) {
    const CGAL::Bounded_side where = side(inner.point(vertex));
    if (where == CGAL::ON_UNBOUNDED_SIDE) return false;
    inside |= where == CGAL::ON_BOUNDED_SIDE;
  }
  return inside;
}

std::vector<Solid> solids_of(const Mesh& all) {
  std::vector<Mesh> shells;
  pmp::split_connected_components(all, shells);
  std::vector<Solid> solids;
  std::vector<Mesh> inward;
  for (Mesh& shell : shells) {
    if (pmp::does_self_intersect(shell)) throw std::runtime_error("a shell crosses itself");
    if (pmp::is_outward_oriented(shell))
      solids.push_back({shell, pmp::volume(shell)});
    else
      inward.push_back(shell);
  }
  const std::size_t outward = solids.size();
  for (Mesh& shell : inward) {
    Solid* around = nullptr;
    for (std::size_t i = 0; i < outward; ++i) {
      if ((around == nullptr || solids[i].shell_volume < around->shell_volume) &&
          encloses(solids[i].mesh, shell))
        around = &solids[i];
    }
    if (around != nullptr) {
      CGAL::copy_face_graph(shell, around->mesh);
    } else {
      pmp::reverse_face_orientations(shell);
      solids.push_back({shell, pmp::volume(shell)});
    }
  }
  return solids;
}

Mesh united(std::vector<Solid> solids) {
  // Neighbors in this list are united first, so that no operand holds nearly all facets each time.
  while (solids.size() > 1) {
    std::vector<Solid> halves;
    for (std::size_t i = 0; i + 1 < solids.size(); i += 2) {
      Solid both;
      if (!pmp::corefine_and_compute_union(solids[i].mesh, solids[i + 1].mesh, both.mesh))
        throw std::runtime_error("the union touches itself along an edge or at a corner");
      halves.push_back(std::move(both));
    }
    if (solids.size() % 2 == 1) halves.push_back(std::move(solids.back()));
    solids = std::move(halves);
  }
  return std::move(solids.front().mesh);
}

int run(const char* file) {
  std::ifstream in(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (bytes.empty() || bytes.size() % sizeof(Corners) != 0)
    throw std::runtime_error("expected whole facets");
  const Mesh whole = united(solids_of(mesh_of(bytes)));
  for (const auto face : whole.faces()) {
    Corners c;
    std::size_t k = 0;
    for (const auto vertex : CGAL::vertices_around_face(whole.halfedge(face), whole))
      for (int axis = 0; axis < 3; ++axis) c.at(k++) = whole.point(vertex)[axis];
    if (std::fwrite(c.data(), sizeof(Corners), 1, stdout) != 1)
      throw std::runtime_error("the output cannot be written");
  }
  if (std::fclose(stdout) != 0) throw std::runtime_error("the output cannot be written");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 2) throw std::runtime_error("usage: firn-unite-mesh FILE");
    // CGAL reports operands that break its conditions by exceptions of many lines.
    CGAL::set_error_behaviour(CGAL::THROW_EXCEPTION);
    return run(argv[1]);
  } catch (const CGAL::Failure_exception&) {
    std::fprintf(stderr, "CGAL cannot unite these shells\n");
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
  }
  return 1;
}
