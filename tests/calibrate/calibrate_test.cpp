// Whole studies of formulas whose answer is known.
#include "calibrate/calibrate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <nlohmann/json.hpp>
#include <set>

#include "calibrate/calibration.h"
#include "experiments/storage/sqlite_file.h"
#include "tests/support/fake_experiment.h"
#include "tests/support/replaced.h"

namespace firn {
namespace {

using nlohmann::json;
using test::replaced;
using testing::HasSubstr;
using Values = FakeExperiment::Values;

JobResult noisy_zhou(const Values& v, std::mt19937_64& random) {
  return finished({scalar("aor", zhou_angle(v) * (1 + 0.08 * normal_deviate(random)), "deg")});
}

// Two responses whose iso-lines cross; both targets are met at mu1 = 0.06, mu2 = 0.15 alone.
constexpr double true_mu1 = 0.06, true_mu2 = 0.15;
JobResult crossing(const Values& v, std::mt19937_64& random) {
  const double x = v.at("a.mu1") / true_mu1, y = v.at("a.mu2") / true_mu2;
  return finished(
      {scalar("aor", 10 * std::pow(x, 0.5) * std::pow(y, 0.2) + 0.4 * normal_deviate(random),
              "deg"),
       scalar("rate", 40 * std::pow(x, -0.2) * std::pow(y, -0.4) + 0.8 * normal_deviate(random),
              "g/s")});
}

TEST(Calibrate, RecoversParametersThatTheDataDetermine) {
  const Folder folder("unique");
  FakeExperiment experiment(crossing);
  const std::string study = folder.write(
      "study.toml", friction_study(angle_target + "[[targets]]\nresponse = \"rate\"\n"
                                                  "value = \"40 g/s\"\nuncertainty = \"1 g/s\"\n"));
  const StudySummary s = run_study(study, folder / "out", experiment);
  EXPECT_EQ(s.verdict, StudyVerdict::calibrated) << s.table;
  EXPECT_EQ(s.exit_status(), 0);
  const json j = json::parse(s.json);
  const double truth[] = {true_mu1, true_mu2};
  for (std::size_t i = 0; i < 2; ++i) {
    const json& p = j["parameters"][i];
    EXPECT_LT(p["interval_95"][0], truth[i]);
    EXPECT_GT(p["interval_95"][1], truth[i]);
    EXPECT_LT(p["posterior_to_prior_sd"], 0.3);
    EXPECT_FALSE(p["at_min"].get<bool>() || p["at_max"].get<bool>());
  }
  EXPECT_TRUE(j["ridge"].empty());
  for (const json& c : j["combinations"]) EXPECT_TRUE(c["identifiable"].get<bool>());
  // Only fresh runs are reported, and they agree.
  EXPECT_EQ(j["estimate"]["runs"]["finished"], 5);
  EXPECT_NEAR(j["estimate"]["simulated"]["aor"]["value"].get<double>(), 10, 1.1);
}

TEST(Calibrate, OneAngleDeterminesOneCombinationOfTwoFrictions) {
  const Folder folder("valley");
  FakeExperiment experiment(noisy_zhou);
  const StudySummary s = run_study(folder.write("study.toml", friction_study(angle_target)),
                                   folder / "out", experiment);
  EXPECT_EQ(s.verdict, StudyVerdict::not_identifiable);
  const json j = json::parse(s.json);
  const json &determined = j["combinations"][0], &open = j["combinations"][1];
  EXPECT_TRUE(determined["identifiable"].get<bool>());
  EXPECT_FALSE(open["identifiable"].get<bool>());
  EXPECT_TRUE(open["uncertainty"].is_null());  // not zero: the data say nothing there
  // 0.27 ln mu1 + 0.22 ln mu2 = ln(10 / 35), at unit length of the coefficients.
  const double norm = std::hypot(0.27, 0.22), sd = determined["uncertainty"].get<double>();
  // 8 % of noise on 8 points with two seeds over 0.9 (one standard deviation of the logarithms)
  // leaves 0.02 to each slope, 0.065 to the direction: three times that.
  EXPECT_NEAR(determined["terms"][0]["coefficient"].get<double>(), 0.27 / norm, 0.19);
  EXPECT_NEAR(determined["terms"][1]["coefficient"].get<double>(), 0.22 / norm, 0.19);
  EXPECT_NEAR(determined["value"].get<double>(), std::log(10.0 / 35) / norm, 3 * sd);
  EXPECT_GT(sd, 0.05);  // the measurement alone: 0.05 / norm = 0.14
  EXPECT_LT(sd, 0.6);
  // Members of the valley are far apart and truly give the target.
  ASSERT_EQ(j["ridge"].size(), 5u);
  const auto mu1 = [&](std::size_t i) { return j["ridge"][i]["parameters"]["mu1"].get<double>(); };
  EXPECT_GT(mu1(4) / mu1(0), 4);
  for (const json& member : j["ridge"])
    EXPECT_NEAR(zhou_angle({{"a.mu1", member["parameters"]["mu1"]},
                            {"a.mu2", member["parameters"]["mu2"]}}),
                10, 1.2);
  EXPECT_THAT(s.table, HasSubstr("not determined:"));
}

TEST(Calibrate, APriorOnOneFrictionDeterminesTheOther) {
  const Folder folder("prior");
  FakeExperiment experiment(noisy_zhou);
  std::string text = friction_study(angle_target);
  text.insert(text.find("max = 0.5\n"), "prior_mean = 0.1\nprior_sd = 0.01\n");
  const json j =
      json::parse(run_study(folder.write("study.toml", text), folder / "out", experiment).json);
  // mu1 from 35 mu1^0.27 0.1^0.22 = 10.
  const double mu1 = std::pow(10.0 / 35 / std::pow(0.1, 0.22), 1 / 0.27);
  EXPECT_LT(j["parameters"][0]["interval_95"][0], mu1);
  EXPECT_GT(j["parameters"][0]["interval_95"][1], mu1);
  EXPECT_LT(j["parameters"][0]["posterior_to_prior_sd"], 0.5);
}

TEST(Calibrate, SaysSoWhenTheTargetIsOutOfReach) {
  const Folder folder("reach");
  FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
    return finished(
        {scalar("aor", 2 * zhou_angle(v) + 0.3 * normal_deviate(random), "deg")});  // 9.3 to 43 deg
  });
  const std::string text = replaced(friction_study(angle_target), "10 deg", "2.5 deg");
  const StudySummary s = run_study(folder.write("study.toml", text), folder / "out", experiment);
  EXPECT_EQ(s.verdict, StudyVerdict::infeasible);
  EXPECT_THAT(s.headline, HasSubstr("infeasible within the ranges: aor = 2.5 deg"));
  EXPECT_EQ(experiment.runs, 3 + 8 * 2 + 3 * 2 + 5);  // the nearest parameters are simulated first
  EXPECT_GE(json::parse(s.json)["estimate"]["simulated"]["aor"]["value"], 8);
  EXPECT_FALSE(json::parse(s.json)["targets"][0]["reach"]["reachable"].get<bool>());
}

