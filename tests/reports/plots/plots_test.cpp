#include "reports/plots/plots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <random>
#include <regex>
#include <string>
#include <vector>

#include "reports/plots/plot_text.h"

namespace firn::plots {
namespace {

using testing::HasSubstr;
using testing::Not;

// Texts of a drawing, in order.
std::vector<std::string> texts(const std::string& svg) {
  std::vector<std::string> all;
  const std::regex pattern("<text>(?:<tspan[^>]*>)?([^<]*)<");
  for (std::sregex_iterator m(svg.begin(), svg.end(), pattern), end; m != end; ++m)
    if (const std::string text = (*m)[1]; !text.empty())
      all.push_back(text.substr(std::min(text.find_first_not_of(' '), text.size())));
  return all;
}

// An upright text of a drawing.
struct PlacedText {
  double x = 0, y = 0;  // pixels; of the end that `anchor` names
  std::string anchor, text;
  double left() const {
    return x - (anchor == "middle" ? width() / 2 : anchor == "end" ? width() : 0);
  }
  double right() const { return left() + width(); }
  double width() const { return kCharacter * static_cast<double>(text_length(text)); }
  static constexpr double kCharacter = 8.5;  // pixels, at least
};

std::vector<PlacedText> placed_texts(const std::string& svg) {
  std::vector<PlacedText> all;
  const std::regex pattern(
      R"re(<g transform="translate\(([-0-9.]+),([-0-9.]+)\)"[^>]*text-anchor="(\w+)">\s*)re"
      R"re(<text>(?:<tspan[^>]*>)?\s*([^<]*)<)re");
  for (std::sregex_iterator m(svg.begin(), svg.end(), pattern), end; m != end; ++m)
    if (!(*m)[4].str().empty())
      all.push_back({std::stod((*m)[1]), std::stod((*m)[2]), (*m)[3], (*m)[4]});
  return all;
}

double canvas_height(const std::string& svg) {
  std::smatch match;
  return std::regex_search(svg, match, std::regex("viewBox=\"0 0 [0-9]+ ([0-9]+)\""))
             ? std::stod(match[1])
             : 0;
}

// Every text lies within the canvas, and none over another one.
void expect_readable(const std::string& svg, double width) {
  const std::vector<PlacedText> all = placed_texts(svg);
  EXPECT_GE(all.size(), 2U);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_GE(all[i].left(), -1) << all[i].text;
    EXPECT_LE(all[i].right(), width + 1) << all[i].text;
    for (std::size_t j = 0; j < i; ++j) {
      constexpr double kLine = 12;  // pixels
      const bool apart = std::abs(all[i].y - all[j].y) >= kLine ||
                         all[i].left() >= all[j].right() || all[j].left() >= all[i].right();
      EXPECT_TRUE(apart) << all[j].text << " and " << all[i].text;
    }
  }
}

const std::string kLongName =
    "the_mean_time_from_the_insertion_of_a_particle_to_its_passage of the sensor at the lower end "
    "of the auger that conveys the ice of the second batch";

std::string log_plot(double low, double high) {
  XyPlot plot;
  plot.x = {"stiffness", "N/m", true, {}, {}};
  plot.y = {"force", "N", false, {}, {}};
  plot.series = {{"", {low, high}, {1, 2}}};
  return draw(plot);
}

TEST(Plots, LogAxesHaveLabelsForEveryRange) {
  EXPECT_THAT(texts(log_plot(0.02, 0.3)), testing::IsSupersetOf({"0.02", "0.05", "0.1", "0.2"}));
  EXPECT_THAT(texts(log_plot(1e-7, 1e3)), testing::IsSupersetOf({"10⁻⁶", "0.01", "1", "100"}));
  EXPECT_THAT(texts(log_plot(2e6, 3e6)), Not(testing::Contains(HasSubstr("e+"))));
  // From the smallest number on, which the standard conversions of texts refuse.
  EXPECT_FALSE(texts(log_plot(std::numeric_limits<double>::denorm_min(), 1e300)).empty());
  std::mt19937 random(7);
  std::uniform_real_distribution<double> start(-12, 12), span(0.01, 14);
  for (int i = 0; i < 40; ++i) {
    const double low = std::pow(10, start(random)), high = low * std::pow(10, span(random));
    std::size_t labels = 0;
    for (const std::string& text : texts(log_plot(low, high)))
      labels += text.find("stiffness") == text.npos && text != "force / N" ? 1 : 0;
    EXPECT_GE(labels, 2U + 2U) << low << " to " << high;  // those of y count, too
    EXPECT_LE(labels, 16U + 12U) << low << " to " << high;
    expect_readable(log_plot(low, high), 520);
  }
}

TEST(Plots, LabelsOfLinearAxesDoNotTouch) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> start(-1000, 1000), span(-4, 4);
  for (int i = 0; i < 30; ++i) {
    const double size = std::pow(10, span(random)), low = size < 1 ? 0 : start(random);
    XyPlot plot;
    plot.x = {"time", "s", false, {}, {}};
    plot.y = {"force", "N", false, {}, {}};
    plot.series = {{"", {low, low + size}, {1, 2}}};
    SCOPED_TRACE(low);
    SCOPED_TRACE(size);
    expect_readable(draw(plot), 520);
  }
}

