#include "experiments/statistics_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace firn {
namespace {

// A field of an event as a column of the file: `put` appends its values to a row of numbers, `get`
// takes them back.
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
    {"approach_normal", "m/s", [](ContactEvent& e) { return &e.approach_normal; }},
    {"approach_tangential", "m/s", [](ContactEvent& e) { return &e.approach_tangential; }},
    {"normal", "1", [](ContactEvent& e) { return e.normal.data(); }, 3},
    {"place", "m", [](ContactEvent& e) { return e.place.data(); }, 3},
    {"place_on_body", "m", [](ContactEvent& e) { return e.place_on_a.data(); }, 3},
    {"place_on_other", "m", [](ContactEvent& e) { return e.place_on_b.data(); }, 3},
    {"dissipated", "J", [](ContactEvent& e) { return &e.dissipated; }},
};
// Beside them, whole numbers: who, and whether it still lasts.
constexpr const char* kEventNumbers[] = {"body", "other", "lasts"};

std::string event_path(const char* name) { return std::string("/events/") + name; }

// Bodies in a file: the id of a particle, or -1 - the number of a boundary in order of the case.
double number_of_body(std::int32_t body, std::size_t particles) {
  const auto n = static_cast<std::int32_t>(particles);
  return body < n ? body : n - 1 - body;
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
  append("body", [&](const ContactEvent& e) { return number_of_body(e.a, particles); });
  append("other", [&](const ContactEvent& e) { return number_of_body(e.b, particles); });
  append("lasts", [](const ContactEvent& e) { return static_cast<double>(e.lasts); });
}

void truncate(hdf5::File& file, const std::string& path, std::uint64_t rows) {
  hdf5::Table table = file.open_table(path);
  if (table.rows() < rows) throw RunError(path + " has fewer rows than its checkpoint");
  table.truncate(rows);
}

}  // namespace

void create_statistics(hdf5::File& file, const Model& model) {
  const StatisticsOptions& options = model.statistics;
  if (!options.any()) return;
  std::vector<std::string> names;
  for (const Boundary& boundary : model.boundaries) names.push_back(boundary.name);
  file.write_strings("/statistics/boundary_name", names);
  if (options.events) {
    for (const EventColumn& column : kEventColumns) {
      file.create_table(event_path(column.name),
                        column.width > 1 ? hdf5::Shape{column.width} : hdf5::Shape{}, column.unit);
    }
    for (const char* name : kEventNumbers) file.create_table(event_path(name), {}, "1");
  }
}

void truncate_statistics(hdf5::File& file, const Model& model, const StatisticsRows& rows) {
  if (!model.statistics.events) return;
  for (const EventColumn& column : kEventColumns)
    truncate(file, event_path(column.name), rows.events);
  for (const char* name : kEventNumbers) truncate(file, event_path(name), rows.events);
}

void append_statistics(hdf5::File& file, Solver& solver, bool at_end, StatisticsRows& rows) {
  const StatisticsOptions& options = solver.model().statistics;
  if (!options.events) return;
  std::vector<ContactEvent> events = solver.take_events();
  if (at_end) {
    for (const ContactEvent& e : solver.open_events())
      if (e.peak_normal_force >= options.threshold) events.push_back(e);
  }
  rows.events += events.size();
  append_events(file, std::move(events), solver.model().particles.size());
}

std::vector<ContactEvent> contact_events(const Recording& recording) {
  if (!recording.contains("/events/start")) return {};
  // A writer that was killed may have left columns of different lengths.
  std::vector<ContactEvent> events;
  const std::vector<double> body = recording.values("/events/body"),
                            other = recording.values("/events/other"),
                            lasts = recording.values("/events/lasts");
  std::size_t count = std::min({body.size(), other.size(), lasts.size()});
  std::vector<std::vector<double>> columns;
  for (const EventColumn& column : kEventColumns) {
    columns.push_back(recording.values(event_path(column.name)));
    count = std::min(count, columns.back().size() / column.width);
  }
  const auto particles = static_cast<std::int32_t>(recording.particle_count());
  const auto body_of = [&](double number) {
    const auto k = static_cast<std::int32_t>(number);
    return k >= 0 ? k : particles - 1 - k;
  };
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(body[i]) || !std::isfinite(other[i])) break;  // never arrived
    ContactEvent& e = events.emplace_back();
    e.a = body_of(body[i]);
    e.b = body_of(other[i]);
    e.lasts = lasts[i] > 0;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const std::size_t width = kEventColumns[k].width;
      std::copy_n(columns[k].begin() + static_cast<std::ptrdiff_t>(i * width), width,
                  kEventColumns[k].at(e));
    }
  }
  return events;
}

}  // namespace firn