TEST(Calibrate, TargetsThatContradictEachOtherAreOutOfReachTogether) {
  const Folder folder("contradiction");
  FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
    const double a = zhou_angle(v);
    return finished({scalar("aor", a + 0.3 * normal_deviate(random), "deg"),
                     scalar("twice", 2 * a + 0.3 * normal_deviate(random), "deg")});
  });
  const StudySummary s = run_study(
      folder.write("study.toml", friction_study(angle_target +
                                                "[[targets]]\nresponse = \"twice\"\n"
                                                "value = \"14 deg\"\nuncertainty = \"0.5 deg\"\n")),
      folder / "out", experiment);
  EXPECT_EQ(s.verdict, StudyVerdict::infeasible);
  EXPECT_THAT(s.headline, HasSubstr("no parameters within the ranges meet all targets at once"));
}

TEST(Calibrate, FailedAndArchedRunsAreCountedAndKeptOutOfTheFit) {
  const Folder folder("arched");
  int failures = 0;
  FakeExperiment experiment([&](const Values& v, std::mt19937_64& random) {
    if (v.at("a.mu1") > 0.12)
      return JobResult{JobStatus::arched, "the flow arched", {scalar("aor", 45, "deg")}, 1};
    if (v.at("a.mu1") < 0.02) {
      ++failures;
      return JobResult{JobStatus::failed, "a value is not finite", {}, 1};
    }
    return noisy_zhou(v, random);
  });
  const StudySummary s = run_study(folder.write("study.toml", friction_study(angle_target)),
                                   folder / "out", experiment);
  EXPECT_NE(s.verdict, StudyVerdict::too_few_runs);
  const json j = json::parse(s.json);
  EXPECT_GT(j["runs"]["arched"], 0);
  EXPECT_EQ(j["runs"]["failed"], failures);
  EXPECT_GT(failures, 0);
  // The answer keeps away from where the flow stops: the experiment's did not.
  EXPECT_LT(j["estimate"]["parameters"]["mu1"], 0.15);
  EXPECT_THAT(read_text(folder / "out/runs.csv"), HasSubstr("a value is not finite"));
}

