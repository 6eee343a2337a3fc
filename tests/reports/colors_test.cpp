// Colors of plots and of replays: distinguishable for the color-blind, by day and by night.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <regex>
#include <string>
#include <vector>

#include "tests/support/read_text.h"

namespace firn {
namespace {

using Color = std::array<double, 3>;
using Matrix = std::array<Color, 3>;

std::string asset_text(const std::string& name) {
  return test::read_text(FIRN_SOURCE_DIR "/reports/assets/" + name);
}

// Linear RGB of "#rrggbb".
Color linear(const std::string& hex) {
  Color c{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double v = std::stoi(hex.substr(1 + 2 * k, 2), nullptr, 16) / 255.0;
    c[k] = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  }
  return c;
}

double luminance(const Color& c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

// Of WCAG 2.
double contrast(const Color& a, const Color& b) {
  const double one = luminance(a), other = luminance(b);
  return (std::max(one, other) + 0.05) / (std::min(one, other) + 0.05);
}

// Machado, Oliveira and Fernandes (2009), full severity.
const std::array<Matrix, 4> kEyes = {
    Matrix{Color{1, 0, 0}, Color{0, 1, 0}, Color{0, 0, 1}},
    Matrix{Color{0.152286, 1.052583, -0.204868}, Color{0.114503, 0.786281, 0.099216},
           Color{-0.003882, -0.048116, 1.051998}},
    Matrix{Color{0.367322, 0.860646, -0.227968}, Color{0.280085, 0.672501, 0.047413},
           Color{-0.011820, 0.042940, 0.968881}},
    Matrix{Color{1.255528, -0.076749, -0.178779}, Color{-0.078411, 0.930809, 0.147602},
           Color{0.004733, 0.691367, 0.303900}}};

Color seen(const Color& c, const Matrix& eye) {
  Color result{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) result[i] += eye[i][k] * c[k];
    result[i] = std::clamp(result[i], 0.0, 1.0);
  }
  return result;
}

// CIE 1976 L*a*b*.
Color lab(const Color& c) {
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  const double x = f((0.4124 * c[0] + 0.3576 * c[1] + 0.1805 * c[2]) / 0.95047),
               y = f(luminance(c)),
               z = f((0.0193 * c[0] + 0.1192 * c[1] + 0.9505 * c[2]) / 1.08883);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

double distance(const Color& a, const Color& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

double least_distance(const std::vector<std::string>& colors, std::size_t first) {
  double least = 1e9;
  for (const Matrix& eye : kEyes)
    for (std::size_t i = 0; i < first; ++i)
      for (std::size_t j = 0; j < i; ++j)
        least = std::min(
            least, distance(lab(seen(linear(colors[i]), eye)), lab(seen(linear(colors[j]), eye))));
  return least;
}

// Every value of a variable in a style sheet, in order: by day, by night.
std::vector<std::string> values_of(const std::string& css, const std::string& variable) {
  std::vector<std::string> all;
  const std::regex pattern("--" + variable + ": (#[0-9a-f]{3,6})");
  for (std::sregex_iterator m(css.begin(), css.end(), pattern), end; m != end; ++m)
    all.push_back((*m)[1].str() == "#fff" ? "#ffffff" : (*m)[1].str());
  return all;
}

TEST(Colors, SeriesAreDistinctForEveryEye) {
  const std::string css = asset_text("page.css");
  for (const std::size_t theme : {0U, 1U}) {
    std::vector<std::string> series;
    const std::string ground = values_of(css, "ground").at(theme);
    for (int k = 1; k <= 8; ++k) {
      series.push_back(values_of(css, "series-" + std::to_string(k)).at(theme));
      EXPECT_GE(contrast(linear(series.back()), linear(ground)), 3) << series.back();
    }
    EXPECT_GE(least_distance(series, 5), 17) << "theme " << theme;
    EXPECT_GE(least_distance(series, 8), 14) << "theme " << theme;
    for (const char* text : {"ink", "faint", "accent", "good", "caution", "bad", "neutral"})
      EXPECT_GE(contrast(linear(values_of(css, text).at(theme)), linear(ground)), 4.5) << text;
  }
}

TEST(Colors, ParticlesStandOutFromBoundaries) {
  const std::string js = asset_text("replay_colors.js");
  const auto list = [&](const std::string& name) {
    const std::size_t from = js.find("const " + name + " = ["), to = js.find(']', from);
    const std::string text = js.substr(from, to - from);
    std::vector<std::string> all;
    const std::regex pattern("#[0-9a-f]{6}");
    for (std::sregex_iterator m(text.begin(), text.end(), pattern), end; m != end; ++m)
      all.push_back(m->str());
    return all;
  };
  const std::vector<std::string> kinds = list("KINDS"), walls = list("WALLS");
  ASSERT_EQ(kinds.size(), 8U);
  ASSERT_EQ(walls.size(), 8U);
  EXPECT_GE(least_distance(kinds, 5), 16);
  EXPECT_GE(least_distance(kinds, 8), 10);
  const auto saturation = [](const std::string& hex) {
    const Color c = lab(linear(hex));
    return std::hypot(c[1], c[2]);
  };
  for (const std::string& wall : walls) EXPECT_LE(saturation(wall), 16) << wall;
  for (std::size_t k = 0; k + 1 < kinds.size(); ++k)
    EXPECT_GE(saturation(kinds[k]), 30) << kinds[k];
}

}  // namespace
}  // namespace firn
