// The logic of the Slurm executor, with scripts in place of a cluster.
#include "experiments/batch/slurm/slurm_executor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <cstdlib>

#include "experiments/batch/slurm/slurm_task.h"
#include "experiments/system/input_file.h"
#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

// A cluster in a folder: sbatch notes the array in `queue/NAME` and calls `script` for each task,
// which decides what becomes of it; squeue prints the files of `queue`.
class SlurmExecutorTest : public testing::Test {
 protected:
  SlurmExecutorTest() : old_path_(std::getenv("PATH")) {
    setenv("PATH", ((folder_ / "bin") + ":" + old_path_).c_str(), 1);
    setenv("CLUSTER", (folder_ / "").c_str(), 1);
    for (const char* name : {"bin", "queue", "study", "runs"})
      std::filesystem::create_directories(folder_ / name);
    command("squeue", "cat $CLUSTER/queue/* 2>/dev/null; exit 0\n");
    command("sacct", "exit 1\n");  // no accounting here
    command("scancel", "echo \"$@\" >> $CLUSTER/scancelled; rm -f $CLUSTER/queue/*\n");
    task("finish");
  }
  ~SlurmExecutorTest() override { setenv("PATH", old_path_.c_str(), 1); }

  void command(const std::string& name, const std::string& script) {
    chmod(folder_.write("bin/" + name, "#!/bin/sh\n" + script).c_str(), 0755);
  }

  // `script` runs for each task with its $index and $key, and has `finish` (an
  // outcome is there) and `state INDEX STATE`.
  void task(const std::string& script) {
    command("sbatch", R"sh(
for argument in "$@"; do
  case $argument in
    --job-name=*) name=${argument#*=} ;;
  esac
done
echo "$@" >> $CLUSTER/submitted
keys=$(sed -n 's/.*"key": "\(.*\)".*/\1/p' $CLUSTER/lists/$name.json)
state() { echo "$name|77|$1|$2" >> $CLUSTER/queue/$name.$1; }
finish() {
  echo '{"status": "failed", "reason": "as planned", "wall": 2, "simulated": 0, "limit": 0}' \
    > $CLUSTER/runs/$key.outcome
}
index=0
for key in $keys; do )sh" +
                          script + R"sh(
  index=$((index + 1))
done
echo 77
)sh");
  }

  std::map<std::string, JobResult> run(const std::vector<std::string>& keys) {
    SlurmOptions options;
    options.settings.poll = 0.01;
    options.settings.partition = "cpu";
    options.settings.options = {"--qos=low"};
    options.program = "/bin/false";
    options.task_program = "/opt/it's/firn";
    options.folder = folder_ / "lists";
    options.at_once = 3;
    options.largest_array = 4;
    options.file_timeout = 0.05;
    options.interrupt = &interrupt_;
    const auto executor = slurm_executor(options, journal_);
    std::vector<Job> jobs;
    for (const std::string& key : keys)
      jobs.push_back({key, folder_ / "case.toml", {}, "text\n", folder_ / "runs", 2, limits_});
    std::map<std::string, JobResult> results;
    JobEvents events;
    events.started = [&](const Job& job) { started_ += job.key + ' '; };
    events.ended = [&](const Job& job, const JobResult& r) { results[job.key] = r; };
    events.tick = [&] {
      if (on_tick) on_tick();
    };
    executor->run(jobs, events);
    return results;
  }

  // Empty if nothing was submitted.
  std::string submitted() const { return read_own_file(folder_ / "submitted"); }

  Folder folder_{"slurm"};
  std::string old_path_;
  Journal journal_{folder_ / "study", "text", false};
  RunLimits limits_;
  std::atomic<bool> interrupt_ = false;
  std::function<void()> on_tick;
  std::string started_;
};

TEST_F(SlurmExecutorTest, HandsOverOneArrayAndTakesItsOutcomes) {
  limits_ = {600, 1 << 30};
  const auto results = run({"a", "b", "c"});
  ASSERT_EQ(results.size(), 3u);
  EXPECT_EQ(results.at("b").status, JobStatus::failed);
  EXPECT_EQ(results.at("b").reason, "as planned");
  EXPECT_EQ(results.at("b").wall, 2);
  const std::string command = submitted();
  for (const char* part :
       {"--parsable", "--requeue", "--array=0-2%3", "--cpus-per-task=2", "--time=15", "--mem=1280M",
        "--partition=cpu", "--qos=low", "--wrap=exec '/opt/it'\\''s/firn' slurm-task "})
    EXPECT_THAT(command, HasSubstr(part));
  EXPECT_TRUE(journal_.submissions().empty());  // over
  EXPECT_FALSE(std::filesystem::exists(folder_ / "runs/a.outcome"));
}

