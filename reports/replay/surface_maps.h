// Where bodies are hit: loads on triangles over a whole run, as replays draw them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "experiments/results/results_file.h"
#include "firn/mesh.h"

namespace firn {

// What one value stands for two triangles that become one.
enum class MapMerge { sum, mean, largest };  // mean: by area

struct MapField {
  std::string key, name, unit;  // "peak_stress", "peak stress", "Pa"
  MapMerge merge = MapMerge::sum;
  std::vector<double> values;  // [triangles]
};
struct SurfaceMap {
  std::string body;   // boundary or shape
  TriangleMesh mesh;  // m, its own axes
  std::vector<MapField> fields;
  std::size_t computed = 0;  // triangles in the results file
};

// Of the monitored boundaries, over all intervals; of the shapes, over all particles of each. At
// most `most` triangles over all of them together. None where the case asked for none.
std::vector<SurfaceMap> boundary_maps(const Recording& recording, std::size_t most);
std::vector<SurfaceMap> shape_maps(const Recording& recording, std::size_t most);

// The same with about `most` triangles of even size at most, corners of the mesh given: sums and
// peaks stay what they are and move by the width of a triangle.
SurfaceMap simplified_map(const SurfaceMap& map, std::size_t most);

}  // namespace firn
