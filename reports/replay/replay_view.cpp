#include "reports/replay/replay_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "experiments/results/bond_results.h"
#include "reports/rendering/simplify_mesh.h"
#include "reports/replay/pose_tracks.h"
#include "reports/replay/replay_data.h"
#include "reports/replay/surface_maps.h"

namespace firn {
namespace {

using replay::Json;
using replay::kBoundaryTriangles;
using replay::mesh_json;
using replay::micro;

// Of maps of where bodies are hit: all boundaries, all shapes.
constexpr std::size_t kMapTriangles = 24'000;

// Frames a second.
double motor_target_rate(const std::vector<double>& times, const ReplayViewOptions& options) {
  const double length = times.back() - times.front();
  return length > 0 ? std::max(options.rate, options.at_least / length) : options.rate;
}

// Particles, then boundaries, at the frames that `rate` selects.
PoseTracks read_tracks(const Recording& recording, const Case& c, double rate) {
  PoseTracks times;  // without bodies: which frames
  times.time = recording.frame_times();
  const std::vector<double> wanted = times.downsampled(rate).time;
  PoseTracks tracks;
  tracks.bodies = recording.particle_count() + c.model.boundaries.size();
  tracks.time = wanted;
  std::size_t i = 0;
  for (const double time : wanted) {
    while (times.time[i] != time) ++i;
    const Frame frame = recording.frame(i);
    for (std::size_t n = 0; n < frame.position.size(); ++n) {
      const auto& p = frame.position[n];
      const auto& q = frame.orientation[n];
      tracks.position.push_back(
          {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
      tracks.orientation.push_back({static_cast<float>(q[0]), static_cast<float>(q[1]),
                                    static_cast<float>(q[2]), static_cast<float>(q[3])});
    }
    for (const Boundary& b : c.model.boundaries) {
      const BoundaryFrame now = recording.boundary(b.name, i);
      const Eigen::Vector3f p = now.position.cast<float>();
      const Eigen::Quaternionf q = now.orientation.cast<float>();
      tracks.position.push_back({p.x(), p.y(), p.z()});
      tracks.orientation.push_back({q.w(), q.x(), q.y(), q.z()});
    }
  }
  return tracks;
}

// Three significant digits: the resolution of the color scale. 0 if it is not finite.
Json map_value(double v) {
  if (v == 0 || !std::isfinite(v)) return 0;
  const double rounded = std::strtod(fmt::format("{:.3g}", v).c_str(), nullptr);
  return std::isfinite(rounded) ? rounded : v;
}

Json map_json(const SurfaceMap& map) {
  Json fields = Json::array();
  for (const MapField& field : map.fields) {
    Json values = Json::array();
    for (const double v : field.values) values.push_back(map_value(v));
    fields.push_back({{"key", field.key},
                      {"name", field.name},
                      {"unit", field.unit},
                      {"per_triangle", field.merge == MapMerge::sum},
                      {"values", std::move(values)}});
  }
  return {{"computed", map.computed}, {"fields", fields}};
}

// One with a map is drawn by the triangles of its map.
Json boundaries_json(const Recording& recording, const Case& c, const Eigen::AlignedBox3d& box) {
  const std::size_t each = kBoundaryTriangles / std::max<std::size_t>(c.model.boundaries.size(), 1);
  const std::vector<SurfaceMap> maps = boundary_maps(recording, kMapTriangles);
  Json boundaries = Json::array();
  for (const Boundary& b : c.model.boundaries) {
    const bool plane = b.mesh.triangles.empty();
    const auto map = std::ranges::find(maps, b.name, &SurfaceMap::body);
    const bool mapped = map != maps.end();
    Json mesh = mesh_json(b.name,
                          mapped  ? map->mesh
                          : plane ? replay::plane_rectangle(b, box)
                                  : simplified_mesh(b.mesh, each),
                          Vec3::Zero());
    mesh["plane"] = plane;
    if (mapped) mesh["map"] = map_json(*map);
    boundaries.push_back(mesh);
  }
  return boundaries;
}

Json shape_maps_json(const Recording& recording) {
  Json maps = Json::array();
  for (const SurfaceMap& map : shape_maps(recording, kMapTriangles)) {
    Json mesh = mesh_json(map.body, map.mesh, Vec3::Zero());
    mesh["map"] = map_json(map);
    maps.push_back(mesh);
  }
  return maps;
}

Json bonds_json(const Recording& recording, const Case& c) {
  Json bonds = Json::array();
  if (c.model.bonds.empty()) return bonds;
  const std::vector<BondOutcome> outcomes = bond_outcomes(recording);
  for (std::size_t k = 0; k < outcomes.size(); ++k) {
    const Bond& bond = c.model.bonds[k];
    Json one = {{"a", bond.a}, {"broken", micro(outcomes[k].time)}};
    if (is_particle(c.model, bond.b)) {
      one["b"] = bond.b;
    } else {
      const Vec3 end = end_on_boundary(c.model, bond);
      one["end"] = {micro(end.x()), micro(end.y()), micro(end.z())};
    }
    bonds.push_back(one);
  }
  return bonds;
}

// All but the poses.
Json facts_json(const Recording& recording, const Case& c) {
  Json facts;
  facts["particles"] = recording.particle_count();
  facts["shape"] = recording.shape();
  facts["tag"] = recording.tag();
  facts["batch"] = recording.batch();
  facts["came"] = micro(recording.insert_time());
  facts["left"] = micro(recording.exit_time());
  facts["outlet"] = recording.outlet();
  facts["peak_force"] = recording.peak_normal_force();
  facts["outlets"] = Json::array();
  for (const Outlet& outlet : c.outlets) facts["outlets"].push_back(outlet.name);
  facts["sensors"] = Json::array();
  for (const Sensor& sensor : c.sensors)
    facts["sensors"].push_back(
        {{"name", sensor.name}, {"time", micro(recording.sensor_time(sensor.name))}});
  facts["stages"] = Json::array();
  for (const StageRecord& s : recording.stages())
    facts["stages"].push_back({{"name", s.name}, {"start", micro(s.start)}});
  facts["bonds"] = bonds_json(recording, c);
  return facts;
}

}  // namespace

ReplaySize add_replay_view(page::Page& page, page::Content& content, const ReplayName& name,
                           const Recording& recording, const Case& c,
                           const ReplayViewOptions& options) {
  ReplaySize size;
  const std::vector<double> times = recording.frame_times();
  size.recorded_frames = times.size();
  if (times.empty()) return size;
  double rate = motor_target_rate(times, options);
  PoseTracks tracks = read_tracks(recording, c, rate);
  Json facts = facts_json(recording, c);
  facts["markers"] = replay::markers_json(c);
  facts["shapes"] = replay::shapes_json(c, recording.particle_count());
  const Eigen::AlignedBox3d extent = replay::scene_extent(c, tracks);
  facts["extent"] = replay::box_json(extent);
  facts["boundaries"] = boundaries_json(recording, c, extent);
  facts["maps"] = shape_maps_json(recording);
  std::string data = replay::data_text(facts, tracks);
  while (data.size() > options.budget && tracks.time.size() > 2) {
    rate *= std::min(0.8,
                     0.95 * static_cast<double>(options.budget) / static_cast<double>(data.size()));
    tracks = tracks.downsampled(rate);
    data = replay::data_text(facts, tracks);
  }
  size.frames = tracks.time.size();
  size.characters = data.size();

  replay::place_view(page, content, name.anchor, name.title, data);
  const std::string kept = size.frames == size.recorded_frames
                               ? fmt::format("All {} frames of the results file", size.frames)
                               : fmt::format("{} of the {} frames of the results file", size.frames,
                                             size.recorded_frames);
  content.paragraph(
      kept +
      "; between them bodies are moved evenly. Meshes are drawn coarser than they are "
      "computed.");
  return size;
}

ReplaySize add_replay(page::Page& page, const Recording& recording, const Case& c,
                      const ReplayViewOptions& options) {
  if (recording.frame_count() == 0) return {};
  return add_replay_view(page, page.section("Replay", "replay"), {"run", c.name}, recording, c,
                         options);
}

}  // namespace firn
