// Runs that are found instead of repeated, and runs that a limit cut short.
#include "experiments/batch/journal/run_cache.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <nlohmann/json.hpp>

#include "calibrate/study/study_file.h"
#include "calibrate/study/study_runs.h"
#include "experiments/batch/execution/execution_settings.h"
#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using Values = FakeExperiment::Values;

JobResult power_law(const Values& v, std::mt19937_64& random) {
  return finished({scalar("aor", zhou_angle(v) * (1 + 0.08 * normal_deviate(random)), "deg")});
}

StudySummary run_with_store(const std::string& study, const std::string& directory,
                            const std::string& store, Executor& executor, double time_limit = 0) {
  StudyOptions options;
  options.study_file = study;
  options.directory = directory;
  options.store = store;
  options.time_limit = time_limit;
  options.show_progress = options.plot = false;
  options.replace_executor = &executor;
  return calibrate(options);
}

TEST(RunCache, ASecondStudyFindsTheRunsOfTheFirst) {
  const Folder folder("store");
  const std::string text = friction_study(angle_target);
  // Another study by name and observed responses, of the same runs.
  std::string other = text;
  other.replace(other.find("\"fake\""), 6, "\"other\"");
  FakeExperiment first(power_law), second(power_law), third(power_law);
  const json a = json::parse(
      run_with_store(folder.write("a.toml", text), folder / "a", folder / "store.db", first).json);
  const json b = json::parse(
      run_with_store(folder.write("b.toml", other), folder / "b", folder / "store.db", second)
          .json);
  EXPECT_EQ(first.runs, 30);
  EXPECT_EQ(second.runs, 0);
  EXPECT_EQ(a["estimate"], b["estimate"]);
  EXPECT_EQ(b["runs"]["finished"], 30);
  // The second one is whole without the store and without the first.
  std::filesystem::remove(folder / "store.db");
  run_with_store(folder / "b.toml", folder / "b", "", third);
  EXPECT_EQ(third.runs, 0);
}

TEST(RunCache, RunsOfAnotherProgramAreAnotherThing) {
  const Folder folder("program");
  const std::string ours = run_key("case", "0123"), theirs = run_key("case", "4567");
  EXPECT_NE(ours, theirs);
  RunCache store(folder / "store.db");
  store.add({theirs, "case", "4567", {}}, finished({scalar("aor", 3, "deg")}));
  EXPECT_FALSE(store.find(ours));
  EXPECT_EQ(store.find(theirs)->responses.at(0).value.at(0), 3);
}

TEST(RunCache, KeepsTheFirstOutcomeUnlessALimitCutItShort) {
  const Folder folder("first");
  RunCache store(folder / "store.db");
  const PlannedRun run{"k", "case", "p", {}};
  JobResult cut{JobStatus::timed_out, "over", {}, 60, 0.25, 60};
  cut.results_file = "/a/k.h5";
  store.add(run, cut);
  const auto known = store.find("k");
  EXPECT_EQ(known->status, JobStatus::timed_out);
  EXPECT_EQ(known->simulated, 0.25);
  EXPECT_EQ(known->limit, 60);
  EXPECT_EQ(known->results_file, "/a/k.h5");
  store.add(run,
            finished({scalar("aor", 1, "deg"), {"curve", {1, std::nan("")}, {}, "s", "m", 2}}));
  store.add(run, finished({scalar("aor", 2, "deg")}));
  const auto kept = store.find("k");
  EXPECT_EQ(kept->status, JobStatus::finished);
  ASSERT_EQ(kept->responses.size(), 2u);
  EXPECT_EQ(kept->responses[0].value[0], 1);
  EXPECT_TRUE(std::isnan(kept->responses[1].value[1]));
}

// Opens a new store in several processes at once; each adds the same runs.
void write_at_once(const std::string& file) {
  constexpr int processes = 6, runs = 25;
  std::vector<pid_t> children;
  for (int p = 0; p < processes; ++p) {
    children.push_back(fork());
    if (children.back() != 0) continue;
    try {
      RunCache store(file);  // the first process creates it
      for (int i = 0; i < runs; ++i)
        store.add({"run" + std::to_string(i), "case", "p", {}},
                  finished({scalar("aor", i, "deg")}));
      _exit(0);
    } catch (const std::exception& e) {
      std::fprintf(stderr, "%s\n", e.what());
      _exit(1);
    }
  }
  for (const pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
  }
  RunCache store(file);
  for (int i = 0; i < runs; ++i)
    EXPECT_EQ(store.find("run" + std::to_string(i))->responses.at(0).value.at(0), i);
}

TEST(RunCache, ManyProcessesWriteAtOnce) {
  const Folder folder("concurrent");
  for (int round = 0; round < 10; ++round)
    write_at_once(folder / ("store" + std::to_string(round) + ".db"));
}

TEST(RunCache, RefusesAFileThatIsNone) {
  const Folder folder("foreign");
  const std::string file = folder.write("store.db", std::string(4096, 'x'));
  EXPECT_THROW(RunCache{file}, InputError);
  EXPECT_THROW(RunCache{folder / "case.toml/store.db"}, InputError);
}

// Slow where mu1 is small: takes 10 s there, 1 s elsewhere.
JobResult slow_where_small(const Values& v, std::mt19937_64& random, double limit) {
  if (v.at("a.mu1") < 0.03 && limit < 10)
    return {JobStatus::timed_out, "over its limit", {}, limit, 0.1, limit};
  return power_law(v, random);
}

