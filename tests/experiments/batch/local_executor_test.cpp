// Processes that end in every way a process can.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "experiments/batch/execution/executor.h"
#include "experiments/system/output_file.h"
#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

class LocalExecutorTest : public testing::Test {
 protected:
  // Runs as many jobs with a shell script in place of firn; results by key.
  std::map<std::string, JobResult> run(const std::string& script, int count, int side_by_side = 2,
                                       const std::atomic<bool>* interrupt = nullptr) {
    const std::string program = folder_.write("program", "#!/bin/sh\n" + script);
    chmod(program.c_str(), 0755);
    const auto executor = local_executor({program, side_by_side, interrupt});
    std::vector<Job> jobs;
    for (int i = 0; i < count; ++i)
      jobs.push_back({"job" + std::to_string(i),
                      folder_ / "case.toml",
                      {},
                      "text of the case\n",
                      folder_ / "runs",
                      3,
                      limits_});
    std::map<std::string, JobResult> results;
    JobEvents events;
    events.started = [&](const Job&) { most_ = std::max(most_, ++running_); };
    events.tick = on_tick_;
    events.note = [&](const Job&, const std::string& line) { notes_.push_back(line); };
    events.ended = [&](const Job& job, const JobResult& r) {
      --running_;
      results[job.key] = r;
    };
    executor->run(jobs, events);
    return results;
  }

  Folder folder_{"executor"};
  RunLimits limits_;
  int running_ = 0, most_ = 0;
  std::function<void()> on_tick_;
  std::vector<std::string> notes_;
};

TEST_F(LocalExecutorTest, BadInputIsAFailureWithTheLastLineOfTheLog) {
  const auto results = run("echo first; echo 'case.toml:3: a.b: wrong' >&2; exit 2\n", 1);
  EXPECT_EQ(results.at("job0").status, JobStatus::failed);
  EXPECT_EQ(results.at("job0").reason, "exit status 2: case.toml:3: a.b: wrong");
}

TEST_F(LocalExecutorTest, ACrashAffectsNoOtherRun) {
  const auto results = run("case $2 in *job1.toml) kill -SEGV $$;; esac; exit 2\n", 3);
  EXPECT_EQ(results.at("job1").status, JobStatus::crashed);
  EXPECT_NE(results.at("job1").reason.find("signal 11"), std::string::npos);
  EXPECT_EQ(results.at("job0").status, JobStatus::failed);
  EXPECT_EQ(results.at("job2").status, JobStatus::failed);
}

TEST_F(LocalExecutorTest, AnEndWithoutResultsIsACrash) {
  EXPECT_EQ(run("exit 0\n", 1).at("job0").status, JobStatus::crashed);
  EXPECT_EQ(run("echo 'firn: std::bad_alloc'; exit 1\n", 1).at("job0").status, JobStatus::crashed);
}

TEST_F(LocalExecutorTest, WhatIsNotTheRunsFaultIsNoOutcome) {
  EXPECT_EQ(run("kill -KILL $$\n", 1).at("job0").status, JobStatus::lost);
  EXPECT_EQ(run("exit 1\n", 1).at("job0").status, JobStatus::lost);  // not a word: no room for one
  EXPECT_THROW(run("exec /no/such/program\n", 3), RunError);
  EXPECT_THAT(
      [&] {
        run("echo 'firn: a.h5: cannot write: No space left on device; b is safe'; exit 1\n", 3);
      },
      testing::ThrowsMessage<WriteError>(
          testing::StrEq("a.h5: cannot write: No space left on device")));
  const auto trouble = [&] {
    run("rm -r \"$(dirname $4)\"; touch \"$(dirname $4)\"; exit 1\n", 1);
  };
  EXPECT_THAT(trouble, testing::ThrowsMessage<RunError>(testing::HasSubstr("cannot write")));
}

TEST_F(LocalExecutorTest, ARunOverItsTimeIsAskedToSaveAndIsTimedOut) {
  limits_.time = 0.3;
  const auto r =
      run("trap 'echo saved > \"$4.saved\"; exit 130' INT; sleep 20 & wait\n", 1).at("job0");
  EXPECT_EQ(r.status, JobStatus::timed_out);
  EXPECT_EQ(r.limit, 0.3);
  EXPECT_GE(r.wall, 0.3);
  EXPECT_EQ(r.reason, "over its limit of 0.3 s at t = 0 s");
  EXPECT_EQ(read_text(folder_ / "runs/job0.h5.saved"), "saved\n");
}

