// Studies of several experiments, numerics checks, advice, stopping, limits and direct search, on
// formulas whose answers are known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "calibrate/calibrate.h"
#include "calibrate/study/study_file.h"
#include "experiments/analysis/sample_statistics.h"
#include "tests/support/fake_experiment.h"
#include "tests/support/replaced.h"

namespace firn {
namespace {

using nlohmann::json;
using test::replaced;
using testing::HasSubstr;
using Values = FakeExperiment::Values;

// The angle of a heap depends on both frictions, that of a slide on the wall on mu2 alone.
double slide(const Values& v) { return std::atan(v.at("a.mu2")) * 180 / M_PI; }

// The keys distinguish the experiments: a run is given only those of its case.
JobResult bench(const Values& v, std::mt19937_64& random) {
  if (!v.contains("a.mu1"))
    return finished({scalar("slide_angle", slide(v) + 0.3 * normal_deviate(random), "deg"),
                     scalar("bounce", 0.3 + 0.01 * normal_deviate(random), "1")});
  const double step = v.contains("case.timestep") ? v.at("case.timestep") : 1;
  return finished(
      {scalar("aor", zhou_angle(v) + 3 * (1 - step) + 0.4 * normal_deviate(random), "deg")});
}

std::string two_experiments(const std::string& more,
                            const std::string& budget =
                                "center_replicates = 3\ndesign_points = 8\n"
                                "replicates_per_point = 2\nconfirm_runs = 4\n") {
  std::string text = friction_study(more, budget);
  const std::string head = "case = \"case.toml\"\n";
  text.erase(text.find(head), head.size());
  return text +
         "\n[[experiments]]\nname = \"drained\"\ncase = \"case.toml\"\n"
         "[[experiments]]\nname = \"slide\"\ncase = \"case.toml\"\nparameters = [\"mu2\"]\n";
}

const std::string heap_target =
    "[[targets]]\nexperiment = \"drained\"\nresponse = \"aor\"\nvalue = \"10 deg\"\n"
    "uncertainty = \"0.5 deg\"\n";
const std::string slide_target =
    "[[targets]]\nexperiment = \"slide\"\nresponse = \"slide_angle\"\nvalue = \"8.5 deg\"\n"
    "uncertainty = \"0.5 deg\"\n";
const std::string slide_candidate =
    "[[observe]]\nexperiment = \"slide\"\nresponse = \"slide_angle\"\nuncertainty = \"0.5 deg\"\n";
const std::string bounce_candidate =
    "[[observe]]\nexperiment = \"slide\"\nresponse = \"bounce\"\nuncertainty = \"0.02\"\n";

TEST(Experiments, ASecondTestDeterminesWhatTheFirstLeavesOpen) {
  const Folder folder("two");
  FakeExperiment experiment(bench);
  const StudySummary s =
      run_study(folder.write("study.toml", two_experiments(heap_target + slide_target)),
                folder / "out", experiment);
  EXPECT_EQ(s.verdict, StudyVerdict::calibrated) << s.table;
  const json j = json::parse(s.json);
  const double mu2 = std::tan(8.5 * M_PI / 180);
  const double mu1 = std::pow(10.0 / 35 / std::pow(mu2, 0.22), 1 / 0.27);
  EXPECT_LT(j["parameters"][0]["interval_95"][0], mu1);
  EXPECT_GT(j["parameters"][0]["interval_95"][1], mu1);
  EXPECT_LT(j["parameters"][1]["interval_95"][0], mu2);
  EXPECT_GT(j["parameters"][1]["interval_95"][1], mu2);
  // The profile agrees where the posterior is near to normal.
  EXPECT_NEAR(std::log(j["parameters"][1]["profile"]["interval_95"][1].get<double>() /
                       j["parameters"][1]["interval_95"][1].get<double>()),
              0, 0.05);
  // The slide is all mu2's doing.
  const json& slides = j["sensitivity"][1];
  EXPECT_EQ(slides["response"], "slide.slide_angle");
  EXPECT_LT(slides["parameters"]["mu1"]["total"], 0.03);
  EXPECT_GT(slides["parameters"]["mu2"]["total"], 0.95);
  EXPECT_THAT(read_text(folder / "out/runs.csv"), HasSubstr(",slide,design,"));
}

TEST(Experiments, RunsThatDoNotDependOnAParameterAreMadeOnce) {
  // Nothing varies for the slide but the seed.
  const Folder folder("shared");
  std::map<double, int> slides;  // by seed
  FakeExperiment experiment([&](const Values& v, std::mt19937_64& random) {
    if (!v.contains("a.mu1")) ++slides[v.at("case.seed")];
    return bench(v, random);
  });
  std::string text = two_experiments(heap_target);
  text.replace(text.rfind("[\"mu2\"]"), 7, "[]");
  text += "set = { \"a.mu2\" = 0.2 }\n";
  run_study(folder.write("study.toml", text), folder / "out", experiment);
  EXPECT_EQ(slides.size(), 3 + 2 * 8 + 4u);  // at the center, of the design, and of the answer
  for (const auto& [seed, count] : slides) EXPECT_EQ(count, 1) << seed;
}

TEST(Seeds, ScatterOfTheSeedAloneDoesNotShiftTheModel) {
  // The scatter is the same wherever a seed runs, as that of a throw with a random height: points
  // with the same seeds would all be off by the same amount.
  double squares = 0;
  constexpr int studies = 12;
  for (int s = 0; s < studies; ++s) {
    const Folder folder("seeds");
    FakeExperiment experiment([s](const Values& v, std::mt19937_64&) {
      std::mt19937_64 random(static_cast<std::uint64_t>(v.at("case.seed")) * 7919 +
                             static_cast<std::uint64_t>(s));
      return finished({scalar("aor", zhou_angle(v) + normal_deviate(random), "deg")});
    });
    const std::string target =
        "[[targets]]\nresponse = \"aor\"\nvalue = \"10 deg\"\nuncertainty = \"0.3 deg\"\n";
    const StudySummary summary =
        run_study(folder.write("study.toml", friction_study(target, "runs = 60\n")), folder / "out",
                  experiment);
    const json answer = json::parse(summary.json)["estimate"];
    const json& fit = answer["fit"]["aor"];
    const double truth = zhou_angle(
        {{"a.mu1", answer["parameters"]["mu1"]}, {"a.mu2", answer["parameters"]["mu2"]}});
    squares += std::pow((fit["value"].get<double>() - truth) / fit["uncertainty"].get<double>(), 2);
  }
  EXPECT_LT(std::sqrt(squares / studies), 1.6);
}

TEST(MeasurementValue, RanksTheTestThatCutsTheValleyFirst) {
  const Folder folder("advice");
  FakeExperiment experiment(bench);
  std::vector<double> extents, of_bounce, of_heap;
  for (int seed = 1; seed <= 6; ++seed) {
    const std::string text =
        replaced(two_experiments(heap_target + slide_candidate + bounce_candidate), "seed = 1",
                 "seed = " + std::to_string(seed));
    const json j = json::parse(
        run_study(folder.write("study.toml", text), folder / std::to_string(seed), experiment)
            .json);
    const json& next = j["measure_next"];
    ASSERT_EQ(next.size(), 3u);
    EXPECT_EQ(next[0]["response"], "slide.slide_angle");
    EXPECT_LT(next[0]["remaining_extent"], 0.5);
    for (const json& other : {next[1], next[2]}) {
      extents.push_back(other["remaining_extent"]);
      (other["response"] == "slide.bounce" ? of_bounce : of_heap)
          .push_back(other["information_bits"]);
    }
  }
  EXPECT_GT(median(extents), 0.97);
  EXPECT_LT(median(of_bounce), 0.05);  // knows nothing of friction
  // Once more: across the valley by less than half of a bit, along it by nothing.
  EXPECT_LT(*std::max_element(of_heap.begin(), of_heap.end()), 0.5);
}

TEST(MeasurementValue, EffortCounts) {
  const Folder folder("effort");
  FakeExperiment experiment(bench);
  const json j = json::parse(
      run_study(
          folder.write("study.toml", two_experiments(heap_target + "effort = \"1 min\"\n" +
                                                     slide_candidate + "effort = \"1000 h\"\n")),
          folder / "out", experiment)
          .json);
  EXPECT_EQ(j["measure_next"][0]["response"], "drained.aor");
  EXPECT_GT(j["measure_next"][1]["information_bits"], j["measure_next"][0]["information_bits"]);
}

// One linear parameter p on [0, 1], known to 0.05 by a measurement: its outcome is worth
// ln(1 + s^2 / u^2) / 2 nats, and leaves s u / sqrt(s^2 + u^2).
TEST(MeasurementValue, OfAGaussianInClosedForm) {
  const Folder folder("gauss");
  FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
    return finished({scalar("y", v.at("p") + 1e-4 * normal_deviate(random), "1")});
  });
  const std::string text =
      "[study]\nname = \"fake\"\ncase = \"case.toml\"\n[budget]\ncentre_runs = 2\n"
      "design_points = 6\nruns_per_point = 2\n[[parameters]]\nname = \"p\"\nkeys = [\"p\"]\nmin = "
      "0\nmax = 1\n[[targets]]\nresponse = \"y\"\nvalue = 0.5\nuncertainty = 0.05\n";
  const json j =
      json::parse(run_study(folder.write("study.toml", text), folder / "out", experiment).json);
  // 1024 samples determine s^2 to about 6 %, and so the bits to 0.02.
  EXPECT_NEAR(j["measure_next"][0]["information_bits"], 0.5 * std::log2(2.0), 0.06);
  EXPECT_NEAR(j["measure_next"][0]["remaining_extent"], std::sqrt(0.5), 0.02);
}

