// Bars by category.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "experiments/system/text_encoding.h"
#include "reports/plots/axes.h"
#include "reports/plots/plot_svg.h"
#include "reports/plots/plot_text.h"
#include "reports/plots/plots.h"

namespace firn::plots {
namespace {

// Names of categories below the axis: side by side in one or two lines; where there is no room,
// slanted, or upright, of very many only some.
struct CategoryLabels {
  std::string script;
  int height = 0;  // pixels beyond those of one line
};

// Whether all of them stand in two lines of so many characters, without a word that is broken.
bool fit_side_by_side(const std::vector<std::string>& names, std::size_t width) {
  return std::ranges::all_of(names, [&](const std::string& name) {
    for (std::size_t at = 0; at <= name.size();) {
      const std::size_t end = std::min(name.find(' ', at), name.size());
      if (text_length(name.substr(at, end - at)) > width) return false;
      at = end + 1;
    }
    const std::vector<std::string> lines = wrap_text(name, width, 2);
    return std::ranges::none_of(
        lines, [](const std::string& line) { return line.find("…") != std::string::npos; });
  });
}

CategoryLabels side_by_side(const std::vector<std::string>& names, std::size_t width) {
  std::vector<std::string> tics;
  std::size_t lines = 1;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::vector<std::string> text = wrap_text(names[i], width, 2);
    lines = std::max(lines, text.size());
    tics.push_back(fmt::format("{} {}", gnuplot_tic_lines(text), i));
  }
  // gnuplot leaves less than a line between names of two lines and the title.
  constexpr double kTitleGap = 10;  // pixels
  const bool several = lines > 1;
  return {
      fmt::format("set xtics ({}) scale 0\n{}", fmt::join(tics, ", "),
                  several ? "set xlabel offset 0,-0.4\n" : ""),
      static_cast<int>(kLineHeight * static_cast<double>(lines - 1) + (several ? kTitleGap : 0))};
}

// `axis`: its length, pixels.
CategoryLabels turned_labels(const std::vector<std::string>& names, double axis, int canvas) {
  constexpr std::size_t kMost = 18;  // characters
  constexpr double kSlanted = 31;    // pixels a category from which slanted lines do not touch
  constexpr double kCosine = 0.82, kSine = 0.57;  // of the slant
  const auto count = static_cast<double>(names.size());
  const double each = axis / count;
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::ceil(kLineHeight / each)));
  std::vector<std::string> tics;
  double longest = 0, beyond = 0;  // pixels; right of the axis, which is shorter by that much
  for (std::size_t i = 0; i < names.size(); i += stride) {
    const std::string text = shorten_text(names[i], kMost);
    const double length = kCharacterWidth * static_cast<double>(text_length(text));
    const double share = (count - 0.5 - static_cast<double>(i)) / count;  // of the axis, to the end
    longest = std::max(longest, length);
    beyond = std::max(beyond, (kCosine * length - share * axis) / (1 - share));
    tics.push_back(fmt::format("{} {}", encode::gnuplot_tic(text), i));
  }
  const std::string list = fmt::format("set xtics ({}) scale 0", fmt::join(tics, ", "));
  if (each < kSlanted) return {list + " rotate by -90 left\n", static_cast<int>(longest)};
  CategoryLabels labels{list + " rotate by -35 left\n", static_cast<int>(kSine * longest)};
  if (beyond > 0)
    labels.script +=
        fmt::format("set rmargin at screen {:.4f}\n", 1 - (beyond + kCharacterWidth) / canvas);
  return labels;
}

CategoryLabels category_labels(const BarPlot& plot) {
  constexpr double kAround = 150;    // pixels of the width that are not the axis
  constexpr std::size_t kLeast = 5;  // characters of a line worth reading
  const std::vector<std::string>& names = plot.categories;
  const double axis = plot.width - kAround;
  const auto width = static_cast<std::size_t>(
      axis / static_cast<double>(std::max<std::size_t>(names.size(), 1)) / kCharacterWidth);
  if (width >= kLeast && fit_side_by_side(names, width)) return side_by_side(names, width);
  return turned_labels(names, axis, plot.width);
}

// One bar: columns of gnuplot's data.
using BarRow = std::array<double, 6>;  // place, value, ends of the error, ends of the interval

