// Motion tables from CSV files.
#include "experiments/case_reader/model/motion_csv.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>

#include "experiments/case/case.h"
#include "experiments/case_reader/read_case.h"
#include "tests/support/error_of.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kMotionCase = R"([case]
duration = "1 s"
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "2 MPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.2
[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
[[particles]]
shape = "cube"
position = "0 0 10 m"
[[boundaries]]
name = "plate"
kind = "box"
material = "ice"
size = "20 20 20 mm"
[[boundaries.motions]]
kind = "translation_table"
direction = [0, 0, 1]
file = "x.csv"
)";

class MotionCsvTest : public ResultsFolder {
 protected:
  Case read(const std::string& csv, const std::vector<Override>& overrides = {}) const {
    std::ofstream(path("x.csv"), std::ios::binary) << csv;
    return read_case_text(kMotionCase, "c.toml", path(""), overrides);
  }
  const Motion& motion(const Case& c) const { return c.model.boundaries[0].motions[0]; }
  // Without the folder's name.
  std::string error_of(const std::string& csv, const std::vector<Override>& overrides = {}) const {
    std::string text = test::error_if_any([&] { read(csv, overrides); });
    for (std::size_t at = 0; (at = text.find(path(""))) != text.npos;)
      text.erase(at, path("").size());
    return text;
  }
};

TEST_F(MotionCsvTest, ReadsUnitsQuotesCommentsAndOtherColumns) {
  const Case c = read(
      "\xef\xbb\xbf# logger 7\r\ntime [ms],note,\"way (mm)\"\r\n0,\"a, b\",1\r\n\r\n"
      "# pause\r\n10,,2.5e0\r\n+30,x,-4\r\n");
  EXPECT_THAT(motion(c).times, ElementsAre(0, 0.01, 0.03));
  EXPECT_THAT(motion(c).positions, ElementsAre(0.001, 0.0025, -0.004));
  EXPECT_THAT(motion(read("way [in];time [s]\n0;0\n1;1\n")).positions, ElementsAre(0, 0.0254));
  const std::string turning =
      "[{ kind = \"rotation_table\", axis = [0, 0, 1], file = \"x.csv\", time_column = \"t\", "
      "position_column = \"angle\" }]";
  const Case turned =
      read("t [s],angle [deg]\n0,0\n1,90\n", {{"boundaries.plate.motions", turning}});
  EXPECT_THAT(motion(turned).positions,
              ElementsAre(0, testing::DoubleNear(std::numbers::pi / 2, 1e-12)));
}

// As spreadsheets and loggers write it where the decimal mark is a comma.
TEST_F(MotionCsvTest, ReadsDecimalCommasBetweenSemicolonsAndTabs) {
  for (const std::string text :
       {"time [s];way [mm]\r\n0,0;0\r\n0,5;-1,25e1\r\n1;+3,0\r\n",
        "\xef\xbb\xbftime [s]\tway [mm]\n0,0\t0\n0,5\t-12,5\n1\t3,0\n",
        "\ntime [s];way [mm];;\n0,0;0;;;\n0,5;-12,5;;;\n1;3,0;;\n",
        "time [s];\"way [mm]\";note, by hand\n0,0;0;a, b\n0,5;-12,5;\n1;3,0;\n",
        "\"time [s]\",\t\"way [mm]\"\n0,\t0\n0.5,\t-12.5\n1,\t3.0\n",
        "\"note; by hand\",time [s],way [mm]\na,0,0\nb,0.5,-12.5\n,1,3.0\n"}) {
    SCOPED_TRACE(text);
    EXPECT_EQ(error_of(text), "");
    const Case c = read(text);
    EXPECT_THAT(motion(c).times, ElementsAre(0, 0.5, 1));
    EXPECT_THAT(motion(c).positions, ElementsAre(0, -0.0125, 0.003));
  }
  const std::string head = "time [s];way [mm]\n";
  EXPECT_EQ(error_of(head + "0;0\n1;1.234,5\n"),
            "x.csv:3: way: is \"1.234,5\"; expected a finite number, such as 1.5 or 1,5");
  EXPECT_EQ(error_of(head + "0;0\n1;1,234,5\n"),
            "x.csv:3: way: is \"1,234,5\"; expected a finite number, such as 1.5 or 1,5");
  EXPECT_EQ(error_of(head + "0;2.5\n1;1,234\n"),
            "x.csv:3: way: has a decimal comma here and a decimal point in line 2; expected one of "
            "the two");
}

