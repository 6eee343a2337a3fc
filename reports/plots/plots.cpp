#include "reports/plots/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "experiments/system/text_encoding.h"
#include "experiments/text/number_text.h"
#include "firn/math.h"
#include "reports/plots/plot_svg.h"

namespace firn::plots {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMostPoints = 1200;  // of a line; more cannot be seen

std::string axis_title(const Axis& axis) { return axis_label(axis.label, axis.unit); }

bool shown(const Axis& axis, double value) {
  // Beyond these the arithmetic of gnuplot overflows.
  constexpr double kLargest = 1e100, kSmallestOfLog = 1e-100;
  return std::abs(value) <= kLargest && (!axis.log || value >= kSmallestOfLog);
}

std::string range(const Axis& axis) {
  const bool empty = axis.low && axis.high && !(*axis.low < *axis.high);
  const auto end = [&](const std::optional<double>& v) {
    return v && shown(axis, *v) && !empty ? fmt::format("{:.17g}", *v) : std::string("*");
  };
  return fmt::format("[{}:{}]", end(axis.low), end(axis.high));
}

std::string tick_text(double value) {
  const double power = std::floor(std::log10(value) + 1e-9);
  if (std::abs(power) < 5) return number_text(value);
  const std::string exponent = std::to_string(static_cast<int>(power));
  static constexpr std::array<const char*, 10> kDigits = {"⁰", "¹", "²", "³", "⁴",
                                                          "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string raised;
  for (const char c : exponent)
    raised += c == '-' ? "⁻" : kDigits[static_cast<std::size_t>(c - '0')];
  const std::string factor = number_text(value / std::pow(10, power));
  return (factor == "1" ? "" : factor + "·") + "10" + raised;
}

// gnuplot's ticks of an axis: a label (none for a minor one) and a place each.
struct Ticks {
  std::vector<std::string> items;
  void add(double at, bool labeled) {
    items.push_back(labeled ? fmt::format("{} {:.17g}", encode::gnuplot_tic(tick_text(at)), at)
                            : fmt::format("'' {:.17g} 1", at));
  }
};

// 1, 2 or 5 times a power of ten that divides a span into so many steps at most.
double even_step(double span, double most) {
  const double rough = span / most, power = std::pow(10, std::floor(std::log10(rough)));
  const double factor = rough / power;
  return power * (factor <= 1 ? 1 : factor <= 2 ? 2 : factor <= 5 ? 5 : 10);
}

// Of a log axis from low to high.
Ticks log_ticks(double low, double high) {
  const double decades = std::log10(high / low);
  const int first = static_cast<int>(std::floor(std::log10(low) + 1e-9)),
            last = static_cast<int>(std::ceil(std::log10(high) - 1e-9));
  const int stride = std::max(1, static_cast<int>(std::ceil(decades / 8)));  // decades a label
  const auto inside = [&](double v) { return v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9); };
  const auto labeled = [&](int exponent, int factor) {
    if (decades > 3) return factor == 1 && (exponent - first) % stride == 0;
    if (decades > 1.2) return factor == 1 || factor == 2 || factor == 5;
    return factor <= 6 || factor == 8;
  };
  Ticks ticks;
  std::size_t labels = 0;
  for (int exponent = first; exponent <= last; ++exponent)
    for (int factor = 1; factor <= 9; ++factor) {
      const double at = std::stod(fmt::format("{}e{}", factor, exponent));
      if (!inside(at) || (stride > 1 && factor > 1)) continue;
      labels += labeled(exponent, factor) ? 1 : 0;
      ticks.add(at, labeled(exponent, factor));
    }
  if (labels > 2) return ticks;
  // Less than a factor of three: evenly spaced ones.
  const double step = even_step(high - low, 5);
  Ticks even;
  for (double k = std::ceil(low / step); k * step <= high * (1 + 1e-9) && even.items.size() < 20;
       ++k)
    even.add(k * step, true);
  return even;
}

std::string axis_script(char name, const Axis& axis) {
  std::string script = fmt::format("set {}label {}\nset {}range {}\n", name,
                                   encode::gnuplot(axis_title(axis)), name, range(axis));
  const bool known = axis.low && axis.high && shown(axis, *axis.low) && shown(axis, *axis.high) &&
                     *axis.low < *axis.high;
  if (axis.log) script += fmt::format("set logscale {}\n", name);
  if (axis.log && known)
    script += fmt::format("set {}tics ({})\n", name,
                          fmt::join(log_ticks(*axis.low, *axis.high).items, ", "));
  if (axis.whole && known && *axis.high - *axis.low < 12)
    script += fmt::format("set {}tics 1\n", name);
  return script;
}

// The axis with its ends where it needs them: on a log axis, and for counts, a little beyond the
// data. `values` may hold what is not shown.
class Extent {
 public:
  explicit Extent(const Axis& axis) : axis_(axis) {}
  void see(const std::vector<double>& values) {
    for (const double v : values) see(v);
  }
  void see(double v) {
    if (!shown(axis_, v)) return;
    low_ = std::fmin(low_, v), high_ = std::fmax(high_, v);
  }
  Axis axis() const {
    Axis result = axis_;
    if ((!axis_.log && !axis_.whole) || std::isnan(low_)) return result;
    const double low = axis_.low && shown(axis_, *axis_.low) ? *axis_.low : low_,
                 high = axis_.high && shown(axis_, *axis_.high) ? *axis_.high : high_;
    if (axis_.log) {
      const double margin = high > low ? std::pow(high / low, 0.05) : 1.5;
      result.low = axis_.low ? low : low / margin;
      result.high = axis_.high ? high : high * margin;
    } else if (high_ - low_ < 12) {
      result.low = axis_.low ? low : low - 0.5;
      result.high = axis_.high ? high : high + 0.5;
    }
    return result;
  }