TEST(PlotText, IsBrokenAtSpacesAndCutInTheMiddle) {
  using Lines = std::vector<std::string>;
  EXPECT_EQ(wrap_text("peak force", 20, 2), Lines{"peak force"});
  EXPECT_EQ(wrap_text("time from insertion to the sensor / s", 28, 2),
            (Lines{"time from insertion to the", "sensor / s"}));
  EXPECT_EQ(wrap_text("", 20, 2), Lines{""});
  EXPECT_EQ(shorten_text("first half of the batch", 10), "first …tch");
  EXPECT_EQ(shorten_text("größe", 5), "größe");
  EXPECT_EQ(text_length("größe"), 5U);
  std::mt19937 random(3);
  for (int i = 0; i < 300; ++i) {
    std::string text;
    for (unsigned k = random() % 120; k > 0; --k) text += random() % 5 == 0 ? " " : "é";
    const std::size_t width = 2 + random() % 30, most = 1 + random() % 3;
    const Lines lines = wrap_text(text, width, most);
    EXPECT_LE(lines.size(), most) << text << ", " << width;
    for (const std::string& line : lines) EXPECT_LE(text_length(line), width) << text;
  }
}

// Of 2 to 6 names of any length.
TEST(Plots, LegendsFit) {
  std::mt19937_64 random(3);
  for (int member = 0; member < 40; ++member) {
    XyPlot plot;
    plot.x = {"time", "s", false, {}, {}};
    plot.y = {"force", "N", false, {}, {}};
    const int count = 2 + member % 5;
    std::string names;
    for (int k = 0; k < count; ++k) {
      const std::size_t length = std::uniform_int_distribution<std::size_t>(1, 20)(random);
      plot.series.push_back({kLongName.substr(0, length), {0, 1}, {1, 20}});
      names += plot.series.back().name + "|";
    }
    SCOPED_TRACE(names);
    expect_readable(draw(plot), 520);
  }
}

