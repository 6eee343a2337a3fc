// What programs read of a study while it runs.
#include "experiments/batch/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

namespace firn {
namespace {

using nlohmann::json;
using testing::HasSubstr;

const PlannedRun run{"0123", "case", "program", {"heap", "design", 4, "mu=0.1", 7}};

std::vector<json> lines(const std::string& text) {
  std::vector<json> all;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) all.push_back(json::parse(line));
  return all;
}

TEST(BatchProgress, IsOneJsonObjectALineForPrograms) {
  testing::internal::CaptureStderr();
  {
    BatchProgress progress(ProgressStyle::json, "calibrate", 10, 2);
    progress.phase("exploring");
    progress.started(run);
    JobResult result{JobStatus::finished, "", {{"aor", {12.5}, {}, "deg", "m", 1}}, 8};
    progress.ended(run, result);
    progress.started(run);
    progress.stopped(run, {JobStatus::lost, "killed", {}});
    result.status = JobStatus::timed_out;
    progress.found(run, result);
    progress.knowledge("text", {{{"mu", {0.1, 0.05, 0.2, "1"}}}, {}, {}});
    progress.tick();
  }
  const auto events = lines(testing::internal::GetCapturedStderr());
  ASSERT_EQ(events.size(), 7u);
  EXPECT_EQ(events[0]["event"], "phase");
  EXPECT_EQ(events[0]["left_at_most"], 10);
  EXPECT_TRUE(events[0]["seconds_left"].is_null());
  EXPECT_EQ(events[1]["run"]["parameters"], "mu=0.1");
  EXPECT_EQ(events[1]["under_way"], 1);
  EXPECT_EQ(events[2]["status"], "finished");
  EXPECT_EQ(events[2]["responses"]["aor"]["value"], 12.5);
  EXPECT_EQ(events[2]["done"], 1);
  EXPECT_EQ(events[2]["seconds_left"], 8.0 * 9 / 2);  // nine left, two at a time
  EXPECT_EQ(events[4]["event"], "stopped");
  EXPECT_EQ(events[4]["done"], 1);
  EXPECT_EQ(events[5]["status"], "timed out");
  EXPECT_EQ(events[6]["knowledge"]["best"]["mu"]["value"], 0.1);
}

TEST(BatchProgress, IsALineNowAndThenForPeople) {
  testing::internal::CaptureStderr();
  {
    BatchProgress progress(ProgressStyle::text, "calibrate", 4, 1);
    progress.phase("exploring");
    progress.started(run);
    progress.ended(run, {JobStatus::out_of_memory, "over", {}, 60});
    progress.knowledge("  best so far: mu = 0.1", {});
    progress.phase("confirming");
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "calibrate: 0 of at most 4 runs, exploring\n"
            "  best so far: mu = 0.1\n"
            "calibrate: 1 of at most 4 runs, 1 cut short, about 3 min left, confirming\n");
}

}  // namespace
}  // namespace firn