  // At most seven labels on an x axis, so that they do not touch.
  std::string script(char name) const {
    const Axis ends = axis();
    std::string text = axis_script(name, ends);
    const double span = ends.high.value_or(high_) - ends.low.value_or(low_);
    if (name == 'x' && !ends.log && !ends.whole && shown(ends, span) && span > 0)
      text += fmt::format("set xtics {:.17g}\n", even_step(span, 6));
    return text;
  }

 private:
  Axis axis_;
  double low_ = kNone, high_ = kNone;
};

// Rows of the legend above a plot of these series: short names stand side by side.
template <class Named>
int key_rows(const std::vector<Named>& series) {
  constexpr std::size_t kShort = 16;
  int named = 0;
  std::size_t longest = 0;
  for (const Named& s : series) {
    named += s.name.empty() ? 0 : 1;
    longest = std::max(longest, s.name.size());
  }
  return longest > kShort ? named : (named + 1) / 2;
}

std::string rules_script(const std::vector<Rule>& vertical, const std::vector<Rule>& horizontal) {
  std::string script;
  for (const Rule& r : vertical) {
    if (!shown({}, r.at)) continue;
    script += fmt::format(
        "set arrow from first {0:.17g}, graph 0 to first {0:.17g}, graph 1 nohead lw 1 dt 3 lc rgb "
        "{1} back\nset label {2} at first {0:.17g}, graph 0.97 right rotate by 90 offset -0.7,0 "
        "textcolor rgb {1} font ',11'\n",
        r.at, color::muted, encode::gnuplot(r.text));
  }
  for (const Rule& r : horizontal) {
    if (!shown({}, r.at)) continue;
    script += fmt::format(
        "set arrow from graph 0, first {0:.17g} to graph 1, first {0:.17g} nohead lw 1 dt 3 lc rgb "
        "{1} back\nset label {2} at graph 0.99, first {0:.17g} right offset 0,0.5 textcolor rgb "
        "{1} "
        "font ',11'\n",
        r.at, color::muted, encode::gnuplot(r.text));
  }
  return script;
}

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

double at(const std::vector<double>& values, std::size_t i) {
  return i < values.size() ? values[i] : kNone;
}

// As gnuplot can draw it: its axes end in an error where all values are next to the least number.
double drawn(const Axis& axis, double v) {
  constexpr double kNothing = 1e-200;
  if (!shown(axis, v)) return kNone;
  return std::abs(v) < kNothing ? (axis.log ? kNone : 0) : v;
}

// Columns: x y x_error y_error low high wide_low wide_high.
std::string write_series(const Drawing& drawing, const std::string& name, const Series& s,
                         const Axis& x, const Axis& y, bool& any) {
  std::vector<std::array<double, 8>> rows;
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    const bool there = shown(x, s.x[i]) && shown(y, s.y[i]);
    any = any || there;
    rows.push_back({drawn(x, s.x[i]), there ? drawn(y, s.y[i]) : kNone, at(s.x_error, i),
                    at(s.y_error, i), drawn(y, at(s.low, i)), drawn(y, at(s.high, i)),
                    drawn(y, at(s.wide_low, i)), drawn(y, at(s.wide_high, i))});
  }
  return drawing.data(name, rows);
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
  commands.push_back(fmt::format("{} {} {}", file, with(s, k),
                                 s.name.empty() ? "notitle" : "title " + encode::gnuplot(s.name)));
}

