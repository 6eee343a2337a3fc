#include "experiments/responses/accelerometer_responses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/analysis/channel_filter.h"
#include "experiments/analysis/recorded_rows.h"
#include "experiments/responses/measured_part.h"

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
    const PartRecords records(recording, c, m, {"acceleration", "force"});
    const std::size_t rows = records.regular_rows();
    if (rows < 4) continue;
    const std::vector<Joint>& joints =
        c.model.frames[static_cast<std::size_t>(m.frame)].free->joints;
    const auto axis = static_cast<std::size_t>(m.axis);
    std::vector<double> acceleration =
        rates_of_change(records.times(), row_column(records.rows("rate"), joints.size(), axis));
    acceleration.resize(rows);
    acceleration.erase(acceleration.begin());  // the first row ends no interval
    const std::vector<double> force = records.rows("force");
    std::vector<double> along;
    for (std::size_t i = 1; i < rows; ++i)
      along.push_back(
          Vec3(force[3 * i], force[3 * i + 1], force[3 * i + 2]).dot(joints[axis].direction));
    const std::string name = m.prefix();
    const std::string method = fmt::format("largest magnitude, CFC {:g} of SAE J211-1", m.cfc);
    const double peak = largest(channel_filter(acceleration, records.interval(), m.cfc));
    const double contact = largest(channel_filter(along, records.interval(), m.cfc));
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
