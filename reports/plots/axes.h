// Axes of plots: what of the values can be drawn, ends, ticks and titles as gnuplot's commands.
// Commands for drawings as wide as XyPlot's and as high.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "reports/plots/plots.h"

namespace firn::plots {

// Whether gnuplot can draw the value on the axis.
bool shown(const Axis& axis, double value);
// The value as gnuplot can draw it, NaN for one that is not shown.
double drawn(const Axis& axis, double value);

// values[i], or NaN beyond their end.
double value_at(const std::vector<double>& values, std::size_t i);

std::string axis_title(const Axis& axis);
// The title in lines of at most so many characters, as a string of gnuplot.
std::string title_lines(const Axis& axis, std::size_t width);
std::string range_script(const Axis& axis);  // "[0:*]"

// gnuplot's list of ticks of a log axis from `low` to `high`, with as many labels as do not touch.
// `pixels`: the length of the axis; `upright`: labels are one above the other.
std::string log_tick_list(double low, double high, double pixels, bool upright);

// Title, range and ticks of axis `name` ('x' or 'y').
std::string axis_script(char name, const Axis& axis);

// The axis with its ends where it needs them: on a log axis, and for counts, a little beyond the
// data. `values` may hold what is not shown.
class Extent {
 public:
  explicit Extent(const Axis& axis);
  void see(const std::vector<double>& values);
  void see(double value);
  Axis axis() const;
  // axis_script() with labels that do not touch.
  std::string script(char name) const;
  // The place of a value between the ends, 0 to 1; NaN where they are not known.
  double share(double value) const;

 private:
  Axis axis_;
  double low_, high_;
};

// Lines across a plot with their texts, which do not lie over each other.
std::string rules_script(const std::vector<Rule>& vertical, const Extent& x,
                         const std::vector<Rule>& horizontal, const Extent& y);

// A name as the legend has room for it.
std::string legend_name(const std::string& name);
// A legend above the plot. Short names are in two columns.
struct Legend {
  int columns = 1, rows = 0;
  // pixels that it needs beyond its first row
  int further_rows_height() const { return 20 * std::max(0, rows - 1); }
  std::string script() const;
};
Legend legend_of(const std::vector<std::string>& names);
template <class Named>
Legend legend_of_series(const std::vector<Named>& series) {
  std::vector<std::string> names;
  for (const Named& s : series) names.push_back(s.name);
  return legend_of(names);
}

// Throws std::logic_error unless `good`.
void require_consistent(bool good, const char* what);

}  // namespace firn::plots