// The bars of one series. Errors and intervals begin at the end of the axis, `low`, where they
// reach below it: gnuplot would leave their upper ends out of its range.
std::vector<BarRow> bar_rows(const BarPlot& plot, std::size_t k, double width,
                             std::optional<double> low) {
  const BarSeries& s = plot.series[k];
  require_consistent(s.values.size() == plot.categories.size() &&
                         (s.errors.empty() || s.errors.size() == s.values.size()) &&
                         (s.low.empty() || s.low.size() == s.values.size()) &&
                         s.low.size() == s.high.size(),
                     "a series of bars is not as long as the categories");
  const double middle = (static_cast<double>(plot.series.size()) - 1) / 2;
  const auto end = [&](double value) { return drawn(plot.y, low && value < *low ? *low : value); };
  std::vector<BarRow> rows;
  for (std::size_t i = 0; i < s.values.size(); ++i) {
    const double value = s.values[i], error = value_at(s.errors, i);
    if (!shown(plot.y, value)) continue;
    rows.push_back({static_cast<double>(i) + (static_cast<double>(k) - middle) * width, value,
                    end(value - error), end(value + error), end(value_at(s.low, i)),
                    end(value_at(s.high, i))});
  }
  return rows;
}

void add_bars(std::vector<std::string>& commands, const Drawing& drawing, const BarSeries& s,
              const std::vector<BarRow>& rows, int k, double width) {
  const std::string file = drawing.data(fmt::format("bars{}", k), rows);
  commands.push_back(
      fmt::format("{0} using 1:2:({1}) with boxes lc rgb {3} fillstyle transparent solid {2} "
                  "border lc rgb {3} title {4}",
                  file, 0.92 * width, k % 2 ? "0.12" : "0.75", series_color(k),
                  encode::gnuplot(legend_name(s.name))));
  if (!s.errors.empty())
    commands.push_back(
        fmt::format("{} using 1:3:(0):($4-$3) with vectors nohead lc rgb {} lw 1.6 notitle", file,
                    color::text));
  if (std::ranges::any_of(rows, [](const BarRow& row) { return std::isfinite(row[4] + row[5]); }))
    commands.push_back(fmt::format(
        "{} using 1:5:(0):($6-$5) with vectors heads size screen 0.006,90 lc rgb {} lw 1.6 "
        "notitle",
        file, color::text));
}

// Bars stand on 0, at an end of the axis where no value is on its other side.
Extent bar_extent(const BarPlot& plot) {
  Axis y = plot.y;
  bool below = false, above = false;
  for (const BarSeries& s : plot.series)
    for (const double v : s.values) {
      below = below || v < 0;
      above = above || v > 0;
    }
  if (!y.low && !y.log && !below) y.low = 0;
  if (!y.high && !y.log && below && !above) y.high = 0;
  Extent extent(y);
  for (const BarSeries& s : plot.series) {
    extent.see(s.values);
    extent.see(s.low);
    extent.see(s.high);
  }
  return extent;
}

}  // namespace

std::string draw(const BarPlot& plot) {
  const CategoryLabels labels = category_labels(plot);
  const Legend legend = legend_of_series(plot.series);
  Drawing drawing(plot.width, plot.height + labels.height + legend.further_rows_height());
  const double width = 0.78 / static_cast<double>(std::max<std::size_t>(plot.series.size(), 1));
  const Extent y = bar_extent(plot);
  std::vector<std::string> commands;
  for (std::size_t k = 0; k < plot.series.size(); ++k) {
    const std::vector<BarRow> rows = bar_rows(plot, k, width, y.axis().low);
    if (!rows.empty())
      add_bars(commands, drawing, plot.series[k], rows, static_cast<int>(k), width);
  }
  if (commands.empty()) return drawing.empty_plot(plot.x_label, axis_title(plot.y));
  const Axis x = {plot.x_label, "", false, -0.6, static_cast<double>(plot.categories.size()) - 0.4};
  return drawing.svg(legend.script() + axis_script('x', x) + y.script('y') + labels.script +
                     fmt::format("plot {}\n", fmt::join(commands, ", ")));
}

}  // namespace firn::plots