TEST(Plots, LongNamesAreCutAndDoNotOverlap) {
  XyPlot curves;
  curves.x = {kLongName, "s", false, {}, {}};
  curves.y = {kLongName, "N", true, {}, {}};
  for (int k = 0; k < 4; ++k)
    curves.series.push_back({kLongName + std::to_string(k), {0, 1}, {1, 20}});
  curves.horizontal = {{3, kLongName}, {3.1, kLongName}};
  const std::string drawn_curves = draw(curves);
  expect_readable(drawn_curves, 520);
  for (int k = 0; k < 4; ++k)  // the ends of the names distinguish them
    EXPECT_THAT(drawn_curves, HasSubstr("batch" + std::to_string(k)));

  BarPlot bars;
  bars.y = {kLongName, "", false, {}, {}};
  for (const int count : {1, 3, 9, 30}) {
    SCOPED_TRACE(count);
    bars.categories.assign(static_cast<std::size_t>(count), kLongName);
    bars.series = {{kLongName, std::vector<double>(static_cast<std::size_t>(count), 1.5)},
                   {"b", std::vector<double>(static_cast<std::size_t>(count), 2)}};
    expect_readable(draw(bars), 520);
  }

  IntervalPlot intervals;
  intervals.x = {kLongName, "%", false, {}, {}};
  intervals.names = {kLongName, "simulation"};
  intervals.vertical = {{0.5, kLongName}};
  for (int k = 0; k < 3; ++k)
    intervals.rows.push_back({kLongName, {Interval{0, 1, 0.5}, Interval{1, 2, 1.5}}});
  const std::string drawn_intervals = draw(intervals);
  expect_readable(drawn_intervals, 520);
  EXPECT_THAT(drawn_intervals, HasSubstr("…"));
}

// Of one and two lines, and with a title below them.
TEST(Plots, NamesOfCategoriesAreApartFromTheTitleOfTheirAxis) {
  for (const char* name : {"glued", "three glued spheres", "glued spheres, three of them"})
    for (const char* title : {"shape", "shape of the particles"}) {
      SCOPED_TRACE(name);
      BarPlot plot;
      plot.y = {"angle", "deg", false, {}, {}};
      plot.x_label = title;
      plot.categories = {"crescent", name, "sphere"};
      plot.series = {{"mean", {21, 29, 1}}};
      const std::string svg = draw(plot);
      expect_readable(svg, 520);
      double title_at = 0, lowest = 0;  // lines of text
      for (const PlacedText& text : placed_texts(svg))
        if (text.text == title)
          title_at = text.y;
        else
          lowest = std::max(lowest, text.y);
      EXPECT_GE(title_at - lowest, 17);  // pixels: the size of the text
      EXPECT_LE(title_at + 4, canvas_height(svg));
    }
}

TEST(Plots, TextsOfCloseRulesAreApart) {
  XyPlot plot;
  plot.x = {"force", "N", false, {}, {}};
  plot.y = {"share", "", false, {}, {}};
  plot.series = {{"", {0, 100}, {0, 1}}};
  plot.vertical = {{50, "weakest"}, {50.5, "strongest"}};
  const std::string svg = draw(plot);
  const std::regex pattern(R"re(translate\(([-0-9.]+),([-0-9.]+)\) rotate\([^)]*\)"[^>]*>\s*)re"
                           R"re(<text>(?:<tspan[^>]*>)?\s*(weakest|strongest))re");
  std::vector<double> places;
  for (std::sregex_iterator m(svg.begin(), svg.end(), pattern), end; m != end; ++m)
    places.push_back(std::stod((*m)[1]));
  ASSERT_EQ(places.size(), 2U);
  EXPECT_GT(std::abs(places[0] - places[1]), 12);  // pixels: one before, one behind its line
}

TEST(Plots, ScalesOfMapsHaveMinorTicks) {
  HeatMap map;
  map.x = {"a", "", false, {}, {}};
  map.y = {"b", "", false, {}, {}};
  map.z = {"rate", "1/s", true, {}, {}};
  map.x_values = map.y_values = {1, 2};
  map.z_values = {1e6, 1e7, 3e6, 1e8};
  const std::string svg = draw(map);
  EXPECT_THAT(texts(svg), testing::Contains("10⁷"));
  EXPECT_THAT(texts(svg), Not(testing::Contains(HasSubstr("e+"))));
}

