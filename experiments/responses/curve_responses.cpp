#include "experiments/responses/curve_responses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "experiments/analysis/channel_filter.h"
#include "experiments/analysis/folded_curve.h"
#include "experiments/responses/measured_part.h"
#include "experiments/results/results_file.h"

namespace firn {
namespace {

// One value a frame.
struct Signal {
  std::vector<double> values;
  std::string unit;
};

// Rows of three as their lengths.
std::vector<double> lengths(const std::vector<double>& rows) {
  std::vector<double> all;
  for (std::size_t i = 0; i + 2 < rows.size(); i += 3)
    all.push_back(std::hypot(rows[i], rows[i + 1], rows[i + 2]));
  return all;
}

// How far the origin is from where it was first.
std::vector<double> displacement(std::vector<double> rows) {
  const std::vector<double> first(rows.begin(),
                                  rows.begin() + std::min<std::ptrdiff_t>(3, std::ssize(rows)));
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] -= first[i % 3];
  return lengths(rows);
}

Signal of_part(const Recording& r, const Case& c, const Measure& m, const std::string& what) {
  const std::string group = part_group(c, m);
  if (what == "displacement") return {displacement(r.series(group + "position")), "m"};
  if (what == "peak_normal_force") return {r.series(group + what), "N"};
  if (what == "dissipated_friction") return {r.series(group + what), "J"};
  return {lengths(r.series(group + what)), what == "force" ? "N" : "N m"};
}

Signal of_frame(const Recording& r, const Case& c, const Measure& m, const std::string& what) {
  const MotionFrame& frame = c.model.frames[static_cast<std::size_t>(m.frame)];
  const std::string group = "/motion_frames/" + frame.name + "/";
  const std::size_t axes = frame.free->joints.size(), k = static_cast<std::size_t>(m.axis);
  const Joint& axis = frame.free->joints[k];
  const bool turns = axis.kind == Joint::Kind::rotation;
  const auto column = [&](const std::string& name) {
    std::vector<double> values;
    const std::vector<double> rows = r.series(group + name);
    for (std::size_t i = k; i < rows.size(); i += axes) values.push_back(rows[i]);
    return values;
  };
  if (what == "coordinate") return {column(what), turns ? "rad" : "m"};
  if (what == "rate") return {column(what), turns ? "rad/s" : "m/s"};
  if (what == "motor_load") return {column(what), turns ? "N m" : "N"};
  if (what == "dissipated_friction") return {column(what), "J"};
  if (what == "force" || what == "reaction_force") return {lengths(r.series(group + what)), "N"};
  const std::vector<double> rate = column("rate"), times = r.frame_times();
  std::vector<double> acceleration(rate.size(), 0);
  for (std::size_t i = 1; i < rate.size(); ++i)
    if (times[i] > times[i - 1])
      acceleration[i] = (rate[i] - rate[i - 1]) / (times[i] - times[i - 1]);
  return {acceleration, turns ? "rad/s^2" : "m/s^2"};
}

Signal signal_of(const Recording& r, const Case& c, const Measure& m, const std::string& what) {
  if (what == "time") return {r.frame_times(), "s"};
  const bool is_frame = m.boundary.empty() && m.contact < 0 && m.coupling < 0;
  return is_frame ? of_frame(r, c, m, what) : of_part(r, c, m, what);
}

// So many of them, the first and the last included.
std::vector<double> downsampled(const std::vector<double>& all, std::size_t points) {
  if (all.size() <= points) return all;
  std::vector<double> some;
  for (std::size_t k = 0; k < points; ++k) some.push_back(all[k * (all.size() - 1) / (points - 1)]);
  return some;
}

// The first frame ends no interval: its forces are 0.
void add_folded(const Measure& m, const Signal& x, const Signal& y, const std::string& method,
                std::vector<Response>& out) {
  const FoldedCurve folded =
      folded_curve(std::span(x.values).subspan(1), std::span(y.values).subspan(1), m.x_period,
                   static_cast<std::size_t>(m.points));
  const std::string bins = fmt::format("{}, folded with a period of {:.6g} {}, {} bins", method,
                                       m.x_period, x.unit, m.points);
  out.push_back({m.name + "_curve_x", folded.x, {}, x.unit, bins + ": middle of each", 1});
  out.push_back({m.name + "_curve_y", folded.mean, {}, y.unit, bins + ": mean of each", 1});
  out.push_back({m.name + "_curve_y_min", folded.least, {}, y.unit, bins + ": least of each", 1});
  out.push_back({m.name + "_curve_y_max", folded.most, {}, y.unit, bins + ": largest of each", 1});
}

}  // namespace

std::vector<Response> curve_responses(const Recording& recording, const Case& c) {
  std::vector<Response> out;
  const std::vector<double> times = recording.frame_times();
  for (const Measure& m : c.measures) {
    if (m.kind != Measure::Kind::curve) continue;
    Signal x = signal_of(recording, c, m, m.x), y = signal_of(recording, c, m, m.y);
    std::size_t frames = std::min(x.values.size(), y.values.size());
    // The last frame may follow the one before it sooner, which a filter does not expect.
    if (m.cfc > 0 && frames > 2 && times[frames - 1] - times[frames - 2] < 0.5 * c.frame_interval)
      --frames;
    if (frames < 2) continue;
    x.values.resize(frames);
    y.values.resize(frames);
    std::string method = fmt::format("{} over {} of \"{}\"", m.y, m.x, measured_part(c, m));
    if (m.cfc > 0) {
      y.values = channel_filter(y.values, c.frame_interval, m.cfc);
      method += fmt::format(", CFC {:g} of SAE J211-1", m.cfc);
    }
    const auto points = static_cast<std::size_t>(m.points);
    if (m.x_period > 0) {
      add_folded(m, x, y, method, out);
      continue;
    }
    out.push_back({m.name + "_curve_x", downsampled(x.values, points), {}, x.unit, method, 1});
    out.push_back({m.name + "_curve_y", downsampled(y.values, points), {}, y.unit, method, 1});
  }
  return out;
}

}  // namespace firn