// Where the runs scatter more than the measurement, a second measurement halves the variance u^2 of
// the measurement alone, and leaves v of the model: sqrt((v + u^2 / 2) / (v + u^2)) of the width.
TEST(MeasurementValue, OfARepeatWhereTheRunsScatter) {
  for (const double noise : {0.02, 0.1, 0.3}) {
    const Folder folder("scatter");
    FakeExperiment experiment([noise](const Values& v, std::mt19937_64& random) {
      return finished({scalar("y", v.at("p") + noise * normal_deviate(random), "1")});
    });
    const std::string text =
        "[study]\nname = \"fake\"\ncase = \"case.toml\"\n[budget]\nruns = 30\n"
        "[[parameters]]\nname = \"p\"\nkeys = [\"p\"]\nmin = "
        "0\nmax = 1\n[[targets]]\nresponse = \"y\"\nvalue = 0.5\nuncertainty = 0.03\n";
    const json j =
        json::parse(run_study(folder.write("study.toml", text), folder / "out", experiment).json);
    const json& split = j["targets"][0]["uncertainty_at_estimate"];
    const double u = split["measurement"];
    const double v = std::pow(split["seed_noise"].get<double>(), 2) +
                     std::pow(split["surrogate"].get<double>(), 2);
    EXPECT_NEAR(j["measure_next"][0]["remaining_extent"], std::sqrt((v + u * u / 2) / (v + u * u)),
                0.04)
        << "noise " << noise << ", " << std::sqrt(v) << " of the model";
  }
}