TEST(Plots, CountsHaveWholeTicks) {
  XyPlot plot;
  plot.x = {"batch", "", false, {}, {}, true};
  plot.y = {"time", "s", false, {}, {}};
  plot.series = {{"", {0, 1, 2}, {1.5, 2.5, 2}}};
  const std::vector<std::string> all = texts(draw(plot));
  EXPECT_THAT(all, testing::IsSupersetOf({"0", "1", "2"}));
  EXPECT_THAT(all, Not(testing::Contains("0.5")));
}

TEST(Plots, ValuesThatALogAxisCannotShowAreGaps) {
  XyPlot plot;
  plot.x = {"a", "", true, {}, {}};
  plot.y = {"b", "", true, {}, {}};
  plot.series = {{"", {-1, 0, 1, 10, INFINITY}, {1, 1, 0, 5, 1}}};
  EXPECT_THAT(draw(plot), Not(HasSubstr("no finite values")));
  plot.series = {{"", {-1, 0}, {1, 1}}};
  EXPECT_THAT(draw(plot), HasSubstr("no finite values"));
}

// How often a part of a drawing occurs.
std::size_t occurrences(const std::string& svg, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = svg.find(part, at)) != svg.npos; at += part.size()) ++count;
  return count;
}

TEST(Plots, ASeriesHasTwoBands) {
  XyPlot plot;
  Series series{"", {1, 2, 3}, {1, 2, 3}};
  const auto bands = [&] {
    plot.series = {series};
    return occurrences(draw(plot), "fill-opacity");
  };
  const std::size_t none = bands();
  series.low = {0.5, 1.5, 2.5}, series.high = {1.5, 2.5, 3.5};
  EXPECT_EQ(bands(), none + 1);
  series.wide_low = {0, 1, 2}, series.wide_high = {2, 3, 40};
  EXPECT_EQ(bands(), none + 2);
  EXPECT_THAT(texts(draw(plot)), testing::Contains("40"));  // the axis holds both
  series.wide_high.pop_back();
  plot.series = {series};
  EXPECT_THROW(draw(plot), std::logic_error);
}

// The lines of a drawing, in order.
std::vector<std::string> drawn_lines(const std::string& svg) {
  std::vector<std::string> all;
  const std::regex pattern(R"re(\sd=["']([^"']*))re");
  for (std::sregex_iterator m(svg.begin(), svg.end(), pattern), end; m != end; ++m)
    all.push_back((*m)[1]);
  return all;
}

TEST(Plots, AStepKeepsItsValueUntilTheNextOne) {
  XyPlot plot;
  plot.x = {"time", "s", false, {}, {}};
  plot.y = {"particles that have passed", "", false, 0.0, {}, true};
  plot.series = {{"", {0, 2.5, 3, 4}, {0, 1, 2, 2}, Style::step}};
  const std::vector<std::string> steps = drawn_lines(draw(plot));
  ASSERT_FALSE(steps.empty());
  plot.series = {{"", {0, 2.5, 2.5, 3, 3, 4}, {0, 0, 1, 1, 2, 2}}};
  EXPECT_EQ(steps, drawn_lines(draw(plot)));
}

TEST(Plots, BarsHaveIntervals) {
  BarPlot plot;
  plot.y = {"index", "", false, 0.0, {}};
  plot.categories = {"angle", "rate"};
  plot.series = {{"friction", {0.4, 0.6}}};
  const std::string plain = draw(plot);
  plot.series[0].low = {0.3, std::nan("")};
  plot.series[0].high = {1.9, std::nan("")};
  const std::string with_interval = draw(plot);
  EXPECT_GT(occurrences(with_interval, "<path"), occurrences(plain, "<path"));
  EXPECT_THAT(texts(with_interval), testing::Contains("1.8"));
  EXPECT_THAT(texts(plain), Not(testing::Contains("1.8")));
  plot.series[0].low = {std::nan(""), std::nan("")};
  plot.series[0].high = plot.series[0].low;
  EXPECT_EQ(occurrences(draw(plot), "<path"), occurrences(plain, "<path"));
  plot.series[0].high.pop_back();
  EXPECT_THROW(draw(plot), std::logic_error);
}

