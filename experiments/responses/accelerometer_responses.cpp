#include "experiments/responses/accelerometer_responses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/analysis/channel_filter.h"
#include "experiments/results/results_file.h"

namespace firn {
namespace {

double largest(const std::vector<double>& values) {
  double most = 0;
  for (double v : values) most = std::max(most, std::abs(v));
  return most;
}

}  // namespace

std::vector<Response> accelerometer_responses(const Recording& recording, const Case& c) {
  std::vector<Response> out;
  for (const Measure& m : c.measures) {
    if (m.kind != Measure::Kind::accelerometer) continue;
    const MotionFrame& frame = c.model.frames[static_cast<std::size_t>(m.frame)];
    const std::string group = "/motion_frames/" + frame.name + "/";
    const std::vector<double> times = recording.frame_times(),
                              rate = recording.series(group + "rate"),
                              force = recording.series(group + "force");
    const std::size_t axes = frame.free->joints.size();
    const Vec3& direction = frame.free->joints[static_cast<std::size_t>(m.axis)].direction;
    std::vector<double> acceleration, along;
    for (std::size_t i = 1; i < times.size(); ++i) {
      const double interval = times[i] - times[i - 1];
      // The last frame may follow the one before it sooner.
      if (interval < 0.5 * c.frame_interval) continue;
      const std::size_t at = i * axes + static_cast<std::size_t>(m.axis);
      acceleration.push_back((rate[at] - rate[at - axes]) / interval);
      along.push_back(Vec3(force[3 * i], force[3 * i + 1], force[3 * i + 2]).dot(direction));
    }
    if (acceleration.size() < 3) continue;
    const std::string name = m.prefix();
    const std::string method = fmt::format("largest magnitude, CFC {:g} of SAE J211-1", m.cfc);
    const double peak = largest(channel_filter(acceleration, c.frame_interval, m.cfc));
    const double contact = largest(channel_filter(along, c.frame_interval, m.cfc));
    out.push_back({name + "acceleration_peak", {peak}, {}, "m/s^2", method, 1});
    out.push_back({name + "contact_force_peak",
                   {contact},
                   {},
                   "N",
                   method + "; of all contacts, along the axis",
                   1});
    const Shape& shape = c.model.shapes[static_cast<std::size_t>(c.model.particles[0].shape)];
    out.push_back({name + "particle_mass_times_acceleration",
                   {shape.mass * peak},
                   {},
                   "N",
                   "mass of the first particle times acceleration_peak: no force on anything",
                   1});
  }
  return out;
}

}  // namespace firn
