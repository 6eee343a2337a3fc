// The state of a batch as another process reads it while the batch runs.
#include "experiments/batch/batch_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "experiments/batch/batch_folder.h"
#include "firn/math.h"
#include "tests/support/read_text.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

PlannedRun planned(int i) {
  return {"key" + std::to_string(i),
          "case " + std::to_string(i),
          "program",
          {"heap", "design", i, "mu=0." + std::to_string(i + 1), 7}};
}

JobResult finished_angle(double angle) {
  return {JobStatus::finished, "", {{"angle", {angle}, {}, "deg", "m", 1}}, 10};
}

// A folder at work, as long as it lives.
struct Working {
  explicit Working(const std::string& folder)
      : batch(folder, {.kind = "calibrate", .identity = "a study", .largest_total = 8, .slurm = {}},
              options()) {}
  static BatchOptions options() {
    BatchOptions o;
    o.jobs = 2;
    o.show_progress = false;
    return o;
  }
  BatchFolder batch;
};

TEST(BatchState, IsNothingWithoutAJournal) {
  const test::ScratchFolder folder("batch-state");
  EXPECT_FALSE(read_batch_state(folder.path().string()).has_value());
  EXPECT_FALSE(read_batch_state((folder.path() / "missing").string()).has_value());
  EXPECT_FALSE(is_at_work(folder.path().string()));
}

TEST(BatchState, FollowsABatchAtWork) {
  const test::ScratchFolder folder("batch-state");
  const std::string path = folder.path().string();
  {
    Working working(path);
    Journal& journal = working.batch.journal();
    journal.plan({planned(0), planned(1), planned(2), planned(3)});
    journal.start("key0");
    journal.finish("key0", finished_angle(12.5));
    journal.start("key1");
    auto state = read_batch_state(path);
    ASSERT_TRUE(state.has_value());
    EXPECT_TRUE(state->at_work);
    EXPECT_EQ(state->progress.command, "calibrate");
    EXPECT_EQ(state->ended(), 1);
    EXPECT_EQ(state->count("running"), 1);
    EXPECT_EQ(state->time_left(), 10.0 * 7 / 2);  // seven runs left, two at a time
    ASSERT_EQ(state->runs.size(), 4u);
    EXPECT_EQ(state->runs[0].result.responses.at(0).value.at(0), 12.5);
    EXPECT_FALSE(state->progress.knowledge.has_value());

    working.batch.progress().knowledge(
        "text", {{{"mu", {0.1, 0.05, 0.2, "1"}}}, {{"ln(mu)", -2.3, 0.25}}, {{"angle", 12}}});
    state = read_batch_state(path);
    const BatchKnowledge known = state->progress.knowledge.value();
    ASSERT_EQ(known.best.size(), 1u);
    EXPECT_EQ(known.best[0].second.high, 0.2);
    ASSERT_EQ(known.determined.size(), 1u);
    EXPECT_EQ(known.determined[0].text(), "ln(mu) = -2.3 ± 0.25");
    ASSERT_EQ(known.targets.size(), 1u);
    EXPECT_EQ(known.targets[0].value, 12);
  }
  const auto state = read_batch_state(path);
  EXPECT_FALSE(state->at_work);
  EXPECT_EQ(state->runs.size(), 4u);
}

// A reader changes neither the journal nor the lock.
TEST(BatchState, DoesNotKeepABatchFromStarting) {
  const test::ScratchFolder folder("batch-state");
  const std::string path = folder.path().string();
  { const Working first(path); }
  for (int i = 0; i < 20; ++i) {
    const Working again(path);
    EXPECT_TRUE(is_at_work(path));
  }
}

TEST(BatchState, DamagedJournalsAreRefused) {
  const test::ScratchFolder folder("batch-state");
  const std::string path = folder.path().string();
  {
    Working working(path);
    working.batch.journal().plan({planned(0), planned(1)});
    working.batch.journal().finish("key0", finished_angle(1));
  }
  const std::string file = (folder.path() / "study.db").string();
  const std::string bytes = test::read_text(file);
  std::mt19937 random(5);
  int refused = 0;
  for (int i = 0; i < 300; ++i) {
    std::string damaged = bytes;
    for (int k = 0; k < 20; ++k) damaged[random() % damaged.size()] = static_cast<char>(random());
    if (i % 3 == 0) damaged.resize(random() % damaged.size());
    std::ofstream(file, std::ios::binary) << damaged;
    try {
      const auto state = read_batch_state(path);
      if (state) {
        EXPECT_LE(state->runs.size(), 100u);
      }
    } catch (const InputError& e) {
      ++refused;
      EXPECT_THAT(e.what(), testing::HasSubstr("study.db"));
    }
  }
  EXPECT_GT(refused, 20);
}

}  // namespace
}  // namespace firn
