// Studies that explore with a cheaper form of the case: its bias is estimated, and the answer is
// of the case itself.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "calibrate/calibrate.h"
#include "calibrate/numerics/experimental_design.h"
#include "calibrate/numerics/surrogate.h"
#include "calibrate/study/study_file.h"
#include "tests/support/fake_experiment.h"
#include "tests/support/replaced.h"

namespace firn {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::json;
using testing::HasSubstr;
using Values = FakeExperiment::Values;

const std::string low = "[low_fidelity]\nset = { coarse = 1 }\n";

// Of a quarter of the time, and 2 degrees too high.
JobResult simulated(const Values& v, std::mt19937_64& random) {
  const bool coarse = v.contains("coarse");
  JobResult r = finished(
      {scalar("aor", zhou_angle(v) + (coarse ? 2 : 0) + 0.4 * normal_deviate(random), "deg")});
  r.wall = coarse ? 0.25 : 1;
  return r;
}

// A smooth response with random coefficients, and a random bias of one form.
struct RandomResponse {
  double level, slope_a, slope_b, bend, bias, bias_slope;
  explicit RandomResponse(std::mt19937_64& random)
      : level(20 + normal_deviate(random)),
        slope_a(3 * normal_deviate(random)),
        slope_b(3 * normal_deviate(random)),
        bend(normal_deviate(random)),
        bias(2 * normal_deviate(random)),
        bias_slope(0.5 * normal_deviate(random)) {}
  double high(const VectorXd& u) const {
    return level + slope_a * u[0] + slope_b * u[1] + bend * u[0] * u[1];
  }
  double bias_at(const VectorXd& u) const { return bias + bias_slope * (u[0] - 0.5); }
};

SurrogateData sampled(const RandomResponse& truth, double noise, std::mt19937_64& random) {
  constexpr int points = 16, high = 5;
  SurrogateData data{MatrixXd(points, 2), VectorXd(points),
                     VectorXd::Constant(points, noise * noise)};
  for (int i = 0; i < points; ++i) {
    const VectorXd u = quasi_random_point(static_cast<std::uint64_t>(i), 2);
    data.u.row(i) = u.transpose();
    data.low_fidelity.push_back(i >= high);
    data.y[i] = truth.high(u) + (i >= high ? truth.bias_at(u) : 0) + noise * normal_deviate(random);
  }
  return data;
}

TEST(LowFidelity, BiasAndPredictionsAreAsFarOffAsTheySay) {
  std::mt19937_64 random(11);
  double bias = 0, prediction = 0;
  int count = 0;
  for (int k = 0; k < 60; ++k) {
    const RandomResponse truth(random);
    const Surrogate s = choose_surrogate(sampled(truth, 0.3, random)).best;
    for (std::uint64_t i = 20; i < 25; ++i, ++count) {
      const VectorXd u = quasi_random_point(i, 2);
      const FidelityBias b = s.fidelity_bias(u);
      const Prediction p = s.predict(u), of_low = s.predict_low_fidelity(u);
      bias += std::pow((b.value - truth.bias_at(u)) / b.sd, 2);
      prediction += std::pow(p.mean - truth.high(u), 2) / p.variance;
      EXPECT_NEAR(of_low.mean - p.mean, b.value, 1e-6 + 0.02 * std::abs(b.value));
    }
  }
  EXPECT_GT(bias / count, 0.3);
  EXPECT_LT(bias / count, 1.8);
  EXPECT_GT(prediction / count, 0.3);
  EXPECT_LT(prediction / count, 1.8);
}

TEST(LowFidelity, CheapPointsNarrowThePrediction) {
  std::mt19937_64 random(5);
  const RandomResponse truth(random);
  const SurrogateData all = sampled(truth, 0.3, random);
  SurrogateData high = all;
  high.u.conservativeResize(5, Eigen::NoChange);
  high.y.conservativeResize(5);
  high.noise_variance.conservativeResize(5);
  high.low_fidelity.clear();
  for (const bool quadratic : {false, true}) {
    const SurrogateForm form{quadratic, false, false};
    const Surrogate with(all, form), without(high, form);
    for (std::uint64_t i = 20; i < 30; ++i) {
      const VectorXd u = quasi_random_point(i, 2);
      EXPECT_LT(with.predict(u).variance, without.predict(u).variance);
    }
  }
}

TEST(LowFidelity, NoneOfThePointsIsTheSameAsNoSuchForm) {
  std::mt19937_64 random(3);
  SurrogateData data = sampled(RandomResponse(random), 0.3, random);
  data.low_fidelity.assign(data.low_fidelity.size(), false);
  SurrogateData plain = data;
  plain.low_fidelity.clear();
  for (const bool matern : {false, true}) {
    const Surrogate a(data, {false, matern, false}), b(plain, {false, matern, false});
    const VectorXd u = Eigen::Vector2d(0.3, 0.8);
    EXPECT_EQ(a.predict(u).mean, b.predict(u).mean);
    EXPECT_EQ(a.predict(u).variance, b.predict(u).variance);
    EXPECT_EQ(b.fidelity_bias(u).value, 0);
    EXPECT_EQ(b.fidelity_bias(u).sd, 0);
  }
}

TEST(LowFidelity, ExploresAndTheCaseItselfConfirms) {
  const Folder folder("low");
  int coarse = 0, fine = 0;
  FakeExperiment experiment([&](const Values& v, std::mt19937_64& random) {
    ++(v.contains("coarse") ? coarse : fine);
    return simulated(v, random);
  });
  const std::string file =
      folder.write("study.toml", friction_study(angle_target + low, "runs = 40\n"));
  const StudySummary s = run_study(file, folder / "out", experiment);
  const json j = json::parse(s.json);
  EXPECT_EQ(j["verdict"], "not identifiable") << s.table;
  EXPECT_LE(coarse + fine, 40);
  EXPECT_GT(coarse, 10);
  const json& l = j["low_fidelity"];
  EXPECT_EQ(l["set"]["coarse"], "1");
  EXPECT_EQ(l["runs"], coarse);
  EXPECT_EQ(l["high_fidelity_runs"], fine);
  EXPECT_DOUBLE_EQ(l["wall_seconds"], 0.25 * coarse);
  const json& bias = l["biases"]["aor"];
  EXPECT_NEAR(bias["value"], 2, 3 * bias["uncertainty"].get<double>());
  EXPECT_LT(bias["uncertainty"], 0.5);
  EXPECT_NEAR(j["estimate"]["simulated"]["aor"]["value"], 10, 1);
  EXPECT_THAT(s.table, HasSubstr("Low fidelity: coarse = 1"));
  const std::string runs = read_text(folder / "out/runs.csv");
  EXPECT_THAT(runs, HasSubstr(",low fidelity: design,"));
  EXPECT_THAT(runs, testing::Not(HasSubstr("low fidelity: confirm")));
  EXPECT_THAT(runs, testing::Not(HasSubstr("low fidelity: valley")));
  // Again in the same folder: nothing is simulated twice, and nothing changes.
  FakeExperiment never(simulated);
  EXPECT_EQ(run_study(file, folder / "out", never).json, s.json);
  EXPECT_EQ(never.runs, 0);
}

TEST(LowFidelity, IsMarkedInTheFittedResponse) {
  const Folder folder("low-drawn");
  const auto legend_of = [&](const std::string& more) {
    FakeExperiment experiment(simulated);
    StudyOptions options;
    options.study_file =
        folder.write("study.toml", friction_study(angle_target + more, "runs = 40\n"));
    options.directory = folder / "out" + std::to_string(more.size());
    options.show_progress = false;
    options.replace_executor = &experiment;
    calibrate(options);
    return read_text(options.directory + "/fitted_response.svg");
  };
  EXPECT_THAT(legend_of(low), HasSubstr("low fidelity, less its bias"));
  const std::string plain = legend_of("");
  EXPECT_THAT(plain, HasSubstr("simulated: mean over seeds"));
  EXPECT_THAT(plain, testing::Not(HasSubstr("low fidelity")));
}

TEST(LowFidelity, ALargeBiasDoesNotMoveTheAnswer) {
  // As large as the response itself, and with another slope.
  const Folder folder("large");
  FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
    const double bias = v.contains("coarse") ? 8 + 10 * v.at("a.mu1") : 0;
    return finished({scalar("aor", zhou_angle(v) + bias + 0.3 * normal_deviate(random), "deg")});
  });
  const StudySummary s =
      run_study(folder.write("study.toml", friction_study(angle_target + low, "runs = 60\n")),
                folder / "out", experiment);
  const json j = json::parse(s.json);
  EXPECT_EQ(j["verdict"], "not identifiable") << s.table;
  const json& fit = j["estimate"]["fit"]["aor"];
  const json& values = j["estimate"]["parameters"];
  const double truth = zhou_angle({{"a.mu1", values["mu1"]}, {"a.mu2", values["mu2"]}});
  EXPECT_NEAR(fit["value"], truth, 3 * fit["uncertainty"].get<double>());
}

