// Curves as targets: parameters that the shape of a recorded curve determines.
#include "calibrate/inference/curve_scores.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "experiments/analysis/random_stream.h"
#include "tests/support/error_of.h"
#include "tests/support/fake_experiment.h"
#include "tests/support/replaced.h"

namespace firn {
namespace {

using Eigen::VectorXd;
using nlohmann::json;
using test::replaced;
using testing::HasSubstr;
using Values = FakeExperiment::Values;

// A force that rises to `height` with the time `tau`, in N over s.
double rise(double height, double tau, double time) { return height * (1 - std::exp(-time / tau)); }

// An error with a root mean square of about `sd`, of a level and a bend.
struct SmoothError {
  SmoothError(double sd, std::mt19937_64& random)
      : level(sd * std::sqrt(0.5) * normal_deviate(random)), bend(sd * normal_deviate(random)) {}
  double at(double time) const { return level + bend * std::cos(M_PI * time / 5); }
  double level, bend;
};

JobResult press(const Values& v, std::mt19937_64& random) {
  const SmoothError noise(0.1, random);
  std::vector<double> x, y;
  for (int i = 0; i <= 40; ++i) {
    x.push_back(i / 8.0);
    y.push_back(rise(v.at("height"), v.at("tau"), x.back()) + noise.at(x.back()));
  }
  return finished({{"press_curve_x", x, {}, "s", "formula", 1},
                   {"press_curve_y", y, {}, "N", "formula", 1},
                   scalar("end", y.back(), "N")});
}

const std::string press_file =
    "name = \"press\"\nstatus = \"recorded\"\nsource = \"the laboratory\"\n[data]\nkind = "
    "\"curve\"\nfile = \"press.csv\"\nresponse = \"press\"\nx = \"time\"\nx_unit = \"s\"\n"
    "y = \"force\"\nunit = \"N\"\n";
const std::string press_target =
    "[[targets]]\nmeasurement = \"press.toml\"\nuncertainty = \"0.3 N\"\n";

std::string press_study(const std::string& targets = press_target) {
  return "[study]\nname = \"fake\"\ncase = \"case.toml\"\n[budget]\ncenter_replicates = 3\n"
         "design_points = 10\nreplicates_per_point = 2\nconfirmation_replicates = 3\n"
         "[[parameters]]\nname = \"height\"\nkeys = [\"height\"]\nmin = 5\nmax = 15\n"
         "[[parameters]]\nname = \"tau\"\nkeys = [\"tau\"]\nmin = 0.5\nmax = 2\n" +
         targets;
}

void write_record(const Folder& folder, const std::function<double(double)>& force) {
  std::string csv = "time [s],force [N]\n";
  for (int i = 0; i <= 60; ++i) csv += fmt::format("{},{}\n", i / 12.0, force(i / 12.0));
  folder.write("press.csv", csv);
  folder.write("press.toml", press_file);
}

TEST(Curves, TheirShapeDeterminesParameters) {
  constexpr int studies = 6;
  int held = 0;
  std::mt19937_64 random(11);
  for (int s = 0; s < studies; ++s) {
    const double truth[] = {7 + 6 * uniform_open(random), 0.6 + 0.7 * uniform_open(random)};
    const SmoothError error(0.2, random);
    const Folder folder("curve");
    write_record(folder, [&](double t) { return rise(truth[0], truth[1], t) + error.at(t); });
    FakeExperiment experiment(press);
    const StudySummary summary =
        run_study(folder.write("study.toml", press_study(replaced(press_target, "0.3 N", "0.2 N"))),
                  folder / "out", experiment);
    EXPECT_EQ(summary.verdict, StudyVerdict::calibrated) << summary.table;
    const json j = json::parse(summary.json);
    for (std::size_t i = 0; i < 2; ++i) {
      const json& p = j["parameters"][i];
      held += p["interval_95"][0] <= truth[i] && truth[i] <= p["interval_95"][1];
      EXPECT_LT(p["posterior_to_prior_sd"], 0.75) << summary.table;
    }
    if (s > 0) continue;
    const json& curve = j["curves"][0];
    EXPECT_EQ(curve["curve"], "press");
    EXPECT_GT(curve["explained_variance"], 0.99);
    EXPECT_LT(curve["recorded_rest"], 0.3);
    EXPECT_EQ(curve["components"].size(), j["targets"].size());
    EXPECT_EQ(curve["components"][0].size(), curve["x"].size());
    EXPECT_EQ(j["targets"][0]["response"], "press.score_1");
    EXPECT_EQ(j["targets"][0]["unit"], "N");
    EXPECT_GE(j["targets"][0]["uncertainty"], 0.2);
    EXPECT_THAT(summary.table, HasSubstr("of the variance between the simulated curves"));
    EXPECT_THAT(read_text(folder / "out/runs.csv"), HasSubstr("press.score_1"));
    // A resumed study is the same.
    const int runs = experiment.runs;
    EXPECT_EQ(json::parse(run_study(folder / "study.toml", folder / "out", experiment).json), j);
    EXPECT_EQ(experiment.runs, runs);
  }
  RecordProperty("intervals_that_hold_the_truth", held);
  EXPECT_GE(held, 2 * studies - 1);
}

TEST(Curves, AreComparedInTheUnitsOfTheRecordWithOtherTargets) {
  const Folder folder("curve-units");
  std::string csv = "time [ms];force [kN]\n";
  for (int i = 0; i <= 50; ++i) csv += fmt::format("{};{}\n", 100 * i, rise(9, 1.2, 0.1 * i) / 1e3);
  folder.write("press.csv", csv);
  folder.write("press.toml", replaced(replaced(press_file, "x_unit = \"s\"", "x_unit = \"ms\""),
                                      "unit = \"N\"", "unit = \"kN\""));
  FakeExperiment experiment(press);
  const StudySummary s = run_study(
      folder.write("study.toml",
                   press_study(replaced(press_target, "0.3 N", "3e-4 kN") +
                               "discrepancy = \"2e-4 kN\"\ncomponents = 1\n[[targets]]\nresponse = "
                               "\"end\"\nvalue = \"8.86 N\"\nuncertainty = \"0.3 N\"\n")),
      folder / "out", experiment);
  const json j = json::parse(s.json);
  EXPECT_NEAR(j["parameters"][0]["median"].get<double>(), 9, 0.7) << s.table;
  ASSERT_EQ(j["targets"].size(), 2u);  // one component alone
  EXPECT_EQ(j["targets"][0]["response"], "end");
  EXPECT_EQ(j["targets"][1]["unit"], "kN");
  EXPECT_EQ(j["targets"][1]["discrepancy"], 2e-4);
}

TEST(Curves, APartThatNoSimulatedCurveHasIsNamed) {
  const Folder folder("curve-part");
  write_record(folder, [](double t) { return rise(9, 1.2, t) + 3 * std::sin(8 * t); });
  FakeExperiment experiment(press);
  const StudySummary s =
      run_study(folder.write("study.toml", press_study()), folder / "out", experiment);
  EXPECT_THAT(s.headline, HasSubstr("the recorded curve press has a part that no simulated curve"));
}

// A record that scatters from place to place as single runs do.
TEST(Curves, TheScatterOfASingleRunIsNoSuchPart) {
  const Folder folder("curve-scatter");
  std::mt19937_64 own(4);
  write_record(folder, [&](double t) { return rise(9, 1.2, t) + normal_deviate(own); });
  FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
    JobResult r = press(v, random);
    for (double& y : r.responses[1].value) y += normal_deviate(random);
    return r;
  });
  const StudySummary s =
      run_study(folder.write("study.toml", press_study()), folder / "out", experiment);
  const json curve = json::parse(s.json)["curves"][0];
  EXPECT_NEAR(curve["single_run_rest"].get<double>(), 0.8, 0.2);
  EXPECT_NEAR(curve["recorded_rest"].get<double>(), 0.8, 0.25);
  EXPECT_LT(curve["simulated_rest"], curve["single_run_rest"]);
  EXPECT_EQ(s.headline.find("has a part"), s.headline.npos) << s.table;
}

