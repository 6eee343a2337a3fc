#include "experiments/responses/drained_repose_responses.h"

#include <algorithm>
#include <cmath>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/responses/heap_slope.h"

namespace firn {
namespace {

using Particles = std::vector<DrainedHeap::Particle>;

constexpr double kQuiet = 0.5;  // s without a particle: the discharge has stopped

std::vector<PlacedMesh> meshes(const Particles& particles) {
  std::vector<PlacedMesh> result;
  for (const auto& p : particles) result.push_back(p.placed);
  return result;
}

Particles standing_of(const Particles& particles, const DrainedHeap& heap, bool door_open) {
  const std::vector<bool> stands =
      supported_particles(meshes(particles), heap.setup, heap.particle_size, door_open);
  Particles result;
  for (std::size_t k = 0; k < particles.size(); ++k) {
    if (stands[k]) result.push_back(particles[k]);
  }
  return result;
}

void add(std::vector<Response>& responses, const std::string& name, double value,
         double uncertainty, const std::string& unit, const std::string& method, int version = 1) {
  responses.push_back({name, {value}, {uncertainty}, unit, method, version});
}

void add_angles(std::vector<Response>& out, const DrainedHeap& heap,
                const std::vector<PlacedMesh>& surface_particles) {
  double volume = 0;
  for (const auto& p : heap.filled) volume += p.volume / static_cast<double>(heap.filled.size());
  const HeapSlope left =
      heap_slope(surface_particles, heap.setup, Side::left, heap.particle_size, volume);
  const HeapSlope right =
      heap_slope(surface_particles, heap.setup, Side::right, heap.particle_size, volume);
  const auto add_three = [&](const std::string& suffix, double l, double r, double sd_l,
                             double sd_r, const std::string& method, int version = 2) {
    add(out, "angle_of_repose_left" + suffix, l, sd_l, "deg", method, version);
    add(out, "angle_of_repose_right" + suffix, r, sd_r, "deg", method, version);
    add(out, "angle_of_repose" + suffix, (l + r) / 2, std::hypot(sd_l, sd_r) / 2, "deg",
        method + ", mean of both sides", version);
  };
  add_three("", left.robust_angle, right.robust_angle, left.robust_uncertainty,
            right.robust_uncertainty, "Theil-Sen line through the mesh surface");
  add_three("_least_squares", left.least_squares_angle, right.least_squares_angle,
            left.least_squares_uncertainty, right.least_squares_uncertainty,
            "least-squares line through the mesh surface");
  const double d = heap.particle_size;
  const HeapSlope left_outline =
      outline_slope(surface_particles, ledge_of(heap.setup, Side::left, d), d);
  const HeapSlope right_outline =
      outline_slope(surface_particles, ledge_of(heap.setup, Side::right, d), d);
  add_three("_outline", left_outline.robust_angle, right_outline.robust_angle,
            left_outline.robust_uncertainty, right_outline.robust_uncertainty,
            "Theil-Sen line through the outline seen from the front", 1);
  const std::string coverage = "part of the fit window's floor with particles above it";
  add(out, "window_coverage_left", left.covered, 0, "1", coverage);
  add(out, "window_coverage_right", right.covered, 0, "1", coverage);
}

void add_wall_height_excess(std::vector<Response>& out, const DrainedHeap& heap,
                            const std::vector<PlacedMesh>& surface_particles) {
  const double d = heap.particle_size;
  if (heap.setup.box.y() < 4 * d) return;  // no middle apart from the walls
  const MeanHeight left =
      wall_height_excess(surface_particles, ledge_of(heap.setup, Side::left, d), d);
  const MeanHeight right =
      wall_height_excess(surface_particles, ledge_of(heap.setup, Side::right, d), d);
  const std::string method =
      "mesh surface within a particle size of the front and back walls less that in the middle";
  add(out, "wall_height_excess_left", left.value, left.uncertainty, "m", method);
  add(out, "wall_height_excess_right", right.value, right.uncertainty, "m", method);
  add(out, "wall_height_excess", (left.value + right.value) / 2,
      std::hypot(left.uncertainty, right.uncertainty) / 2, "m", method + ", mean of both sides");
}

void add_remaining(std::vector<Response>& out, const DrainedHeap& heap) {
  double count_left = 0, count_right = 0, mass_left = 0, mass_right = 0;
  for (const auto& p : heap.remaining) {
    const bool is_left = p.center.x() < 0;
    (is_left ? count_left : count_right) += 1;
    (is_left ? mass_left : mass_right) += p.mass;
  }
  const std::string method = "particles whose center of mass never passed the floor's underside";
  const std::string half = method + ", by the side of the center of mass";
  add(out, "remaining_count", count_left + count_right, 0, "1", method);
  add(out, "remaining_count_left", count_left, 0, "1", half);
  add(out, "remaining_count_right", count_right, 0, "1", half);
  add(out, "remaining_mass", mass_left + mass_right, 0, "kg", method);
  add(out, "remaining_mass_left", mass_left, 0, "kg", half);
  add(out, "remaining_mass_right", mass_right, 0, "kg", half);
}

void add_discharge(std::vector<Response>& out, const DrainedHeap& heap) {
  const std::vector<double>& times = heap.discharge_times;
  const std::size_t n = times.size();
  add(out, "discharged_count", static_cast<double>(n), 0, "1",
      "particles whose center of mass passed the floor's underside");
  if (n == 0) return;
  out.push_back({"discharge_curve", times, std::vector<double>(n, heap.time_resolution), "s",
                 "entry k: time after the opening at which k + 1 particles had passed", 1});
  // The time by which the given part of all that discharged had passed.
  const auto index = [n](double part) {
    return static_cast<std::size_t>(std::ceil(part * static_cast<double>(n) - 1e-9)) - 1;
  };
  const std::string method = "time after the opening by which this part of the discharge passed";
  add(out, "t10", times[index(0.1)], heap.time_resolution, "s", method);
  add(out, "t50", times[index(0.5)], heap.time_resolution, "s", method);
  add(out, "t90", times[index(0.9)], heap.time_resolution, "s", method);
  add(out, "discharge_time", times[index(0.9)], heap.time_resolution, "s",
      "t90: without the last tenth, which passes at irregular times");

  const std::size_t first = index(0.1), last = index(0.9);
  const double duration = times[last] - times[first];
  if (last < first + 2 || duration <= 0) return;
  const double passed = static_cast<double>(last - first);
  // A renewal process: the scatter of a count is that of the gaps, by the root of their number.
  std::vector<double> gaps;
  for (std::size_t k = first; k < last; ++k) gaps.push_back(times[k + 1] - times[k]);
  const double rate = passed / duration;
  const double relative = standard_deviation(gaps) * rate / std::sqrt(passed);
  add(out, "discharge_rate", rate, rate * relative, "1/s", "particles between t10 and t90");
}

// Mean height over the whole box and its standard error from tiles of one particle size.
void add_fill(std::vector<Response>& out, const DrainedHeap& heap) {
  const Particles standing_particles = standing_of(heap.filled, heap, false);
  const Vec3& box = heap.setup.box;
  const HeightMap surface = closed_height_map(meshes(standing_particles), -box.x() / 2, box.x() / 2,
                                              -box.y() / 2, box.y() / 2, heap.particle_size);
  const auto [height, error] = mean_height(surface.height, surface.grid, heap.particle_size);
  add(out, "fill_height", height, error, "m",
      "mean height of the mesh surface over the box when the door opens");
  if (height <= 0) return;
  double mass = 0, volume = 0;
  for (const auto& p : standing_particles) {
    mass += p.mass;
    volume += p.volume;
  }
  const double space = box.x() * box.y() * height;
  const std::string method = "particles over the box's floor area times fill_height";
  add(out, "bulk_density", mass / space, mass / space * error / height, "kg/m^3", method);
  add(out, "solid_fraction", volume / space, volume / space * error / height, "1", method);
}

}  // namespace

std::vector<Response> drained_repose_responses(const DrainedHeap& heap) {
  std::vector<Response> out;
  if (!heap.opened) return out;
  const std::vector<PlacedMesh> surface_particles = meshes(standing_of(heap.remaining, heap, true));
  add_angles(out, heap, surface_particles);
  add_wall_height_excess(out, heap, surface_particles);
  add_remaining(out, heap);
  add_discharge(out, heap);
  add_fill(out, heap);
  const double last = heap.discharge_times.empty() ? 0 : heap.discharge_times.back();
  const bool arched = heap.observed - last >= kQuiet &&
                      spans_opening(surface_particles, heap.setup, heap.particle_size);
  add(out, "arched", arched, 0, "1",
      "1: particles bridge the opening from lip to lip and none passed for the last 0.5 s");
  add(out, "settled", heap.settled, 0, "1", "1: the last stage ended at rest");
  return out;
}

namespace {

bool opens_door(const Stage& stage, const Model& model, const std::string& door) {
  if (std::find(stage.remove.begin(), stage.remove.end(), door) != stage.remove.end()) return true;
  return std::any_of(stage.motions.begin(), stage.motions.end(), [&](const auto& start) {
    return start.boundary >= 0 &&
           model.boundaries[static_cast<std::size_t>(start.boundary)].name == door;
  });
}

}  // namespace

PlacedMesh placed_mesh(const Frame& frame, std::size_t particle, const Shape& shape) {
  const auto& q = frame.orientation[particle];
  const Mat3 rotation = Quat(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  const Vec3 center(frame.position[particle].data());
  return {&shape.mesh, {rotation, center - rotation * shape.centroid}};
}

std::vector<DrainedHeap::Particle> particles_in_box(const Recording& recording, const Case& c,
                                                    std::size_t frame) {
  const Frame f = recording.frame(frame);
  const std::vector<int> shape = recording.shape();
  const std::vector<double> mass = recording.mass();
  Particles result;
  for (std::size_t k = 0; k < shape.size(); ++k) {
    const Vec3 center(f.position[k].data());
    if (!center.allFinite() || center.z() < -c.drained_repose->floor_thickness) continue;
    const Shape& s = c.model.shapes[static_cast<std::size_t>(shape[k])];
    result.push_back({placed_mesh(f, k, s), center, mass[k], s.volume});
  }
  return result;
}

double mean_particle_size(const Recording& recording, const Case& c) {
  const std::vector<int> shape = recording.shape();
  double sum = 0;
  for (int s : shape) sum += middle_edge(c.model.shapes[static_cast<std::size_t>(s)]);
  return sum / static_cast<double>(shape.size());
}

std::optional<double> opening_time(const Recording& recording, const Case& c) {
  for (const StageRecord& record : recording.stages()) {
    for (const Stage& stage : c.stages) {
      if (stage.name == record.name && opens_door(stage, c.model, c.drained_repose->door)) {
        return record.start;
      }
    }
  }
  return std::nullopt;
}

DrainedHeap drained_heap(const Recording& recording, const Case& c) {
  DrainedHeap heap;
  heap.setup = *c.drained_repose;
  heap.time_resolution = recording.timestep();
  const std::vector<double> times = recording.frame_times();
  const std::optional<double> opening = opening_time(recording, c);
  if (!opening || times.empty()) return heap;
  heap.opened = true;
  heap.particle_size = mean_particle_size(recording, c);
  heap.settled = recording.stages().back().end_reason == "settled";
  heap.observed = times.back() - *opening;

  // The last frame before the door opened (a frame at that very step still counts).
  const double until = *opening + 0.5 * recording.timestep();
  const auto after = std::upper_bound(times.begin(), times.end(), until) - times.begin();
  heap.filled = particles_in_box(recording, c,
                                 static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - 1, 0)));
  heap.remaining = particles_in_box(recording, c, times.size() - 1);
  for (double t : recording.discharge_time()) {
    if (std::isfinite(t)) heap.discharge_times.push_back(t - *opening);
  }
  std::sort(heap.discharge_times.begin(), heap.discharge_times.end());
  return heap;
}

}  // namespace firn
