#include "experiments/measurements/measurement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "firn/math.h"
#include "tests/support/error_of.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

using testing::HasSubstr;

const std::string kHead =
    "name = \"n\"\nresponse = \"r\"\nstatus = \"measured\"\nsource = \"bench\"\n";

std::string complaint(const std::string& text) {
  return test::error_of([&] { read_measurement_text(text, "m.toml"); });
}

TEST(Measurement, DrainedAngleOfReposeShipsWithItsAssumptionsNamed) {
  const Measurement m = read_measurement(std::string(FIRN_SOURCE_DIR) +
                                         "/cases/measurements/drained_angle_of_repose.toml");
  EXPECT_EQ(m.response, "angle_of_repose");
  EXPECT_EQ(m.value, 10);
  EXPECT_EQ(m.unit, "deg");
  EXPECT_EQ(m.repeats, 7);
  EXPECT_EQ(m.status, MeasurementStatus::published);
  EXPECT_EQ(m.scatter, ScatterKind::not_stated);
  EXPECT_NEAR(m.standard_uncertainty(), std::sqrt(2.0 * 2.0 / 7 + 0.6 * 0.6), 1e-12);
  EXPECT_THAT(m.sentence(),
              HasSubstr("10.00 ± 0.97 deg (n = 7; standard deviation 2 deg, ASSUMED:"));
}

TEST(Measurement, TakesAStandardDeviationAsItIs) {
  const Measurement m = read_measurement_text(kHead +
                                                  "value = \"3 N\"\nrepeats = 4\n[scatter]\n"
                                                  "kind = \"standard deviation\"\n"
                                                  "standard_deviation = \"0.5 N\"\n",
                                              "m.toml");
  EXPECT_DOUBLE_EQ(m.standard_uncertainty(), 0.25);
  EXPECT_TRUE(m.assumption.empty());
}

TEST(Measurement, EstimatesTheScatterFromARange) {
  // Tabulated d2: 1.128 (n = 2), 2.704 (7), 3.078 (10).
  EXPECT_NEAR(expected_range(2), 2 / std::sqrt(M_PI), 1e-9);
  EXPECT_NEAR(expected_range(7), 2.704, 5e-4);
  EXPECT_NEAR(expected_range(10), 3.078, 5e-4);
  const Measurement m =
      read_measurement_text(kHead +
                                "value = \"1044.0 N\"\nrepeats = 7\n[scatter]\nkind = \"range\"\n"
                                "minimum = \"898.5 N\"\nmaximum = \"1227.7 N\"\n",
                            "m.toml");
  EXPECT_NEAR(m.standard_deviation, (1227.7 - 898.5) / 2.704, 0.05);
}

TEST(Measurement, ComputesStatisticsOfGivenValues) {
  const Measurement m =
      read_measurement_text(kHead + "values = [\"9 deg\", \"10 deg\", \"12.5 deg\"]\n", "m.toml");
  EXPECT_DOUBLE_EQ(m.value, 10.5);
  EXPECT_EQ(m.repeats, 3);
  EXPECT_DOUBLE_EQ(m.standard_deviation, std::sqrt((2.25 + 0.25 + 4) / 2));
  EXPECT_EQ(m.minimum, 9);
  EXPECT_EQ(m.maximum, 12.5);
}

using MeasuredColumn = ResultsFolder;
TEST_F(MeasuredColumn, GivesTheRepeats) {
  const auto csv = [&](const std::string& text) { std::ofstream(path("angles.csv")) << text; };
  const auto with = [&](const std::string& keys) {
    return kHead + "values = { file = \"angles.csv\", " + keys + " }\n";
  };
  const auto read = [&](const std::string& keys) {
    return read_measurement_text(with(keys), path("m.toml"));
  };
  const auto refusal = [&](const std::string& keys) { return test::error_of([&] { read(keys); }); };
  EXPECT_THAT(refusal("column = \"angle\", unit = \"deg\""), HasSubstr("angles.csv"));
  csv("test;angle [deg];bounce\n1;9,5;0,31\n2;11;0,28\n3;12,5;0,31\n");
  const Measurement m = read("column = \"angle\", unit = \"deg\"");
  EXPECT_EQ(m.unit, "deg");
  EXPECT_NEAR(m.value, 11, 1e-12);
  EXPECT_NEAR(m.standard_deviation, 1.5, 1e-12);
  EXPECT_EQ(m.repeats, 3);
  EXPECT_NEAR(read("column = \"angle\", unit = \"rad\"").value, 11 * M_PI / 180, 1e-12);
  EXPECT_NEAR(read("column = \"bounce\", unit = \"1\"").value, 0.3, 1e-12);
  EXPECT_THAT(refusal("column = \"bounce\", unit = \"deg\""), HasSubstr("bounce"));
  EXPECT_THAT(refusal("column = \"angel\", unit = \"deg\""), HasSubstr("angel"));
  EXPECT_THAT(refusal("column = \"angle\""), HasSubstr("unit"));
  EXPECT_THAT(refusal("column = \"angle\", unit = \"deg\", rows = 3"), HasSubstr("rows"));
  csv("angle [deg]\n9\n");
  EXPECT_THAT(refusal("column = \"angle\", unit = \"deg\""), HasSubstr("at least two"));
}