TEST(LowFidelity, OfOneExperimentLeavesTheOthersAlone) {
  const Folder folder("one");
  std::map<std::string, int> slides;  // by all their values
  FakeExperiment experiment([&](const Values& v, std::mt19937_64& random) {
    if (v.contains("a.mu1")) return simulated(v, random);
    EXPECT_FALSE(v.contains("coarse"));
    std::string key;
    for (const auto& [name, value] : v) key += name + std::to_string(value);
    ++slides[key];
    return finished(
        {scalar("slide_angle", std::atan(v.at("a.mu2")) * 180 / M_PI + 0.3 * normal_deviate(random),
                "deg")});
  });
  std::string text = friction_study(
      "[[targets]]\nexperiment = \"drained\"\nresponse = \"aor\"\nvalue = \"10 deg\"\n"
      "uncertainty = \"0.5 deg\"\n[[targets]]\nexperiment = \"slide\"\nresponse = "
      "\"slide_angle\"\nvalue = \"8.5 deg\"\nuncertainty = \"0.5 deg\"\n" +
      low + "experiment = \"drained\"\npairs = 3\n");
  const std::string head = "case = \"case.toml\"\n";
  text.erase(text.find(head), head.size());
  text +=
      "\n[[experiments]]\nname = \"drained\"\ncase = \"case.toml\"\n[[experiments]]\nname = "
      "\"slide\"\ncase = \"case.toml\"\nparameters = [\"mu2\"]\n";
  const StudySummary s = run_study(folder.write("study.toml", text), folder / "out", experiment);
  const json j = json::parse(s.json);
  EXPECT_EQ(j["verdict"], "calibrated") << s.table;
  EXPECT_FALSE(j["low_fidelity"]["biases"].contains("slide.slide_angle"));
  EXPECT_NEAR(j["low_fidelity"]["biases"]["drained.aor"]["value"], 2, 1);
  for (const auto& [key, count] : slides) EXPECT_EQ(count, 1);
}

