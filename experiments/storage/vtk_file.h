// VTK XML files of surfaces and of points, for ParaView.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "firn/math.h"

namespace firn {

// Polygons with point data and cell data.
struct VtkSurface {
  struct Field {
    std::string name;
    std::size_t width = 1;
    std::vector<float> values;  // [points * width] or [polygons * width]
  };
  std::vector<float> points;               // [points * 3] m
  std::vector<std::int32_t> connectivity;  // corners of all polygons
  std::vector<std::int32_t> offsets;       // [polygons] end of each polygon in `connectivity`
  std::vector<Field> fields;               // at points
  std::vector<Field> cell_fields;          // on polygons

  std::size_t point_count() const { return points.size() / 3; }
};

// Writes a PolyData file (.vtp, binary). Throws as OutputFile.
void save_vtp(const VtkSurface& surface, const std::filesystem::path& path);
// The same with one vertex per point and without polygons.
void save_vtp_points(const VtkSurface& points, const std::filesystem::path& path);

// A time series: an index file (.pvd) and a folder of .vtp files.
class VtkTimeSeries {
 public:
  // Creates the folder. Throws as make_output_folder().
  VtkTimeSeries(const std::filesystem::path& directory, const std::string& name);
  void add(double time, std::size_t number, const VtkSurface& surface);
  void save() const;

 private:
  std::filesystem::path directory_;
  std::string name_, entries_;
};

}  // namespace firn
