#include "reports/documents/run_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "experiments/analysis/recorded_rows.h"
#include "experiments/text/units.h"
#include "reports/plots/plots.h"

namespace firn {
namespace {

plots::Series curve(const std::string& name, const std::vector<double>& times,
                    const std::vector<double>& values) {
  Curve c = downsampled_curve(times, values);
  plots::Series series;
  series.name = name;
  series.x = std::move(c.x);
  series.y = std::move(c.y);
  return series;
}

// Of the frames.
plots::Series curve(const std::string& name, const Recording& recording,
                    const std::vector<double>& values) {
  return curve(name, recording.frame_times(), values);
}

// NaN for none.
double largest_magnitude(const std::vector<double>& values) {
  double largest = std::nan("");
  for (const double v : values)
    if (std::isfinite(v)) largest = std::fmax(largest, std::abs(v));
  return largest;
}

// "bucket at most 118 N, chute at most 20 N".
std::string heights(const std::vector<plots::Series>& all, const std::string& unit) {
  std::string text;
  for (const plots::Series& s : all)
    text += fmt::format("{}{} at most {} {}", text.empty() ? "" : ", ", s.name,
                        page::number_text(largest_magnitude(s.y), 3), unit);
  return text;
}

page::Figure over_time(const std::string& label, const std::string& unit,
                       const std::vector<plots::Series>& series, const std::string& caption) {
  plots::XyPlot plot;
  plot.x = {"time", "s", false, {}, {}};
  plot.y = {label, unit, false, {}, {}};
  plot.series = series;
  return {plots::draw(plot), caption,
          fmt::format("{} against time: {}", label, heights(series, unit))};
}

// A quantity of a measured curve, in the words of the other plots.
std::string quantity_words(const std::string& quantity, const std::string& unit) {
  if (quantity == "coordinate") return unit == "m" ? "displacement" : "angle";
  if (quantity == "motor_load") return unit == "N" ? "drive force" : "drive torque";
  return page::words(quantity);
}

// How far something has turned, in degrees within one turn, from its orientations [T, 4] (w x y z).
// NaN once it is gone. Empty where it turns too far between two frames, or not at all.
std::vector<double> turned(const std::vector<double>& orientations) {
  constexpr double too_fast = 150, nothing = 1;  // deg
  std::vector<double> angle;
  double sum = 0, farthest = 0;
  std::optional<Quat> before;
  Vec3 axis = Vec3::Zero();
  for (std::size_t i = 0; i + 3 < orientations.size(); i += 4) {
    const Quat q(orientations[i], orientations[i + 1], orientations[i + 2], orientations[i + 3]);
    if (before && std::isfinite(q.w())) {
      const Eigen::AngleAxisd step(q * before->conjugate());
      if (step.angle() * kRadToDeg > too_fast) return {};
      if (axis.isZero() && step.angle() > 1e-9) axis = step.axis();
      sum += step.angle() * kRadToDeg * (step.axis().dot(axis) < 0 ? -1 : 1);
      farthest = std::max(farthest, std::abs(sum));
    }
    if (std::isfinite(q.w())) before = q;
    angle.push_back(std::isfinite(q.w()) ? std::fmod(sum, 360) : std::nan(""));
  }
  return farthest > nothing ? angle : std::vector<double>();
}

// Boundaries on a motion frame that turns them, one of each frame; and those that turn alone.
std::vector<page::Figure> angle_figures(const Recording& recording, const Case& c) {
  std::vector<plots::Series> series;
  std::set<int> seen;
  for (const Boundary& b : c.model.boundaries) {
    const int frame = b.frame;
    if (frame >= 0 && !seen.insert(frame).second) continue;
    const std::vector<double> angle =
        turned(recording.series("/boundaries/" + b.name + "/orientation"));
    if (!angle.empty()) series.push_back(curve(b.name, recording, angle));
  }
  if (series.empty()) return {};
  return {over_time("angle within one turn", "deg", series, "Boundaries that turn: how far.")};
}

page::Figure passages_over_time(const std::map<std::string, std::vector<double>>& sorted,
                                double end) {
  plots::XyPlot plot;
  plot.x = {"time", "s", false, {}, {}};
  plot.y = {"particles that have passed", "", false, 0.0, {}, true};
  std::string seen;
  for (const auto& [sensor, times] : sorted) {
    plots::Series s;
    s.name = sensor;
    s.style = plots::Style::step;
    s.x = {0};
    s.y = {0};
    for (std::size_t i = 0; i < times.size(); ++i) {
      s.x.push_back(times[i]);
      s.y.push_back(static_cast<double>(i + 1));
    }
    s.x.push_back(end);
    s.y.push_back(s.y.back());
    plot.series.push_back(s);
    seen += fmt::format("{}{}: {} from {} to {} s", seen.empty() ? "" : "; ", sensor, times.size(),
                        page::number_text(times.front()), page::number_text(times.back()));
  }
  return {plots::draw(plot), "How many have passed each sensor.", seen};
}

page::Figure residence_by_batch(const std::string& sensor, const std::vector<double>& passed,
                                const std::vector<double>& came, const std::vector<int>& batch) {
  plots::Series each;
  each.name = "a particle";
  each.style = plots::Style::points;
  std::map<int, std::vector<double>> by_batch;
  for (std::size_t i = 0; i < passed.size(); ++i) {
    if (!std::isfinite(passed[i] - came[i]) || batch[i] < 0) continue;
    each.x.push_back(batch[i]);
    each.y.push_back(passed[i] - came[i]);
    by_batch[batch[i]].push_back(each.y.back());
  }
  plots::Series mean;
  mean.name = "mean of the batch";
  std::string seen;
  for (const auto& [b, times] : by_batch) {
    double sum = 0;
    for (const double t : times) sum += t;
    mean.x.push_back(b);
    mean.y.push_back(sum / static_cast<double>(times.size()));
    seen += fmt::format("{}batch {}: {} s", seen.empty() ? "" : ", ", b,
                        page::number_text(mean.y.back(), 3));
  }
  plots::XyPlot plot;
  plot.x = {"batch", "", false, {}, {}, true};
  plot.y = {"time from insertion to the sensor", "s", false, 0.0, {}};
  plot.series = {each, mean};
  return {plots::draw(plot),
          fmt::format("How long they were inside before \"{}\", by batch.", sensor),
          fmt::format("mean residence time, {}", seen)};
}

}  // namespace

Curve downsampled_curve(const std::vector<double>& x, const std::vector<double>& y,
                        std::size_t most) {
  if (y.size() <= most) return {x, y};
  Curve out;
  const std::size_t stretches = std::max<std::size_t>(most / 3, 1);
  const auto keep = [&](std::size_t i) {
    out.x.push_back(x[i]);
    out.y.push_back(y[i]);
  };
  for (std::size_t s = 0; s < stretches; ++s) {
    const std::size_t first = s * y.size() / stretches, last = (s + 1) * y.size() / stretches;
    std::size_t low = first, high = first;
    for (std::size_t i = first; i < last; ++i) {
      // What is not finite loses every comparison, unless it comes first.
      if (y[i] < y[low] || std::isnan(y[low])) low = i;
      if (y[i] > y[high] || std::isnan(y[high])) high = i;
    }
    keep(first);
    for (const std::size_t i : {std::min(low, high), std::max(low, high)})
      if (i != first && out.x.back() != x[i]) keep(i);
  }
  if (out.x.back() != x.back()) keep(y.size() - 1);
  return out;
}

std::vector<page::Figure> energy_figures(const Recording& recording) {
  std::vector<page::Figure> figures;
  const auto energy = [&](const char* name) {
    return recording.series(fmt::format("/energy/{}", name));
  };
  const auto draw = [&](const std::vector<std::pair<const char*, const char*>>& parts,
                        const std::string& label, const std::string& caption) {
    std::vector<plots::Series> series;
    for (const auto& [name, word] : parts)
      if (largest_magnitude(energy(name)) > 0)
        series.push_back(curve(word, recording, energy(name)));
    if (!series.empty()) figures.push_back(over_time(label, "J", series, caption));
  };
  draw({{"kinetic", "kinetic"}}, "kinetic energy", "Translation and rotation of all particles.");
  draw({{"gravitational", "gravitational"},
        {"dissipated", "dissipated since the start"},
        {"boundary_work", "done by boundaries"}},
       "energy", "Where it goes: heights, contacts, work of moving boundaries.");
  if (recording.contains("/energy/free_bodies_kinetic"))
    draw({{"free_bodies_kinetic", "kinetic"},
          {"free_bodies_gravitational", "gravitational"},
          {"free_bodies_elastic", "springs of joints"},
          {"boundary_contacts_elastic", "elastic where parts touch"},
          {"dissipated_joint_friction", "lost by friction of joints"},
          {"dissipated_joint_damping", "lost by dampers and limits"},
          {"dissipated_boundary_contacts", "lost where parts touch"},
          {"free_bodies_work", "work done on them"}},
         "energy of free bodies",
         "Of the machine's moving parts. Losses and work count from the start. The sum of all less "
         "the work is constant.");
  return figures;
}

std::vector<page::Figure> load_figures(const Recording& recording, const Case& c) {
  constexpr std::size_t kMost = 5;  // curves a plot
  std::vector<plots::Series> all;
  for (const Boundary& b : c.model.boundaries) {
    const std::vector<double> peak =
        recording.series(fmt::format("/boundaries/{}/peak_normal_force", b.name));
    if (largest_magnitude(peak) > 0) all.push_back(curve(b.name, recording, peak));
  }
  std::ranges::stable_sort(all, [](const plots::Series& a, const plots::Series& b) {
    return largest_magnitude(a.y) > largest_magnitude(b.y);
  });
  std::vector<page::Figure> figures;
  for (std::size_t i = 0; i < all.size(); i += kMost) {
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(i);
    const auto last = all.begin() + static_cast<std::ptrdiff_t>(std::min(i + kMost, all.size()));
    figures.push_back(over_time("largest contact force", "N", {first, last},
                                i == 0 ? "Largest single contact within each frame."
                                       : "The same of boundaries that bear less."));
  }
  return figures;
}

std::vector<page::Figure> sample_figures(const Recording& recording, const Case& c) {
  std::vector<page::Figure> figures;
  if (c.samples.interval == 0) return figures;
  const std::vector<double> times = recording.values("/samples/time");
  const auto add = [&](const std::string& what, const std::string& unit, const std::string& name,
                       const std::vector<double>& values, const std::string& caption) {
    if (largest_magnitude(values) > 0)
      figures.push_back(over_time(what, unit, {curve(name, times, values)}, caption));
  };
  const auto add_force = [&](const std::string& group, const std::string& name) {
    add("force of contacts", "N", name,
        row_lengths(recording.values("/samples/" + group + "/force")),
        fmt::format("{}: mean over each sample.", name));
  };
  for (const int b : c.samples.boundaries) {
    const std::string& name = c.model.boundaries[static_cast<std::size_t>(b)].name;
    add_force("boundaries/" + name, name);
  }
  for (const int f : c.samples.frames) {
    const MotionFrame& frame = c.model.frames[static_cast<std::size_t>(f)];
    const std::string group = "motion_frames/" + frame.name;
    add_force(group, frame.name);
    if (!frame.free || frame.free->joints.empty()) continue;
    const std::size_t width = frame.free->joints.size();
    const std::vector<double> rates = recording.values("/samples/" + group + "/rate");
    for (std::size_t k = 0; k < width; ++k) {
      const bool turns = frame.free->joints[k].kind == Joint::Kind::rotation;
      const std::string which = width > 1 ? fmt::format(", axis {}", k + 1) : "";
      add("acceleration", turns ? "rad/s^2" : "m/s^2", frame.name,
          rates_of_change(times, row_column(rates, width, k)),
          fmt::format("{}{}: mean over each sample, not filtered.", frame.name, which));
    }
  }
  return figures;
}

std::vector<page::Figure> motion_figures(const Recording& recording, const Case& c) {
  std::vector<page::Figure> figures = angle_figures(recording, c);
  for (const MotionFrame& frame : c.model.frames) {
    const std::string group = "/motion_frames/" + frame.name;
    if (frame.free && recording.contains(group + "/coordinate")) {
      const std::size_t width = frame.free->joints.size();
      const std::vector<double> coordinates = recording.series(group + "/coordinate");
      const std::vector<double> motors = recording.series(group + "/motor_load");
      for (std::size_t k = 0; k < width; ++k) {
        const bool turns = frame.free->joints[k].kind == Joint::Kind::rotation;
        const std::string which = width > 1 ? fmt::format(", axis {}", k + 1) : "";
        std::vector<double> displacements = row_column(coordinates, width, k);
        for (double& w : displacements) w *= turns ? kRadToDeg : 1e3;
        if (largest_magnitude(displacements) > 0)
          figures.push_back(over_time(turns ? "angle" : "displacement", turns ? "deg" : "mm",
                                      {curve(frame.name, recording, displacements)},
                                      fmt::format("{}{}: where it is.", frame.name, which)));
        const std::vector<double> drive = row_column(motors, width, k);
        if (largest_magnitude(drive) > 0)
          figures.push_back(over_time(
              turns ? "drive torque" : "drive force", turns ? "N m" : "N",
              {curve(frame.name, recording, drive)},
              fmt::format("{}{}: what drives it, mean of each frame.", frame.name, which)));
      }
    }
    const std::vector<double> torque = row_lengths(recording.series(group + "/torque"));
    if (largest_magnitude(torque) > 0)
      figures.push_back(over_time("torque by contacts", "N m",
                                  {curve(frame.name, recording, torque)},
                                  fmt::format("{}: by contacts, about its origin.", frame.name)));
  }
  return figures;
}

std::vector<page::Figure> passage_figures(const Recording& recording, const Case& c) {
  std::vector<page::Figure> figures;
  std::map<std::string, std::vector<double>> sorted;
  for (const Sensor& sensor : c.sensors) {
    std::vector<double> times = recording.sensor_time(sensor.name);
    std::erase_if(times, [](double t) { return !std::isfinite(t); });
    std::ranges::sort(times);
    if (!times.empty()) sorted[sensor.name] = times;
  }
  const std::vector<double> frames = recording.frame_times();
  if (sorted.empty() || frames.empty()) return figures;
  figures.push_back(passages_over_time(sorted, frames.back()));
  const std::vector<int> batch = recording.batch();
  const bool batches = !batch.empty() && *std::ranges::max_element(batch) > 0;
  for (const auto& [sensor, times] : sorted)
    if (batches && times.size() > 4)
      figures.push_back(residence_by_batch(sensor, recording.sensor_time(sensor),
                                           recording.insert_time(), batch));
  return figures;
}

std::vector<page::Figure> measured_curve_figures(const std::vector<Response>& responses,
                                                 const Case& c) {
  std::vector<page::Figure> figures;
  for (const Measure& m : c.measures) {
    if (m.kind != Measure::Kind::curve) continue;
    const auto response = [&](const char* suffix) {
      const auto found = std::ranges::find(responses, m.prefix() + suffix, &Response::name);
      return found == responses.end() ? Response{} : *found;
    };
    Response x = response("curve_x");
    const Response y = response("curve_y");
    if (y.value.empty() || x.value.size() != y.value.size()) continue;
    if (x.unit == "rad") {
      x.unit = "deg";
      for (double& v : x.value) v *= kRadToDeg;
    }
    plots::XyPlot plot;
    plot.x = {quantity_words(m.x, x.unit), unit_text(x.unit), false, {}, {}};
    plot.y = {quantity_words(m.y, y.unit), unit_text(y.unit), false, {}, {}};
    plots::Series series;
    series.x = x.value;
    series.y = y.value;
    if (m.x_period > 0) {
      series.low = response("curve_y_min").value;
      series.high = response("curve_y_max").value;
    }
    plot.series = {series};
    figures.push_back(
        {plots::draw(plot),
         fmt::format("{}: {}.", page::words(m.name),
                     m.x_period > 0
                         ? "mean over all passes, and from the least to the largest value"
                         : "as measured"),
         fmt::format("{} against {}: at most {} {}", plot.y.label, plot.x.label,
                     page::number_text(largest_magnitude(y.value), 3), unit_text(y.unit))});
  }
  return figures;
}

}  // namespace firn
