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

}  // namespace
}  // namespace firn::plots
