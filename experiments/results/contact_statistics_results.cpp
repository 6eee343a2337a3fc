#include "experiments/results/contact_statistics_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/results/body_number.h"
#include "firn/mesh.h"

namespace firn {
namespace {

// A field of an event as a column of the file.
struct EventColumn {
  const char* name;
  const char* unit;
  double* (*at)(ContactEvent&);  // its values lie one behind the other
  std::size_t width = 1;
};
constexpr EventColumn kEventColumns[] = {
    {"start", "s", [](ContactEvent& e) { return &e.start; }},
    {"duration", "s", [](ContactEvent& e) { return &e.duration; }},
    {"peak_time", "s", [](ContactEvent& e) { return &e.peak_time; }},
    {"peak_normal_force", "N", [](ContactEvent& e) { return &e.peak_normal_force; }},
    {"peak_friction", "N", [](ContactEvent& e) { return &e.peak_friction; }},
    {"normal_impulse", "N s", [](ContactEvent& e) { return &e.normal_impulse; }},
    {"tangential_impulse", "N s", [](ContactEvent& e) { return &e.tangential_impulse; }},
    {"impulse", "N s", [](ContactEvent& e) { return e.impulse.data(); }, 3},
    {"impact_velocity_normal", "m/s", [](ContactEvent& e) { return &e.impact_velocity_normal; }},
    {"impact_velocity_tangential", "m/s",
     [](ContactEvent& e) { return &e.impact_velocity_tangential; }},
    {"normal", "1", [](ContactEvent& e) { return e.normal.data(); }, 3},
    {"position", "m", [](ContactEvent& e) { return e.position.data(); }, 3},
    {"position_on_body_a", "m", [](ContactEvent& e) { return e.position_on_a.data(); }, 3},
    {"position_on_body_b", "m", [](ContactEvent& e) { return e.position_on_b.data(); }, 3},
    {"dissipated", "J", [](ContactEvent& e) { return &e.dissipated; }},
};
// Integer columns of the same table: the bodies, and whether the contact is still open.
constexpr const char* kEventNumbers[] = {"body_a", "body_b", "open_at_end"};

// Loads and wear of a triangle, from its sums, its area (m^2) and the length of the interval (s).
struct TriangleColumn {
  const char* name;
  const char* unit;
  double (*of)(const TriangleSums&, double area, double time);
};
constexpr TriangleColumn kTriangleColumns[] = {
    {"normal_force", "N",
     [](const TriangleSums& t, double, double time) { return t.normal_impulse / time; }},
    {"tangential_force", "N",
     [](const TriangleSums& t, double, double time) { return t.tangential_impulse / time; }},
    {"impulse_x", "N s", [](const TriangleSums& t, double, double) { return t.impulse.x(); }},
    {"impulse_y", "N s", [](const TriangleSums& t, double, double) { return t.impulse.y(); }},
    {"impulse_z", "N s", [](const TriangleSums& t, double, double) { return t.impulse.z(); }},
    {"peak_stress", "Pa", [](const TriangleSums& t, double area, double) { return t.peak / area; }},
    {"sliding_distance", "m",
     [](const TriangleSums& t, double, double) { return t.sliding_distance; }},
    {"frictional_power", "W",
     [](const TriangleSums& t, double, double time) { return t.friction_work / time; }},
};
constexpr const char* kWearDepth = "wear_depth";

std::string event_path(const char* name) { return std::string("/events/") + name; }
std::string boundary_path(const std::string& boundary, const std::string& name) {
  return fmt::format("/statistics/boundaries/{}/{}", boundary, name);
}
std::string shape_path(std::size_t shape, const std::string& name) {
  return fmt::format("/statistics/shapes/{}/{}", shape, name);
}
constexpr const char* kIntervalStart = "/statistics/intervals/start";
constexpr const char* kIntervalEnd = "/statistics/intervals/end";
constexpr const char* kNames = "/statistics/boundary_name";

const std::string& name_of(const Model& model, const MonitoredBoundary& monitored) {
  return model.boundaries[static_cast<std::size_t>(monitored.boundary)].name;
}

// Every table that grows, with the rows that it has.
template <class Visit>
void for_each_table(const Case& c, const StatisticsRows& rows, const Visit& visit) {
  const StatisticsOptions& options = c.model.statistics;
  if (options.events) {
    for (const EventColumn& column : kEventColumns) {
      visit(event_path(column.name), column.width > 1 ? hdf5::Shape{column.width} : hdf5::Shape{},
            column.unit, rows.events);
    }
    for (const char* name : kEventNumbers) visit(event_path(name), {}, "1", rows.events);
  }
  if (options.monitored.empty()) return;
  for (const char* path : {kIntervalStart, kIntervalEnd}) visit(path, {}, "s", rows.intervals);
  for (const MonitoredBoundary& monitored : options.monitored) {
    const std::string& name = name_of(c.model, monitored);
    const hdf5::Shape row{monitored.mesh.triangles.size()};
    for (const TriangleColumn& column : kTriangleColumns)
      visit(boundary_path(name, column.name), row, column.unit, rows.intervals);
    if (c.wear_rate > 0) visit(boundary_path(name, kWearDepth), row, "m", rows.intervals);
  }
}

void append_events(hdf5::File& file, std::vector<ContactEvent> events, std::size_t particles) {
  if (events.empty()) return;
  std::vector<double> values;
  for (const EventColumn& column : kEventColumns) {
    values.clear();
    for (ContactEvent& e : events)
      values.insert(values.end(), column.at(e), column.at(e) + column.width);
    file.open_table(event_path(column.name)).append(values);
  }
  const auto append = [&](const char* name, auto number) {
    values.clear();
    for (const ContactEvent& e : events) values.push_back(number(e));
    file.open_table(event_path(name)).append(values);
  };
  append("body_a", [&](const ContactEvent& e) { return number_of_body(e.a, particles); });
  append("body_b", [&](const ContactEvent& e) { return number_of_body(e.b, particles); });
  append("open_at_end", [](const ContactEvent& e) { return static_cast<double>(e.open_at_end); });
}

void append_interval(hdf5::File& file, const Case& c, const LoadInterval& interval) {
  file.open_table(kIntervalStart).append(std::span(&interval.start, 1));
  file.open_table(kIntervalEnd).append(std::span(&interval.end, 1));
  const double time = interval.end - interval.start;
  std::size_t first = 0;
  std::vector<double> values;
  for (const MonitoredBoundary& monitored : c.model.statistics.monitored) {
    const std::size_t count = monitored.mesh.triangles.size();
    const auto append = [&](const char* name, auto value) {
      values.clear();
      for (std::size_t t = 0; t < count; ++t)
        values.push_back(
            value(interval.triangles[first + t], 0.5 * area_normal(monitored.mesh, t).norm()));
      file.open_table(boundary_path(name_of(c.model, monitored), name)).append(values);
    };
    for (const TriangleColumn& column : kTriangleColumns)
      append(column.name,
             [&](const TriangleSums& sums, double area) { return column.of(sums, area, time); });
    if (c.wear_rate > 0)
      append(kWearDepth, [&](const TriangleSums& sums, double area) {
        return c.wear_rate * sums.sliding_work / area;
      });
    first += count;
  }
}

// A field of numbers that replaces the earlier one each time.
template <class Sums, class Value>
void write_field(hdf5::File& file, const std::string& path, const char* unit,
                 const hdf5::Shape& shape, std::span<const Sums> sums, Value value) {
  std::vector<double> values;
  values.reserve(sums.size());
  for (const Sums& s : sums) values.push_back(static_cast<double>(value(s)));
  file.write<double>(path, shape, values);
  file.set_attribute(path, "unit", std::string(unit));
}

void write_opposed(hdf5::File& file, const std::vector<CompressiveLoad>& loads) {
  const hdf5::Shape all{loads.size()};
  const std::span<const CompressiveLoad> span(loads);
  write_field(file, "/particles/compressive_load", "N", all, span,
              [](const CompressiveLoad& o) { return o.load; });
  write_field(file, "/particles/compressive_load_time", "s", all, span,
              [](const CompressiveLoad& o) { return o.load > 0 ? o.time : NAN; });
  for (const std::size_t k : {0, 1}) {
    write_field(file, fmt::format("/particles/compressive_load_body_{}", k), "1", all, span,
                [&](const CompressiveLoad& o) {
                  return o.load > 0 ? static_cast<double>(number_of_body(o.bodies[k], loads.size()))
                                    : NAN;
                });
  }
}

void write_sums(hdf5::File& file, const Case& c, const Solver& solver) {
  const StatisticsOptions& options = c.model.statistics;
  if (options.compressive_loads) write_opposed(file, solver.compressive_loads());
  std::size_t first = 0;
  for (std::size_t k = 0; k < options.surfaces.size(); ++k) {
    const std::size_t count = options.surfaces[k].triangles.size();
    const std::span sums = std::span(solver.surface_sums()).subspan(first, count);
    write_field(file, shape_path(k, "contacts"), "1", {count}, sums,
                [](const SurfaceSums& s) { return s.contacts; });
    write_field(file, shape_path(k, "normal_impulse"), "N s", {count}, sums,
                [](const SurfaceSums& s) { return s.normal_impulse; });
    write_field(file, shape_path(k, "peak_normal_force"), "N", {count}, sums,
                [](const SurfaceSums& s) { return s.peak_normal_force; });
    first += count;
  }
  const auto classes = static_cast<std::size_t>(options.energies.count());
  if (classes == 0) return;
  const hdf5::Shape shape{1 + c.model.boundaries.size(), classes};
  const std::span<const EnergySums> energies(solver.energy_sums());
  write_field(file, "/statistics/energy_spectrum/contacts", "1", shape, energies,
              [](const EnergySums& s) { return s.contacts; });
  write_field(file, "/statistics/energy_spectrum/dissipated", "J", shape, energies,
              [](const EnergySums& s) { return s.dissipated; });
}

void write_mesh(hdf5::File& file, const std::string& group, const TriangleMesh& mesh) {
  std::vector<double> vertices;
  std::vector<int> triangles;
  for (const Vec3& v : mesh.vertices) vertices.insert(vertices.end(), v.begin(), v.end());
  for (const auto& t : mesh.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  file.write<double>(group + "vertices", {mesh.vertices.size(), 3}, vertices);
  file.set_attribute(group + "vertices", "unit", std::string("m"));
  file.write<int>(group + "triangles", {mesh.triangles.size(), 3}, triangles);
}

}  // namespace

void create_statistics(hdf5::File& file, const Case& c) {
  const Model& model = c.model;
  const StatisticsOptions& options = model.statistics;
  if (!options.any()) return;
  std::vector<std::string> names;
  for (const Boundary& boundary : model.boundaries) names.push_back(boundary.name);
  file.write_strings(kNames, names);
  for_each_table(
      c, {}, [&](const std::string& path, const hdf5::Shape& row, const char* unit, std::uint64_t) {
        file.create_table(path, row, unit);
      });
  for (const MonitoredBoundary& monitored : options.monitored)
    write_mesh(file, boundary_path(name_of(model, monitored), ""), monitored.mesh);
  for (std::size_t k = 0; k < options.surfaces.size(); ++k)
    write_mesh(file, shape_path(k, ""), options.surfaces[k]);
  if (options.energies.count() == 0) return;
  std::vector<double> lower;
  lower.reserve(static_cast<std::size_t>(options.energies.count()));
  for (int k = 0; k < options.energies.count(); ++k)
    lower.push_back(options.energies.lower_bound(k));
  file.write<double>("/statistics/energy_spectrum/lower_bound", {lower.size()}, lower);
  file.set_attribute("/statistics/energy_spectrum/lower_bound", "unit", std::string("J"));
}

void truncate_statistics(hdf5::File& file, const Case& c, const StatisticsRows& rows) {
  for_each_table(c, rows,
                 [&](const std::string& path, const hdf5::Shape&, const char*, std::uint64_t keep) {
                   hdf5::Table table = file.open_table(path);
                   if (table.rows() < keep)
                     throw RunError(path + " has fewer rows than its checkpoint");
                   table.truncate(keep);
                 });
}

void append_statistics(hdf5::File& file, const Case& c, Solver& solver, bool at_end,
                       StatisticsRows& rows) {
  const StatisticsOptions& options = c.model.statistics;
  std::vector<ContactEvent> events = solver.take_events();
  if (at_end && options.events) {
    for (const ContactEvent& e : solver.open_events())
      if (e.peak_normal_force >= options.threshold) events.push_back(e);
  }
  rows.events += events.size();
  append_events(file, std::move(events), c.model.particles.size());
  for (const LoadInterval& interval : solver.take_load_intervals(at_end)) {
    append_interval(file, c, interval);
    ++rows.intervals;
  }
  write_sums(file, c, solver);
}

namespace {

// Numbers of bodies as a file has them, back to those of the solver.
class Bodies {
 public:
  explicit Bodies(const Recording& recording)
      : file_(recording.file()),
        particles_(static_cast<std::int32_t>(recording.particle_count())),
        boundaries_(static_cast<std::int32_t>(recording.strings(kNames).size())) {}