TEST(Numerics, AStepThatMattersIsNamed) {
  const Folder folder("numerics");
  FakeExperiment experiment(bench);
  const StudySummary s = run_study(
      folder.write("study.toml",
                   two_experiments(heap_target + "[[numerics]]\nname = \"half the step\"\nset = { "
                                                 "\"case.timestep\" = 0.5 }\n"
                                                 "[[numerics]]\nname = \"the same step\"\nset = { "
                                                 "\"case.timestep\" = 1 }\n")),
      folder / "out", experiment);
  const json n = json::parse(s.json)["numerics"];
  ASSERT_EQ(n.size(), 2u);
  EXPECT_NEAR(n[0]["shifts"]["drained.aor"]["shift"], 1.5, 1.0);
  EXPECT_NEAR(n[1]["shifts"]["drained.aor"]["shift"], 0, 1.0);
  EXPECT_NEAR(n[0]["shifts"]["drained.aor"]["standard_error"], 0.4 * std::sqrt(1.0 / 2 + 1.0 / 3),
              0.2);
  EXPECT_THAT(s.table, HasSubstr("half the step"));
}

TEST(Refinement, StopsWhenFurtherRunsCannotHelp) {
  // The measurement is coarse and the simulation quiet: nothing left to learn by simulating.
  const Folder folder("stop");
  FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
    return finished({scalar("aor", zhou_angle(v) * (1 + 0.005 * normal_deviate(random)), "deg")});
  });
  std::string text = friction_study(
      "[[targets]]\nresponse = \"aor\"\nvalue = \"10 deg\"\nuncertainty = \"2 deg\"\n",
      "center_replicates = 3\ndesign_points = 8\nruns_per_point = 2\nrefine_rounds = 10\n");
  const StudySummary s = run_study(folder.write("study.toml", text), folder / "out", experiment);
  const json j = json::parse(s.json);
  EXPECT_EQ(j["refinement"]["rounds"], 0);
  EXPECT_THAT(j["refinement"]["stopped"].get<std::string>(), HasSubstr("further runs cannot help"));
}

