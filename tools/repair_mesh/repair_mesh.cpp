// SPDX-License-Identifier: GPL-2.0-or-later
//
// firn-repair-mesh FILE: repairs a mesh with admesh (https://github.com/admesh/admesh).
//
// A separate program because admesh is under the GNU General Public License, and Firn is not.
// experiments/meshes/mesh_repair.cpp starts it.
//
// FILE: 9 floats (x, y, z of three corners, one unit throughout) for each facet, in the byte order
// of the machine. Standard output: 7 integers of 32 bits (degenerate, edges without a neighbor
// before the repair, edges joined, removed, added, reversed, parts), then the repaired facets as in
// FILE. Exit status 1 and a line on standard error when admesh fails.
#include <admesh/stl.h>
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace {

constexpr float kCrack = 1e-5F;  // of the mesh's diameter: corners so near are one

int fail(const char* text) {
  std::fprintf(stderr, "%s\n", text);
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return fail("usage: firn-repair-mesh FILE");
  // admesh prints remarks on standard output.
  std::FILE* const answer = ::fdopen(::dup(STDOUT_FILENO), "wb");
  const int nothing = ::open("/dev/null", O_WRONLY);
  if (answer == nullptr || nothing < 0 || ::dup2(nothing, STDOUT_FILENO) < 0)
    return fail("the output cannot be written");
  std::ifstream in(argv[1], std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  using Corners = std::array<stl_vertex, 3>;
  static_assert(sizeof(Corners) == 36);
  const std::size_t count = bytes.size() / sizeof(Corners);
  if (count == 0 || count * sizeof(Corners) != bytes.size()) return fail("expected whole facets");

  stl_file stl{};
  stl_initialize(&stl);
  stl.stats.type = inmemory;
  stl.stats.number_of_facets = stl.stats.original_num_facets = static_cast<int>(count);
  stl_allocate(&stl);
  if (stl_get_error(&stl)) return fail("admesh has no memory for this mesh");
  for (std::size_t i = 0; i < count; ++i) {
    stl_facet& facet = stl.facet_start[i];
    facet = {};
    bytes.copy(reinterpret_cast<char*>(facet.vertex), sizeof(Corners), i * sizeof(Corners));
    stl_facet_stats(&stl, facet, i == 0 ? 1 : 0);
  }
  stl_get_size(&stl);
  stl_check_facets_exact(&stl);
  const int disconnected = 3 * stl.stats.number_of_facets - stl.stats.connected_edges;
  // Without a facet, only ones without area were there.
  if (stl.stats.number_of_facets > 0) {
    // All repairs, but for the distance of corners that are joined: admesh's own, the shortest
    // edge, would pull coarse meshes together.
    constexpr int kRounds = 2;
    const float crack = kCrack * stl.stats.bounding_diameter;
    stl_repair(&stl, 0, 1, 1, crack, 1, crack, 1, kRounds, 1, 1, 1, 1, 0, 0);
    if (stl_get_error(&stl)) return fail("admesh cannot work on this mesh");
    stl_calculate_volume(&stl);
    if (stl.stats.volume < 0) {
      stl_reverse_all_facets(&stl);
      stl.stats.facets_reversed = stl.stats.number_of_facets - stl.stats.facets_reversed;
    }
  }
  const stl_stats& s = stl.stats;
  const std::array<std::int32_t, 7> counts = {
      s.degenerate_facets, disconnected,
      s.edges_fixed,       s.facets_removed - s.degenerate_facets,
      s.facets_added,      s.facets_reversed,
      s.number_of_parts};
  bool written = std::fwrite(counts.data(), sizeof(counts), 1, answer) == 1;
  for (int i = 0; i < s.number_of_facets; ++i)
    written &= std::fwrite(stl.facet_start[i].vertex, sizeof(Corners), 1, answer) == 1;
  written &= std::fclose(answer) == 0;
  stl_close(&stl);
  return written ? 0 : fail("the output cannot be written");
}
