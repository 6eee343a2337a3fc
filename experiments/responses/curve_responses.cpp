#include "experiments/responses/curve_responses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "experiments/analysis/channel_filter.h"
#include "experiments/analysis/folded_curve.h"
#include "experiments/analysis/recorded_rows.h"
#include "experiments/responses/measured_part.h"
#include "experiments/results/results_file.h"

namespace firn {
namespace {

// One value a row of the records.
struct Signal {
  std::vector<double> values;
  std::string unit;
};

// How far the origin is from where it was first.
std::vector<double> displacement(std::vector<double> rows) {
  const std::vector<double> first(rows.begin(),
                                  rows.begin() + std::min<std::ptrdiff_t>(3, std::ssize(rows)));
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] -= first[i % 3];
  return row_lengths(rows);
}

// The dataset that a quantity comes from.
std::string_view source_of(std::string_view what) {
  if (what == "displacement") return "position";
  return what == "acceleration" ? "rate" : what;
}

Signal of_part(const PartRecords& records, const std::string& what) {
  const std::vector<double> rows = records.rows(source_of(what));
  if (what == "displacement") return {displacement(rows), "m"};
  if (what == "peak_normal_force") return {rows, "N"};
  if (what == "dissipated_friction") return {rows, "J"};
  return {row_lengths(rows), what == "force" ? "N" : "N m"};
}

Signal of_frame(const PartRecords& records, const MotionFrame& frame, std::size_t joint,
                const std::string& what) {
  const std::size_t joints = frame.free->joints.size();
  const bool turns = frame.free->joints[joint].kind == Joint::Kind::rotation;
  const std::vector<double> rows = records.rows(source_of(what));
  if (what == "force" || what == "reaction_force") return {row_lengths(rows), "N"};
  const std::vector<double> values = row_column(rows, joints, joint);
  if (what == "coordinate") return {values, turns ? "rad" : "m"};
  if (what == "rate") return {values, turns ? "rad/s" : "m/s"};
  if (what == "motor_load") return {values, turns ? "N m" : "N"};
  if (what == "dissipated_friction") return {values, "J"};
  return {rates_of_change(records.times(), values), turns ? "rad/s^2" : "m/s^2"};
}

Signal signal_of(const PartRecords& records, const Case& c, const Measure& m,
                 const std::string& what) {
  if (what == "time") return {records.times(), "s"};
  if (!m.boundary.empty() || m.contact >= 0 || m.coupling >= 0) return of_part(records, what);
  return of_frame(records, c.model.frames[static_cast<std::size_t>(m.frame)],
                  static_cast<std::size_t>(m.axis), what);
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
  for (const Measure& m : c.measures) {
    if (m.kind != Measure::Kind::curve) continue;
    const PartRecords records(recording, c, m, {m.x, m.y});
    // A filter expects equal intervals.
    const std::size_t rows = m.cfc > 0 ? records.regular_rows() : records.times().size();
    if (rows < 2) continue;
    Signal x = signal_of(records, c, m, m.x), y = signal_of(records, c, m, m.y);
    x.values.resize(rows);
    y.values.resize(rows);
    std::string method = fmt::format("{} over {} of \"{}\"", m.y, m.x, measured_part(c, m));
    if (m.cfc > 0) {
      y.values = channel_filter(y.values, records.interval(), m.cfc);
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
