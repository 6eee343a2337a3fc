#include "experiments/inspection/state_trace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "tests/support/results_folder.h"
#include "tests/support/tray_case.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class StateTrace : public ResultsFolder {
 protected:
  // Two cubes above a floor for 60 steps. `speed`: m/s of the second one; at `disturbed` the loads
  // on the floor are forgotten.
  std::string trace(const std::string& name, TraceOptions options, double speed = -0.5,
                    int disturbed = -1) const {
    const Case c = tray();
    Model model = c.model;
    Solver solver(model);
    options.file = path(name);
    TraceWriter writer(c, options);
    const Quat upright = Quat::Identity();
    solver.insert(0, {0, 0, 0.01}, upright, {0, 0, -0.5}, Vec3::Zero());
    solver.insert(1, {0, 0.05, 0.01}, upright, {0, 0, speed}, Vec3::Zero());
    for (int i = 0; i <= 60; ++i) {
      if (i == disturbed) solver.clear_boundary_loads();
      writer.add_step(solver, i == 60);
      if (i < 60) solver.step();
    }
    writer.close();
    return options.file;
  }
};

TEST_F(StateTrace, EqualRunsAreEqual) {
  const TraceDifference d = compare_traces(trace("a", {}), trace("b", {}), 10);
  EXPECT_TRUE(d.equal);
  EXPECT_TRUE(d.same_case);
  EXPECT_EQ(d.steps_compared, 61u);
  EXPECT_EQ(d.last_equal, 60u);
  EXPECT_EQ(d.only_first + d.only_second, 0u);
}

TEST_F(StateTrace, NamesStepGroupAndBody) {
  TraceOptions numbers;
  numbers.numbers_from = 28;
  numbers.numbers_to = 32;
  const TraceDifference d = compare_traces(trace("a", numbers), trace("b", numbers, -0.5, 30), 10);
  ASSERT_FALSE(d.equal);
  EXPECT_EQ(d.step, 30u);
  EXPECT_EQ(d.last_equal, 29u);
  EXPECT_THAT(d.groups, testing::ElementsAre("boundary loads"));
  ASSERT_TRUE(d.has_numbers);
  ASSERT_FALSE(d.numbers.empty());
  EXPECT_THAT(d.numbers[0], HasSubstr("boundary 0: impulse_"));
  EXPECT_THAT(d.numbers[0], HasSubstr("against 0"));
}

TEST_F(StateTrace, SeesTheLastBitOfOneNumber) {
  TraceOptions numbers;
  numbers.numbers_from = numbers.numbers_to = 0;
  const TraceDifference d =
      compare_traces(trace("a", numbers), trace("b", numbers, std::nextafter(-0.5, 0)), 10);
  ASSERT_FALSE(d.equal);
  EXPECT_EQ(d.step, 0u);
  EXPECT_FALSE(d.any_equal);
  ASSERT_EQ(d.number_count, 1u);
  EXPECT_THAT(d.numbers[0],
              testing::StartsWith("particle 1: velocity_z -0.5 against -0.4999999999999999"));
}

TEST_F(StateTrace, WithoutNumbersItNamesTheStepAlone) {
  const TraceDifference d = compare_traces(trace("a", {}), trace("b", {}, -0.5, 30), 10);
  EXPECT_EQ(d.step, 30u);
  EXPECT_FALSE(d.has_numbers);
  EXPECT_TRUE(d.numbers.empty());
}

TEST_F(StateTrace, SparseTracesMeetWhereTheyCan) {
  TraceOptions fives, sevens;
  fives.every = 5;
  sevens.every = 7;
  const TraceDifference d = compare_traces(trace("a", fives), trace("b", sevens), 10);
  EXPECT_TRUE(d.equal);
  EXPECT_EQ(d.steps_compared, 3u);  // 0, 35 and the last one
  EXPECT_EQ(d.only_first, 10u);     // 5 ... 55 but 35
  EXPECT_EQ(d.only_second, 7u);     // 7 ... 56 but 35
}

TEST_F(StateTrace, KilledRunsTraceIsReadUpToItsLastWholeLine) {
  const std::string whole = trace("a", {}), cut = trace("b", {});
  fs::resize_file(cut, fs::file_size(cut) - 5);
  const TraceDifference d = compare_traces(whole, cut, 10);
  EXPECT_TRUE(d.equal);
  EXPECT_EQ(d.steps_compared, 60u);
  EXPECT_EQ(d.only_first, 1u);
}

TEST_F(StateTrace, OtherFilesAreRefused) {
  const std::string good = trace("a", {});
  std::ofstream(path("text")) << "no trace\n";
  EXPECT_THROW(compare_traces(good, path("text"), 10), InputError);
  EXPECT_THROW(compare_traces(path("nowhere"), good, 10), InputError);
  std::ofstream(path("other")) << "# firn trace 1\n# case 0\n# groups time,else\n";
  EXPECT_THROW(compare_traces(good, path("other"), 10), InputError);
  TraceOptions unwritable;
  unwritable.file = path("no/such/folder");
  EXPECT_THROW(TraceWriter(tray(), unwritable), InputError);
}

}  // namespace
}  // namespace firn