TEST(Curves, RunsThatEndTooEarlyGiveNoScore) {
  const Folder folder("curve-short");
  write_record(folder, [](double t) { return rise(9, 1.2, t); });
  FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
    JobResult r = press(v, random);
    for (std::size_t i = 0; i < 2; ++i) r.responses[i].value.resize(20);
    return r;
  });
  const StudySummary s =
      run_study(folder.write("study.toml", press_study()), folder / "out", experiment);
  EXPECT_EQ(s.verdict, StudyVerdict::too_few_runs);
  EXPECT_EQ(s.exit_status(), 1);
}

TEST(Curves, ARunWithoutTheCurveEndsTheStudy) {
  const auto message = [](const FakeExperiment::Formula& formula) {
    const Folder folder("curve-none");
    write_record(folder, [](double t) { return rise(9, 1.2, t); });
    FakeExperiment experiment(formula);
    return test::error_of(
        [&] { run_study(folder.write("study.toml", press_study()), folder / "out", experiment); });
  };
  EXPECT_THAT(
      message([](const Values&, std::mt19937_64&) { return finished({scalar("end", 1, "N")}); }),
      HasSubstr("targets: press: \"press_curve_x\" in \"s\" is not a response of the run"));
  EXPECT_THAT(message([](const Values& v, std::mt19937_64& random) {
                JobResult r = press(v, random);
                r.responses[1].unit = "mm";
                return r;
              }),
              HasSubstr("\"press_curve_y\" in \"N\" is not a response"));
}

