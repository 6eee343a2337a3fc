// Discrepancies: what a study states of a simulation that is systematically wrong.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "calibrate/inference/response_model.h"
#include "calibrate/study/study_file.h"
#include "experiments/analysis/random_stream.h"
#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

using Eigen::VectorXd;
using nlohmann::json;
using testing::HasSubstr;
using Values = FakeExperiment::Values;

constexpr double bias_sd = 1.5, measurement_sd = 0.5;

double line(double a) { return 10 + 8 * a; }

// One parameter, one response, twelve points with two runs each.
struct LineStudy {
  explicit LineStudy(double discrepancy) {
    study.targets.push_back({{0, "y", "y"}, 0, measurement_sd, "1", "", 0});
    study.targets[0].discrepancy = discrepancy;
    study.experiments.push_back({"", "", {}, {true}});
    Parameter p;
    p.name = "a";
    p.max = 1;
    study.parameters.push_back(p);
    std::mt19937_64 random(5);
    std::vector<Point> points;
    for (int i = 0; i < 12; ++i) {
      Point point;
      point.u = VectorXd::Constant(1, i / 11.0);
      point.results.resize(1);
      for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        point.seeds.push_back(seed);
        point.results[0].push_back(
            finished({scalar("y", line(point.u[0]) + 0.05 * normal_deviate(random), "1")}));
      }
      points.push_back(point);
    }
    knowledge = fit_response_models(study, points);
  }

  // Whether the densest 95 % of the posterior hold `a`, by the density on a grid.
  bool region_holds(double a) const {
    constexpr int cells = 400;
    const NegativeLogPosterior posterior(study, *knowledge);
    const auto density = [&](double x) {
      return std::exp(-0.5 * posterior.cost(VectorXd::Constant(1, x)));
    };
    const double there = density(a);
    double all = 0, denser = 0;
    for (int i = 0; i < cells; ++i) {
      const double here = density((i + 0.5) / cells);
      all += here;
      if (here > there) denser += here;
    }
    return denser <= 0.95 * all;
  }

  Study study;
  std::optional<ResponseModels> knowledge;
};

// Reality is the simulated line and a bias that is drawn once for each of the studies.
double coverage(double discrepancy, int studies) {
  LineStudy s(discrepancy);
  std::mt19937_64 random(17);
  int held = 0;
  for (int i = 0; i < studies; ++i) {
    const double a = 0.2 + 0.6 * uniform_open(random);
    const double bias = bias_sd * normal_deviate(random);
    s.study.targets[0].value = line(a) + bias + measurement_sd * normal_deviate(random);
    held += s.region_holds(a);
  }
  return static_cast<double>(held) / studies;
}

TEST(Discrepancy, RegionsOfABiasedSimulationHoldTheTruthWithItAndNotWithout) {
  constexpr int studies = 400;
  const double without = coverage(0, studies), with = coverage(bias_sd, studies);
  RecordProperty("without", fmt::format("{:.3f}", without));
  RecordProperty("with", fmt::format("{:.3f}", with));
  // A bias of 1.5 with 0.5 of the measurement: P(|x| < 1.96 * 0.5) of a normal x with sd 1.58.
  EXPECT_NEAR(without, std::erf(1.96 * 0.5 / std::hypot(0.5, 1.5) / std::sqrt(2)), 0.08);
  EXPECT_NEAR(with, 0.95, 0.03);
}

// Of one parameter p on [0, 1].
std::string p_study(const std::string& targets) {
  return "[study]\nname = \"fake\"\ncase = \"case.toml\"\n[budget]\ncenter_replicates = 3\n"
         "design_points = 8\nreplicates_per_point = 2\nconfirmation_replicates = 3\n"
         "[[parameters]]\nname = \"p\"\nkeys = [\"p\"]\nmin = 0\nmax = 1\n" +
         targets;
}

JobResult two_lines(const Values& v, std::mt19937_64& random) {
  return finished({scalar("x", 10 + 8 * v.at("p") + 0.05 * normal_deviate(random), "deg"),
                   scalar("y", 20 + 8 * v.at("p") + 0.05 * normal_deviate(random), "deg")});
}

