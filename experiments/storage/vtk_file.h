// VTK XML files of surfaces and of points, for ParaView.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "firn/math.h"

namespace firn {

// Polygons with point data and cell data for a VTK file.
struct VtkSurface {
  struct Field {
    std::string name;
    std::size_t width = 1;
    std::vector<float> values;  // [points * width], or of the polygons
  };
  std::vector<float> points;               // [points * 3] m
  std::vector<std::int32_t> connectivity;  // corners of all polygons
  std::vector<std::int32_t> offsets;       // end of each polygon in it
  std::vector<Field> fields;               // at points
  std::vector<Field> cell_fields;          // on polygons

  std::size_t point_count() const { return points.size() / 3; }
};

// One PolyData file (.vtp, binary). Throws InputError when it cannot be written.
void save_vtp(const VtkSurface& surface, const std::filesystem::path& path);
// The same of the points alone, each a vertex, with their fields.
void save_vtp_points(const VtkSurface& points, const std::filesystem::path& path);

// The .pvd index of a time series and its folder of files.
class VtkTimeSeries {
 public:
  // Makes the folder. Throws InputError when it cannot be made.
  VtkTimeSeries(const std::filesystem::path& directory, const std::string& name);
  void add(double time, std::size_t number, const VtkSurface& surface);
  void save() const;

 private:
  std::filesystem::path directory_;
  std::string name_, entries_;
};

}  // namespace firn
