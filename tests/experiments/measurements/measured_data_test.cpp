#include "experiments/measurements/measured_data.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "experiments/measurements/measurement.h"
#include "tests/support/error_of.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;

class MeasuredDataTest : public ResultsFolder {
 protected:
  Measurement read(const std::string& data) const {
    return read_measurement_text(
        "name = \"n\"\nstatus = \"qualitative\"\nstatement = \"s\"\nsource = \"s\"\n"
        "[[criteria]]\nstatement = \"s\"\nlhs = \"x\"\nrhs = \"1\"\nrationale = \"b\"\n[data]\n" +
            data,
        path("m.toml"));
  }
  std::string complaint(const std::string& data) const {
    return test::error_of([&] { read(data); });
  }
  void csv(const std::string& text) const { std::ofstream(path("a.csv")) << text; }
};

constexpr const char* kValues =
    "file = \"a.csv\"\nkind = \"values\"\ncolumn = \"force\"\nunit = \"N\"\nresponse = \"x\"\n";
constexpr const char* kClasses = "file = \"a.csv\"\nkind = \"classes\"\nresponse = \"x\"\n";
constexpr const char* kTrace =
    "file = \"a.csv\"\nkind = \"trace\"\ncolumn = \"force\"\nunit = \"N\"\nresponse = \"x\"\n"
    "threshold = \"10 N\"\ndead_time = \"5 ms\"\n";

TEST_F(MeasuredDataTest, MayBeMissing) {
  EXPECT_FALSE(read(kValues).data->present);
  EXPECT_FALSE(read(kClasses).data->present);
  EXPECT_FALSE(read(kTrace).data->present);
}

// The trace of a load cell: a separate status, no words needed.
TEST_F(MeasuredDataTest, RecordedOnesNeedDataAndNoStatement) {
  const auto recorded = [&](const std::string& text) {
    return read_measurement_text("name = \"n\"\nstatus = \"recorded\"\nsource = \"s\"\n" + text,
                                 path("m.toml"));
  };
  const auto complaint = [&](const std::string& text) {
    return test::error_of([&] { recorded(text); });
  };
  const std::string data = "[data]\n" + std::string(kTrace);
  EXPECT_THAT(complaint(data), HasSubstr("a.csv does not exist; expected what was recorded"));
  csv("time [s],force [N]\n0,0\n0.001,20\n0.002,0\n0.003,0\n");
  const Measurement m = recorded(data);
  EXPECT_EQ(m.statement, "recorded in a.csv");
  EXPECT_STREQ(status_text(m), "recorded");
  EXPECT_THAT(m.data->values, ElementsAre(20));
  EXPECT_EQ(recorded("statement = \"a press\"\n" + data).statement, "a press");
  EXPECT_THAT(complaint(""), HasSubstr("data: is missing; expected a table [data]"));
  EXPECT_THAT(complaint("value = \"1 N\"\n" + data), HasSubstr("value: does not go with"));
}

TEST_F(MeasuredDataTest, ReadsValuesInTheResponsesUnit) {
  csv("# by hand\nevent,force [kN]\n1,0.5\n2,1.25\n");
  EXPECT_THAT(read(kValues).data->values, ElementsAre(500, 1250));
}

TEST_F(MeasuredDataTest, KeepsApartWhatIsOnlyALowerBound) {
  csv("force [kN],open\n0.5,0\n1.25,1\n2,0\n");
  const Measurement m = read(std::string(kValues) + "right_censored = \"open\"\n");
  EXPECT_THAT(m.data->values, ElementsAre(500, 2000));
  EXPECT_THAT(m.data->right_censored, ElementsAre(1250));
  const Measurement old = read(std::string(kValues) + "at_least = \"open\"\n");  // its first name
  EXPECT_EQ(old.data->right_censored, m.data->right_censored);
  EXPECT_THAT(complaint(std::string(kTrace) + "right_censored = \"open\"\n"),
              HasSubstr("does not go with"));
  EXPECT_THAT(complaint(std::string(kValues) + "right_censored = \"shut\"\n"), HasSubstr("shut"));
}

TEST_F(MeasuredDataTest, ReadsCountsByClass) {
  csv("class,count\nleft,3\nright,9\n");
  const Measurement m = read(kClasses);
  EXPECT_THAT(m.data->classes, ElementsAre("left", "right"));
  EXPECT_THAT(m.data->counts, ElementsAre(3, 9));
}

constexpr const char* kCurve =
    "file = \"a.csv\"\nkind = \"curve\"\nresponse = \"press\"\nx = \"way\"\nx_unit = \"m\"\n"
    "y = \"force\"\nunit = \"N\"\n";