TEST(Refinement, GoesOnWhileItHelpsAndStopsAtTheTimeGiven) {
  const Folder folder("time");
  const auto noisy = [](const Values& v, std::mt19937_64& random) {
    JobResult r =
        finished({scalar("aor", zhou_angle(v) * (1 + 0.15 * normal_deviate(random)), "deg")});
    r.wall = 60;
    return r;
  };
  const auto rounds = [&](const std::string& time, const std::string& out) {
    FakeExperiment experiment(noisy);
    const std::string text = friction_study(
        "[[targets]]\nresponse = \"aor\"\nvalue = \"10 deg\"\nuncertainty = "
        "\"0.2 deg\"\n",
        "center_replicates = 3\ndesign_points = 6\nruns_per_point = 2\n"
        "confirmation_replicates = 2\nrefine_points = 2\ntime = \"" +
            time + "\"\n");
    const StudySummary s = run_study(folder.write(out + ".toml", text), folder / out, experiment);
    EXPECT_LE(experiment.runs, std::stoi(time)) << "more minutes than given";
    EXPECT_THAT(json::parse(s.json)["refinement"]["stopped"].get<std::string>(),
                HasSubstr("the budget's time is used"));
    return json::parse(s.json)["refinement"]["rounds"].get<int>();
  };
  // 15 minutes to explore, 4 a round, 2 to confirm.
  EXPECT_EQ(rounds("22 min", "short"), 1);
  EXPECT_EQ(rounds("34 min", "long"), 4);
}

TEST(Budget, ANumberOfRunsDividesItself) {
  const Folder folder("budget");
  for (const int runs : {24, 30, 56, 100, 200}) {
    const Study s = read_study(folder.write(
        "study.toml", friction_study(heap_target.substr(0, 12) + heap_target.substr(35) +
                                         "[[numerics]]\nname = \"n\"\nset = { a = 1 }\n",
                                     "runs = " + std::to_string(runs) + "\n")));
    EXPECT_LE(s.largest_total(), runs);
    EXPECT_GT(s.largest_total(), runs - 2 * s.budget.refine_points - 1) << runs;
    EXPECT_GE(s.budget.confirmation_replicates, 3);
  }
  const std::string few =
      friction_study(heap_target.substr(0, 12) + heap_target.substr(35), "runs = 8\n");
  EXPECT_THAT(folder.study_error(few), HasSubstr("budget.runs: 8 are too few"));
}