TEST_F(SlurmExecutorTest, LargeBatchesBecomeSeveralArrays) {
  EXPECT_EQ(run({"a", "b", "c", "d", "e", "f"}).size(), 6u);
  EXPECT_THAT(submitted(), HasSubstr("--array=0-3%3"));
  EXPECT_THAT(submitted(), HasSubstr("--array=0-1%3"));
}

TEST_F(SlurmExecutorTest, ATaskThatVanishesIsLostAndTheOthersAreNot) {
  task("[ $index = 1 ] && state $index NODE_FAIL || finish");
  const auto results = run({"a", "b", "c"});
  EXPECT_EQ(results.at("a").status, JobStatus::failed);
  EXPECT_EQ(results.at("b").status, JobStatus::lost);
  EXPECT_THAT(results.at("b").reason, HasSubstr("task 77_1"));
  EXPECT_THAT(results.at("b").reason, HasSubstr("NODE_FAIL"));
}

TEST_F(SlurmExecutorTest, TheAccountingKnowsWhatTheQueueHasForgotten) {
  task(":");
  command("sacct", "echo OUT_OF_MEMORY\n");
  EXPECT_THAT(run({"a"}).at("a").reason, HasSubstr("OUT_OF_MEMORY"));
}

// Queued again by Slurm, as after the loss of a node: no loss for us.
TEST_F(SlurmExecutorTest, ARequeuedTaskIsWaitedFor) {
  task("state $index PENDING");
  int ticks = 0;
  on_tick = [&] {
    if (++ticks == 20)
      folder_.write("runs/a.outcome",
                    R"({"status":"crashed","reason":"r","wall":1,"simulated":0,"limit":0})");
  };
  EXPECT_EQ(run({"a"}).at("a").status, JobStatus::crashed);
  EXPECT_GE(ticks, 20);
}

TEST_F(SlurmExecutorTest, ASilentQueueLosesNothing) {
  int ticks = 0;
  task("state $index RUNNING");
  on_tick = [&] {
    if (++ticks == 2) command("squeue", "echo 'Unable to contact slurm controller' >&2; exit 1\n");
    if (ticks == 30)
      folder_.write("runs/a.outcome",
                    R"({"status":"failed","reason":"r","wall":1,"simulated":0,"limit":0})");
  };
  EXPECT_EQ(run({"a"}).at("a").status, JobStatus::failed);
}

TEST_F(SlurmExecutorTest, WhatSbatchRefusesIsOneLine) {
  command("sbatch",
          "echo 'sbatch: error: a' >&2; echo 'sbatch: error: invalid account' >&2; exit 1\n");
  EXPECT_THAT([&] { run({"a"}); },
              ThrowsMessage<RunError>("sbatch takes no jobs: sbatch: error: invalid account"));
  EXPECT_TRUE(journal_.submissions().empty());
}

TEST_F(SlurmExecutorTest, WithoutSlurmItSaysSo) {
  setenv("PATH", "/nowhere", 1);
  EXPECT_THAT([&] { run({"a"}); }, ThrowsMessage<RunError>(HasSubstr("sbatch: not found")));
}

TEST_F(SlurmExecutorTest, AnInterruptCancelsTheArrays) {
  task("state $index RUNNING");
  on_tick = [&] { interrupt_ = true; };
  const auto results = run({"a", "b"});
  EXPECT_EQ(results.at("a").status, JobStatus::interrupted);
  EXPECT_EQ(results.at("b").status, JobStatus::interrupted);
  EXPECT_EQ(read_text(folder_ / "scancelled"), "77\n");
  EXPECT_TRUE(journal_.submissions().empty());
}

TEST_F(SlurmExecutorTest, AnEarlierSessionsTasksAreAttachedAndOnlyTheMissingSubmitted) {
  // a: still queued; b: done unseen; c: gone with its node; d: never handed over.
  journal_.submit({"firn-earlier", "55", {"a", "b", "c"}});
  folder_.write("queue/earlier", "firn-earlier|55|0|RUNNING\nfirn-earlier|55|2|NODE_FAIL\n");
  folder_.write("runs/b.outcome",
                R"({"status":"failed","reason":"unseen","wall":1,"simulated":0,"limit":0})");
  int ticks = 0;
  on_tick = [&] {
    if (++ticks == 3)
      folder_.write("runs/a.outcome",
                    R"({"status":"failed","reason":"waited","wall":1,"simulated":0,"limit":0})");
  };
  const auto results = run({"a", "b", "c", "d"});
  EXPECT_EQ(results.at("a").reason, "waited");
  EXPECT_EQ(results.at("b").reason, "unseen");
  EXPECT_EQ(results.at("c").reason, "as planned");
  EXPECT_EQ(results.at("d").reason, "as planned");
  EXPECT_THAT(submitted(), HasSubstr("--array=0-1%3"));  // c and d
  EXPECT_TRUE(journal_.submissions().empty());
}