  std::int32_t of(double number) const {
    if (!(number >= -boundaries_ && number < particles_))
      throw InputError(fmt::format("{}: names a body {} that is not there", file_, number));
    const auto k = static_cast<std::int32_t>(number);
    return k >= 0 ? k : particles_ - 1 - k;
  }

 private:
  const std::string& file_;
  std::int32_t particles_, boundaries_;
};

}  // namespace

std::vector<ContactEvent> contact_events(const Recording& recording) {
  if (!recording.contains("/events/start")) return {};
  // A writer that was killed may have left columns of different lengths.
  std::vector<ContactEvent> events;
  const std::vector<double> body = recording.values("/events/body_a"),
                            other = recording.values("/events/body_b"),
                            lasts = recording.values("/events/open_at_end");
  std::size_t count = std::min({body.size(), other.size(), lasts.size()});
  std::vector<std::vector<double>> columns;
  for (const EventColumn& column : kEventColumns) {
    columns.push_back(recording.values(event_path(column.name)));
    count = std::min(count, columns.back().size() / column.width);
  }
  const Bodies bodies(recording);
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(body[i]) || !std::isfinite(other[i])) break;  // never arrived
    ContactEvent& e = events.emplace_back();
    e.a = bodies.of(body[i]);
    e.b = bodies.of(other[i]);
    e.open_at_end = lasts[i] > 0;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const std::size_t width = kEventColumns[k].width;
      std::copy_n(columns[k].begin() + static_cast<std::ptrdiff_t>(i * width), width,
                  kEventColumns[k].at(e));
    }
  }
  return events;
}