void check(bool good, const char* what) {
  if (!good) throw std::logic_error(std::string("plot: ") + what);
}

void check(const Series& s) {
  const auto fits = [&](const std::vector<double>& v) {
    return v.empty() || v.size() == s.x.size();
  };
  check(s.y.size() == s.x.size() && fits(s.x_error) && fits(s.y_error) && fits(s.low) &&
            fits(s.high) && s.low.size() == s.high.size() && fits(s.wide_low) &&
            s.wide_low.size() == s.wide_high.size(),
        "lists of a series have different lengths");
}

void see(const Series& s, Extent& x, Extent& y) {
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    const double dx = i < s.x_error.size() && std::isfinite(s.x_error[i]) ? s.x_error[i] : 0;
    const double dy = i < s.y_error.size() && std::isfinite(s.y_error[i]) ? s.y_error[i] : 0;
    x.see({s.x[i], s.x[i] - dx, s.x[i] + dx});
    y.see({s.y[i], s.y[i] - dy, s.y[i] + dy, at(s.low, i), at(s.high, i), at(s.wide_low, i),
           at(s.wide_high, i)});
  }
}

}  // namespace

std::string draw(const XyPlot& plot) {
  Drawing drawing(plot.width, plot.height + 20 * std::max(0, key_rows(plot.series) - 1));
  std::vector<std::string> commands;
  bool any = false;
  Extent x(plot.x), y(plot.y);
  for (std::size_t k = 0; k < plot.series.size(); ++k) {
    check(plot.series[k]);
    see(plot.series[k], x, y);
    const Series s = downsampled(plot.series[k]);
    const std::string file =
        write_series(drawing, fmt::format("series{}", k), s, plot.x, plot.y, any);
    add_series(commands, file, s, static_cast<int>(k));
  }
  if (!any) return drawing.empty_plot(axis_title(plot.x), axis_title(plot.y));
  for (const Rule& r : plot.vertical) x.see(r.at);
  for (const Rule& r : plot.horizontal) y.see(r.at);
  return drawing.svg(x.script('x') + y.script('y') + rules_script(plot.vertical, plot.horizontal) +
                     fmt::format("plot {}\n", fmt::join(commands, ", ")));
}