// Killed between handing over and noting the answer.
TEST_F(SlurmExecutorTest, ALostAnswerIsFoundByTheNameOfTheArray) {
  journal_.submit({"firn-earlier", "", {"a", "b"}});
  folder_.write("queue/earlier", "firn-earlier|55|0|PENDING\nfirn-earlier|55|1|RUNNING\n");
  on_tick = [&] {
    const std::string outcome =
        R"({"status":"failed","reason":"first","wall":1,"simulated":0,"limit":0})";
    folder_.write("runs/a.outcome", outcome);
    folder_.write("runs/b.outcome", outcome);
  };
  const auto results = run({"a", "b"});
  EXPECT_EQ(results.at("a").reason, "first");
  EXPECT_EQ(results.at("b").reason, "first");
  EXPECT_EQ(submitted(), "");
}

TEST_F(SlurmExecutorTest, AnArrayThatNeverArrivedIsHandedOverAgain) {
  journal_.submit({"firn-earlier", "", {"a"}});
  EXPECT_EQ(run({"a"}).at("a").reason, "as planned");
}

TEST_F(SlurmExecutorTest, NothingIsSubmittedWhileTheQueueOfAnEarlierSessionIsSilent) {
  journal_.submit({"firn-earlier", "", {"a"}});
  command("squeue", "echo 'Unable to contact slurm controller' >&2; exit 1\n");
  EXPECT_THAT([&] { run({"a"}); }, ThrowsMessage<RunError>(HasSubstr("Unable to contact")));
  EXPECT_EQ(submitted(), "");
  EXPECT_EQ(journal_.submissions().size(), 1u);
}

TEST_F(SlurmExecutorTest, AnOutcomeCutShortByALowerLimitIsNone) {
  limits_.time = 60;
  folder_.write("runs/a.outcome",
                R"({"status":"timed out","reason":"over","wall":30,"simulated":0,"limit":30})");
  EXPECT_EQ(run({"a"}).at("a").reason, "as planned");
}

// What a node does, with a script in place of firn run.
TEST(SlurmTask, LeavesAnOutcomeOnlyForWhatIsOne) {
  const Folder folder("task");
  const std::string program = folder.write(
      "program", "#!/bin/sh\ncase $2 in *lost*) kill -KILL $$;; *stop*) exit 130;; esac; exit 2\n");
  chmod(program.c_str(), 0755);
  std::vector<Job> jobs;
  for (const char* key : {"bad", "lost", "stop"})
    jobs.push_back({key, "", {}, "text\n", folder / "runs", 1, {}});
  const std::string list = folder / "lists/tasks.json";
  write_tasks(list, jobs, program);
  EXPECT_EQ(read_text(folder / "runs/bad.toml"), "text\n");
  EXPECT_EQ(run_slurm_task(list, 0, nullptr), 0);
  EXPECT_EQ(read_task_outcome(jobs[0])->status, JobStatus::failed);
  EXPECT_THROW(run_slurm_task(list, 1, nullptr), RunError);
  EXPECT_FALSE(read_task_outcome(jobs[1]));
  EXPECT_THROW(run_slurm_task(list, 2, nullptr), RunError);  // a signal to the run alone
  EXPECT_FALSE(read_task_outcome(jobs[2]));
  const std::atomic<bool> interrupt = true;
  EXPECT_EQ(run_slurm_task(list, 2, &interrupt), 130);  // to both
  EXPECT_FALSE(read_task_outcome(jobs[2]));
  EXPECT_THROW(run_slurm_task(list, 3, nullptr), InputError);
  EXPECT_THROW(run_slurm_task(folder / "none.json", 0, nullptr), InputError);
  // Handed out twice: the second finds the outcome of the first.
  folder.write("program", "#!/bin/sh\ntouch \"$4.again\"\nexit 2\n");
  EXPECT_EQ(run_slurm_task(list, 0, nullptr), 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "runs/bad.h5.again"));
}

}  // namespace
}  // namespace firn