TEST_F(MeasuredDataTest, ReadsCurvesByRepeat) {
  EXPECT_FALSE(read(kCurve).data->present);
  csv("test,way [mm],force [kN]\na,0,0\na,1,0.5\na,2,0.75\nb,0,0\nb,1,1\nb,3,2\n");
  const Measurement m = read(std::string(kCurve) + "repeat = \"test\"\nalign = \"onset\"\n");
  ASSERT_EQ(m.data->repeats.size(), 2U);
  EXPECT_THAT(m.data->repeats[0].y, ElementsAre(0, 500, 750));
  EXPECT_NEAR(m.data->repeats[1].x[2], 3e-3, 1e-12);
  EXPECT_EQ(m.data->align, MeasuredData::Alignment::onset);
  EXPECT_EQ(read(kCurve).data->repeats.size(), 1U);
  EXPECT_THAT(complaint(std::string(kCurve) + "cfc = \"100 Hz\"\n"), HasSubstr("over a time"));
  EXPECT_THAT(complaint(std::string(kCurve) + "threshold = \"1 N\"\n"), HasSubstr("does not go"));
  csv("way [mm],force [kN]\n0,0\n1,1\n");
  EXPECT_THAT(complaint(kCurve), HasSubstr("expected three at least"));
}

TEST_F(MeasuredDataTest, TakesPeaksOfATrace) {
  // Two half sines of 1 ms and 100 and 40 N, 20 ms apart, every 0.05 ms, with ripple below.
  std::string text = "time [ms],force [N]\n";
  for (int i = 0; i <= 1000; ++i) {
    const double t = 0.05 * i;  // ms
    double f = std::sin(40 * t);
    if (t > 10 && t < 11) f += 100 * std::sin(std::numbers::pi * (t - 10));
    if (t > 30 && t < 31) f -= 40 * std::sin(std::numbers::pi * (t - 30));
    text += std::to_string(t) + "," + std::to_string(f) + "\n";
  }
  csv(text);
  const std::vector<double> raw = read(kTrace).data->values;
  ASSERT_EQ(raw.size(), 2u);
  EXPECT_NEAR(raw[0], 100, 1.1);
  EXPECT_NEAR(raw[1], -40, 1.1);
  // A class of 1000 Hz passes a half sine of 1 ms (mostly below 1 kHz) nearly whole, one of 100 Hz
  // does not.
  EXPECT_NEAR(read(std::string(kTrace) + "cfc = \"1000 Hz\"\n").data->values.at(0), 100, 6);
  EXPECT_LT(read(std::string(kTrace) + "cfc = \"100 Hz\"\n").data->values.at(0), 60);
  EXPECT_THAT(complaint(std::string(kTrace) + "cfc = \"10000 Hz\"\n"), HasSubstr("a tenth"));
}

// A recorder that was not set to zero, and is wired the other way round.
TEST_F(MeasuredDataTest, TaresAndInvertsTracesAndCurves) {
  csv("time [ms],force [kN]\n0,0.002\n1,0.004\n2,0.003\n3,-0.097\n4,0.003\n5,0.003\n");
  const std::string trace = kTrace;
  EXPECT_NEAR(read(trace + "tare = \"3 N\"\n").data->values.at(0), -100, 1e-9);
  EXPECT_NEAR(read(trace + "tare = \"3 N\"\ninvert = true\n").data->values.at(0), 100, 1e-9);
  // The mean of the first three samples.
  const Measurement m = read(trace + "tare_over = \"2 ms\"\ninvert = true\n");
  EXPECT_NEAR(m.data->values.at(0), 100, 1e-9);
  EXPECT_NEAR(m.data->samples.at(1), -1, 1e-9);
  EXPECT_THAT(complaint(trace + "tare = \"3 N\"\ntare_over = \"2 ms\"\n"),
              HasSubstr("tare_over: does not go with tare"));
  EXPECT_THAT(complaint(trace + "tare_over = \"5 ms\"\n"), HasSubstr("as long as the data"));
  EXPECT_THAT(complaint(trace + "tare_over = \"-1 ms\"\n"), HasSubstr("tare_over"));
  EXPECT_THAT(complaint(trace + "tare = \"3 mm\"\n"), HasSubstr("tare"));
  EXPECT_THAT(complaint(std::string(kValues) + "invert = true\n"), HasSubstr("does not go with"));

  // Each repeat has its own zero; x runs down in the second.
  csv("test,way [mm],force [kN]\na,0,0.5\na,1,0.7\na,2,-0.4\nb,3,2\nb,1,1.2\nb,0,1\n");
  const std::string curve = std::string(kCurve) + "repeat = \"test\"\ninvert = true\n";
  const Measurement c = read(curve + "tare_over = \"1 mm\"\n");
  EXPECT_THAT(c.data->repeats.at(0).y,
              ElementsAre(DoubleNear(100, 1e-9), DoubleNear(-100, 1e-9), DoubleNear(1000, 1e-9)));
  EXPECT_NEAR(c.data->repeats.at(1).y.at(0), -900, 1e-9);
  EXPECT_NEAR(read(curve + "tare = \"0.5 kN\"\n").data->repeats.at(0).y.at(2), 900, 1e-9);
  EXPECT_THAT(complaint(curve + "tare_over = \"2 mm\"\n"), HasSubstr("shorter than 0.002"));

  // The sum of two samples is beyond all numbers.
  csv("test,way [mm],force [N]\na,0,1e308\na,1,1e308\na,2,1\n");
  EXPECT_THAT(complaint(curve + "tare_over = \"1 mm\"\n"), HasSubstr("too large"));
}