// Of positive, negative and mixed values, with and without errors.
TEST(Plots, BarsStandOnZero) {
  for (const auto& [values, from, to] : {std::tuple{std::vector{0.09, 0.1, 0.12}, "0", "0.12"},
                                         std::tuple{std::vector{-0.09, -0.1, -0.12}, "-0.12", "0"},
                                         std::tuple{std::vector{-0.1, 0.05, 0.1}, "-0.1", "0.1"}})
    for (const bool with_errors : {false, true}) {
      SCOPED_TRACE(values.front());
      BarPlot plot;
      plot.y = {"index", "", false, {}, {}};
      plot.categories = {"slow", "as it is", "fast"};
      plot.series = {{"mean", values}};
      const std::string plain = draw(plot);
      if (with_errors) plot.series[0].errors = {0.001, std::nan(""), 0.002};
      const std::string svg = draw(plot);
      expect_readable(svg, 520);
      EXPECT_THAT(texts(svg), testing::Contains("0"));
      EXPECT_THAT(texts(svg), testing::Contains(from));
      EXPECT_THAT(texts(svg), testing::Contains(to));
      EXPECT_EQ(occurrences(svg, "<path") > occurrences(plain, "<path"), with_errors);
    }
}

// Also where they begin below it.
TEST(Plots, ErrorsAndIntervalsOfBarsAreWithinTheAxis) {
  for (const double error : {0.5, 1.0, 2.3, 40.0})
    for (const bool interval : {false, true}) {
      SCOPED_TRACE(fmt::format("{} {}", error, interval));
      BarPlot plot;
      plot.y = {"torque", "N m", false, {}, {}};
      plot.categories = {"slow", "fast"};
      plot.series = {{"mean", {1.5, 0.3}}};
      if (interval) {
        plot.series[0].low = {1.5 - error, 0.2};
        plot.series[0].high = {1.5 + error, 0.4};
      } else {
        plot.series[0].errors = {error, 0.1};
      }
      double highest = 0;
      for (const std::string& text : texts(draw(plot)))
        if (text.find_first_not_of("0123456789.") == std::string::npos && !text.empty())
          highest = std::max(highest, std::stod(text));
      EXPECT_GE(highest, 1.5 + error - 1e-9);
    }
}

TEST(Plots, RulesWithoutTextAreLinesAlone) {
  XyPlot plot;
  plot.series = {{"", {0, 1}, {0, 2}}};
  const std::string bare = draw(plot);
  plot.vertical = {{0.5, ""}};
  plot.horizontal = {{1, ""}};
  const std::string ruled = draw(plot);
  EXPECT_EQ(texts(ruled), texts(bare));
  const std::regex text("<text>"), line("stroke-dasharray|<path");
  const auto count = [](const std::string& svg, const std::regex& what) {
    return std::distance(std::sregex_iterator(svg.begin(), svg.end(), what), {});
  };
  EXPECT_EQ(count(ruled, text), count(bare, text));
  EXPECT_GT(count(ruled, line), count(bare, line));
}

TEST(Plots, UnitsAreNotBroken) {
  XyPlot plot;
  plot.series = {{"", {0, 1}, {0, 2}}};
  plot.y = {"torque of the contacts", "N m", false, {}, {}};  // 28 characters before the m
  const std::vector<std::string> all = texts(draw(plot));
  EXPECT_TRUE(std::ranges::none_of(all, [](const std::string& text) { return text == "m"; }));
  EXPECT_TRUE(
      std::ranges::any_of(all, [](const std::string& text) { return text.ends_with("N\u00a0m"); }));
}

}  // namespace
}  // namespace firn::plots
