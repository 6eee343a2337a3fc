#include <fmt/format.h>

#include <array>
#include <optional>

#include "experiments/export/export.h"
#include "experiments/results/contact_statistics_results.h"
#include "experiments/storage/vtk_file.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/csv/csv_writer.h"

namespace firn {
namespace {

// Where the boundary was in the last frame up to this time in which it was there.
std::optional<BoundaryFrame> place_at(const Recording& recording, const std::string& boundary,
                                      const std::vector<double>& times, double time) {
  for (std::size_t k = times.size(); k-- > 0;) {
    if (times[k] > time) continue;
    const BoundaryFrame frame = recording.boundary(boundary, k);
    if (!frame.position.hasNaN()) return frame;
  }
  return std::nullopt;
}

// Appends a mesh; returns the number of its triangles.
std::size_t add_mesh(VtkSurface& surface, const TriangleMesh& mesh, const Vec3& position,
                     const Quat& orientation) {
  const auto base = static_cast<std::int32_t>(surface.point_count());
  for (const Vec3& vertex : mesh.vertices) {
    const Eigen::Vector3f p = (orientation * vertex + position).cast<float>();
    surface.points.insert(surface.points.end(), {p.x(), p.y(), p.z()});
  }
  for (const auto& t : mesh.triangles) {
    for (const int corner : t) surface.connectivity.push_back(base + corner);
    surface.offsets.push_back(static_cast<std::int32_t>(surface.connectivity.size()));
  }
  return mesh.triangles.size();
}

// Values of one mesh, behind those of the meshes before it.
void add_values(VtkSurface& surface, const std::vector<TriangleField>& fields, std::size_t first,
                std::size_t count) {
  for (std::size_t k = 0; k < fields.size(); ++k) {
    if (surface.cell_fields.size() == k) surface.cell_fields.push_back({fields[k].name, 1, {}});
    for (std::size_t i = first; i < first + count; ++i)
      surface.cell_fields[k].values.push_back(static_cast<float>(fields[k].values[i]));
  }
}

// The name of a shape as part of a file name.
std::string without_slashes(std::string name) {
  for (char& c : name)
    if (c == '/') c = '_';
  return name;
}

// Field of a CSV file: the number of a particle, the name of a boundary, empty for no body.
std::string body_field(int body, std::size_t particles,
                       const std::vector<std::string>& boundaries) {
  if (body < 0) return "";
  const auto k = static_cast<std::size_t>(body);
  return k < particles ? fmt::format("{}", k) : encode::csv_field(boundaries.at(k - particles));
}

void export_contacts(const Recording& recording, const std::string& directory) {
  const std::vector<std::string> boundaries = recording.strings("/statistics/boundary_name");
  CsvFile csv(directory, "contacts.csv");
  csv.line(
      "start [s],duration [s],body_a,body_b,open_at_end,peak_normal_force [N],peak_time [s],"
      "peak_friction [N],normal_impulse [N s],tangential_impulse [N s],impulse.x [N s],"
      "impulse.y [N s],impulse.z [N s],impact_velocity_normal [m/s],impact_velocity_tangential "
      "[m/s],normal.x,"
      "normal.y,normal.z,position.x [m],position.y [m],position.z [m],position_on_body_a.x [m],"
      "position_on_body_a.y [m],position_on_body_a.z [m],position_on_body_b.x "
      "[m],position_on_body_b.y [m],"
      "position_on_body_b.z [m],dissipated [J]");
  for (const ContactEvent& e : contact_events(recording)) {
    std::string line =
        fmt::format("{},{},{},{},{}", e.start, e.duration, e.a,
                    body_field(e.b, recording.particle_count(), boundaries), e.open_at_end);
    append(line, std::array{e.peak_normal_force, e.peak_time, e.peak_friction, e.normal_impulse,
                            e.tangential_impulse});
    append(line, std::span(e.impulse.data(), 3));
    append(line, std::array{e.impact_velocity_normal, e.impact_velocity_tangential});
    for (const Vec3& v : {e.normal, e.position, e.position_on_a, e.position_on_b})
      append(line, std::span(v.data(), 3));
    csv.line(line + fmt::format(",{}", e.dissipated));
  }
  csv.close();
}

void export_opposed(const Recording& recording, const std::vector<CompressiveLoad>& loads,
                    const std::string& directory) {
  const std::vector<std::string> boundaries = recording.strings("/statistics/boundary_name");
  CsvFile csv(directory, "compressive_loads.csv");
  csv.line("particle,load [N],time [s],body_0,body_1");
  const std::size_t particles = recording.particle_count();
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const CompressiveLoad& o = loads[i];
    csv.line(fmt::format("{},{},{},{},{}", i, o.load, o.load > 0 ? fmt::format("{}", o.time) : "",
                         body_field(o.bodies[0], particles, boundaries),
                         body_field(o.bodies[1], particles, boundaries)));
  }
  csv.close();
}

std::string with_units(std::string header, const std::vector<TriangleField>& fields) {
  for (const TriangleField& field : fields)
    header +=
        field.unit == "1" ? "," + field.name : fmt::format(",{} [{}]", field.name, field.unit);
  return header;
}

void export_boundary_triangles(const std::vector<BoundaryLoads>& all,
                               const std::string& directory) {
  CsvFile csv(directory, "boundary_maps.csv");
  csv.line(with_units("boundary,start [s],end [s],triangle,area [m^2]", all[0].fields));
  for (const BoundaryLoads& loads : all) {
    for (std::size_t i = 0; i < loads.end.size(); ++i) {
      for (std::size_t t = 0; t < loads.area.size(); ++t) {
        std::string line = fmt::format("{},{},{},{},{}", encode::csv_field(loads.boundary),
                                       loads.start[i], loads.end[i], t, loads.area[t]);
        for (const TriangleField& field : loads.fields)
          line += fmt::format(",{}", field.values[i * loads.area.size() + t]);
        csv.line(line);
      }
    }
  }
  csv.close();
}

void export_surface_triangles(const std::vector<SurfaceLoads>& all, const std::string& directory) {
  CsvFile csv(directory, "particle_maps.csv");
  csv.line(with_units("shape,triangle", all[0].fields));
  for (const SurfaceLoads& loads : all) {
    for (std::size_t t = 0; t < loads.mesh.triangles.size(); ++t) {
      std::string line = fmt::format("{},{}", encode::csv_field(loads.shape), t);
      for (const TriangleField& field : loads.fields) line += fmt::format(",{}", field.values[t]);
      csv.line(line);
    }
  }
  csv.close();
}

void export_energies(const EnergySpectrum& spectrum, const std::string& directory) {
  CsvFile csv(directory, "energy_spectrum.csv");
  csv.line("pair,from [J],to [J],contacts,dissipated [J]");
  const std::size_t classes = spectrum.lower.size();
  for (std::size_t kind = 0; kind < spectrum.kind.size(); ++kind) {
    for (std::size_t k = 0; k < classes; ++k) {
      csv.line(fmt::format(
          "{},{},{},{},{}", encode::csv_field(spectrum.kind[kind]), spectrum.lower[k],
          k + 1 < classes ? fmt::format("{}", spectrum.lower[k + 1]) : "",
          spectrum.contacts[kind * classes + k], spectrum.dissipated[kind * classes + k]));
    }
  }
  csv.close();
}

}  // namespace