TEST_F(LocalExecutorTest, ARunOverItsMemoryIsKilled) {
  limits_.memory = 200e6;  // above what a sanitizer needs before the shell starts
  // A shell that doubles a text until it is stopped.
  const auto results =
      run("case $2 in *job0.toml) exit 2;; esac; "
          "x=aaaaaaaa; while [ ${#x} -lt 400000000 ]; do x=$x$x; done; sleep 20\n",
          2);
  EXPECT_EQ(results.at("job0").status, JobStatus::failed);
  EXPECT_EQ(results.at("job1").status, JobStatus::out_of_memory);
  EXPECT_EQ(results.at("job1").limit, 200e6);
}

TEST_F(LocalExecutorTest, NoMoreProcessesThanAskedFor) {
  EXPECT_EQ(run("exit 2\n", 5, 2).size(), 5u);
  EXPECT_EQ(most_, 2);
}

TEST_F(LocalExecutorTest, PassesCaseResultsAndThreads) {
  run("cp \"$2\" \"$4.case\"; echo \"$1 $3 $5 $6\" > \"$4.arguments\"; exit 2\n", 1);
  EXPECT_EQ(read_text(folder_ / "runs/job0.h5.case"), "text of the case\n");
  EXPECT_EQ(read_text(folder_ / "runs/job0.h5.arguments"), "run -o --threads 3\n");
}

TEST_F(LocalExecutorTest, AResultsFileCutShortIsNotGoneOnWith) {
  std::filesystem::create_directories(folder_ / "runs");
  folder_.write("runs/job0.h5", "half of a results fi");
  run("echo $1 $2 > \"$4.arguments\"; exit 2\n", 1);
  EXPECT_NE(read_text(folder_ / "runs/job0.h5.arguments").find("run"), std::string::npos);
}

TEST_F(LocalExecutorTest, ResultsThatCannotBeOpenedAreRenamed) {
  std::filesystem::create_directories(folder_ / "runs");
  const std::string name = folder_ / "runs/job0.h5";
  for (const std::string end : {".unreadable", ".unreadable-2", ".unreadable-3"}) {
    folder_.write("runs/job0.h5", "a results file of old" + end);
    folder_.write("runs/job0.h5.saved", "its copy" + end);
    notes_.clear();
    run("exit 2\n", 1);
    EXPECT_EQ(read_text(name + end), "a results file of old" + end);
    EXPECT_EQ(read_text(name + ".saved" + end), "its copy" + end);
    EXPECT_FALSE(std::filesystem::exists(name));
    EXPECT_FALSE(std::filesystem::exists(name + ".saved"));
    ASSERT_EQ(notes_.size(), 1u);
    EXPECT_THAT(notes_[0], testing::StartsWith(name + ": not a results file"));
    EXPECT_THAT(notes_[0], testing::EndsWith("; renamed to " + name + end + ", " + name + ".saved" +
                                             end + "; the run starts from its beginning"));
    EXPECT_EQ(notes_[0].find('\n'), std::string::npos);
  }
}

// As the lock of a run makes it, before anything is simulated.
TEST_F(LocalExecutorTest, AnEmptyResultsFileIsRemoved) {
  std::filesystem::create_directories(folder_ / "runs");
  folder_.write("runs/job0.h5", "");
  run("exit 2\n", 1);
  EXPECT_TRUE(notes_.empty());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "runs/job0.h5"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "runs/job0.h5.unreadable"));
}

TEST_F(LocalExecutorTest, ASignalToARunAloneIsNoInterruption) {
  const auto results = run("case $2 in *job0.toml) exit 130;; esac; exit 2\n", 2);
  EXPECT_EQ(results.at("job0").status, JobStatus::lost);
  EXPECT_EQ(results.at("job0").reason, "interrupted by a signal");
  EXPECT_EQ(results.at("job1").status, JobStatus::failed);
}

TEST_F(LocalExecutorTest, AnInterruptOfTheBatchIsOneOfItsRuns) {
  std::atomic<bool> interrupt = false;
  on_tick_ = [&] { interrupt = std::filesystem::exists(folder_ / "runs/job0.h5.ready"); };
  const auto results =
      run("trap 'exit 130' INT; touch \"$4.ready\"; sleep 20 & wait\n", 1, 1, &interrupt);
  EXPECT_EQ(results.at("job0").status, JobStatus::interrupted);
}

TEST_F(LocalExecutorTest, AnInterruptStopsTheRunningAndStartsNoMore) {
  const std::atomic<bool> interrupt = true;
  EXPECT_TRUE(run("exit 2\n", 4, 2, &interrupt).empty());
}

}  // namespace
}  // namespace firn