TEST(Calibrate, EndsWithStatusOneWhenNothingFinishes) {
  const Folder folder("nothing");
  FakeExperiment experiment([](const Values&, std::mt19937_64&) {
    return JobResult{JobStatus::failed, "runaway energy", {}, 1};
  });
  const StudySummary s = run_study(folder.write("study.toml", friction_study(angle_target)),
                                   folder / "out", experiment);
  EXPECT_EQ(s.verdict, StudyVerdict::too_few_runs);
  EXPECT_EQ(s.exit_status(), 1);
}

TEST(Calibrate, AnAnswerThatFreshRunsContradictIsNotConfirmed) {
  const Folder folder("contradicted");
  FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
    const double seed = v.at("case.seed");
    const bool confirms = seed > confirm_seeds && seed < design_seeds;
    return finished(
        {scalar("aor", zhou_angle(v) + (confirms ? 5 : 0) + 0.2 * normal_deviate(random), "deg")});
  });
  const StudySummary s = run_study(folder.write("study.toml", friction_study(angle_target)),
                                   folder / "out", experiment);
  EXPECT_EQ(s.verdict, StudyVerdict::unconfirmed);
  EXPECT_GT(json::parse(s.json)["estimate"]["simulated"]["aor"]["value"], 13);
}

TEST(Calibrate, ResponsesThatAreNotNumbersStayOutOfTheFit) {
  const Folder folder("nan");
  FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
    JobResult r = noisy_zhou(v, random);
    const auto seed = static_cast<std::uint64_t>(v.at("case.seed"));
    if (seed == 2 || (seed > design_seeds && seed % 2 == 0)) r.responses[0].value[0] = std::nan("");
    return r;
  });
  const StudySummary s = run_study(folder.write("study.toml", friction_study(angle_target)),
                                   folder / "out", experiment);
  EXPECT_EQ(s.verdict, StudyVerdict::not_identifiable);
  // At the center, seeds 1 and 3 remain: one degree of freedom. Elsewhere one seed of two. The five
  // fresh seeds of the confirmation give four more.
  EXPECT_EQ(json::parse(s.json)["models"][0]["seed_noise"]["degrees_of_freedom"], 1 + 4);
}

TEST(Calibrate, AProcessThatDiedIsTriedOnceMore) {
  const Folder folder("crash");
  std::set<std::string> tried;
  FakeExperiment* self = nullptr;
  std::string key;
  FakeExperiment experiment([&](const Values& v, std::mt19937_64& random) {
    if (tried.insert(key).second && self->runs % 7 == 0)
      return JobResult{JobStatus::crashed, "killed by signal 9", {}, 1};
    return noisy_zhou(v, random);
  });
  self = &experiment;
  experiment.on_run = [&](const Job& job) { key = job.key; };
  const StudySummary s = run_study(folder.write("study.toml", friction_study(angle_target)),
                                   folder / "out", experiment);
  const json j = json::parse(s.json);
  EXPECT_EQ(j["runs"]["failed"], 0);
  EXPECT_GT(experiment.runs, j["runs"]["total"].get<int>());
}