TEST(Discrepancy, AConflictOfTwoTargetsIsAcceptedWhereItIsStated) {
  // By themselves p = 0.375 +- 0.05 and p = 0.75 +- 0.05.
  const std::string targets =
      "[[targets]]\nresponse = \"x\"\nvalue = \"13 deg\"\nuncertainty = \"0.4 deg\"\n"
      "[[targets]]\nresponse = \"y\"\nvalue = \"26 deg\"\nuncertainty = \"0.4 deg\"\n";
  const auto carry_out = [&](const std::string& more, const Folder& folder) {
    FakeExperiment experiment(two_lines);
    return run_study(folder.write("study.toml", p_study(targets + more)), folder / "out",
                     experiment);
  };
  const Folder without("discrepancy-none"), with("discrepancy");
  EXPECT_EQ(carry_out("", without).verdict, StudyVerdict::infeasible);

  const StudySummary s = carry_out("discrepancy = \"2 deg\"\n", with);
  EXPECT_EQ(s.verdict, StudyVerdict::calibrated) << s.table;
  const json j = json::parse(s.json);
  EXPECT_TRUE(j["goodness_of_fit"]["acceptable"].get<bool>());
  // The mean of both, weighted by their variances 0.16 and 4.16.
  const double weight = (1 / 0.16) / (1 / 0.16 + 1 / 4.16);
  EXPECT_NEAR(j["parameters"][0]["median"].get<double>(), 0.375 * weight + 0.75 * (1 - weight),
              0.01);
  const double sd = std::sqrt(1 / (1 / 0.16 + 1 / 4.16)) / 8;
  EXPECT_NEAR(j["parameters"][0]["interval_95"][1].get<double>() -
                  j["parameters"][0]["interval_95"][0].get<double>(),
              2 * 1.96 * sd, 0.3 * sd);
  EXPECT_FALSE(j["targets"][0].contains("discrepancy"));
  EXPECT_EQ(j["targets"][1]["discrepancy"], 2.0);
  EXPECT_EQ(j["targets"][1]["uncertainty"], 0.4);
  EXPECT_FALSE(j["targets"][0]["uncertainty_at_estimate"].contains("discrepancy"));
  EXPECT_NEAR(j["targets"][1]["uncertainty_at_estimate"]["discrepancy"].get<double>(), 2, 1e-12);
  EXPECT_THAT(s.table, HasSubstr("discrepancy of the simulation, a prior: ± 2 deg; with the "
                                 "measurement ± 2 deg"));
  EXPECT_THAT(s.table, HasSubstr(", discrepancy 2 deg; the other surrogate"));
  EXPECT_THAT(read_text(with / "out/report.md"), HasSubstr("discrepancy of the simulation"));
}

// With u of the measurement and b of the discrepancy, a second measurement leaves b^2 + u^2 / 2 of
// b^2 + u^2.
TEST(Discrepancy, ARepeatedMeasurementDoesNotReduceIt) {
  const double u = 0.06, b = 0.08;
  const Folder folder("discrepancy-repeat");
  FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
    return finished({scalar("y", v.at("p") + 1e-4 * normal_deviate(random), "1"),
                     scalar("z", v.at("p") + 1e-4 * normal_deviate(random), "1")});
  });
  const json j = json::parse(
      run_study(
          folder.write("study.toml",
                       p_study("[[targets]]\nresponse = \"y\"\nvalue = 0.5\nuncertainty = 0.06\n"
                               "discrepancy = 0.08\n[[observe]]\nresponse = \"z\"\n"
                               "uncertainty = 0.06\ndiscrepancy = 0.08\n")),
          folder / "out", experiment)
          .json);
  // Another response with another discrepancy is a fresh witness.
  ASSERT_EQ(j["measure_next"].size(), 2u);
  EXPECT_EQ(j["measure_next"][0]["response"], "z");
  EXPECT_NEAR(j["measure_next"][0]["remaining_extent"], std::sqrt(0.5), 0.02);
  EXPECT_EQ(j["measure_next"][0]["discrepancy"], b);
  EXPECT_NEAR(j["measure_next"][1]["remaining_extent"],
              std::sqrt((b * b + u * u / 2) / (b * b + u * u)), 0.02);
}

TEST(Discrepancy, ReportsWhatIsWrongWithIt) {
  const Folder folder("discrepancy-wrong");
  const auto message = [&](const std::string& more) { return folder.study_error(p_study(more)); };
  const std::string target =
      "[[targets]]\nresponse = \"x\"\nvalue = \"13 deg\"\nuncertainty = \"0.4 deg\"\n";
  const struct {
    std::string more, complaint;
  } cases[] = {
      {"discrepancy = \"1 rad\"\n",
       "study.toml:18: targets.0.discrepancy: has the unit \"rad\"; expected "
       "\"deg\" as the value has"},
      {"discrepancy = 1\n", "has the unit \"\"; expected \"deg\""},
      {"discrepancy = \"0 deg\"\n", "discrepancy: 0 is not above 0; expected one standard"},
      {"discrepancy = \"-1 deg\"\n", "discrepancy: -1 is not above 0"},
      {"discrepancy = true\n", "discrepancy"},
      {"[[observe]]\nresponse = \"y\"\ndiscrepancy = \"1 deg\"\n",
       "study.toml:20: observe.0.discrepancy: is given without an uncertainty; expected the "
       "uncertainty of a possible measurement"},
      {"[[observe]]\nresponse = \"y\"\nuncertainty = \"1 deg\"\ndiscrepancy = \"1 mm\"\n",
       "discrepancy: has the unit \"mm\"; expected \"deg\""},
  };
  for (const auto& c : cases) EXPECT_THAT(message(target + c.more), HasSubstr(c.complaint));
  for (const char* huge : {"inf", "nan", "\"1e400 deg\"", "\"inf deg\""})
    EXPECT_THAT(message(target + "discrepancy = " + huge + "\n"),
                HasSubstr("study.toml:18: targets.0.discrepancy: "))
        << huge;
}

}  // namespace
}  // namespace firn