TEST(Budget, CostlyNumericsDoNotMakeTheRunsToComeCostly) {
  // Noise 3 x 1 s, numerics 2 x 100 s, design 16 x 1 s: 219 s. A round of six runs and the five
  // that confirm take 11 s more.
  const auto rounds_within = [](const std::string& time) {
    const Folder folder("time");
    FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
      JobResult r = finished({scalar("aor", zhou_angle(v) + 2 * normal_deviate(random), "deg")});
      if (v.contains("stiff")) r.wall = 100;
      return r;
    });
    const std::string study = friction_study(
        "[[targets]]\nresponse = \"aor\"\nvalue = \"10 deg\"\nuncertainty = \"0.5 deg\"\n"
        "[[numerics]]\nname = \"stiff\"\nset = { stiff = 1 }\n",
        "center_replicates = 3\nnumerics_runs = 2\ndesign_points = 8\nruns_per_point = 2\n"
        "refine_rounds = 2\nrefine_points = 3\nconfirm_runs = 5\ntime = \"" +
            time + "\"\n");
    const json j =
        json::parse(run_study(folder.write("study.toml", study), folder / "out", experiment).json);
    return j["refinement"]["rounds"].get<int>();
  };
  EXPECT_EQ(rounds_within("229 s"), 0);
  EXPECT_EQ(rounds_within("231 s"), 1);
  EXPECT_EQ(rounds_within("237 s"), 2);
}

TEST(Refinement, AModelThatDoesNotExplainItsRunsIsNamed) {
  // Smooth but for one spike, as narrow as one of the points of the design.
  const auto explains = [](double spike) {
    const Folder folder("spike");
    FakeExperiment experiment([&](const Values& v, std::mt19937_64& random) {
      const double away = std::log(v.at("a.mu1") / 0.0548) / 0.1;
      return finished({scalar(
          "aor", zhou_angle(v) + spike * std::exp(-away * away) + 0.1 * normal_deviate(random),
          "deg")});
    });
    const StudySummary s = run_study(
        folder.write(
            "study.toml",
            friction_study("[[targets]]\nresponse = \"aor\"\nvalue = \"10 deg\"\n"
                           "uncertainty = \"0.5 deg\"\n",
                           "center_replicates = 3\ndesign_points = 20\nruns_per_point = 2\n")),
        folder / "out", experiment);
    const bool is_stated = s.table.find("DOES NOT EXPLAIN ITS OWN RUNS") != std::string::npos;
    EXPECT_EQ(is_stated, !json::parse(s.json)["models"][0]["passes_cross_validation"].get<bool>());
    return !is_stated;
  };
  EXPECT_TRUE(explains(0));
  EXPECT_FALSE(explains(30));
}

TEST(Refinement, AValleyThatBendsIsDistinguishedFromAStraightOne) {
  // A quarter of a circle about one corner of the ranges: no combination holds along all of it.
  const Folder folder("bent");
  FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
    const double p = std::log(v.at("a.mu1") / 0.01) / std::log(30);
    const double q = std::log(v.at("a.mu2") / 0.03) / std::log(0.5 / 0.03);
    return finished({scalar("r", p * p + q * q + 1e-3 * normal_deviate(random), "1")});
  });
  const StudySummary s = run_study(
      folder.write("study.toml", friction_study("[[targets]]\nresponse = \"r\"\nvalue = 0.7\n"
                                                "uncertainty = 0.02\n")),
      folder / "out", experiment);
  EXPECT_THAT(s.table, HasSubstr("bend away from it"));
  const json c = json::parse(s.json)["combinations"][0];
  EXPECT_GT(c["spread_over_posterior"], 3 * c["uncertainty_near_estimate"].get<double>());
  EXPECT_GE(c["uncertainty"], c["spread_over_posterior"]);
}