TEST(Calibrate, ComparesNamedSetsAndSharesTheirRunsWithTheFit) {
  const Folder folder("compare");
  FakeExperiment experiment(noisy_zhou);
  const std::string sets =
      "[[compare]]\nname = \"paper text\"\nvalues = { mu1 = 0.1, mu2 = 0.3 }\n"
      "[[compare]]\nname = \"paper table\"\nvalues = { mu1 = 0.1, mu2 = 0.2 }\n";
  const StudySummary s = run_study(folder.write("study.toml", friction_study(angle_target + sets)),
                                   folder / "out", experiment);
  const json j = json::parse(s.json);
  ASSERT_EQ(j["compare"].size(), 2u);
  const double text = zhou_angle({{"a.mu1", 0.1}, {"a.mu2", 0.3}});
  EXPECT_NEAR(j["compare"][0]["simulated"]["aor"]["value"].get<double>(), text, 4 * 0.08 * text);
  EXPECT_EQ(j["models"][0]["points"], 2 + 1 + 8 + 3 + 1);  // the answer's own among them
  EXPECT_THAT(s.table, HasSubstr("paper table"));
  EXPECT_THAT(s.table, HasSubstr(" deg"));
  EXPECT_THAT(s.table, testing::Not(testing::ContainsRegex("[0-9]deg")));
}

TEST(Calibrate, DrawsTheFittedResponse) {
  const Folder folder("plot");
  FakeExperiment experiment(noisy_zhou);
  StudyOptions options;
  const std::string text = replaced(friction_study(angle_target), "\"mu1\"", "\"ice_friction\"");
  options.study_file = folder.write("study.toml", text);
  options.directory = folder / "it's drawn";
  options.show_progress = false;
  options.replace_executor = &experiment;
  calibrate(options);
  EXPECT_EQ(read_text(folder / "it's drawn/fitted_response.png").substr(1, 3), "PNG");
  const std::string svg = read_text(folder / "it's drawn/fitted_response.svg");
  EXPECT_THAT(svg, HasSubstr("equally good"));
  EXPECT_THAT(svg, HasSubstr("</svg>"));
  // Axes have words, not keys.
  EXPECT_THAT(svg, HasSubstr(">ice friction<"));
}

// Names of parameters and of compared sets are text of the pictures, and no commands.
TEST(Calibrate, NamesAreNoCommandsOfThePlot) {
  for (const int parameters : {1, 2}) {
    const Folder folder("hostile");
    const FakeExperiment::Formula line = [](const Values& v, std::mt19937_64& random) {
      return finished({scalar("aor", 40 * v.at("a.mu1") + 0.1 * normal_deviate(random), "deg")});
    };
    FakeExperiment experiment(parameters == 1 ? line : noisy_zhou);
    const std::string mark = folder / "MARK";
    setenv("MARK", mark.c_str(), 1);  // names have no slashes
    const std::string attack =
        "`touch $MARK`'.system('touch $MARK').'\\\".system(\\\"touch $MARK\\\").\\\"@GPVAL_PWD "
        "{Symbol a}";
    std::string text = friction_study(angle_target);
    const auto name = text.find("\"mu1\"");
    text.replace(name, 5, '"' + attack + '"');
    if (parameters == 1) {
      const auto second = text.find("[[parameters]]", name);
      text.erase(second, text.find("[[targets]]") - second);
    } else {
      text += "[[compare]]\nname = \"" + attack + "\"\nvalues = { \"" + attack +
              "\" = 0.05, mu2 = 0.1 }\n";
    }
    StudyOptions options;
    options.study_file = folder.write("study.toml", text);
    options.directory = folder / "out";
    options.show_progress = false;
    options.replace_executor = &experiment;
    calibrate(options);
    EXPECT_THAT(read_text(folder / "out/fitted_response.svg"), HasSubstr("{Symbol a}"));
    EXPECT_FALSE(std::filesystem::exists(mark)) << parameters << " parameters";
  }
}