TEST(Curves, AreRefusedWithOneLine) {
  const Folder folder("curve-wrong");
  const auto message = [&](const std::string& study) { return folder.study_error(study); };
  write_record(folder, [](double t) { return rise(9, 1.2, t); });
  EXPECT_EQ(message(press_study()), "no complaint");
  const struct {
    std::string from, to, complaint;
  } cases[] = {
      {"uncertainty = \"0.3 N\"\n", "", "targets.0.uncertainty"},
      {"0.3 N", "0.3 mm", "has the unit \"mm\"; expected \"N\" as the curve has"},
      {"0.3 N", "0 N", "targets.0.uncertainty: 0 is not above 0"},
      {"0.3 N\"\n", "0.3 N\"\ncomponents = 0\n", "components"},
      {"0.3 N\"\n", "0.3 N\"\ncomponents = 6\n", "components: is 6; expected at most 5"},
      {"0.3 N\"\n", "0.3 N\"\ndiscrepancy = \"1 mm\"\n", "discrepancy: has the unit \"mm\""},
      {"0.3 N\"\n", "0.3 N\"\nresponse = \"x\"\n", "response"},
      {"0.3 N\"\n", "0.3 N\"\n" + press_target, "\"press\" is a target twice"},
      {"[[parameters]]\nname = \"height\"",
       "[[parameters]]\nname = \"law\"\nkeys = [\"law\"]\nchoices = [1, 2]\n"
       "[[parameters]]\nname = \"height\"",
       "is a curve in a study of a parameter with choices"},
      {"0.3 N\"\n", "0.3 N\"\n[direct]\nsearch = \"crs\"\nevaluations = 20\n",
       "takes no curves as targets"},
  };
  for (const auto& c : cases) {
    const std::string said = message(replaced(press_study(), c.from, c.to));
    EXPECT_THAT(said, HasSubstr(c.complaint)) << c.to;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
  folder.write("press.toml", press_file + "align = \"onset\"\n");
  EXPECT_THAT(message(press_study()), HasSubstr("expected align = \"none\" in [data]"));
  folder.write("press.toml", press_file + "repeat = \"test\"\n");
  folder.write("press.csv",
               "test,time [s],force [N]\na,0,1\na,0.5,1\na,1,2\nb,2,1\nb,2.5,1\nb,3,2\n");
  EXPECT_THAT(message(press_study()), HasSubstr("the repeats have no stretch of time in common"));
}

TEST(Curves, ABasisHoldsAFamilyOfCurvesAndNoMore) {
  CurveTarget target;
  target.name = "press";
  target.x_unit = "s";
  target.unit = "N";
  target.x = VectorXd::LinSpaced(100, 0, 5);
  target.y = 3 * target.x + VectorXd::Constant(100, 7);
  target.uncertainty = 0.1;
  target.components = 5;
  std::vector<Point> points;
  for (int i = 0; i < 9; ++i) {
    Point p;
    p.u = Eigen::Vector2d(i % 3 / 2.0, i / 3 / 2.0);
    p.seeds = {1};
    std::vector<double> x, y;
    for (int k = 0; k <= 50; ++k) {
      x.push_back(k / 10.0);
      y.push_back(10 * p.u[0] + 4 * p.u[1] * x.back());
    }
    p.results = {
        {finished({{"press_curve_x", x, {}, "s", "", 1}, {"press_curve_y", y, {}, "N", "", 1}})}};
    points.push_back(p);
  }
  const auto basis = curve_basis(target, points);
  ASSERT_TRUE(basis);
  EXPECT_EQ(basis->components.cols(), 2);
  EXPECT_NEAR(basis->explained, 1, 1e-9);
  EXPECT_NEAR(basis->simulated_rest, 0, 1e-9);
  EXPECT_NEAR(basis->recorded_rest, 0, 1e-9);
  EXPECT_FALSE(has_unexplained_part(target, *basis));
  const Eigen::Matrix2d product = basis->components.transpose() * basis->components / 100.0;
  EXPECT_NEAR((product - Eigen::Matrix2d::Identity()).norm(), 0, 1e-9);
  const auto targets = score_targets(target, *basis);
  ASSERT_EQ(targets.size(), 2u);
  VectorXd again = basis->mean;
  for (int k = 0; k < 2; ++k)
    again += targets[static_cast<std::size_t>(k)].value * basis->components.col(k);
  EXPECT_NEAR((again - target.y).norm(), 0, 1e-9);
  points.resize(2);
  EXPECT_FALSE(curve_basis(target, points));
}

}  // namespace
}  // namespace firn