void export_statistics_vtk(const Recording& recording, const std::string& directory) {
  const std::vector<BoundaryLoads> all = boundary_loads(recording);
  if (!all.empty()) {
    const std::vector<double> times = recording.frame_times();
    VtkTimeSeries series(directory, "boundary_loads");
    for (std::size_t i = 0; i < all[0].end.size(); ++i) {
      VtkSurface surface;
      for (const BoundaryLoads& loads : all) {
        if (i >= loads.end.size()) continue;  // its last rows never arrived
        const auto place = place_at(recording, loads.boundary, times, loads.end[i]);
        if (!place) continue;
        const std::size_t count =
            add_mesh(surface, loads.mesh, place->position, place->orientation);
        add_values(surface, loads.fields, i * count, count);
      }
      series.add(all[0].end[i], i, surface);
    }
    series.save();
  }
  for (const SurfaceLoads& loads : surface_loads(recording)) {
    VtkSurface surface;
    add_mesh(surface, loads.mesh, Vec3::Zero(), Quat::Identity());
    add_values(surface, loads.fields, 0, loads.mesh.triangles.size());
    save_vtp(surface, std::filesystem::path(directory) /
                          fmt::format("surface_{}.vtp", without_slashes(loads.shape)));
  }
}

void export_statistics_csv(const Recording& recording, const std::string& directory) {
  if (recording.contains("/events/start")) export_contacts(recording, directory);
  const std::vector<CompressiveLoad> opposed = compressive_loads(recording);
  if (!opposed.empty()) export_opposed(recording, opposed, directory);
  const std::vector<BoundaryLoads> boundaries = boundary_loads(recording);
  if (!boundaries.empty()) export_boundary_triangles(boundaries, directory);
  const std::vector<SurfaceLoads> surfaces = surface_loads(recording);
  if (!surfaces.empty()) export_surface_triangles(surfaces, directory);
  if (const auto spectrum = energy_spectrum(recording)) export_energies(*spectrum, directory);
}

}  // namespace firn