TEST(Limits, RunsThatMeetALimitBiasNothing) {
  // Heaps of low friction take long to come to rest: those above 20 s meet the limit. The answer
  // lies among them, and must not be pushed away.
  const auto truth = [](const Values& v) { return 20 * std::sqrt(v.at("a.mu1") / 0.05); };
  const auto study = [&](double limit, int seed) {
    const Folder folder("limit");
    FakeExperiment experiment([&](const Values& v, std::mt19937_64& random) {
      const double wall = 1 / v.at("a.mu1") * (0.8 + 0.4 * std::abs(normal_deviate(random)));
      if (wall > limit) return JobResult{JobStatus::timed_out, "time limit", {}, limit};
      return finished({scalar("aor", truth(v) + 0.3 * normal_deviate(random), "deg")});
    });
    const std::string text = replaced(
        friction_study(
            "[[targets]]\nresponse = \"aor\"\nvalue = \"18 deg\"\nuncertainty = \"0.5 deg\"\n"),
        "seed = 1\n", "seed = " + std::to_string(seed) + "\n");
    return json::parse(
        run_study(folder.write("study.toml", text), folder / "out", experiment).json);
  };
  const double mu1 = 0.05 * std::pow(18.0 / 20, 2);
  constexpr int studies = 12;
  double sum = 0, squares = 0;
  int held = 0;
  for (int s = 0; s < studies; ++s) {
    const json free = study(1e9, 1 + 10000 * s), limited = study(25, 1 + 10000 * s);
    EXPECT_EQ(free["runs"]["timed_out"], 0);
    EXPECT_GT(limited["runs"]["timed_out"], 3);
    const json& interval = limited["parameters"][0]["interval_95"];
    held += interval[0] < mu1 && mu1 < interval[1];
    const double shift = std::log(limited["parameters"][0]["median"].get<double>() /
                                  free["parameters"][0]["median"].get<double>());
    sum += shift;
    squares += shift * shift;
  }
  const double mean = sum / studies;
  const double scatter = std::sqrt((squares - sum * mean) / (studies - 1));
  RecordProperty("mean_shift", std::to_string(mean));
  RecordProperty("scatter", std::to_string(scatter));
  EXPECT_GE(held, studies - 2);
  EXPECT_LT(std::abs(mean), 0.05);
  EXPECT_LT(scatter, 0.15);
}

TEST(Direct, FindsTheTargetAndConfessesItsLuck) {
  for (const char* search : {"bobyqa", "cobyla", "nelder-mead", "crs"}) {
    const Folder folder("direct");
    FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
      return finished({scalar("aor", zhou_angle(v) * (1 + 0.08 * normal_deviate(random)), "deg")});
    });
    const StudySummary s =
        run_study(folder.write("study.toml", friction_study(angle_target + "[direct]\nsearch = \"" +
                                                            search + "\"\nevaluations = 40\n")),
                  folder / "out", experiment);
    EXPECT_EQ(s.verdict, StudyVerdict::direct_search_only);
    EXPECT_EQ(s.exit_status(), 0);
    const json j = json::parse(s.json);
    EXPECT_LE(j["direct_search"]["evaluations"], 40);
    EXPECT_NEAR(zhou_angle({{"a.mu1", j["estimate"]["parameters"]["mu1"]},
                            {"a.mu2", j["estimate"]["parameters"]["mu2"]}}),
                10, 2.5)
        << search;
    // Journalled: asked again, it replays.
    FakeExperiment again([](const Values&, std::mt19937_64&) -> JobResult { std::abort(); });
    EXPECT_EQ(run_study(folder / "study.toml", folder / "out", again).json, s.json);
  }
}

}  // namespace
}  // namespace firn