TEST_F(MeasuredDataTest, PeaksAreOneAStretch) {
  const std::vector<double> t = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  const std::vector<double> x = {0, 5, 6, 0, 7, 0, 0, 0, -9, 8};
  EXPECT_THAT(peaks(t, x, 4, 0), ElementsAre(6, 7, -9));
  EXPECT_THAT(peaks(t, x, 4, 2), ElementsAre(7, -9));
  EXPECT_THAT(peaks(t, x, 4, 10), ElementsAre(-9));
  EXPECT_THAT(peaks(t, x, 20, 0), ElementsAre());
}

TEST_F(MeasuredDataTest, MistakesHaveTheirPlace) {
  csv("force [N]\n1\nmany\n");
  EXPECT_THAT(complaint(kValues), HasSubstr("a.csv:3: force: is \"many\""));
  csv("force [kN]\n1\n1e306\n");
  EXPECT_THAT(complaint(kValues), HasSubstr("a.csv:3: force: is \"1e306\""));
  csv("force [N]\n1\n-1e307\n");
  std::string in_millinewton = kValues;
  in_millinewton.replace(in_millinewton.find("\"N\""), 3, "\"mN\"");
  EXPECT_THAT(complaint(in_millinewton), HasSubstr("finite in the unit of the measurement"));
  csv("force [mm]\n1\n");
  EXPECT_THAT(complaint(kValues), HasSubstr("a.csv:1: force: is in \"mm\""));
  csv("weight [N]\n1\n");
  EXPECT_THAT(complaint(kValues), HasSubstr("no such column"));
  csv("force [N]\n");
  EXPECT_THAT(complaint(kValues), HasSubstr("a.csv:1: CSV: holds no value"));
  csv("force [N]\n1\n\"2\n3\n");
  EXPECT_THAT(complaint(kValues), HasSubstr("CSV: a quote does not close, or is inside a field"));
  csv("class,count\na,1.5\n");
  EXPECT_THAT(complaint(kClasses), HasSubstr("expected a whole number"));
  csv("class,count\na,0\n");
  EXPECT_THAT(complaint(kClasses), HasSubstr("counts nothing"));
  csv("time [s],force [N]\n0,1\n0,2\n1,3\n");
  EXPECT_THAT(complaint(kTrace), HasSubstr("a.csv:3: time: does not grow"));
  csv("time [s],force [N]\n0,1\n1,2\n");
  EXPECT_THAT(complaint(kTrace), HasSubstr("a.csv:3: CSV: holds 2 samples"));
  csv("time [s],force [N]\n0,1\n1,2\n1.0000000001,3\n2,3\n");
  EXPECT_THAT(complaint(kTrace), HasSubstr("a.csv:4: time: two times are only 1.0000"));
  csv("time [s],force [N]\n0,1\n1,2\n2,3\n");
  EXPECT_THAT(complaint(kTrace), HasSubstr("above the threshold"));
  EXPECT_THAT(complaint(std::string(kClasses) + "cfc = \"1 Hz\"\n"), HasSubstr("does not go with"));
}

TEST(Claims, MistakesAreOneLineWithTheirPlace) {
  const std::string head =
      "name = \"n\"\nstatus = \"qualitative\"\nstatement = \"s\"\nsource = \"s\"\n[[criteria]]\n";
  const auto complaint = [&](const std::string& text) {
    return test::error_if_any([&] { read_measurement_text(head + text, "m.toml"); });
  };
  const std::string whole =
      "statement = \"s\"\nlhs = \"a\"\nrhs = \"b\"\nrationale = \"c\"\nfactor = "
      "2\nobserved_once_in = 3\n";
  EXPECT_EQ(complaint(whole), "");
  EXPECT_THAT(complaint("statement = \"s\"\nlhs = \"a\"\nrhs = \"b\"\n"),
              HasSubstr("rationale: missing"));
  EXPECT_THAT(complaint("statement = \"\"\nlhs = \"a\"\nrhs = \"b\"\nrationale = \"c\"\n"),
              HasSubstr("m.toml:6: criteria.0.statement: is empty"));
  EXPECT_THAT(complaint("statement = \"s\"\nlhs = \"a\"\nrhs = \"b\"\nrationale = \"c\"\n"
                        "factor = 0\n"),
              HasSubstr("expected more than zero"));
}

}  // namespace
}  // namespace firn