TEST(Calibrate, RefusesADirectoryThatHoldsAnotherStudy) {
  const Folder folder("other");
  FakeExperiment experiment(noisy_zhou);
  const std::string text = friction_study(angle_target);
  run_study(folder.write("study.toml", text), folder / "out", experiment);
  const std::string other = folder.write("other.toml", text + "[[observe]]\nresponse = \"rate\"\n");
  EXPECT_THROW(run_study(other, folder / "out", experiment), InputError);
  StudyOptions resume;
  resume.study_file = other;
  resume.directory = folder / "empty";
  resume.resume = true;
  resume.replace_executor = &experiment;
  EXPECT_THROW(calibrate(resume), InputError);
}

TEST(Calibrate, NamesResponsesThatTheCaseDoesNotHave) {
  const Folder folder("missing");
  FakeExperiment experiment(
      [](const Values&, std::mt19937_64&) { return finished({scalar("angle", 1, "deg")}); });
  const std::string study = folder.write("study.toml", friction_study(angle_target));
  EXPECT_THAT([&] { run_study(study, folder / "out", experiment); },
              testing::ThrowsMessage<InputError>(HasSubstr("expected one of angle")));
}

TEST(Resume, ARepeatedCommandRunsNothingAgain) {
  const Folder folder("again");
  const std::string study = folder.write("study.toml", friction_study(angle_target));
  FakeExperiment first(noisy_zhou), second(noisy_zhou);
  const StudySummary a = run_study(study, folder / "out", first);
  const StudySummary b = run_study(study, folder / "out", second);
  EXPECT_EQ(first.runs, 30);
  EXPECT_EQ(second.runs, 0);
  EXPECT_EQ(a.json, b.json);
}

TEST(Resume, AnInterruptedStudyGoesOnToTheSameAnswer) {
  const Folder folder("interrupt");
  const std::string study = folder.write("study.toml", friction_study(angle_target));
  FakeExperiment whole(noisy_zhou);
  const StudySummary expected = run_study(study, folder / "whole", whole);
  FakeExperiment stopped(noisy_zhou);
  std::atomic<bool> interrupt = false;
  stopped.on_run = [&](const Job&) { interrupt = stopped.stop = stopped.runs == 5; };
  StudyOptions options;
  options.study_file = study;
  options.directory = folder / "out";
  options.show_progress = options.plot = false;
  options.interrupt = &interrupt;
  options.replace_executor = &stopped;
  const StudySummary s = calibrate(options);
  EXPECT_EQ(s.verdict, StudyVerdict::interrupted);
  EXPECT_EQ(s.exit_status(), 130);
  FakeExperiment rest(noisy_zhou);
  EXPECT_EQ(run_study(study, folder / "out", rest).json, expected.json);
  EXPECT_EQ(stopped.runs + rest.runs, whole.runs);
}