TEST_F(MotionCsvTest, ResolvedCaseHoldsTheTable) {
  const Case c = read("time [s],way [mm]\n0,0\n0.5,3\n");
  std::filesystem::remove(path("x.csv"));
  const Case again = read_case_text(c.resolved, "again.toml", "/");
  EXPECT_EQ(again.resolved, c.resolved);
  EXPECT_EQ(motion(again).positions, motion(c).positions);
}

TEST_F(MotionCsvTest, SaysWhereWhatIsWrong) {
  const std::string head = "time [s],way [mm]\n";
  const auto error = [&](const std::string& rows) { return error_of(head + rows); };
  EXPECT_EQ(error("0,0\n1,nan\n"),
            "x.csv:3: way: is \"nan\"; expected a finite number, such as 1.5");
  EXPECT_EQ(error("0,0\n1,\n"), "x.csv:3: way: is \"\"; expected a finite number, such as 1.5");
  EXPECT_EQ(error("0,0\n1e999,1\n"),
            "x.csv:3: time: is \"1e999\"; expected a finite number, such as 1.5");
  EXPECT_EQ(error("0,0\n1,1\n\n1,2\n"),
            "x.csv:5: time: go from 1 s to 1 s; expected each later than the one before");
  EXPECT_EQ(error("1,0\n2,1\n"),
            "x.csv:2: time: begin at 1 s; expected 0, the start of the motion");
  EXPECT_EQ(error("0,0\n1,2,3\n"),
            "x.csv:3: CSV: has 3 fields; expected 2, as in the header, line 1");
  EXPECT_EQ(error("0,00,0,00\n"),
            "x.csv:2: CSV: has 4 fields; expected 2, as in the header, line 1; numbers with a "
            "decimal comma need semicolons or tabs between them");
  EXPECT_EQ(error_of("Logger 7\n" + head + "0,0\n"),
            "x.csv:2: CSV: has 2 fields; expected 1, as in the header, line 1; lines above the "
            "header must begin with #");
  EXPECT_THAT(error("0,0\n1e-6,1\n"), HasSubstr("x.csv:3: way: jump from 0 to 0.001 m within"));
  EXPECT_THAT(error("0,0\n"), HasSubstr("x.csv:2: way: has 1 values for 1 times"));
  EXPECT_THAT(error("0,0\n1,\"2\n"), HasSubstr("x.csv:3: CSV: "));
  EXPECT_THAT(
      error_of("time,way [mm]\n0,0\n"),
      HasSubstr("x.csv:1: time: names no unit; expected one in brackets, such as \"time [s]\""));
  EXPECT_THAT(error_of("time [s],way [kg]\n0,0\n"), HasSubstr("x.csv:1: way: is in \"kg\": "));
  EXPECT_THAT(
      error_of("time [s],height [mm]\n0,0\n"),
      HasSubstr("x.csv:1: way: no such column; the header has \"time\", \"height\"; expected"));
  EXPECT_THAT(error_of("way [mm],way [mm],time [s]\n0,0,0\n"), HasSubstr("heads two columns"));
  EXPECT_EQ(error_of(""), "x.csv:1: CSV: is empty; expected a header and rows");
  EXPECT_THAT(error_of(head, {{"boundaries.plate.motions.0.file", "y.csv"}}),
              HasSubstr("motions.0.file: \"y.csv\" is not a file; expected a CSV file"));
}

TEST_F(MotionCsvTest, FindsAGapInASeries) {
  std::string rows = "time [s],way [mm]\n";
  for (int i = 0; i < 30; ++i) rows += fmt::format("{},0\n", 0.01 * i + (i > 20 ? 1 : 0));
  EXPECT_THAT(error_of(rows), HasSubstr("x.csv:23: time: have a gap from 0.2 s to 1.21 s"));
}

}  // namespace
}  // namespace firn
