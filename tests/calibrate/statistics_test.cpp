// What a study states of its answer, held against problems whose truth is known: many studies of
// each, with separate measurements and seeds.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "calibrate/numerics/noise_model.h"
#include "experiments/analysis/random_stream.h"
#include "tests/calibrate/lab_study.h"
#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using namespace lab;

TEST(Budget, IsUsedOrWhatIsLeftIsExplained) {
  for (const int runs : {25, 40, 61, 80}) {
    const Outcome o =
        carry_out(study_text(unit_square, {{13, 0.5}, {15, 0.5}}, runs, 3),
                  [](const Values& v, auto& random) {
                    return std::vector{10 + 8 * v.at("a") + 2 * normal_deviate(random),
                                       10 + 8 * v.at("b") + 2 * normal_deviate(random)};
                  });
    EXPECT_EQ(o.j["budget"]["left"], runs - o.runs);
    EXPECT_LE(o.runs, runs);
    const bool used = o.summary.table.find("the budget's runs are used") != std::string::npos;
    if (used) {
      EXPECT_EQ(o.runs, runs) << o.summary.table;
    }
    EXPECT_EQ(o.runs < runs, o.summary.table.find("runs are left: ") != std::string::npos);
  }
}

TEST(Budget, IsUsedForAModelWhereMostOfTheRangesFail) {
  const Outcome o =
      carry_out(study_text(unit_square, {{11.5, 0.5}}, 40, 1), [](const Values& v, auto& random) {
        if (v.at("a") + v.at("b") > 0.77) return std::vector<double>{};
        return std::vector{10 + 8 * v.at("a") * v.at("b") + 4 * v.at("a") +
                           0.3 * normal_deviate(random)};
      });
  EXPECT_NE(o.summary.verdict, StudyVerdict::too_few_runs) << o.summary.table;
  EXPECT_GT(o.runs, 30);
}

TEST(Measurement, IdenticalValuesAreNoUncertaintyOfZero) {
  const Folder folder("identical");
  const auto measurement = [&](const std::string& more) {
    folder.write("time.toml",
                 "name = \"time\"\nresponse = \"t0\"\nstatus = \"measured\"\nsource = \"\"\n"
                 "values = [\"0.35 s\", \"0.35 s\"]\n" +
                     more);
    const std::string text = study_text(unit_square, {}, 40, 1);
    return read_study(
        folder.write("study.toml", text + "[[targets]]\nmeasurement = \"time.toml\"\n"));
  };
  EXPECT_THAT([&] { measurement(""); },
              testing::ThrowsMessage<InputError>(HasSubstr("its values are identical")));
  EXPECT_DOUBLE_EQ(
      measurement("[systematic]\nuncertainty = \"0.003 s\"\nrationale = \"resolution\"\n")
          .targets[0]
          .uncertainty,
      0.003);
}

TEST(Parameters, ValuesAreRoundedRelativeToTheirRange) {
  for (const bool logarithmic : {false, true})
    for (const auto& [min, max] : {std::pair{1000.0, 1003.0},
                                   {0.1, 0.100001},
                                   {-5.0002, -5.0001},
                                   {1e-9, 1.00001e-9},
                                   {0.0, 1.0},
                                   {0.03, 0.5}}) {
      if (logarithmic && !(min > 0)) continue;
      Parameter p;
      p.min = min;
      p.max = max;
      p.logarithmic = logarithmic;
      for (double u = 0; u <= 1; u += 0.0371) {
        EXPECT_NEAR(p.to_unit(p.rounded(u)), u, 1.01e-3) << min << ' ' << max;
        EXPECT_EQ(std::stod(p.text(p.rounded(u))), p.rounded(u));
      }
    }
  Parameter usual;  // as before
  usual.min = 0.03;
  usual.max = 0.5;
  EXPECT_EQ(usual.text(usual.rounded(0.34567)), fmt::format("{:.4g}", usual.from_unit(0.34567)));
}

TEST(Parameters, ANarrowRangeFarFromZeroIsCalibrated) {
  const Outcome o = carry_out(
      study_text({{"a", 1000, 1003}}, {{1.37, 0.02}}, 30, 1), [](const Values& v, auto& random) {
        return std::vector{v.at("a") - 1000 + 0.02 * normal_deviate(random)};
      });
  EXPECT_EQ(o.summary.verdict, StudyVerdict::calibrated) << o.summary.table;
  EXPECT_NEAR(o.j["estimate"]["parameters"]["a"].get<double>(), 1001.37, 0.05);
  EXPECT_THAT(o.summary.headline, HasSubstr("a = 1001.3"));
}

