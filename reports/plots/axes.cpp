#include "reports/plots/axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>
#include <stdexcept>
#include <utility>

#include "experiments/system/text_encoding.h"
#include "experiments/text/number_text.h"
#include "reports/plots/plot_svg.h"
#include "reports/plots/plot_text.h"

namespace firn::plots {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
// Nominal pixels of the axes of a drawing of 520 by 320 with titles of two lines, and between
// neighboring labels.
constexpr double kAcross = 330, kUp = 155, kGap = 8;

bool ends_known(const Axis& axis) {
  return axis.low && axis.high && shown(axis, *axis.low) && shown(axis, *axis.high) &&
         *axis.low < *axis.high;
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

// gnuplot's tick: with a label, or a minor one.
std::string tick_item(double at, bool labeled) {
  return labeled ? fmt::format("{} {:.17g}", encode::gnuplot_tic(tick_text(at)), at)
                 : fmt::format("'' {:.17g} 1", at);
}

// 1, 2 or 5 times a power of ten that divides a span into so many steps at most.
double even_step(double span, double most) {
  const double rough = span / most, power = std::pow(10, std::floor(std::log10(rough)));
  const double factor = rough / power;
  return power * (factor <= 1 ? 1 : factor <= 2 ? 2 : factor <= 5 ? 5 : 10);
}

// A log axis: the places of its labels are ascending.
struct LogAxis {
  double low, high, pixels;
  bool upright;

  double decades() const { return std::log10(high / low); }
  bool holds(double v) const { return v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9); }
  bool labels_touch(const std::vector<double>& places) const {
    for (std::size_t i = 0; i + 1 < places.size(); ++i) {
      const double apart = pixels * std::log10(places[i + 1] / places[i]) / decades();
      const auto length = [&](std::size_t k) {
        return static_cast<double>(text_length(tick_text(places[k])));
      };
      const double needed =
          upright ? kLineHeight : kGap + kCharacterWidth * (length(i) + length(i + 1)) / 2;
      if (apart < needed) return true;
    }
    return false;
  }
};

// At the given multiples of every `stride`-th power of ten.
std::vector<double> decade_places(const LogAxis& axis, const std::set<int>& factors, int stride) {
  std::vector<double> places;
  const int first = static_cast<int>(std::floor(std::log10(axis.low) + 1e-9)),
            last = static_cast<int>(std::ceil(std::log10(axis.high) - 1e-9));
  for (int exponent = first; exponent <= last; ++exponent) {
    if ((exponent - first) % stride != 0) continue;
    for (const int factor : factors) {
      const double at = std::strtod(fmt::format("{}e{}", factor, exponent).c_str(), nullptr);
      if (axis.holds(at)) places.push_back(at);
    }
  }
  return places;
}

// As many as do not touch: some multiples of each power of ten, or only some of these powers.
std::vector<double> label_places(const LogAxis& axis) {
  static const std::array<std::set<int>, 5> kFactors = {
      {{1, 2, 3, 4, 5, 6, 7, 8, 9}, {1, 2, 3, 4, 5, 6, 8}, {1, 2, 5}, {1, 3}, {1}}};
  constexpr double kMostOfAll = 1.2, kMostOfSome = 3;  // decades; more would be crowded
  for (const std::set<int>& factors : kFactors) {
    if (factors.size() > 3 && axis.decades() > kMostOfAll) continue;
    if (factors.size() > 1 && axis.decades() > kMostOfSome) continue;
    std::vector<double> places = decade_places(axis, factors, 1);
    if (!axis.labels_touch(places)) return places;
  }
  for (int stride = 2;; ++stride) {
    std::vector<double> places = decade_places(axis, {1}, stride);
    if (places.size() < 2 || !axis.labels_touch(places)) return places;
  }
}

// Evenly spaced ones, for an axis of about one decade or less.
std::vector<double> even_places(const LogAxis& axis) {
  const auto multiples = [&](double step, int stride) {
    constexpr std::size_t kMost = 20;
    std::vector<double> places;
    for (double k = std::ceil(axis.low / step); axis.holds(k * step) && places.size() < kMost;
         k += stride)
      places.push_back(k * step);
    return places;
  };
  const double span = axis.high - axis.low;
  for (const auto& [most, stride] : {std::pair(5.0, 1), {3.0, 1}, {5.0, 2}, {5.0, 3}, {5.0, 4}}) {
    const std::vector<double> places = multiples(even_step(span, most), stride);
    if (places.size() > 1 && !axis.labels_touch(places)) return places;
  }
  return {};
}

// Between the ticks of a linear axis whose labels do not touch.
double label_step(double low, double high) {
  for (const double most : {6.0, 5.0, 4.0, 3.0}) {
    const double step = even_step(high - low, most), first = std::floor(low / step);
    std::size_t longest = 0;
    for (int k = 0; k < 10; ++k)
      longest = std::max(longest, fmt::format("{:g}", (first + k) * step).size());
    const double steps = std::ceil(high / step) - first;  // gnuplot extends the axis to ticks
    if (kCharacterWidth * static_cast<double>(longest) + kGap <= kAcross / steps) return step;
  }
  return even_step(high - low, 2);
}

// Where the text of a rule stands: before or behind its line, at its usual end or at the other one.
struct RulePlace {
  bool behind = false, other_end = false;
};

// Places at which no text lies over another one, over another line or beyond the axis, while there
// are such places. `pixels`: the length of the axis; `behind`: the usual place.
std::vector<RulePlace> place_rules(const std::vector<Rule>& rules, const Extent& axis,
                                   double pixels, bool behind) {
  const std::array<RulePlace, 4> tried_places = {
      {{behind, false}, {!behind, false}, {behind, true}, {!behind, true}}};
  struct Taken {
    double from, to;  // pixels along the axis
    bool other_end;
  };
  std::vector<Taken> taken;
  std::vector<RulePlace> places(rules.size());
  for (std::size_t i = 0; i < rules.size(); ++i) {
    places[i].behind = behind;
    if (rules[i].text.empty()) continue;
    const double at = pixels * axis.share(rules[i].at);
    for (const RulePlace& tried : tried_places) {
      const Taken wanted{tried.behind ? at : at - kLineHeight, tried.behind ? at + kLineHeight : at,
                         tried.other_end};
      const bool on_text = std::ranges::any_of(taken, [&](const Taken& t) {
        return t.other_end == wanted.other_end && t.from < wanted.to && wanted.from < t.to;
      });
      const bool on_line = std::ranges::any_of(rules, [&](const Rule& r) {
        const double line = pixels * axis.share(r.at);
        return line > wanted.from && line < wanted.to;
      });
      if (on_text || on_line || wanted.from < 0 || wanted.to > pixels) continue;
      places[i] = tried;
      taken.push_back(wanted);
      break;
    }
  }
  return places;
}

}  // namespace

