// Lines and points over two axes: curves, shares and counts of samples.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "experiments/system/text_encoding.h"
#include "reports/plots/axes.h"
#include "reports/plots/plot_svg.h"
#include "reports/plots/plot_text.h"
#include "reports/plots/plots.h"
#include "reports/plots/series.h"

namespace firn::plots {
namespace {

constexpr std::size_t kMostPoints = 1200;  // of a line; more cannot be seen

// Of every stretch of a long line its lowest and highest point, in order, and nothing else.
Series downsampled(const Series& s) {
  if (s.x.size() <= kMostPoints || !s.low.empty() || !s.wide_low.empty() || !s.y_error.empty() ||
      !s.x_error.empty() || s.style == Style::points)
    return s;
  Series result{s.name, {}, {}, s.style};
  const std::size_t stretches = kMostPoints / 2;
  for (std::size_t k = 0; k < stretches; ++k) {
    const std::size_t first = k * s.x.size() / stretches, end = (k + 1) * s.x.size() / stretches;
    std::size_t low = first, high = first;
    for (std::size_t i = first; i < end; ++i) {
      if (!(s.y[i] >= s.y[low])) low = i;  // a gap counts, so that it stays one
      if (s.y[i] > s.y[high]) high = i;
    }
    for (const std::size_t i : {std::min(low, high), std::max(low, high)}) {
      result.x.push_back(s.x[i]);
      result.y.push_back(s.y[i]);
    }
  }
  return result;
}

std::string with(const Series& s, int k) {
  const std::string line = fmt::format("lc rgb {} lw 1.8 dt {}", series_color(k), dash(k));
  const std::string point =
      fmt::format("lc rgb {} pt {} ps 0.75 lw 1.4", series_color(k), marker(k));
  switch (s.style) {
    case Style::line:
      return "using 1:2 with lines " + line;
    case Style::step:
      return "using 1:2 with steps " + line;
    case Style::joined:
      return fmt::format("using 1:2 with linespoints {} pt {} ps 0.75", line, marker(k));
    case Style::points:
      return "using 1:2 with points " + point;
  }
  return "";
}

// The plot commands of one series: its bands below, its error bars, itself.
void add_series(std::vector<std::string>& commands, const std::string& file, const Series& s,
                int k) {
  const auto add_band = [&](const char* columns, double opacity) {
    commands.push_back(fmt::format(
        "{} using {} with filledcurves fillstyle transparent solid {} noborder lc rgb {} notitle",
        file, columns, opacity, series_color(k)));
  };
  if (!s.wide_low.empty()) add_band("1:7:8", 0.16);
  if (!s.low.empty()) add_band("1:5:6", 0.22);
  const std::string bar = fmt::format("lc rgb {} lw 1.4 dt 1 pt -1 notitle", series_color(k));
  if (!s.y_error.empty())
    commands.push_back(fmt::format("{} using 1:2:4 with yerrorbars {}", file, bar));
  if (!s.x_error.empty())
    commands.push_back(fmt::format("{} using 1:2:3 with xerrorbars {}", file, bar));
  commands.push_back(
      fmt::format("{} {} {}", file, with(s, k),
                  s.name.empty() ? "notitle" : "title " + encode::gnuplot(legend_name(s.name))));
}

void see_series(const Series& s, Extent& x, Extent& y) {
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    const double dx = i < s.x_error.size() && std::isfinite(s.x_error[i]) ? s.x_error[i] : 0;
    const double dy = i < s.y_error.size() && std::isfinite(s.y_error[i]) ? s.y_error[i] : 0;
    x.see({s.x[i], s.x[i] - dx, s.x[i] + dx});
    y.see({s.y[i], s.y[i] - dy, s.y[i] + dy, value_at(s.low, i), value_at(s.high, i),
           value_at(s.wide_low, i), value_at(s.wide_high, i)});
  }
}

// Equal bins, on a log axis in the logarithm.
struct Bins {
  const Axis& axis;
  double low, high;
  int count;