std::vector<CompressiveLoad> compressive_loads(const Recording& recording) {
  if (!recording.contains("/particles/compressive_load")) return {};
  const std::vector<double> load = recording.values("/particles/compressive_load"),
                            time = recording.values("/particles/compressive_load_time"),
                            first = recording.values("/particles/compressive_load_body_0"),
                            second = recording.values("/particles/compressive_load_body_1");
  std::vector<CompressiveLoad> loads(
      std::min({load.size(), time.size(), first.size(), second.size()}));
  const Bodies bodies(recording);
  for (std::size_t i = 0; i < loads.size(); ++i) {
    if (!(load[i] > 0)) continue;
    loads[i] = {load[i], time[i], {bodies.of(first[i]), bodies.of(second[i])}};
  }
  return loads;
}

namespace {

TriangleMesh read_mesh(const Recording& recording, const std::string& group) {
  TriangleMesh mesh;
  const std::vector<double> v = recording.values(group + "vertices"),
                            t = recording.values(group + "triangles");
  for (std::size_t i = 0; i + 2 < v.size(); i += 3)
    mesh.vertices.emplace_back(v[i], v[i + 1], v[i + 2]);
  const auto corner = [&](double number) {
    if (!(number >= 0 && number < static_cast<double>(mesh.vertices.size())))
      throw InputError(
          fmt::format("{}: {}triangles names a corner that is not there", recording.file(), group));
    return static_cast<int>(number);
  };
  for (std::size_t i = 0; i + 2 < t.size(); i += 3)
    mesh.triangles.push_back({corner(t[i]), corner(t[i + 1]), corner(t[i + 2])});
  if (mesh.triangles.empty())
    throw InputError(fmt::format("{}: {}triangles is empty", recording.file(), group));
  return mesh;
}

}  // namespace

