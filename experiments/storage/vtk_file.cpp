#include "experiments/storage/vtk_file.h"

#include <fmt/format.h>

#include <numeric>
#include <span>
#include <string_view>

#include "experiments/system/output_file.h"

namespace firn {
namespace {

// One VTK XML PolyData file. Arrays follow the XML as raw blocks, each after its size in bytes.
class VtpFile {
 public:
  // `cells`: Verts or Polys.
  VtpFile(const VtkSurface& surface, const char* cells) {
    const std::size_t count = surface.offsets.size();
    const bool are_vertices = std::string_view(cells) == "Verts";
    xml_ = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
        "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n<Piece "
        "NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
        "NumberOfPolys=\"{}\">\n<Points>\n",
        surface.point_count(), are_vertices ? count : 0, are_vertices ? 0 : count);
    add("points", "Float32", 3, std::as_bytes(std::span(surface.points)));
    xml_ += fmt::format("</Points>\n<{}>\n", cells);
    add("connectivity", "Int32", 1, std::as_bytes(std::span(surface.connectivity)));
    add("offsets", "Int32", 1, std::as_bytes(std::span(surface.offsets)));
    xml_ += fmt::format("</{}>\n<PointData>\n", cells);
    for (const VtkSurface::Field& field : surface.fields)
      add(field.name, "Float32", field.width, std::as_bytes(std::span(field.values)));
    xml_ += "</PointData>\n<CellData>\n";
    for (const VtkSurface::Field& field : surface.cell_fields)
      add(field.name, "Float32", field.width, std::as_bytes(std::span(field.values)));
    xml_ += "</CellData>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
  }

  void save(const std::filesystem::path& path) const {
    OutputFile out(path.string());
    out << xml_;
    for (const std::span<const std::byte>& block : blocks_) {
      const std::uint64_t size = block.size();
      out.write(reinterpret_cast<const char*>(&size), sizeof(size));
      out.write(reinterpret_cast<const char*>(block.data()), static_cast<std::streamsize>(size));
    }
    out << "\n</AppendedData>\n</VTKFile>\n";
    out.commit();
  }

 private:
  void add(const std::string& name, const char* type, std::size_t width,
           std::span<const std::byte> block) {
    xml_ += fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
        "offset=\"{}\"/>\n",
        type, name, width, offset_);
    offset_ += sizeof(std::uint64_t) + block.size();
    blocks_.push_back(block);
  }

  std::string xml_;
  std::size_t offset_ = 0;
  std::vector<std::span<const std::byte>> blocks_;
};

}  // namespace

void save_vtp(const VtkSurface& surface, const std::filesystem::path& path) {
  VtpFile(surface, "Polys").save(path);
}

void save_vtp_points(const VtkSurface& points, const std::filesystem::path& path) {
  VtkSurface out = points;
  out.connectivity.resize(points.point_count());
  std::iota(out.connectivity.begin(), out.connectivity.end(), 0);
  out.offsets.resize(points.point_count());
  std::iota(out.offsets.begin(), out.offsets.end(), 1);
  VtpFile(out, "Verts").save(path);
}

VtkTimeSeries::VtkTimeSeries(const std::filesystem::path& directory, const std::string& name)
    : directory_(directory), name_(name) {
  make_output_folder((directory / name).string());
}

void VtkTimeSeries::add(double time, std::size_t number, const VtkSurface& surface) {
  const std::string file = fmt::format("{0}/{0}_{1:06}.vtp", name_, number);
  save_vtp(surface, directory_ / file);
  entries_ += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", time, file);
}

void VtkTimeSeries::save() const {
  const std::filesystem::path path = directory_ / (name_ + ".pvd");
  OutputFile out(path.string());
  out << "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
         "byte_order=\"LittleEndian\">\n<Collection>\n"
      << entries_ << "</Collection>\n</VTKFile>\n";
  out.commit();
}

}  // namespace firn
