// Plots for pages: data in, one inline <svg> out. Colors follow the page's (light, dark, paper),
// and text is the page's; series differ by dash and marker as well as by color. Values that are
// not finite (on a log axis: not positive) are gaps. Units are those of the numbers as given:
// nothing is converted. Log axes have ticks at 1, 2, ... 9 times each power of ten, with as many
// labels as there is room for. All throw InputError without gnuplot.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace firn::plots {

struct Axis {
  std::string label;  // plain words: "force on the auger"
  std::string unit;   // "N"; empty or "1": none
  bool log = false;
  std::optional<double> low, high;  // ends; by default the range of the data
  bool whole = false;               // counts: no ticks between whole numbers
};

// step: a value holds until the next one; joined: points and lines between them.
enum class Style { line, step, points, joined };

// y over x. Errors are one standard deviation, drawn as bars; low and high are a shaded band, which
// wide_low and wide_high surround with a lighter one. Empty, or as long as x.
struct Series {
  std::string name;  // empty: not in the legend
  std::vector<double> x, y;
  Style style = Style::line;
  std::vector<double> x_error = {}, y_error = {};
  std::vector<double> low = {}, high = {};
  std::vector<double> wide_low = {}, wide_high = {};
};

// A vertical or horizontal line across the plot, with its text along it.
struct Rule {
  double at = 0;
  std::string text;
};

struct XyPlot {
  Axis x, y;
  std::vector<Series> series;
  std::vector<Rule> vertical = {}, horizontal = {};
  int width = 520, height = 320;  // nominal pixels; it scales with the page
};
std::string draw(const XyPlot& plot);

// Rows of intervals over one axis: an experiment compared with simulations.
struct Interval {
  double low = 0, high = 0;
  std::optional<double> middle;  // drawn as a marker
};
struct IntervalRow {
  std::string label;
  std::vector<std::optional<Interval>> intervals;  // in order of `names`; none: left out
};
struct IntervalPlot {
  Axis x;
  std::vector<std::string> names;  // {"experiment", "simulation"}
  std::vector<IntervalRow> rows;   // from above
  std::vector<Rule> vertical = {};
  int width = 520;  // the height follows
};
std::string draw(const IntervalPlot& plot);

// Samples as fractions of them at or below x: steps, with a shaded band where there is one (say,
// what chance alone does to so many samples).
struct Samples {
  std::string name;
  std::vector<double> values;
};
struct Band {
  std::string name;
  std::vector<double> x, low, high;
};
struct CdfPlot {
  Axis x;
  std::vector<Samples> samples;
  std::vector<Band> bands = {};
  std::vector<Rule> vertical = {};
  std::string y_label = "share at or below";
};
std::string draw(const CdfPlot& plot);

// How many samples fall into each of equal bins.
struct HistogramPlot {
  Axis x;
  std::vector<Samples> samples;
  int bins = 0;  // 0: about the square root of the number of samples, at least 5
  std::string y_label = "count";
  std::vector<Rule> vertical = {};
};
std::string draw(const HistogramPlot& plot);

// Values on a grid, with marks over them. Cells are centered on the axes' values, which are evenly
// spaced (on a log axis: in the logarithm).
struct HeatMap {
  Axis x, y, z;
  std::vector<double> x_values, y_values;
  std::vector<double> z_values;    // [y][x]
  std::vector<Series> marks = {};  // points and lines over the map
};
std::string draw(const HeatMap& map);

// Values by category. Errors are one standard deviation, low and high the ends of an interval;
// empty, or as long as the values.
struct BarSeries {
  std::string name;
  std::vector<double> values;  // in order of the categories; not finite: none
  std::vector<double> errors = {};
  std::vector<double> low = {}, high = {};  // not finite: none
};
struct BarPlot {
  Axis y;
  std::vector<std::string> categories;
  std::vector<BarSeries> series;
  std::string x_label = "";
  int width = 520, height = 320;
};
std::string draw(const BarPlot& plot);

}  // namespace firn::plots
