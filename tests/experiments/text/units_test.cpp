#include "experiments/text/units.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/support/error_of.h"

namespace firn {
namespace {

struct Example {
  const char* text;
  Dimension dimension;
  double si;
};

TEST(Units, ReadTheEverydayOnes) {
  const double pi = std::numbers::pi;
  const std::vector<Example> examples = {
      {"2.4 in", dimension::length, 2.4 * 0.0254},
      {"13.716 mm", dimension::length, 0.013716},
      {"0.5mm", dimension::length, 0.0005},
      {"40 um", dimension::length, 40e-6},
      {"40 \u00b5m", dimension::length, 40e-6},
      {"40 \u03bcm", dimension::length, 40e-6},
      {"1 ft", dimension::length, 0.3048},
      {"-3 dam", dimension::length, -30},
      {"1 ms", dimension::time, 1e-3},
      {"2 min", dimension::time, 120},
      {"1.5 h", dimension::time, 5400},
      {"13.7 g", dimension::mass, 0.0137},
      {"1 lb", dimension::mass, 0.45359237},
      {"916.7 kg/m^3", dimension::density, 916.7},
      {"0.01 GPa", dimension::pressure, 1e7},
      {"1 psi", dimension::pressure, 6894.757293168361},
      {"1e6 N/m", dimension::stiffness, 1e6},
      {"1 lbf/in", dimension::stiffness, 4.4482216152605 / 0.0254},
      {"1044 N", dimension::force, 1044},
      {"1e-6 J", dimension::energy, 1e-6},
      {"1 N m", dimension::energy, 1},
      {"1 N*m", dimension::energy, 1},
      {"50.8 mm/min", dimension::velocity, 50.8e-3 / 60},
      {"+9.81 m/s^2", dimension::acceleration, 9.81},
      {"9.81 m s^-2", dimension::acceleration, 9.81},
      {"9.81 m/(s*s)", dimension::acceleration, 9.81},
      {"9.81 m/s/s", dimension::acceleration, 9.81},
      {"9.81 m/s2", dimension::acceleration, 9.81},
      {"4 rad/s", dimension::angular_velocity, 4},
      {"30 rpm", dimension::angular_velocity, pi},
      {"180 deg", dimension::angle, pi},
      {"180 °", dimension::angle, pi},
      {"105 mL", dimension::volume, 105e-6},
      {"2 1/s", {0, 0, -1, 0}, 2},
      {"263.15 K", dimension::temperature, 263.15},
      {"-10 degC", dimension::temperature, 263.15},
      {"-10 °C", dimension::temperature, 263.15},
      {"14 degF", dimension::temperature, 263.15},
  };
  for (const Example& e : examples) {
    EXPECT_NEAR(parse_quantity(e.text, e.dimension), e.si, 1e-15 * std::abs(e.si)) << e.text;
  }
}

TEST(Units, DivisionTakesTheNextSymbolOnly) {
  // kg / m * s^2
  EXPECT_EQ(parse_unit("kg/m s^2").dimension, (Dimension{-1, 1, 2, 0}));
  EXPECT_EQ(parse_unit("kg/(m s^2)").dimension, dimension::pressure);
}

TEST(Units, WholeSymbolsComeBeforePrefixes) {
  EXPECT_EQ(parse_unit("min").dimension, dimension::time);   // not milli-inch
  EXPECT_EQ(parse_unit("ft").dimension, dimension::length);  // not femto-tonne
  EXPECT_EQ(parse_unit("d").dimension, dimension::time);
  EXPECT_DOUBLE_EQ(parse_unit("dm").factor, 0.1);
}

TEST(Units, VectorsShareOneUnit) {
  EXPECT_TRUE(parse_vector("1 -2.5 3e1 mm", dimension::length).isApprox(Vec3(1e-3, -2.5e-3, 0.03)));
  EXPECT_EQ(parse_vector("0 0 -9.81 m/s^2", dimension::acceleration), Vec3(0, 0, -9.81));
}

// Superscripts and dots are read as ^, signs and spaces: any unit means the same in both spellings.
TEST(Units, TypesetOnesAreTheSame) {
  EXPECT_EQ(parse_quantity("14.9 cm\u00b3", dimension::volume),
            parse_quantity("14.9 cm^3", dimension::volume));
  EXPECT_EQ(parse_quantity("9.81 m\u00b7s\u207b\u00b2", dimension::acceleration),
            parse_quantity("9.81 m s^-2", dimension::acceleration));
  EXPECT_EQ(plain_unit("kg/m\u00b3"), "kg/m^3");
  EXPECT_EQ(plain_unit("N\u22c5m"), "N m");
  EXPECT_EQ(plain_unit("m^\u22122"), "m^-2");
  for (const char* plain : {"kg/m^3", "N m", "1/s", "\u00b5m", "\u00b0", "deg", "", "x"})
    EXPECT_EQ(plain_unit(plain), plain);
  const std::vector<std::string> symbols = {"m", "kg", "s", "mm", "N", "rad", "Pa", "\u00b5m"};
  const std::vector<std::string> digits = {"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                           "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
  std::mt19937 random(2);
  for (int i = 0; i < 500; ++i) {
    std::string plain, typeset;
    for (std::size_t count = 1 + random() % 3; count > 0; --count) {
      const std::string& symbol = symbols[random() % symbols.size()];
      const bool divided = random() % 3 == 0;
      if (!plain.empty()) {
        plain += divided ? "/" : " ";
        typeset += divided ? "/" : random() % 2 == 0 ? "\u00b7" : " ";
      }
      plain += symbol;
      typeset += symbol;
      if (random() % 2 == 0) continue;
      const bool negative = random() % 2 == 0;
      const std::string exponent = std::to_string(random() % 30);
      plain += (negative ? "^-" : "^") + exponent;
      if (negative) typeset += "\u207b";
      for (const char digit : exponent) typeset += digits[static_cast<std::size_t>(digit - '0')];
    }
    EXPECT_EQ(plain_unit(typeset), plain) << typeset;
    const Unit a = parse_unit(plain), b = parse_unit(typeset);
    EXPECT_EQ(a.factor, b.factor) << typeset;
    EXPECT_EQ(a.dimension, b.dimension) << typeset;
  }
  for (const char* wrong : {"\u00b2", "m^\u00b2", "m^2\u00b3", "\u207bm", "m\u207b"})
    EXPECT_THROW(parse_unit(wrong), InputError) << wrong;
}

TEST(Units, SiTextReadsBackToTheSameBits) {
  for (const double value : {0.1, 1.0 / 3, 60.96e-3, 1234.56789}) {
    for (const Dimension& d : {dimension::length, dimension::stiffness, dimension::density,
                               dimension::angular_velocity, dimension::energy}) {
      EXPECT_EQ(parse_quantity(si_text(value, d), d), value) << si_text(value, d);
    }
  }
}

TEST(Units, SayWhatIsWrong) {
  const auto length = [](const char* text) {
    return test::error_of([&] { parse_quantity(text, dimension::length); });
  };
  EXPECT_EQ(length("2.4"), "\"2.4\" has no unit; expected a length, such as \"2.4 in\"");
  EXPECT_EQ(length("2 kg"), "\"2 kg\" is a mass; expected a length, such as \"2.4 in\"");
  EXPECT_EQ(length("2 kg m/s"),
            "\"2 kg m/s\" is in units of kg m s^-1; expected a length, such as \"2.4 in\"");
  EXPECT_EQ(length("2 inc"),
            "\"2 inc\": unknown unit \"inc\" (nearest: in, inch, min); expected a length, such as "
            "\"2.4 in\"");
  EXPECT_EQ(length("two in"), "cannot read \"two in\"; expected a length, such as \"2.4 in\"");
  EXPECT_EQ(length(""), "cannot read \"\"; expected a length, such as \"2.4 in\"");
  EXPECT_EQ(length("inf m"), "\"inf m\" is not finite; expected a length, such as \"2.4 in\"");
  EXPECT_EQ(length("nan m"), "\"nan m\" is not finite; expected a length, such as \"2.4 in\"");
  EXPECT_EQ(length("1e999 m"), "\"1e999 m\" is not finite; expected a length, such as \"2.4 in\"");
  EXPECT_EQ(length("1e290 Tm^1"), "\"1e290 Tm^1\" is beyond 1000000 m; expected a length up to it");
  EXPECT_EQ(length("1e308 km"),
            "\"1e308 km\" is not finite; expected a length, such as \"2.4 in\"");
  EXPECT_EQ(length("1 2 3 m"),
            "\"1 2 3 m\" has too many numbers; expected a length, such as \"2.4 in\"");
  EXPECT_EQ(length("1 m^"),
            "\"1 m^\": cannot read \"m^\" as a unit; expected a length, such as \"2.4 in\"");
  EXPECT_EQ(length("1 (m"),
            "\"1 (m\": cannot read \"(m\" as a unit; expected a length, such as \"2.4 in\"");
  EXPECT_EQ(test::error_of([] { parse_quantity("4 1/s", dimension::angular_velocity); }),
            "\"4 1/s\" is a frequency; expected an angular velocity, such as \"4 rad/s\"");
  EXPECT_EQ(test::error_of([] { parse_quantity("916.7 kg/M^3", dimension::density); }),
            "\"916.7 kg/M^3\": unknown unit \"M\" (nearest: m, Mm, g); expected a density, such as "
            "\"916.7 kg/m^3\"");
  EXPECT_EQ(test::error_of([] { parse_vector("0 0 m", dimension::length); }),
            "cannot read \"0 0 m\"; expected three numbers and the unit of a length, such as "
            "\"0 0 0.2 m\"");
}

TEST(Units, NestingAndExponentsAreBounded) {
  const std::string deep = std::string(1000, '(') + "m" + std::string(1000, ')');
  EXPECT_THROW(parse_unit(deep), InputError);
  EXPECT_THROW(parse_unit("((m^90)^90)^90"), InputError);
  EXPECT_THROW(parse_unit("m^99999999999"), InputError);
}

TEST(Durations, AreShortAndInCommonUnits) {
  EXPECT_EQ(duration_text(7.31), "7.3 s");
  EXPECT_EQ(duration_text(47.2), "48 s");
  EXPECT_EQ(duration_text(725), "12 min 05 s");
  EXPECT_EQ(duration_text(12000), "3 h 20 min");
  EXPECT_EQ(duration_text(1e13), "undefined");
  EXPECT_EQ(estimated_duration_text(0), "0 s");
  EXPECT_EQ(estimated_duration_text(47.2), "48 s");
  EXPECT_EQ(estimated_duration_text(725), "12 min");
  EXPECT_EQ(estimated_duration_text(12000), "3.3 h");
  EXPECT_EQ(estimated_duration_text(std::nan("")), "undefined");
}

}  // namespace
}  // namespace firn
