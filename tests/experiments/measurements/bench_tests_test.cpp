#include "experiments/measurements/bench_tests.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "experiments/case_reader/read_case.h"
#include "experiments/measurements/measurement.h"
#include "tests/support/bench_run.h"
#include "tests/support/error_of.h"
#include "tests/support/read_text.h"
#include "tests/support/replaced.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using testing::EndsWith;
using testing::HasSubstr;

constexpr const char* kTwoTests = R"([[tests]]
name = "tilt"
title = "one cube on a plate"
case = "tilt/case.toml"
informs = "friction"
setup = "30 min"
time_per_repeat = "3 min"
repeats = 10
rationale = "judgement"
[[tests.responses]]
name = "slip_angle"
measurement = "tilt.toml"
standard_deviation = "1.5 deg"
systematic_uncertainty = "0.3 deg"
rationale = "judgement"

[[tests]]
name = "weigh"
title = "what is left"
case = "tilt/case.toml"
informs = "little"
extends_test = "tilt"
setup = "0 min"
time_per_repeat = "90 s"
repeats = 1
rationale = "judgement"
[[tests.responses]]
name = "remaining_mass"
measurement = "tilt.toml"
standard_deviation = "0.02 kg"
rationale = "judgement"
)";

class BenchTests : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "tilt");
    std::ofstream(folder_ / "tilt/case.toml") << "\n";
    std::ofstream(folder_ / "tilt.toml") << "\n";
  }
  std::vector<BenchTest> read(const std::string& text) const {
    const std::string file = folder_ / "bench.toml";
    std::ofstream(file) << text;
    return read_bench_tests(file);
  }
  // The file with one piece of its text exchanged is refused with these words.
  void refused(const std::string& from, const std::string& to, const std::string& why) const {
    const std::string text = test::replaced(kTwoTests, from, to);
    EXPECT_THAT(test::error_of([&] { read(text); }), HasSubstr(why)) << to;
  }
  const test::ScratchFolder folder_{"bench-tests"};
};

TEST_F(BenchTests, EverythingIsRead) {
  const std::vector<BenchTest> tests = read(kTwoTests);
  ASSERT_EQ(tests.size(), 2u);
  const BenchTest& tilt = tests[0];
  EXPECT_EQ(tilt.name, "tilt");
  EXPECT_EQ(tilt.case_file, folder_ / "tilt/case.toml");
  EXPECT_EQ(tilt.setup, 1800);
  EXPECT_EQ(tilt.effort(10), 3600);
  EXPECT_EQ(tilt.with, "");
  ASSERT_EQ(tilt.responses.size(), 1u);
  EXPECT_EQ(tilt.responses[0].unit, "deg");
  EXPECT_THAT(tilt.responses[0].measurement, EndsWith("tilt.toml"));
  EXPECT_DOUBLE_EQ(tilt.responses[0].standard_uncertainty(9), std::hypot(0.5, 0.3));
  EXPECT_EQ(tests[1].with, "tilt");
  EXPECT_EQ(tests[1].per_repeat, 90);
  EXPECT_EQ(tests[1].responses[0].systematic_uncertainty, 0);
}

TEST_F(BenchTests, MistakesAreNamedWithTheirPlace) {
  refused("informs =", "informz =", "bench.toml:5: tests.tilt.informz");
  refused("tilt/case.toml", "tilt/none.toml", "is not a file");
  refused("\"30 min\"", "\"30 mm\"", "bench.toml:6: tests.tilt.setup");
  refused("\"1.5 deg\"", "\"0 deg\"", "expected more than zero");
  refused("\"0.3 deg\"", "\"0.3 rad\"", "systematic_uncertainty: has the unit \"rad\"");
  refused("name = \"weigh\"", "name = \"tilt\"", "is taken already");
  refused("extends_test = \"tilt\"", "extends_test = \"weigh\"", "is not another test");
  refused("rationale = \"judgement\"", "rationale = \"\"", "is empty");
  refused("repeats = 10", "repeats = 0", "repeats");
  refused("name = \"slip_angle\"", "", "name");
}