TEST(Limits, RunsCutShortAreCountedKeptOutOfTheFitAndGoneOnWithUnderAHigherLimit) {
  const Folder folder("limit");
  const std::string study = folder.write("study.toml", friction_study(angle_target));
  const auto session = [&](double limit, int& runs) {
    FakeExperiment experiment([limit](const Values& v, std::mt19937_64& random) {
      return slow_where_small(v, random, limit);
    });
    const StudySummary s =
        run_with_store(study, folder / "out", folder / "store.db", experiment, limit);
    runs = experiment.runs;
    return s;
  };
  int runs = 0;
  const StudySummary first = session(5, runs);
  const json j = json::parse(first.json);
  EXPECT_GT(runs, 20);
  EXPECT_GT(j["runs"]["timed_out"], 0);
  EXPECT_EQ(j["runs"]["timed_out"], j["runs"]["cut_short"].size());
  EXPECT_EQ(j["runs"]["failed"], 0);
  EXPECT_THAT(first.table, HasSubstr("cut short"));
  EXPECT_THAT(read_text(folder / "out/runs.csv"), HasSubstr("timed out"));
  EXPECT_EQ(session(5, runs).json, first.json);
  EXPECT_EQ(runs, 0);  // the same limit: nothing to find out
  EXPECT_EQ(session(4, runs).json, first.json);
  EXPECT_EQ(runs, 0);
  const json raised = json::parse(session(10, runs).json);
  EXPECT_GT(runs, 0);
  EXPECT_EQ(raised["runs"]["timed_out"], 0);
  // In the end as if there had never been a limit.
  FakeExperiment unlimited(power_law);
  const json whole = json::parse(run_with_store(study, folder / "whole", "", unlimited).json);
  EXPECT_EQ(raised["estimate"], whole["estimate"]);
}

// The fast half of the runs has a higher response: what a limit would make of the answer if the
// mean of those that got through were taken for the mean.
TEST(Limits, SeedsThatGotThroughDoNotSpeakForThoseThatDidNot) {
  const ResponseId aor{0, "aor", "aor"};
  Point p;
  p.results = {{finished({scalar("aor", 12, "deg")}), {JobStatus::timed_out, "over", {}, 1}}};
  EXPECT_TRUE(p.finished(aor).empty());
  p.results[0][1] = finished({scalar("aor", 8, "deg")});
  EXPECT_EQ(p.finished(aor).size(), 2u);
}

TEST(Limits, AnAnswerWhoseFreshRunsAreCutShortIsNotConfirmed) {
  const Folder folder("cut-answer");
  FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
    if (v.at("case.seed") == 1002) return JobResult{JobStatus::timed_out, "over", {}, 5, 0.1, 5};
    return power_law(v, random);
  });
  const StudySummary s = run_with_store(folder.write("study.toml", friction_study(angle_target)),
                                        folder / "out", "", experiment, 5);
  EXPECT_EQ(s.verdict, StudyVerdict::unconfirmed);
  EXPECT_THAT(s.headline, HasSubstr("cut short"));
}

TEST(Execution, IsReadAndChecked) {
  const Folder folder("execution");
  const auto read = [&](const std::string& text) {
    return read_study(folder.write("study.toml", friction_study(angle_target + text))).execution;
  };
  const Execution e = read(
      "[execution]\ntime_limit = \"10 min\"\nmemory_limit = \"1.5 GiB\"\n[execution.slurm]\n"
      "partition = \"cpu\"\naccount = \"ice\"\noptions = [\"--qos=low\"]\npoll = \"2 s\"\n");
  EXPECT_EQ(e.limits.time, 600);
  EXPECT_EQ(e.limits.memory, 1.5 * (1 << 30));
  EXPECT_EQ(e.slurm.partition, "cpu");
  EXPECT_EQ(e.slurm.account, "ice");
  EXPECT_EQ(e.slurm.options, std::vector<std::string>{"--qos=low"});
  EXPECT_EQ(e.slurm.poll, 2);
  EXPECT_EQ(read("").limits.time, 0);
  const auto refused = [&](const std::string& text, const std::string& message) {
    EXPECT_THAT([&] { read(text); }, testing::ThrowsMessage<InputError>(HasSubstr(message)));
  };
  refused("[execution]\ntime_limit = 10\n", "execution.time_limit");
  refused("[execution]\ntime_limit = \"-1 s\"\n", "execution.time_limit");
  refused("[execution]\nmemory_limit = \"2 G\"\n", "is not an amount of memory");
  refused("[execution]\nmemory_limit = \"-2 GiB\"\n", "is not an amount of memory");
  refused("[execution]\nmemory_limits = \"2 GiB\"\n", "memory_limit");
  for (const char* option : {"low", "--wrap=touch x", "--wra=x", "--export=LD_PRELOAD=x.so", "-J",
                             "--container=x", "--output=/x", "job.sh", "--", "--qos =x"})
    refused(std::string("[execution.slurm]\noptions = [\"") + option + "\"]\n",
            "is not an option of sbatch");
}

TEST(Execution, DoesNotMakeAnotherStudy) {
  const std::string text = friction_study(angle_target);
  EXPECT_EQ(study_identity(text, "s"),
            study_identity(text + "# a remark\n[execution]\ntime_limit = \"1 min\"\n", "s"));
  EXPECT_NE(study_identity(text, "s"),
            study_identity(text + "[[observe]]\nresponse = \"rate\"\n", "s"));
}

}  // namespace
}  // namespace firn
