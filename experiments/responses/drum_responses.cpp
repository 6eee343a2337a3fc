#include "experiments/responses/drum_responses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "experiments/analysis/line_fit.h"
#include "experiments/responses/drained_repose_responses.h"
#include "experiments/responses/heap_slope.h"

namespace firn {
namespace {

constexpr std::size_t kFewest = 10;  // frames
constexpr std::size_t kBlocks = 10;  // of frames: what a turn does to the bed comes in waves
constexpr double kMiddle = 0.5;      // of the radius: ends of the surface, where it bends, left out

// The bed across the axis of the drum: u to one side, v up, m from the axis.
struct Section {
  Vec3 across = Vec3::Zero();
  Vec3 origin = Vec3::Zero();
  double radius = 0;  // m, inner
  double width = 0;   // m, of a column: the particles' size

  double u(const Vec3& p) const { return (p - origin).dot(across); }
  double v(const Vec3& p) const { return p.z() - origin.z(); }
};

struct Angles {
  double surface = std::numeric_limits<double>::quiet_NaN();  // deg
  double mass = std::numeric_limits<double>::quiet_NaN();
};

Angles angles_of(const Recording& recording, std::size_t index, const Case& c, const Measure& m,
                 const Section& section) {
  const Frame frame = recording.frame(index);
  const std::vector<double> mass = recording.mass();
  const int columns =
      std::max(4, static_cast<int>(std::min(2 * kMiddle * section.radius / section.width, 1e6)));
  const double step = 2 * kMiddle * section.radius / columns;
  std::vector<double> x, top;
  for (int i = 0; i < columns; ++i) {
    x.push_back(-kMiddle * section.radius + (i + 0.5) * step);
    top.push_back(-std::sqrt(section.radius * section.radius - x.back() * x.back()));  // bare
  }
  Vec3 center = Vec3::Zero();
  double total = 0;
  for (std::size_t k = 0; k < mass.size(); ++k) {
    const Particle& particle = c.model.particles[k];
    const Vec3 p(frame.position[k].data());
    if (!p.allFinite() || (m.tag && particle.tag != *m.tag)) continue;
    center += mass[k] * p;
    total += mass[k];
    const PlacedMesh placed =
        placed_mesh(frame, k, c.model.shapes[static_cast<std::size_t>(particle.shape)]);
    for (const Vec3& vertex : placed.mesh->vertices) {
      const Vec3 at = placed.pose * vertex;
      const int column = static_cast<int>(std::clamp(
          std::floor((section.u(at) + kMiddle * section.radius) / step), -1.0, 1.0 * columns));
      if (column < 0 || column >= columns) continue;
      double& height = top[static_cast<std::size_t>(column)];
      height = std::max(height, section.v(at));
    }
  }
  if (total == 0) return {};
  center /= total;
  return {std::atan(least_squares_line(x, top).slope) * kRadToDeg,
          std::atan2(section.u(center), -section.v(center)) * kRadToDeg};
}

// Mean, and its standard error from the means of blocks in time.
std::pair<double, double> mean_of(const std::vector<double>& values) {
  std::vector<double> blocks;
  for (std::size_t b = 0; b < kBlocks; ++b) {
    const std::size_t from = b * values.size() / kBlocks, to = (b + 1) * values.size() / kBlocks;
    double sum = 0;
    for (std::size_t i = from; i < to; ++i) sum += values[i];
    blocks.push_back(sum / static_cast<double>(to - from));
  }
  double mean = 0, square = 0;
  for (const double b : blocks) mean += b / kBlocks;
  for (const double b : blocks) square += (b - mean) * (b - mean);
  return {mean, std::sqrt(square / (kBlocks - 1) / kBlocks)};
}

void measure_drum(const Recording& recording, const Case& c, const Measure& m,
                  std::vector<Response>& out) {
  const auto drum = std::ranges::find(c.model.boundaries, m.boundary, &Boundary::name);
  Section section;
  section.across = m.axis == 0 ? Vec3::UnitY() : Vec3(-Vec3::UnitX());
  section.origin = drum->origin;
  for (const Vec3& p : drum->mesh.vertices) {
    const Vec3 at = drum->orientation * p;
    section.radius = std::max(section.radius, std::hypot(at.dot(section.across), at.z()));
  }
  double particles = 0;
  for (const Particle& p : c.model.particles) {
    section.width += middle_edge(c.model.shapes[static_cast<std::size_t>(p.shape)]);
    particles += 1;
  }
  section.width /= particles;
  std::vector<double> surface, mass;
  const std::vector<double> times = recording.frame_times();
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (times[i] < m.begin) continue;
    const Angles angles = angles_of(recording, i, c, m, section);
    if (std::isnan(angles.mass)) continue;
    surface.push_back(angles.surface);
    mass.push_back(angles.mass);
  }
  const std::string prefix = m.prefix();
  const auto add = [&](const char* name, double value, double uncertainty,
                       const std::string& method) {
    out.push_back({prefix + name, {value}, {uncertainty}, "deg", method, 1});
  };
  if (surface.size() < kFewest) {
    const std::string method =
        fmt::format("mean over frames; undefined: {} frames from {:.4g} s on, fewer than {}",
                    surface.size(), m.begin, kFewest);
    for (const char* name : {"drum_angle", "drum_mass_angle", "drum_angle_scatter"})
      add(name, kUndefined, kUndefined, method);
    return;
  }
  // Either way round: an angle that is taken up by the drum is positive.
  const double sign = mean_of(mass).first < 0 ? -1 : 1;
  const auto [angle, error] = mean_of(surface);
  add("drum_angle", sign * angle, error,
      "least-squares line through the highest points of columns in the middle half of the drum; "
      "mean over frames");
  const auto [leaning, leaning_error] = mean_of(mass);
  add("drum_mass_angle", sign * leaning, leaning_error,
      "of the center of mass about the drum's axis, from straight down; mean over frames");
  double square = 0;
  for (const double s : surface) square += (s - angle) * (s - angle);
  add("drum_angle_scatter", std::sqrt(square / static_cast<double>(surface.size() - 1)), kUndefined,
      "standard deviation of the line over frames");
}

}  // namespace

std::vector<Response> drum_responses(const Recording& recording, const Case& c) {
  std::vector<Response> out;
  if (recording.frame_times().empty()) return out;
  for (const Measure& m : c.measures)
    if (m.kind == Measure::Kind::drum) measure_drum(recording, c, m, out);
  return out;
}

}  // namespace firn