TEST_F(BenchTests, ATestNeedsAResponseAndAFileTests) {
  EXPECT_THROW(read(std::string(kTwoTests, std::string(kTwoTests).find("[[tests.responses]]"))),
               InputError);
  EXPECT_THROW(read(""), InputError);
  EXPECT_THROW(read_bench_tests(folder_ / "none.toml"), InputError);
}

// --- the shipped list ---

std::vector<BenchTest> shipped() {
  return read_bench_tests(FIRN_SOURCE_DIR "/cases/bench_tests.toml");
}

TEST(ShippedBenchTests, EveryFormIsRefusedUntilItIsFilledIn) {
  int forms = 0;
  for (const BenchTest& test : shipped()) {
    for (const BenchResponse& response : test.responses) {
      if (test.name == "drained_repose") continue;  // has been measured
      ++forms;
      std::string text = test::read_text(response.measurement);
      EXPECT_THAT(test::error_of([&] { read_measurement_text(text, "form.toml"); }),
                  HasSubstr("values: has fewer than two entries"))
          << response.measurement;
      const std::string empty = "values = []";
      ASSERT_NE(text.find(empty), text.npos);
      const std::string unit = response.unit == "1" ? "" : " " + response.unit;
      text.replace(text.find(empty), empty.size(),
                   "values = [\"1" + unit + "\", \"2" + unit + "\"]");
      const Measurement filled = read_measurement_text(text, "form.toml");
      EXPECT_EQ(filled.response, response.name);
      EXPECT_EQ(filled.unit, response.unit);
      EXPECT_EQ(filled.value, 1.5);
    }
  }
  EXPECT_EQ(forms, 12);
}

// Runs the test's case and looks for its responses, with their units.
void expect_responses(const BenchTest& test, const std::vector<Override>& overrides) {
  const BenchRun r = run_case(read_case(test.case_file, overrides));
  for (const BenchResponse& response : test.responses) {
    ASSERT_TRUE(r.has(response.name)) << test.name << ": " << response.name;
    EXPECT_EQ(r[response.name].unit, response.unit) << test.name << ": " << response.name;
    EXPECT_EQ(r[response.name].value.size(), 1u);
  }
}

bool many_bodies(const BenchTest& test) {
  return test.name == "drained_repose" || test.with == "drained_repose" ||
         test.name == "bin_heap" || test.name == "drum" || test.name == "hopper";
}

TEST(ShippedBenchTests, SingleBodiesHaveTheirResponses) {
  int single = 0;
  for (const BenchTest& test : shipped()) {
    if (many_bodies(test)) continue;
    expect_responses(test, {{"interactions.ice-plastic.static_friction", "0.1"}});
    ++single;
  }
  EXPECT_EQ(single, 4);
}

// Small ones; full sizes take minutes.
TEST(ShippedBenchTestsLong, HeapsHaveTheirResponses) {
  for (const BenchTest& test : shipped()) {
    if (test.name == "bin_heap") expect_responses(test, {{"fills.0.count", "24"}});
    if (test.name == "hopper")
      expect_responses(test, {{"fills.0.count", "40"}, {"stages.discharge.count", "40"}});
    if (test.name == "drum")
      expect_responses(test, {{"fills.0.count", "60"},
                              {"fills.0.batch", "60"},
                              {"case.duration", "4 s"},
                              {"measure.0.begin", "3 s"}});
    if (test.name != "drained_repose" && test.with != "drained_repose") continue;
    expect_responses(test, {{"experiment.fill.count", "60"},
                            {"experiment.fill.max_duration", "0.5 s"},
                            {"experiment.drain.max_duration", "0.5 s"},
                            {"materials.ice.young_modulus", "1 MPa"}});
  }
}

}  // namespace
}  // namespace firn
