// Rows of intervals over one axis.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "experiments/system/text_encoding.h"
#include "reports/plots/axes.h"
#include "reports/plots/plot_svg.h"
#include "reports/plots/plot_text.h"
#include "reports/plots/plots.h"

namespace firn::plots {
namespace {

// What is drawn, by interval of a row. A row is its name, in one or two lines of text, and its
// intervals below it; y is in lines, from 0 downwards.
struct IntervalRows {
  std::vector<std::vector<std::array<double, 4>>> data;  // middle y low high
  std::string labels;
  double bottom = 0;
};

IntervalRows arrange_rows(const IntervalPlot& plot, Extent& extent) {
  constexpr double kFirstLine = 0.55, kLine = 0.95, kToIntervals = 0.85, kBetweenRows = 0.9;
  const auto width = static_cast<std::size_t>(static_cast<double>(plot.width) / kCharacterWidth);
  IntervalRows rows;
  rows.data.resize(plot.names.size());
  for (const IntervalRow& row : plot.rows) {
    require_consistent(row.intervals.size() == plot.names.size(), "a row of intervals lacks some");
    double text = rows.bottom - kFirstLine;
    for (const std::string& line : wrap_text(row.label, width, 2)) {
      rows.labels += fmt::format("set label {} at graph 0.01, first {} left textcolor rgb {}\n",
                                 encode::gnuplot(line), text, color::text);
      text -= kLine;
    }
    const double first = text + kLine - kToIntervals;
    double y = first;
    for (std::size_t k = 0; k < plot.names.size(); ++k) {
      const auto& interval = row.intervals[k];
      if (!interval || !shown(plot.x, interval->low) || !shown(plot.x, interval->high)) continue;
      rows.data[k].push_back({interval->middle.value_or(std::numeric_limits<double>::quiet_NaN()),
                              y, interval->low, interval->high});
      extent.see({interval->low, interval->high});
      y -= 1;
    }
    rows.bottom = std::min(y + 1, first) - kBetweenRows;
  }
  return rows;
}

}  // namespace

std::string draw(const IntervalPlot& plot) {
  Extent extent(plot.x);
  for (const Rule& r : plot.vertical) extent.see(r.at);
  const IntervalRows rows = arrange_rows(plot, extent);
  // Texts along the lines would lie over the names of rows: they are in the legend.
  std::vector<std::string> names;
  for (const std::string& name : plot.names)
    if (!name.empty()) names.push_back(legend_name(name));
  std::vector<Rule> lines = plot.vertical;
  std::vector<std::string> commands;
  for (Rule& r : lines) {
    if (r.text.empty()) continue;
    names.push_back(legend_name(r.text));
    commands.push_back(fmt::format("keyentry with lines lc rgb {} lw 1 dt 3 title {}", color::muted,
                                   encode::gnuplot(names.back())));
    r.text.clear();
  }
  const Legend legend = legend_of(names);
  Drawing drawing(plot.width, 95 + 20 * legend.rows + static_cast<int>(-22 * rows.bottom));
  const bool any = std::ranges::any_of(rows.data, [](const auto& one) { return !one.empty(); });
  if (!any) return drawing.empty_plot(axis_title(plot.x), "");
  for (std::size_t k = plot.names.size(); k-- > 0;) {
    if (rows.data[k].empty()) continue;
    const int series = static_cast<int>(k);
    const std::string file = drawing.data(fmt::format("intervals{}", k), rows.data[k]);
    std::vector<std::string> own = {
        fmt::format("{} using ($3):2:($4-$3):(0) with vectors heads size screen 0.008,90 lc rgb {} "
                    "lw 2.4 dt {} notitle",
                    file, series_color(series), dash(series)),
        fmt::format("{} using 1:2 with points lc rgb {} pt {} ps 0.95 notitle", file,
                    series_color(series), marker(series))};
    if (!plot.names[k].empty())
      own.push_back(
          fmt::format("keyentry with linespoints lc rgb {} lw 2.4 dt {} pt {} ps 0.95 title {}",
                      series_color(series), dash(series), marker(series),
                      encode::gnuplot(legend_name(plot.names[k]))));
    commands.insert(commands.begin(), own.begin(), own.end());
  }
  return drawing.svg(
      legend.script() + extent.script('x') + rules_script(lines, extent, {}, extent) + rows.labels +
      fmt::format("unset ytics\nset border 1\nset lmargin 2\nset yrange [{}:0]\nplot {}\n",
                  rows.bottom + 0.3, fmt::join(commands, ", ")));
}

}  // namespace firn::plots
