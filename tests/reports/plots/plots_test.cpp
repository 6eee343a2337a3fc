#include "reports/plots/plots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <regex>
#include <string>
#include <vector>

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
  std::mt19937 random(7);
  std::uniform_real_distribution<double> start(-12, 12), span(0.01, 14);
  for (int i = 0; i < 40; ++i) {
    const double low = std::pow(10, start(random)), high = low * std::pow(10, span(random));
    std::size_t labels = 0;
    for (const std::string& text : texts(log_plot(low, high)))
      labels += text.find("stiffness") == text.npos && text != "force / N" ? 1 : 0;
    EXPECT_GE(labels, 2U + 2U) << low << " to " << high;  // those of y count, too
    EXPECT_LE(labels, 16U + 12U) << low << " to " << high;
  }
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

}  // namespace
}  // namespace firn::plots
