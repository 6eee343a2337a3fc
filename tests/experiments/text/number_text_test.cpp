#include "experiments/text/number_text.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace firn {
namespace {

TEST(NumberText, KeepsSignificantDigits) {
  EXPECT_EQ(number_text(0.30000000000000004), "0.3");
  EXPECT_EQ(number_text(0.041638), "0.04164");
  EXPECT_EQ(number_text(410.4, 2), "410");
  EXPECT_EQ(number_text(12345.6), "12346");
  EXPECT_EQ(number_text(-0.00012), "-0.00012");
  EXPECT_EQ(number_text(9.9996), "10");
  EXPECT_EQ(number_text(1.5e-7), "1.5e-07");
  EXPECT_EQ(number_text(0), "0");
  EXPECT_EQ(number_text(-0.0), "0");
  EXPECT_EQ(number_text(7), "7");
  EXPECT_EQ(number_text(999999999), "999999999");
  EXPECT_EQ(number_text(std::nan("")), "undefined");
  EXPECT_EQ(number_text(INFINITY), "undefined");
}

TEST(NumberText, WritesKeysAsWords) {
  EXPECT_EQ(words("discharge_time"), "discharge time");
  EXPECT_EQ(words("tilt.slide_angle"), "slide angle (tilt)");
  EXPECT_EQ(words("materials.ice.young_modulus"), "materials.ice.young modulus");
}

TEST(NumberText, UncertaintyDecidesTheDigits) {
  EXPECT_EQ(measured_text(11.4321, 1.2345), "11.4 ± 1.2");
  EXPECT_EQ(measured_text(-3.1012, 0.1299), "-3.10 ± 0.13");
  EXPECT_EQ(measured_text(1234.5, 412), "1230 ± 410");
  EXPECT_EQ(measured_text(0.25, 0.0996), "0.25 ± 0.10");
  EXPECT_EQ(measured_text(1.2341e-7, 5.6e-9), "(1.234 ± 0.056)e-07");
  EXPECT_EQ(measured_text(2.5e12, 3e10), "(2.500 ± 0.030)e+12");
  EXPECT_EQ(measured_text(-0.001, 1), "0.0 ± 1.0");
  EXPECT_EQ(measured_text(0.01449865321, 6.4e-9), "0.0144987 ± 6.4e-09");
  EXPECT_EQ(measured_text(5.12345, 0), "5.123");
  EXPECT_EQ(measured_text(5.12345, std::nan("")), "5.123");
  EXPECT_EQ(measured_text(std::nan(""), 1), "undefined");
}

// What is printed is the number to within half of its last digit, and never longer than readable.
TEST(NumberText, IsTheNumberRounded) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> exponent(-14, 14), mantissa(-10, 10);
  std::uniform_int_distribution<int> digit_count(1, 6);
  for (int i = 0; i < 20000; ++i) {
    const double value = mantissa(random) * std::pow(10, exponent(random));
    const int digits = digit_count(random);
    const std::string text = number_text(value, digits);
    EXPECT_NEAR(std::stod(text), value, 0.5001 * std::pow(10, 1 - digits) * std::abs(value))
        << text;
    EXPECT_LE(text.size(), 17U) << text;
    const double sd = std::abs(mantissa(random)) * std::pow(10, exponent(random));
    const std::string both = measured_text(value, sd);
    EXPECT_EQ(both.find("-0 "), both.npos);
    const std::size_t mark = both.find(" ± ");
    ASSERT_NE(mark, both.npos) << both;
    const bool power = both[0] == '(';
    const double unit = power ? std::stod("1" + both.substr(both.find(')') + 1)) : 1;
    const double shown = unit * std::stod(both.substr(power ? 1 : 0)),
                 shown_sd = unit * std::stod(both.substr(mark + 4));
    EXPECT_NEAR(shown_sd, sd, 0.0501 * sd + 1e-15 * std::abs(value)) << both;
    EXPECT_NEAR(shown, value, 0.0501 * sd + 5.01e-6 * std::abs(value)) << both;
  }
}

TEST(NumberText, ShortensNumbersOfToml) {
  EXPECT_EQ(shortest_numbers("a = 0.29999999999999999\nb = [ 0.10000000000000001, 2, 1.5 ]"),
            "a = 0.3\nb = [ 0.1, 2, 1.5 ]");
  EXPECT_EQ(shortest_numbers("c = 9.9999999999999995e-08"), "c = 1e-07");
  EXPECT_EQ(shortest_numbers("n = \"0.29999999999999999 \\\" 0.29999999999999999\" # x"),
            "n = \"0.29999999999999999 \\\" 0.29999999999999999\" # x");
  EXPECT_EQ(shortest_numbers("v1.0000000000000001 = 1979-05-27T07:32:00Z"),
            "v1.0000000000000001 = 1979-05-27T07:32:00Z");
  EXPECT_EQ(shortest_numbers("x = -3.0000000000000000\ny = 1_000.5"), "x = -3.0\ny = 1_000.5");
}

}  // namespace
}  // namespace firn