bool shown(const Axis& axis, double value) {
  // Beyond these the arithmetic of gnuplot overflows.
  constexpr double kLargest = 1e100, kSmallestOfLog = 1e-100;
  return std::abs(value) <= kLargest && (!axis.log || value >= kSmallestOfLog);
}

// The axes of gnuplot end in an error where all values are next to the least number.
double drawn(const Axis& axis, double value) {
  constexpr double kNothing = 1e-200;
  if (!shown(axis, value)) return kNone;
  return std::abs(value) < kNothing ? (axis.log ? kNone : 0) : value;
}

double value_at(const std::vector<double>& values, std::size_t i) {
  return i < values.size() ? values[i] : kNone;
}

// No line breaks within the unit: "N m" has a space that does not break.
std::string axis_title(const Axis& axis) {
  std::string unit;
  for (const char c : axis.unit) unit += c == ' ' ? "\u00a0" : std::string(1, c);
  return axis_label(axis.label, unit);
}

std::string title_lines(const Axis& axis, std::size_t width) {
  return gnuplot_lines(wrap_text(axis_title(axis), width, 2));
}

std::string range_script(const Axis& axis) {
  const bool empty = axis.low && axis.high && !(*axis.low < *axis.high);
  const auto end = [&](const std::optional<double>& v) {
    return v && shown(axis, *v) && !empty ? fmt::format("{:.17g}", *v) : std::string("*");
  };
  return fmt::format("[{}:{}]", end(axis.low), end(axis.high));
}

std::string log_tick_list(double low, double high, double pixels, bool upright) {
  const LogAxis axis{low, high, pixels, upright};
  constexpr double kFew = 1.3;          // decades
  constexpr double kMostOfMinor = 8.5;  // decades; minor ticks would touch
  std::vector<double> labels = label_places(axis);
  if (labels.size() < 3 && axis.decades() < kFew)
    if (std::vector<double> even = even_places(axis); even.size() >= labels.size()) labels = even;
  std::vector<std::string> items;
  for (const double at : labels) items.push_back(tick_item(at, true));
  const std::set<int> minor =
      axis.decades() > kMostOfMinor ? std::set<int>{1} : std::set<int>{1, 2, 3, 4, 5, 6, 7, 8, 9};
  for (const double at : decade_places(axis, minor, 1))
    if (!std::ranges::any_of(labels, [&](double l) { return std::abs(l / at - 1) < 1e-9; }))
      items.push_back(tick_item(at, false));
  return fmt::format("{}", fmt::join(items, ", "));
}