TEST(LowFidelity, OutOfReachIsSaidAfterSimulatingTheCaseItselfThere) {
  const Folder folder("reach");
  FakeExperiment experiment(simulated);
  const std::string far = test::replaced(angle_target, "10 deg", "60 deg");
  const StudySummary s =
      run_study(folder.write("study.toml", friction_study(far + low, "runs = 60\n")),
                folder / "out", experiment);
  EXPECT_EQ(json::parse(s.json)["verdict"], "infeasible") << s.table;
  EXPECT_THAT(read_text(folder / "out/runs.csv"), HasSubstr(",refine 1,"));
}

TEST(LowFidelity, BadTablesAreRefused) {
  const Folder folder("bad");
  const auto message = [&](const std::string& more) {
    return folder.study_error(friction_study(angle_target + more));
  };
  EXPECT_EQ(message(low), "no complaint");
  EXPECT_THAT(message("[low_fidelity]\nset = {}\n"), HasSubstr("low_fidelity.set: is empty"));
  EXPECT_THAT(message("[low_fidelity]\npairs = 2\n"), HasSubstr("low_fidelity.set"));
  EXPECT_THAT(message(low + "pairs = 0\n"), HasSubstr("low_fidelity.pairs"));
  EXPECT_THAT(message(low + "pairs = 100000000\n"), HasSubstr("low_fidelity.pairs"));
  EXPECT_THAT(message(low + "experiment = \"none\"\n"),
              HasSubstr("\"none\" is not an experiment of this study"));
  EXPECT_THAT(message(low + "cost = 2\n"), HasSubstr("low_fidelity.cost"));
  EXPECT_THAT(message(low + "[direct]\nsearch = \"bobyqa\"\nevaluations = 5\n"),
              HasSubstr("takes no [low_fidelity]"));
}

}  // namespace
}  // namespace firn
