// Values on a grid.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "experiments/system/text_encoding.h"
#include "reports/plots/axes.h"
#include "reports/plots/plot_svg.h"
#include "reports/plots/plots.h"
#include "reports/plots/series.h"

namespace firn::plots {
namespace {

using GridCell = std::array<double, 5>;  // x from, x to, y from, y to, z

// Half a step around each value, on a log axis of its logarithm.
std::vector<double> cell_edges(const std::vector<double>& values, bool log) {
  const auto to = [&](double v) { return log ? std::log(v) : v; };
  const double step =
      (to(values.back()) - to(values.front())) / static_cast<double>(values.size() - 1);
  std::vector<double> result;
  for (std::size_t i = 0; i <= values.size(); ++i) {
    const double v = to(values.front()) + step * (static_cast<double>(i) - 0.5);
    result.push_back(log ? std::exp(v) : v);
  }
  return result;
}

// Light in dark: seen on every color of the map.
void add_marks(std::vector<std::string>& commands, const std::string& file, const Series& marks,
               int k) {
  const bool line = marks.style == Style::line || marks.style == Style::step;
  const std::array<const char*, 2> colors = {"'#000000'", "'#ffffff'"};
  for (std::size_t pass = 0; pass < 2; ++pass) {
    const std::string title = pass == 1 && !marks.name.empty()
                                  ? "title " + encode::gnuplot(legend_name(marks.name))
                                  : "notitle";
    commands.push_back(line ? fmt::format("{} using 1:2 with lines lc rgb {} lw {} dt {} {}", file,
                                          colors[pass], pass ? 1.6 : 4, pass ? dash(k) : "1", title)
                            : fmt::format("{} using 1:2 with points lc rgb {} pt {} ps {} {}", file,
                                          colors[pass], marker(k), pass ? 0.6 : 0.95, title));
  }
}

// Title, range and ticks of the color scale.
std::string scale_script(const Axis& z, const std::vector<GridCell>& cells) {
  constexpr std::size_t kTitle = 34;  // characters
  constexpr double kLength = 280;     // nominal pixels
  const auto [least, most] =
      std::ranges::minmax_element(cells, {}, [](const auto& c) { return c[4]; });
  Axis ends = z;
  if (z.log) {
    ends.low = z.low.value_or((*least)[4]);
    ends.high = z.high.value_or((*most)[4]);
  }
  std::string script =
      fmt::format("unset rmargin\nset cblabel {} textcolor rgb {}\nset cbrange {}\n",
                  title_lines(z, kTitle), color::text, range_script(ends));
  if (!z.log) return script;
  script += "set logscale cb\n";
  if (shown(z, *ends.low) && shown(z, *ends.high) && *ends.low < *ends.high)
    script += fmt::format("set cbtics ({})\n", log_tick_list(*ends.low, *ends.high, kLength, true));
  return script;
}

}  // namespace

std::string draw(const HeatMap& map) {
  require_consistent(map.z_values.size() == map.x_values.size() * map.y_values.size(),
                     "the map is not x by y");
  require_consistent(map.x_values.size() > 1 && map.y_values.size() > 1,
                     "a map needs two values each way");
  Drawing drawing(520, 400);
  // Cells as boxes: right on a log axis, too.
  const std::vector<double> x = cell_edges(map.x_values, map.x.log),
                            y = cell_edges(map.y_values, map.y.log);
  std::vector<GridCell> cells;
  for (std::size_t j = 0; j + 1 < y.size(); ++j)
    for (std::size_t i = 0; i + 1 < x.size(); ++i) {
      const double z = map.z_values[j * map.x_values.size() + i];
      if (shown(map.z, z)) cells.push_back({x[i], x[i + 1], y[j], y[j + 1], z});
    }
  if (cells.empty()) return drawing.empty_plot(axis_title(map.x), axis_title(map.y));
  const std::string file = drawing.data("cells", cells);
  std::vector<std::string> commands = {
      fmt::format("{} using (($1+$2)/2):(($3+$4)/2):1:2:3:4:5 with boxxyerror fillstyle solid 1 "
                  "noborder lc palette notitle",
                  file)};
  for (std::size_t k = 0; k < map.marks.size(); ++k) {
    require_fitting_lists(map.marks[k]);
    bool any = false;
    const std::string marks =
        write_series(drawing, fmt::format("marks{}", k), map.marks[k], map.x, map.y, any);
    if (any) add_marks(commands, marks, map.marks[k], static_cast<int>(k));
  }
  Axis right = map.x, up = map.y;
  right.low = x.front(), right.high = x.back(), up.low = y.front(), up.high = y.back();
  return drawing.svg(axis_script('x', right) + axis_script('y', up) + scale_script(map.z, cells) +
                     palette_script() +
                     fmt::format("unset grid\nplot {}\n", fmt::join(commands, ", ")));
}

}  // namespace firn::plots