std::vector<BoundaryLoads> boundary_loads(const Recording& recording) {
  std::vector<BoundaryLoads> all;
  if (!recording.contains(kIntervalEnd)) return all;
  for (const std::string& name : recording.strings(kNames)) {
    if (!recording.contains(boundary_path(name, "triangles"))) continue;
    BoundaryLoads& loads = all.emplace_back();
    loads.boundary = name;
    loads.mesh = read_mesh(recording, boundary_path(name, ""));
    const std::size_t triangles = loads.mesh.triangles.size();
    for (std::size_t t = 0; t < triangles; ++t)
      loads.area.push_back(0.5 * area_normal(loads.mesh, t).norm());
    loads.start = recording.values(kIntervalStart);
    loads.end = recording.values(kIntervalEnd);
    std::size_t whole = std::min(loads.start.size(), loads.end.size());
    for (const TriangleColumn& column : kTriangleColumns)
      loads.fields.push_back(
          {column.name, column.unit, recording.values(boundary_path(name, column.name))});
    if (recording.contains(boundary_path(name, kWearDepth)))
      loads.fields.push_back({kWearDepth, "m", recording.values(boundary_path(name, kWearDepth))});
    for (const TriangleField& field : loads.fields)
      whole = std::min(whole, field.values.size() / triangles);
    loads.start.resize(whole);
    loads.end.resize(whole);
    for (TriangleField& field : loads.fields) field.values.resize(whole * triangles);
  }
  return all;
}