// Runs the study in a separate process that kills itself after some events; true when it got
// through before. `log` gathers a line as each run starts and as each has been reported.
bool run_and_kill(const std::string& study, const std::string& directory, const std::string& log,
                  int events) {
  const pid_t child = fork();
  if (child == 0) {
    FakeExperiment experiment(noisy_zhou);
    const auto event = [&](const char* what, const Job& job) {
      std::ofstream(log, std::ios::app) << what << ' ' << job.key << '\n';
      if (--events == 0) kill(getpid(), SIGKILL);
    };
    experiment.on_run = [&](const Job& job) { event("start", job); };
    experiment.on_ended = [&](const Job& job) { event("end", job); };
    run_study(study, directory, experiment);
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST(Resume, KilledAgainAndAgainItReachesTheSameAnswerAndRepeatsNothing) {
  const Folder folder("kill");
  const std::string study = folder.write("study.toml", friction_study(angle_target));
  FakeExperiment whole(noisy_zhou);
  const StudySummary expected = run_study(study, folder / "whole", whole);
  std::mt19937_64 random(7);
  int sessions = 1;
  while (!run_and_kill(study, folder / "out", folder / "log", 1 + static_cast<int>(random() % 9)))
    ASSERT_LT(++sessions, 200);
  EXPECT_GT(sessions, 5);
  EXPECT_EQ(read_text(folder / "out/results.json"), expected.json + "\n");
  std::set<std::string> ended;
  std::ifstream log(folder / "log");
  for (std::string what, key; log >> what >> key;) {
    if (what == "end")
      ended.insert(key);
    else
      EXPECT_FALSE(ended.contains(key)) << "a finished run was repeated";
  }
  EXPECT_EQ(static_cast<int>(ended.size()), whole.runs);
}

// What the study claims of the determined combination is about as often true as it says.
TEST(CalibrateLong, IntervalsCoverTheTruth) {
  const double norm = std::hypot(0.27, 0.22), truth = std::log(10.0 / 35) / norm;
  double squares = 0;
  constexpr int studies = 40;
  for (int i = 0; i < studies; ++i) {
    const Folder folder("coverage");
    // The measurement scatters as it says it does: 0.5 deg about 10 deg.
    std::mt19937_64 scatter(static_cast<std::uint64_t>(100 + i));
    const std::string text = replaced(
        replaced(friction_study(angle_target), "seed = 1", "seed = " + std::to_string(10000 * i)),
        "10 deg", std::to_string(10 + 0.5 * normal_deviate(scatter)) + " deg");
    FakeExperiment experiment(noisy_zhou);
    const json j =
        json::parse(run_study(folder.write("study.toml", text), folder / "out", experiment).json);
    const json& c = j["combinations"][0];
    // Along its own direction: coefficients are estimated too, so judge at the middle of the
    // valley.
    const double a = c["terms"][0]["coefficient"], b = c["terms"][1]["coefficient"];
    const double mu2 = j["estimate"]["parameters"]["mu2"];
    const double mu1 = std::exp((truth * norm - 0.22 * std::log(mu2)) / 0.27);
    squares += std::pow((a * std::log(mu1) + b * std::log(mu2) - c["value"].get<double>()) /
                            c["uncertainty"].get<double>(),
                        2);
  }
  EXPECT_GT(squares / studies, 0.4);
  EXPECT_LT(squares / studies, 1.7);
}

// One simulation in the first that returns what no measurement can be: that run has failed, the
// study continues. The same of a journal in which such numbers were written.
TEST(Calibrate, AbsurdResponsesEndTheirRunAlone) {
  const std::string target = angle_target;
  for (const double absurd : {1e200, -1e200, 1e308, 1e31, HUGE_VAL}) {
    const Folder folder("absurd");
    int runs = 0;
    FakeExperiment experiment([&](const Values& v, std::mt19937_64& random) {
      JobResult result = noisy_zhou(v, random);
      if (++runs == 2) result.responses[0].value = {absurd};
      return result;
    });
    const std::string study = folder.write("study.toml", friction_study(target));
    const StudySummary s = run_study(study, folder / "out", experiment);
    EXPECT_EQ(s.exit_status(), 0) << s.table;
    EXPECT_EQ(json::parse(s.json)["runs"]["failed"], 1) << absurd;

    sqlite::File journal(folder / "out/study.db", sqlite::File::Access::write);
    journal.execute(
        "UPDATE responses SET value = 1e308 WHERE run IN (SELECT key FROM runs WHERE number % 5 = "
        "0)");
    journal.execute("UPDATE runs SET wall = -1e308 WHERE number % 7 = 0");
    const StudySummary again = run_study(study, folder / "out", experiment);
    EXPECT_GT(json::parse(again.json)["runs"]["failed"], 1) << absurd;
  }
}

}  // namespace
}  // namespace firn
