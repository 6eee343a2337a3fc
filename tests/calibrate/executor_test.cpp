// Processes that end in every way a process can.
#include "calibrate/executor.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/calibrate/fake_experiment.h"

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
                      3});
    std::map<std::string, JobResult> results;
    JobEvents events;
    events.started = [&](const Job&) { most_ = std::max(most_, ++running_); };
    events.ended = [&](const Job& job, const JobResult& r) {
      --running_;
      results[job.key] = r;
    };
    executor->run(jobs, events);
    return results;
  }

  Folder folder_{"executor"};
  int running_ = 0, most_ = 0;
};

TEST_F(LocalExecutorTest, BadInputIsAFailureWithTheLastLineOfTheLog) {
  const auto results = run("echo first; echo 'case.toml:3: a.b: wrong' >&2; exit 2\n", 1);
  EXPECT_EQ(results.at("job0").status, JobStatus::failed);
  EXPECT_EQ(results.at("job0").reason, "exit status 2: case.toml:3: a.b: wrong");
}

TEST_F(LocalExecutorTest, ACrashTakesNobodyAlong) {
  const auto results = run("case $2 in *job1.toml) kill -SEGV $$;; esac; exit 2\n", 3);
  EXPECT_EQ(results.at("job1").status, JobStatus::crashed);
  EXPECT_NE(results.at("job1").reason.find("signal 11"), std::string::npos);
  EXPECT_EQ(results.at("job0").status, JobStatus::failed);
  EXPECT_EQ(results.at("job2").status, JobStatus::failed);
}

TEST_F(LocalExecutorTest, AFinishedProcessWithoutResultsIsAFailure) {
  EXPECT_EQ(run("exit 0\n", 1).at("job0").status, JobStatus::failed);
}

TEST_F(LocalExecutorTest, AProgramThatIsMissingIsAFailure) {
  const auto results = run("exec /no/such/program\n", 1);
  EXPECT_EQ(results.at("job0").status, JobStatus::failed);
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

TEST_F(LocalExecutorTest, AnInterruptStopsTheRunningAndStartsNoMore) {
  const std::atomic<bool> interrupt = true;
  EXPECT_TRUE(run("exit 2\n", 4, 2, &interrupt).empty());
}

}  // namespace
}  // namespace firn