std::vector<SurfaceLoads> surface_loads(const Recording& recording) {
  std::vector<SurfaceLoads> all;
  const std::vector<std::string> names = recording.strings("/shapes/name");
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (!recording.contains(shape_path(k, "contacts"))) continue;
    SurfaceLoads& loads = all.emplace_back();
    loads.shape = names[k];
    loads.mesh = read_mesh(recording, shape_path(k, ""));
    for (const auto& [name, unit] :
         {std::pair{"contacts", "1"}, {"normal_impulse", "N s"}, {"peak_normal_force", "N"}}) {
      loads.fields.push_back({name, unit, recording.values(shape_path(k, name))});
      if (loads.fields.back().values.size() != loads.mesh.triangles.size())
        throw InputError(fmt::format("{}: {} has the wrong shape; expected one value a triangle",
                                     recording.file(), shape_path(k, name)));
    }
  }
  return all;
}

std::optional<EnergySpectrum> energy_spectrum(const Recording& recording) {
  if (!recording.contains("/statistics/energy_spectrum/contacts")) return std::nullopt;
  EnergySpectrum spectrum;
  spectrum.lower = recording.values("/statistics/energy_spectrum/lower_bound");
  spectrum.kind = recording.strings(kNames);
  spectrum.kind.insert(spectrum.kind.begin(), "particles");
  spectrum.contacts = recording.values("/statistics/energy_spectrum/contacts");
  spectrum.dissipated = recording.values("/statistics/energy_spectrum/dissipated");
  const std::size_t size = spectrum.lower.size() * spectrum.kind.size();
  if (spectrum.contacts.size() != size || spectrum.dissipated.size() != size)
    throw InputError(recording.file() +
                     ": /statistics/energy_spectrum has lists of different lengths");
  return spectrum;
}

}  // namespace firn