std::string draw(const IntervalPlot& plot) {
  const std::size_t n = plot.names.size();
  std::vector<std::vector<std::array<double, 4>>> data(n);  // middle y low high
  std::string labels;
  Extent extent(plot.x);
  for (const Rule& r : plot.vertical) extent.see(r.at);
  double top = 0;  // lines; a row is a line of text and its intervals
  for (const IntervalRow& row : plot.rows) {
    check(row.intervals.size() == n, "a row of intervals lacks some");
    labels += fmt::format("set label {} at graph 0.01, first {} left textcolor rgb {}\n",
                          encode::gnuplot(row.label), top - 0.55, color::text);
    double y = top - 1.4;
    for (std::size_t k = 0; k < n; ++k) {
      const auto& interval = row.intervals[k];
      if (!interval || !shown(plot.x, interval->low) || !shown(plot.x, interval->high)) continue;
      data[k].push_back({interval->middle.value_or(kNone), y, interval->low, interval->high});
      extent.see({interval->low, interval->high});
      y -= 1;
    }
    top = std::min(y + 1, top - 1.4) - 0.9;
  }
  const int key_lines = (static_cast<int>(n) + 1) / 2;
  Drawing drawing(plot.width, 75 + 20 * key_lines + static_cast<int>(-22 * top));
  const bool any = std::ranges::any_of(data, [](const auto& one) { return !one.empty(); });
  if (!any) return drawing.empty_plot(axis_title(plot.x), "");
  std::vector<std::string> commands;
  for (std::size_t k = 0; k < n; ++k) {
    if (data[k].empty()) continue;
    const int series = static_cast<int>(k);
    const std::string file = drawing.data(fmt::format("intervals{}", k), data[k]);
    commands.push_back(
        fmt::format("{} using ($3):2:($4-$3):(0) with vectors heads size screen 0.008,90 lc rgb {} "
                    "lw 2.4 dt {} notitle",
                    file, series_color(series), dash(series)));
    commands.push_back(fmt::format("{} using 1:2 with points lc rgb {} pt {} ps 0.95 notitle", file,
                                   series_color(series), marker(series)));
    commands.push_back(fmt::format(
        "keyentry with linespoints lc rgb {} lw 2.4 dt {} pt {} ps 0.95 title {}",
        series_color(series), dash(series), marker(series), encode::gnuplot(plot.names[k])));
  }
  return drawing.svg(
      extent.script('x') + rules_script(plot.vertical, {}) + labels +
      fmt::format("unset ytics\nset border 1\nset lmargin 2\nset yrange [{}:0]\nplot {}\n",
                  top + 0.3, fmt::join(commands, ", ")));
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
  Drawing drawing(520, 320);
  double low = kNone, high = kNone;
  std::size_t most = 0;
  for (const Samples& samples : plot.samples) {
    most = std::max(most, samples.values.size());
    for (const double v : samples.values)
      if (shown(plot.x, v)) low = std::fmin(low, v), high = std::fmax(high, v);
  }
  if (std::isnan(low)) return drawing.empty_plot(axis_title(plot.x), plot.y_label);
  if (low == high) low -= 0.5, high += 0.5;
  const int bins =
      plot.bins > 0
          ? plot.bins
          : std::max(5, static_cast<int>(std::lround(std::sqrt(static_cast<double>(most)))));
  const auto scale = [&](double v) { return plot.x.log ? std::log(v) : v; };
  const auto edge = [&](int i) {
    const double v = scale(low) + (scale(high) - scale(low)) * i / bins;
    return plot.x.log ? std::exp(v) : v;
  };
  std::vector<std::string> commands;
  for (std::size_t k = 0; k < plot.samples.size(); ++k) {
    std::vector<double> count(static_cast<std::size_t>(bins), 0);
    for (const double v : plot.samples[k].values) {
      if (!shown(plot.x, v)) continue;
      const double share = (scale(v) - scale(low)) / (scale(high) - scale(low));
      ++count[static_cast<std::size_t>(std::clamp(static_cast<int>(share * bins), 0, bins - 1))];
    }
    std::vector<std::array<double, 2>> outline = {{edge(0), 0}};
    for (int i = 0; i < bins; ++i)
      for (const int side : {i, i + 1})
        outline.push_back({edge(side), count[static_cast<std::size_t>(i)]});
    outline.push_back({edge(bins), 0});
    const std::string file = drawing.data(fmt::format("bins{}", k), outline);
    const int series = static_cast<int>(k);
    commands.push_back(
        fmt::format("{} using 1:2 with filledcurves y1=0 fillstyle transparent solid 0.22 noborder "
                    "lc rgb {} notitle",
                    file, series_color(series)));
    commands.push_back(fmt::format("{} using 1:2 with lines lc rgb {} lw 1.8 dt {} title {}", file,
                                   series_color(series), dash(series),
                                   encode::gnuplot(fmt::format("{} ({})", plot.samples[k].name,
                                                               plot.samples[k].values.size()))));
  }
  Extent x(plot.x);
  x.see({low, high});
  for (const Rule& r : plot.vertical) x.see(r.at);
  return drawing.svg(x.script('x') + axis_script('y', {plot.y_label, "", false, 0, {}}) +
                     rules_script(plot.vertical, {}) +
                     fmt::format("plot {}\n", fmt::join(commands, ", ")));
}

std::string draw(const HeatMap& map) {
  check(map.z_values.size() == map.x_values.size() * map.y_values.size(), "the map is not x by y");
  check(map.x_values.size() > 1 && map.y_values.size() > 1, "a map needs two values each way");
  Drawing drawing(520, 400);
  // Cells as boxes: right on a log axis, too.
  const auto edges = [](const std::vector<double>& values, bool log) {
    const auto to = [&](double v) { return log ? std::log(v) : v; };
    const double step =
        (to(values.back()) - to(values.front())) / static_cast<double>(values.size() - 1);
    std::vector<double> result;
    for (std::size_t i = 0; i <= values.size(); ++i) {
      const double v = to(values.front()) + step * (static_cast<double>(i) - 0.5);
      result.push_back(log ? std::exp(v) : v);
    }
    return result;
  };
  const std::vector<double> x = edges(map.x_values, map.x.log), y = edges(map.y_values, map.y.log);
  std::vector<std::array<double, 5>> cells;
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
    check(map.marks[k]);
    bool any = false;
    const std::string marks =
        write_series(drawing, fmt::format("marks{}", k), map.marks[k], map.x, map.y, any);
    if (!any) continue;
    const bool line = map.marks[k].style == Style::line || map.marks[k].style == Style::step;
    // Light in dark: seen on every color of the map.
    const std::array<const char*, 2> colors = {"'#000000'", "'#ffffff'"};
    for (std::size_t pass = 0; pass < 2; ++pass) {
      const std::string title = pass == 1 && !map.marks[k].name.empty()
                                    ? "title " + encode::gnuplot(map.marks[k].name)
                                    : "notitle";
      commands.push_back(
          line
              ? fmt::format("{} using 1:2 with lines lc rgb {} lw {} dt {} {}", marks, colors[pass],
                            pass ? 1.6 : 4, pass ? dash(static_cast<int>(k)) : "1", title)
              : fmt::format("{} using 1:2 with points lc rgb {} pt {} ps {} {}", marks,
                            colors[pass], marker(static_cast<int>(k)), pass ? 0.6 : 0.95, title));
    }
  }
  Axis right = map.x, up = map.y;
  right.low = x.front(), right.high = x.back(), up.low = y.front(), up.high = y.back();
  return drawing.svg(
      axis_script('x', right) + axis_script('y', up) +
      fmt::format("set cblabel {} textcolor rgb {}\nset cbrange {}\n{}",
                  encode::gnuplot(axis_title(map.z)), color::text, range(map.z),
                  map.z.log ? "set logscale cb\nset format cb '%g'\n" : "") +
      fmt::format("{}unset grid\nplot {}\n", palette_script(), fmt::join(commands, ", ")));
}

