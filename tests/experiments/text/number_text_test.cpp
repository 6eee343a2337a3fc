#include "experiments/text/number_text.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "experiments/text/units.h"

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

TEST(NumberText, RoundingErrorsOfZeroAreZero) {
  EXPECT_EQ(without_rounding_error(-3.6e-25, 1e-9), 0);
  EXPECT_EQ(without_rounding_error(3.6e-25, -1), 0);
  EXPECT_EQ(without_rounding_error(2e-6, 1), 2e-6);
  EXPECT_EQ(without_rounding_error(-3.6e-25, 1e-25),
            -3.6e-25);  // as large as what it is held against
  EXPECT_EQ(without_rounding_error(-3.6e-25, 0), -3.6e-25);
  EXPECT_TRUE(std::isnan(without_rounding_error(std::nan(""), 1)));
  EXPECT_EQ(number_text(without_rounding_error(-3.6e-25, 1)), "0");
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

// What is below the resolution of its unit is 0; anything else keeps all of its digits.
TEST(NumberText, RoundingErrorIsZero) {
  struct Member {
    const char* unit;
    double least;  // in the unit
  };
  const Member members[] = {{"rad", 1e-9},    {"deg", 1e-9 * 180 / M_PI},
                            {"mrad", 1e-6},   {"m", 1e-12},
                            {"mm", 1e-9},     {"in", 1e-12 / 0.0254},
                            {"m/s", 1e-12},   {"mm/s", 1e-9},
                            {"rad/s", 1e-9},  {"rpm", 1e-9 * 30 / M_PI},
                            {"m/s^2", 1e-12}, {"m/s\u00b2", 1e-12},
                            {"s", 1e-12},     {"N", 1e-15},
                            {"N m", 1e-16},   {"N\u00b7m", 1e-16},
                            {"J", 1e-20},     {"kg", 1e-20},
                            {"g", 1e-17},     {"1", 1e-15},
                            {"", 1e-15}};
  std::mt19937 random(5);
  std::uniform_real_distribution<double> decades(0.01, 20);
  for (const Member& m : members) {
    for (int i = 0; i < 200; ++i) {
      const double sign = i % 2 == 0 ? 1 : -1;
      const double below = sign * m.least * std::pow(10, -decades(random));
      const double above = sign * m.least * std::pow(10, decades(random));
      EXPECT_EQ(resolved(below, m.unit), 0) << below << " " << m.unit;
      EXPECT_EQ(resolved(above, m.unit), above) << above << " " << m.unit;
      EXPECT_EQ(measured_text(below, 0, m.unit), "0" + unit_suffix(m.unit));
      EXPECT_EQ(measured_text(below, below / 3, m.unit), "0" + unit_suffix(m.unit));
      EXPECT_EQ(measured_text(above, std::abs(below), m.unit),
                number_text(above) + unit_suffix(m.unit));
    }
  }
  // Where it is not known what a value can mean.
  for (const char* unit : {"1/s", "Pa m^0.5", "widgets", "%", "kg/m^3"}) {
    EXPECT_EQ(resolution(unit), 0) << unit;
    EXPECT_EQ(resolved(1e-30, unit), 1e-30) << unit;
  }
  EXPECT_TRUE(std::isnan(resolved(std::nan(""), "m")));
  EXPECT_EQ(resolved(-INFINITY, "m"), -INFINITY);
}

// One spelling, whichever was read.
TEST(NumberText, UnitsHaveOneSpelling) {
  EXPECT_EQ(unit_text("cm\u00b3"), "cm^3");
  EXPECT_EQ(unit_text("cm^3"), "cm^3");
  EXPECT_EQ(unit_suffix("kg/m\u00b3"), " kg/m^3");
  EXPECT_EQ(axis_label("rate", "s\u207b\u00b9"), "rate / s^-1");
  EXPECT_EQ(unit_text("1"), "");
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