TEST(Posterior, IsExportedWithAllItsSamples) {
  const Folder folder("samples");
  FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
    return finished({scalar("t0", 10 + 8 * v.at("a") + 0.2 * normal_deviate(random), "1"),
                     scalar("t1", 10 + 8 * v.at("b") + 0.2 * normal_deviate(random), "1")});
  });
  const StudySummary s =
      run_study(folder.write("study.toml", study_text(unit_square, {{13, 0.4}, {15, 0.4}}, 30, 1)),
                folder / "out", experiment);
  std::istringstream csv(read_text(folder / "out/posterior.csv"));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line, "a,b,weight,log_density");
  double weights = 0, mean = 0;
  int samples = 0;
  while (std::getline(csv, line)) {
    double a = 0, b = 0, w = 0, density = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &a, &b, &w, &density), 4) << line;
    weights += w;
    mean += w * a;
    ++samples;
  }
  EXPECT_NEAR(weights, 1, 1e-9);
  EXPECT_NEAR(mean, 3.0 / 8, 0.1);
  const json j = json::parse(s.json);
  EXPECT_EQ(j["posterior"]["samples"], samples);
  EXPECT_GT(j["posterior"]["effective_samples"], 100);
  EXPECT_THAT(s.table, HasSubstr("independent ones (posterior.csv)"));
}

TEST(Report, EachFitIsFollowedByItsSimulation) {
  const Outcome o = carry_out(
      study_text(unit_square, {{13, 0.4}, {15, 0.4}}, 30, 1), [](const Values& v, auto& random) {
        return std::vector{10 + 8 * v.at("a") + 0.2 * normal_deviate(random),
                           10 + 8 * v.at("b") + 0.2 * normal_deviate(random)};
      });
  int lines = 0;
  std::istringstream table(o.summary.table);
  for (std::string line; std::getline(table, line);)
    if (line.find(" fit ") != std::string::npos && line.find("simulated") != std::string::npos) {
      EXPECT_THAT(line, testing::ContainsRegex("simulated 1[0-9.]* "));
      ++lines;
    }
  EXPECT_EQ(lines, 2) << o.summary.table;
}

TEST(Report, TheTableHasThePredictedResponseOfEachTarget) {
  std::mt19937_64 random(8);
  for (int s = 0; s < 3; ++s) {
    const double a = 0.2 + 0.6 * uniform_open(random), b = 0.2 + 0.6 * uniform_open(random);
    const Outcome o =
        carry_out(study_text(unit_square, {{10 + 8 * a, 0.4}, {10 + 8 * b, 0.4}}, 30, 1 + 1000 * s),
                  [](const Values& v, auto& noise) {
                    return std::vector{10 + 8 * v.at("a") + 0.2 * normal_deviate(noise),
                                       10 + 8 * v.at("b") + 0.2 * normal_deviate(noise)};
                  });
    const std::string& table = o.summary.table;
    const std::size_t begin = table.find("Predicted responses");
    ASSERT_NE(begin, table.npos) << table;
    for (const json& t : o.j["targets"]) {
      const std::size_t line = table.find("  " + t["response"].get<std::string>() + " ", begin);
      ASSERT_NE(line, table.npos) << table;
      const std::string text = table.substr(line, table.find('\n', line) - line);
      const json& mean = t["posterior_predictive"]["mean_response"]["quantiles"];
      const json& run = t["posterior_predictive"]["single_run"]["quantiles"];
      EXPECT_THAT(text, HasSubstr(fmt::format("{:.4g}, {:.4g} to {:.4g}", mean[2].get<double>(),
                                              mean[0].get<double>(), mean[4].get<double>())));
      EXPECT_THAT(text, HasSubstr(fmt::format("{:.4g} to {:.4g}", run[0].get<double>(),
                                              run[4].get<double>())));
    }
  }
}

// Squares of `seeds` deviations at random places; in a corner they are `factor` times as large.
LocalNoise scattered(int sites, int seeds, double factor, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<NoiseSite> all;
  for (int i = 0; i < sites; ++i) {
    NoiseSite site{Eigen::Vector2d(uniform_open(random), uniform_open(random)), 0, seeds - 1.0};
    const double scale = site.u.minCoeff() > 0.5 ? factor : 1;
    for (int k = 1; k < seeds; ++k) site.squares += scale * std::pow(normal_deviate(random), 2);
    all.push_back(site);
  }
  return LocalNoise(all);
}

TEST(Noise, ThatDiffersFromPlaceToPlaceIsModeledSo) {
  int uniform_ones = 0, local_ones = 0, distinct = 0;
  for (std::uint64_t s = 0; s < 40; ++s) {
    uniform_ones += scattered(20, 2, 1, s).uniform();
    const LocalNoise local = scattered(30, 3, 50, s);
    if (local.uniform()) continue;
    ++local_ones;
    distinct +=
        local.factor(Eigen::Vector2d(0.8, 0.8)) > 3 * local.factor(Eigen::Vector2d(0.2, 0.2));
  }
  EXPECT_GE(uniform_ones, 37);
  EXPECT_GE(local_ones, 36);
  EXPECT_GE(distinct, 34);
  EXPECT_TRUE(LocalNoise().uniform());
  EXPECT_EQ(LocalNoise().factor(Eigen::Vector2d(0.5, 0.5)), 1);
}