TEST(Measurement, QualitativeOnesHaveAStatementAndNoNumber) {
  const std::string head =
      "name = \"n\"\nresponse = \"r\"\nstatus = \"qualitative\"\nsource = \"s\"\n";
  EXPECT_EQ(read_measurement_text(head + "statement = \"a cube falls\"\n", "m.toml").sentence(),
            "a cube falls");
  EXPECT_EQ(
      read_measurement_text(head + "statement = \"\"\"a\ncube\tfalls\"\"\"\n", "m.toml").sentence(),
      "a cube falls");
  EXPECT_THAT(complaint(head + "statement = \"a\"\nvalue = \"1 N\"\n"),
              HasSubstr("m.toml:6: value: does not go with the status \"qualitative\""));
}

TEST(Measurement, MistakesAreOneLineWithTheirPlace) {
  EXPECT_THAT(complaint(kHead + "value = \"ten\"\n"), HasSubstr("m.toml:5: value: \"ten\" is no"));
  EXPECT_THAT(complaint(kHead + "value = \"10 degg\"\n"), HasSubstr("m.toml:5: value: "));
  EXPECT_THAT(complaint(kHead + "value = \"10 deg\"\nrepeats = 7\n"), HasSubstr("scatter"));
  EXPECT_THAT(
      complaint(kHead + "value = \"10 deg\"\nrepeats = 7\n[scatter]\nkind = \"not stated\"\n"
                        "assumed_standard_deviation = \"2 deg\"\n"),
      HasSubstr("assumption"));
  EXPECT_THAT(
      complaint(kHead + "value = \"10 deg\"\nrepeats = 7\n[scatter]\nkind = \"not stated\"\n"
                        "assumed_standard_deviation = \"2 mm\"\nassumed_because = \"x\"\n"),
      HasSubstr("m.toml:9: scatter.assumed_standard_deviation: has the unit \"mm\""));
  EXPECT_THAT(complaint(kHead + "value = \"5 N\"\nrepeats = 7\n[scatter]\nkind = \"range\"\n"
                                "minimum = \"6 N\"\nmaximum = \"7 N\"\n"),
              HasSubstr("does not lie between"));
  EXPECT_THAT(complaint(kHead + "valeu = \"1 N\"\n"), HasSubstr("m.toml:5: valeu: "));
  EXPECT_THROW(read_measurement("no such file.toml"), InputError);
}

// Whatever stands in place of a quantity, or of a list of them: the message states what is there
// and how one is written.
TEST(Measurement, OtherValuesThanQuantitiesAreNamed) {
  struct Wrong {
    const char *text, *message;
  };
  for (const auto& [text, message] :
       {Wrong{"10", "is the bare number 10"}, Wrong{"10.5", "is the bare number 10.5"},
        Wrong{"true", "is true"}, Wrong{"[1, 2]", "is an array"}, Wrong{"{ a = 1 }", "is a table"},
        Wrong{"1979-05-27", "is a date or time"}, Wrong{"\"ten deg\"", "is not a quantity"}}) {
    const std::string refused = complaint(kHead + "value = " + text + "\nrepeats = 2\n");
    EXPECT_THAT(refused, HasSubstr("m.toml:5: value: ")) << text;
    EXPECT_THAT(refused, HasSubstr(message)) << text;
    EXPECT_THAT(refused, HasSubstr("expected a number and its unit, such as \"10 deg\"")) << text;
  }
  for (const char* text : {"10", "\"10 deg\"", "true", "1979-05-27"}) {
    const std::string refused = complaint(kHead + "values = " + text + "\n");
    EXPECT_THAT(refused, HasSubstr("m.toml:5: values: is ")) << text;
    EXPECT_THAT(refused, HasSubstr("expected a list such as [\"9 deg\", \"11 deg\"]")) << text;
  }
  for (const char* text : {"[10, 11]", "[\"10 deg\", 11.5]", "[true]"}) {
    const std::string refused = complaint(kHead + "values = " + text + "\n");
    EXPECT_THAT(refused, HasSubstr("m.toml:5: values: holds ")) << text;
    EXPECT_THAT(refused, HasSubstr("expected quantities, such as")) << text;
  }
}

TEST(Measurement, AnEntryOfAListIsReportedAtItsLine) {
  EXPECT_THAT(complaint(kHead + "values = [\n\"9 deg\",\n\"10 dge\",\n]\n"),
              HasSubstr("m.toml:7: values: unknown unit \"dge\""));
  EXPECT_THAT(complaint(kHead + "values = [\n\"9 deg\",\n\"10 deg\",\n\"1 rad\",\n]\n"),
              HasSubstr("m.toml:8: values: has the units \"deg\" and \"rad\""));
}

// A superscript is the same unit.
TEST(Measurement, UnitsHaveOneSpelling) {
  const Measurement m = read_measurement_text(
      kHead + "values = [\"9 cm\u00b3\", \"10 cm^3\", \"12.5 cm\u00b3\"]\n", "m.toml");
  EXPECT_EQ(m.unit, "cm^3");
  EXPECT_EQ(m.repeats, 3);
}

TEST(Measurement, FilesOfAnotherKindAreNamed) {
  for (const char* table : {"case", "study", "suite", "sweep", "optimization"})
    EXPECT_THAT(complaint(std::string("# about it\n[") + table + "]\nname = \"n\"\n"),
                HasSubstr(std::string("m.toml:2: ") + table + ": is a file for firn "));
}

}  // namespace
}  // namespace firn