  double scale(double v) const { return axis.log ? std::log(v) : v; }
  double edge(int i) const {
    const double v = scale(low) + (scale(high) - scale(low)) * i / count;
    return axis.log ? std::exp(v) : v;
  }
  std::vector<double> counts(const std::vector<double>& values) const {
    std::vector<double> result(static_cast<std::size_t>(count), 0);
    for (const double v : values) {
      if (!shown(axis, v)) continue;
      const double share = (scale(v) - scale(low)) / (scale(high) - scale(low));
      ++result[static_cast<std::size_t>(std::clamp(static_cast<int>(share * count), 0, count - 1))];
    }
    return result;
  }
  std::vector<std::array<double, 2>> outline(const std::vector<double>& counts) const {
    std::vector<std::array<double, 2>> corners = {{edge(0), 0}};
    for (int i = 0; i < count; ++i)
      for (const int side : {i, i + 1})
        corners.push_back({edge(side), counts[static_cast<std::size_t>(i)]});
    corners.push_back({edge(count), 0});
    return corners;
  }
};

// None where no value is shown.
std::optional<Bins> bins_of(const HistogramPlot& plot) {
  double low = std::numeric_limits<double>::quiet_NaN(), high = low;
  std::size_t most = 0;
  for (const Samples& samples : plot.samples) {
    most = std::max(most, samples.values.size());
    for (const double v : samples.values)
      if (shown(plot.x, v)) low = std::fmin(low, v), high = std::fmax(high, v);
  }
  if (std::isnan(low)) return std::nullopt;
  if (low == high) low -= 0.5, high += 0.5;
  const int usual =
      std::max(5, static_cast<int>(std::lround(std::sqrt(static_cast<double>(most)))));
  return Bins{plot.x, low, high, plot.bins > 0 ? plot.bins : usual};
}

}  // namespace

std::string draw(const XyPlot& plot) {
  const Legend legend = legend_of_series(plot.series);
  Drawing drawing(plot.width, plot.height + legend.further_rows_height());
  std::vector<std::string> commands;
  bool any = false;
  Extent x(plot.x), y(plot.y);
  for (std::size_t k = 0; k < plot.series.size(); ++k) {
    require_fitting_lists(plot.series[k]);
    see_series(plot.series[k], x, y);
    const Series s = downsampled(plot.series[k]);
    const std::string file =
        write_series(drawing, fmt::format("series{}", k), s, plot.x, plot.y, any);
    add_series(commands, file, s, static_cast<int>(k));
  }
  if (!any) return drawing.empty_plot(axis_title(plot.x), axis_title(plot.y));
  for (const Rule& r : plot.vertical) x.see(r.at);
  for (const Rule& r : plot.horizontal) y.see(r.at);
  return drawing.svg(legend.script() + x.script('x') + y.script('y') +
                     rules_script(plot.vertical, x, plot.horizontal, y) +
                     fmt::format("plot {}\n", fmt::join(commands, ", ")));
}

std::string draw(const CdfPlot& plot) {
  XyPlot xy{plot.x, {plot.y_label, "", false, 0, 1.02}, {}, plot.vertical};
  for (const Samples& samples : plot.samples) {
    std::vector<double> sorted;
    std::ranges::copy_if(samples.values, std::back_inserter(sorted),
                         [&](double v) { return shown(plot.x, v); });
    std::ranges::sort(sorted);
    Series s{fmt::format("{} ({})", samples.name, sorted.size()), {}, {}, Style::line};
    for (std::size_t i = 0; i < sorted.size(); ++i)  // the corners of the steps
      for (const std::size_t below : {i, i + 1}) {
        s.x.push_back(sorted[i]);
        s.y.push_back(static_cast<double>(below) / static_cast<double>(sorted.size()));
      }
    xy.series.push_back(std::move(s));
  }
  for (const Band& band : plot.bands) {
    Series s{band.name, band.x, {}, Style::line, {}, {}, band.low, band.high};
    for (std::size_t i = 0; i < band.x.size(); ++i) s.y.push_back((band.low[i] + band.high[i]) / 2);
    xy.series.push_back(std::move(s));
  }
  return draw(xy);
}

std::string draw(const HistogramPlot& plot) {
  std::vector<std::string> names, commands;
  for (const Samples& samples : plot.samples)
    names.push_back(fmt::format("{} ({})", shorten_text(samples.name, 24), samples.values.size()));
  const Legend legend = legend_of(names);
  Drawing drawing(520, 320 + legend.further_rows_height());
  const std::optional<Bins> bins = bins_of(plot);
  if (!bins) return drawing.empty_plot(axis_title(plot.x), plot.y_label);
  Extent x(plot.x), y({plot.y_label, "", false, 0, {}, true});
  x.see({bins->low, bins->high});
  for (std::size_t k = 0; k < plot.samples.size(); ++k) {
    const std::vector<double> counts = bins->counts(plot.samples[k].values);
    y.see(counts);
    const std::string file = drawing.data(fmt::format("bins{}", k), bins->outline(counts));
    const int series = static_cast<int>(k);
    commands.push_back(
        fmt::format("{} using 1:2 with filledcurves y1=0 fillstyle transparent solid 0.22 noborder "
                    "lc rgb {} notitle",
                    file, series_color(series)));
    commands.push_back(fmt::format("{} using 1:2 with lines lc rgb {} lw 1.8 dt {} title {}", file,
                                   series_color(series), dash(series), encode::gnuplot(names[k])));
  }
  for (const Rule& r : plot.vertical) x.see(r.at);
  return drawing.svg(legend.script() + x.script('x') + y.script('y') +
                     rules_script(plot.vertical, x, {}, y) +
                     fmt::format("plot {}\n", fmt::join(commands, ", ")));
}

}  // namespace firn::plots