std::string draw(const BarPlot& plot) {
  const std::size_t n = plot.series.size();
  std::size_t longest = 0;
  for (const std::string& name : plot.categories) longest = std::max(longest, name.size());
  const bool slanted = longest * plot.categories.size() > 40;
  Drawing drawing(plot.width, plot.height + (slanted ? static_cast<int>(4 * longest) : 0) +
                                  20 * std::max(0, key_rows(plot.series) - 1));
  std::vector<std::string> commands;
  bool any = false;
  const double width = 0.78 / static_cast<double>(std::max<std::size_t>(n, 1));
  for (std::size_t k = 0; k < n; ++k) {
    const BarSeries& s = plot.series[k];
    check(s.values.size() == plot.categories.size() &&
              (s.errors.empty() || s.errors.size() == s.values.size()) &&
              (s.low.empty() || s.low.size() == s.values.size()) && s.low.size() == s.high.size(),
          "a series of bars is not as long as the categories");
    std::vector<std::array<double, 5>> rows;
    for (std::size_t i = 0; i < s.values.size(); ++i) {
      if (!shown(plot.y, s.values[i])) continue;
      any = true;
      rows.push_back({static_cast<double>(i) +
                          (static_cast<double>(k) - (static_cast<double>(n) - 1) / 2) * width,
                      s.values[i], at(s.errors, i), drawn(plot.y, at(s.low, i)),
                      drawn(plot.y, at(s.high, i))});
    }
    if (rows.empty()) continue;
    const int series = static_cast<int>(k);
    const std::string file = drawing.data(fmt::format("bars{}", k), rows);
    commands.push_back(fmt::format(
        "{0} using 1:2:({1}) with boxes lc rgb {3} fillstyle transparent solid {2} border lc rgb "
        "{3} title {4}",
        file, 0.92 * width, k % 2 ? "0.12" : "0.75", series_color(series),
        encode::gnuplot(s.name)));
    if (!s.errors.empty())
      commands.push_back(
          fmt::format("{} using 1:($2-$3):(0):(2*$3) with vectors nohead lc rgb {} lw 1.6 notitle",
                      file, color::text));
    if (std::ranges::any_of(rows, [](const auto& row) { return std::isfinite(row[3] + row[4]); }))
      commands.push_back(fmt::format(
          "{} using 1:4:(0):($5-$4) with vectors heads size screen 0.006,90 lc rgb {} lw 1.6 "
          "notitle",
          file, color::text));
  }
  if (!any) return drawing.empty_plot(plot.x_label, axis_title(plot.y));
  std::vector<std::string> tics;
  for (std::size_t i = 0; i < plot.categories.size(); ++i)
    tics.push_back(fmt::format("{} {}", encode::gnuplot_tic(plot.categories[i]), i));
  Axis y = plot.y;
  if (!y.low && !y.log && std::ranges::none_of(plot.series, [](const BarSeries& s) {
        return std::ranges::any_of(s.values, [](double v) { return v < 0; });
      }))
    y.low = 0;
  Extent extent(y);
  for (const BarSeries& s : plot.series) {
    extent.see(s.values);
    extent.see(s.low);
    extent.see(s.high);
  }
  return drawing.svg(axis_script('x', {plot.x_label, "", false, -0.6,
                                       static_cast<double>(plot.categories.size()) - 0.4}) +
                     extent.script('y') +
                     fmt::format("set xtics ({}) scale 0 {}\nplot {}\n", fmt::join(tics, ", "),
                                 slanted ? "rotate by -35 left" : "", fmt::join(commands, ", ")));
}

}  // namespace firn::plots