std::string axis_script(char name, const Axis& axis) {
  constexpr std::size_t kWidth = 48, kHeight = 28;  // characters of a title
  std::string script =
      fmt::format("set {}label {}\nset {}range {}\n", name,
                  title_lines(axis, name == 'y' ? kHeight : kWidth), name, range_script(axis));
  if (axis.log) script += fmt::format("set logscale {}\n", name);
  if (axis.log && name == 'x') script += "set rmargin 5\n";  // half of the last label
  if (axis.log && ends_known(axis))
    script +=
        fmt::format("set {}tics ({})\n", name,
                    log_tick_list(*axis.low, *axis.high, name == 'y' ? kUp : kAcross, name == 'y'));
  if (axis.whole && ends_known(axis) && *axis.high - *axis.low < 12)
    script += fmt::format("set {}tics 1\n", name);
  return script;
}

Extent::Extent(const Axis& axis) : axis_(axis), low_(kNone), high_(kNone) {}

void Extent::see(const std::vector<double>& values) {
  for (const double v : values) see(v);
}

void Extent::see(double value) {
  if (!shown(axis_, value)) return;
  low_ = std::fmin(low_, value), high_ = std::fmax(high_, value);
}

Axis Extent::axis() const {
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

std::string Extent::script(char name) const {
  const Axis ends = axis();
  std::string text = axis_script(name, ends);
  const double low = ends.low.value_or(low_), high = ends.high.value_or(high_);
  if (name == 'x' && !ends.log && !ends.whole && shown(ends, low) && shown(ends, high) &&
      high > low)
    text += fmt::format("set xtics {:.17g}\n", label_step(low, high));
  return text;
}

double Extent::share(double value) const {
  const Axis ends = axis();
  const double low = ends.low.value_or(low_), high = ends.high.value_or(high_);
  return ends.log ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
}

std::string rules_script(const std::vector<Rule>& vertical, const Extent& x,
                         const std::vector<Rule>& horizontal, const Extent& y) {
  constexpr std::size_t kWhole = 20, kHalf = 10, kAcrossWhole = 36, kAcrossHalf = 18;  // characters
  const auto both_ends = [](const std::vector<RulePlace>& places) {
    return std::ranges::any_of(places, &RulePlace::other_end);
  };
  std::string script;
  const std::vector<RulePlace> along = place_rules(vertical, x, kAcross, false);
  for (std::size_t i = 0; i < vertical.size(); ++i) {
    const Rule& r = vertical[i];
    if (!shown({}, r.at)) continue;
    script += fmt::format(
        "set arrow from first {0:.17g}, graph 0 to first {0:.17g}, graph 1 nohead lw 1 dt 3 lc rgb "
        "{1} back\n",
        r.at, color::muted);
    if (r.text.empty()) continue;
    script += fmt::format(
        "set label {2} at first {0:.17g}, graph {3} rotate by 90 offset {4},0 textcolor "
        "rgb {1} font ',14'\n",
        r.at, color::muted,
        encode::gnuplot(shorten_text(r.text, both_ends(along) ? kHalf : kWhole)),
        along[i].other_end ? "0.03 left" : "0.97 right", along[i].behind ? "0.9" : "-0.7");
  }
  const std::vector<RulePlace> above = place_rules(horizontal, y, kUp, true);
  for (std::size_t i = 0; i < horizontal.size(); ++i) {
    const Rule& r = horizontal[i];
    if (!shown({}, r.at)) continue;
    script += fmt::format(
        "set arrow from graph 0, first {0:.17g} to graph 1, first {0:.17g} nohead lw 1 dt 3 lc rgb "
        "{1} back\n",
        r.at, color::muted);
    if (r.text.empty()) continue;
    script += fmt::format(
        "set label {2} at graph {3}, first {0:.17g} {4} offset 0,{5} textcolor rgb {1} "
        "font ',14'\n",
        r.at, color::muted,
        encode::gnuplot(shorten_text(r.text, both_ends(above) ? kAcrossHalf : kAcrossWhole)),
        above[i].other_end ? "0.01" : "0.99", above[i].other_end ? "left" : "right",
        above[i].behind ? "0.5" : "-0.6");
  }
  return script;
}

std::string legend_name(const std::string& name) {
  constexpr std::size_t kMost = 34;  // characters
  return shorten_text(name, kMost);
}

Legend legend_of(const std::vector<std::string>& names) {
  constexpr std::size_t kShort = 12;  // characters of which two columns fit
  int named = 0;
  std::size_t longest = 0;
  for (const std::string& name : names) {
    named += name.empty() ? 0 : 1;
    longest = std::max(longest, text_length(name));
  }
  const int columns = longest > kShort ? 1 : 2;
  return {columns, (named + columns - 1) / columns};
}

std::string Legend::script() const { return fmt::format("set key maxcols {}\n", columns); }

void require_consistent(bool good, const char* what) {
  if (!good) throw std::logic_error(std::string("plot: ") + what);
}

}  // namespace firn::plots
