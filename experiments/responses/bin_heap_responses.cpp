#include "experiments/responses/bin_heap_responses.h"

#include <fmt/format.h>

#include <cmath>

#include "experiments/responses/drained_repose_responses.h"
#include "experiments/responses/heap_slope.h"

namespace firn {
namespace {

// What lies in the bin in the last frame, in axes whose z = 0 is its floor.
struct Content {
  std::vector<PlacedMesh> placed;
  double mass = 0;           // kg
  double particle_size = 0;  // m: mean of the middle bounding-box edges
  double mean_volume = 0;    // m^3
};

bool inside(const Vec3& p, const Measure& m) {
  return (p - m.region_min).minCoeff() >= 0 && (m.region_max - p).minCoeff() >= 0;
}

Content content_of(const Recording& recording, const Case& c, const Measure& m) {
  Content content;
  const std::vector<double> mass = recording.mass();
  const Frame frame = recording.frame(recording.frame_times().size() - 1);
  for (std::size_t k = 0; k < c.model.particles.size(); ++k) {
    const Particle& particle = c.model.particles[k];
    const Vec3 center(frame.position[k].data());
    if (m.tag && particle.tag != *m.tag) continue;
    if (!center.allFinite() || !inside(center, m)) continue;
    const Shape& shape = c.model.shapes[static_cast<std::size_t>(particle.shape)];
    PlacedMesh placed = placed_mesh(frame, k, shape);
    placed.pose.translation.z() -= m.region_min.z();
    content.placed.push_back(placed);
    content.mass += mass[k];
    content.particle_size += middle_edge(shape);
    content.mean_volume += shape.volume;
  }
  const double n = static_cast<double>(content.placed.size());
  content.particle_size /= n;
  content.mean_volume /= n;
  return content;
}

// From an end wall up to where the heap is poured.
Ledge side_of(const Measure& m, double end_wall, double particle_size) {
  const double length = std::abs(m.peak - end_wall);
  const FitWindow window{m.end_margin, length - m.peak_margin};
  if (window.to - window.from < 2 * particle_size) {
    throw InputError(fmt::format(
        "measure of kind \"heap\": margins of {:.4g} m at the end wall and {:.4g} m at the peak "
        "leave no window of two particle sizes ({:.4g} m) on a side of {:.4g} m; expected smaller "
        "margins",
        m.end_margin, m.peak_margin, 2 * particle_size, length));
  }
  return {end_wall, m.peak, m.region_min.y(), m.region_max.y(), window};
}

void measure_heap(const Recording& recording, const Case& c, const Measure& m,
                  std::vector<Response>& out) {
  const std::string prefix = m.prefix();
  const auto add = [&](const char* name, double value, double uncertainty, const char* unit,
                       const std::string& method) {
    out.push_back({prefix + name, {value}, {uncertainty}, unit, method, 1});
  };
  const Content content = content_of(recording, c, m);
  add("heap_count", static_cast<double>(content.placed.size()), 0, "1",
      "particles whose center of mass is in the bin in the last frame");
  add("heap_mass", content.mass, 0, "kg", "their mass");
  if (content.placed.empty()) return;

  const double d = content.particle_size;
  const HeapSlope left =
      heap_slope(content.placed, side_of(m, m.region_min.x(), d), d, content.mean_volume);
  const HeapSlope right =
      heap_slope(content.placed, side_of(m, m.region_max.x(), d), d, content.mean_volume);
  const std::string line = "Theil-Sen line through the mesh surface, positive towards the peak";
  add("heap_angle_left", left.robust_angle, left.robust_uncertainty, "deg", line);
  add("heap_angle_right", right.robust_angle, right.robust_uncertainty, "deg", line);
  add("heap_angle", (left.robust_angle + right.robust_angle) / 2,
      std::hypot(left.robust_uncertainty, right.robust_uncertainty) / 2, "deg",
      line + ", mean of both sides");
  const HeapSlope left_outline = outline_slope(content.placed, side_of(m, m.region_min.x(), d), d);
  const HeapSlope right_outline = outline_slope(content.placed, side_of(m, m.region_max.x(), d), d);
  const std::string outline =
      "Theil-Sen line through the outline seen from the front, positive towards the peak";
  add("heap_angle_left_outline", left_outline.robust_angle, left_outline.robust_uncertainty, "deg",
      outline);
  add("heap_angle_right_outline", right_outline.robust_angle, right_outline.robust_uncertainty,
      "deg", outline);
  add("heap_angle_outline", (left_outline.robust_angle + right_outline.robust_angle) / 2,
      std::hypot(left_outline.robust_uncertainty, right_outline.robust_uncertainty) / 2, "deg",
      outline + ", mean of both sides");
  const HeightMap peak = closed_height_map(content.placed, m.peak - d, m.peak + d, m.region_min.y(),
                                           m.region_max.y(), d);
  const auto [height, error] = mean_height(peak.height, peak.grid, d);
  add("heap_height", height, error, "m",
      "mean height of the mesh surface within a particle size of the peak");
}

}  // namespace

std::vector<Response> bin_heap_responses(const Recording& recording, const Case& c) {
  std::vector<Response> out;
  if (recording.frame_times().empty()) return out;
  for (const Measure& m : c.measures) {
    if (m.kind == Measure::Kind::heap) measure_heap(recording, c, m, out);
  }
  return out;
}

}  // namespace firn