TEST(Outliers, AreFoundByOtherSeedsReportedAndLeftOut) {
  int found = 0;
  for (const double absurd : {1e9, -1e6, 1e3}) {
    int run = 0;
    const Outcome o = carry_out(
        study_text(unit_square, {{14, 0.5}, {14, 0.5}}, 40, 1), [&](const Values& v, auto& random) {
          const double t = 10 + 8 * v.at("a") + 0.4 * normal_deviate(random);
          return std::vector{++run % 13 == 9 ? absurd : t,
                             10 + 8 * v.at("b") + 0.4 * normal_deviate(random)};
        });
    for (const char* name : {"a", "b"}) {
      const json& p = o.j["parameters"][name[0] - 'a'];
      EXPECT_LT(p["interval_95"][0], 0.5) << o.summary.table;
      EXPECT_GT(p["interval_95"][1], 0.5) << o.summary.table;
      EXPECT_LT(p["posterior_to_prior_sd"], 0.5);
    }
    for (const json& outlier : o.j["outliers"]) EXPECT_EQ(outlier["value"], absurd);
    EXPECT_GE(o.j["outliers"].size(), 1u);
    EXPECT_THAT(o.summary.table, HasSubstr("Outlier, left out: t0 = "));
    EXPECT_THAT(o.summary.headline, HasSubstr("left out"));
    EXPECT_EQ(o.summary.verdict, StudyVerdict::calibrated) << o.summary.table;
    found += static_cast<int>(o.j["outliers"].size());
  }
  EXPECT_LE(found, 10);
}

TEST(Outliers, AValueThatAllSeedsHaveIsNone) {
  // A step of the response, and noise of which a third is far off.
  for (const bool step : {true, false}) {
    const Outcome o = carry_out(
        study_text(unit_square, {{14, 0.5}, {14, 0.5}}, 40, 1), [&](const Values& v, auto& random) {
          const double t = 10 + 8 * v.at("a") + 0.4 * normal_deviate(random);
          const bool high =
              step ? v.at("a") > 0.85 && v.at("b") > 0.85 : uniform_open(random) < 0.3;
          return std::vector{t + (high ? 1000 : 0),
                             10 + 8 * v.at("b") + 0.4 * normal_deviate(random)};
        });
    EXPECT_TRUE(o.j["outliers"].empty()) << o.summary.table;
  }
}

TEST(Border, TheIntervalOfATruthOnTheBorderHoldsIt) {
  for (const double a : {0.0, 1.0}) {
    const Outcome o =
        carry_out(study_text(unit_square, {{10 + 8 * a, 0.8}, {14, 0.8}}, 40, 1),
                  [](const Values& v, auto& random) {
                    return std::vector{10 + 8 * v.at("a") + 0.4 * normal_deviate(random),
                                       10 + 8 * v.at("b") + 0.4 * normal_deviate(random)};
                  });
    const json& p = o.j["parameters"][0];
    EXPECT_EQ(p["interval_95"][a == 0 ? 0 : 1], a) << o.summary.table;
    EXPECT_TRUE(p[a == 0 ? "at_min" : "at_max"].get<bool>());
    EXPECT_FALSE(p[a == 0 ? "at_max" : "at_min"].get<bool>());
    EXPECT_FALSE(o.j["parameters"][1]["at_min"].get<bool>());
  }
}

// One response along a bent valley determines a combination only near the answer.
TEST(Border, ACombinationIsNotStatedMorePreciselyThanTheValleyIsStraight) {
  int off = 0;
  for (int s = 0; s < 24; ++s) {
    std::mt19937_64 random(static_cast<std::uint64_t>(50 + s));
    const double a = s % 2 == 0 ? 0 : uniform_open(random), b = uniform_open(random);
    const auto response = [](double x, double y) { return 10 * (x - 0.2) * (x - 0.2) + 8 * y; };
    const Outcome o = carry_out(
        study_text(unit_square, {{response(a, b) + 0.3 * normal_deviate(random), 0.3}}, 40,
                   1 + 1000 * s),
        [&](const Values& v, auto& noise) {
          return std::vector{response(v.at("a"), v.at("b")) + 0.2 * normal_deviate(noise)};
        });
    const json& c = o.j["combinations"][0];
    if (!c["identifiable"].get<bool>()) continue;
    const double truth = c["terms"][0]["coefficient"].get<double>() * a +
                         c["terms"][1]["coefficient"].get<double>() * b;
    off += std::abs(truth - c["value"].get<double>()) > 2 * c["uncertainty"].get<double>();
    EXPECT_GE(c["uncertainty"], c["uncertainty_near_estimate"]);
  }
  EXPECT_LE(off, 2);  // 5 % of 24 are 1.2
}

}  // namespace
}  // namespace firn
