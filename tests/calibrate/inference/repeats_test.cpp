// Models of points with one run each: whether they know their uncertainty, and whether noise that
// the middle of the ranges does not have is noticed.
#include "calibrate/inference/repeats.h"

#include <gtest/gtest.h>

#include "calibrate/numerics/experimental_design.h"
#include "experiments/analysis/random_stream.h"
#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

// A response y over the unit square, run four times in the middle and once at each other point.
struct SingleRuns {
  using Response = std::function<double(const VectorXd&, std::mt19937_64&)>;

  SingleRuns(std::uint64_t seed, const Response& response) {
    study.targets.push_back({{0, "y", "y"}, 8, 0.6, "1", "", 0});
    study.experiments.push_back({"", "", {}, {true, true}});
    for (const char* name : {"a", "b"}) {
      Parameter p;
      p.name = name;
      p.max = 1;
      study.parameters.push_back(p);
    }
    std::mt19937_64 random(seed);
    const auto add = [&](const VectorXd& u, int runs) {
      Point point;
      point.u = u;
      point.results.resize(1);
      for (int i = 0; i < runs; ++i) {
        point.seeds.push_back(static_cast<std::uint64_t>(i + 1));
        point.results[0].push_back(finished({scalar("y", response(u, random), "1")}));
      }
      points.push_back(point);
    };
    add(Vector2d(0.5, 0.5), 4);
    for (const VectorXd& u : maximin_latin_hypercube(26, 2, seed, {points[0].u})) add(u, 1);
    models = fit_response_models(study, points);
  }

  Study study;
  std::vector<Point> points;
  std::optional<ResponseModels> models;
};

TEST(SingleRuns, ModelsOfLinesStateTheUncertaintyThatTheyHave) {
  constexpr int models = 40, places = 20;
  double squares = 0;
  for (std::uint64_t s = 0; s < models; ++s) {
    std::mt19937_64 random(900 + s);
    const double a = 4 + 8 * uniform_open(random), b = 8 * uniform_open(random);
    const auto line = [&](const VectorXd& u) { return a * u[0] + b * u[1]; };
    const SingleRuns runs(s + 1, [&](const VectorXd& u, std::mt19937_64& noise) {
      return line(u) + 0.6 * normal_deviate(noise);
    });
    for (int i = 0; i < places; ++i) {
      const Vector2d u(uniform_open(random), uniform_open(random));
      const Prediction p = runs.models->targets[0].surrogate.best.predict(u);
      squares += std::pow(p.mean - line(u), 2) / p.variance;
    }
  }
  const double ratio = std::sqrt(squares / (models * places));
  RecordProperty("error_over_stated", std::to_string(ratio));
  EXPECT_GT(ratio, 0.7);
  EXPECT_LT(ratio, 1.2);
}

TEST(SingleRuns, ScatterThatTheMiddleDoesNotHaveIsNoticed) {
  int noticed = 0, alarms = 0;
  for (std::uint64_t s = 0; s < 20; ++s) {
    const auto response = [](bool shifted) {
      return [shifted](const VectorXd& u, std::mt19937_64& random) {
        const double y = 10 * u[0] + 6 * u[1] + 0.4 * normal_deviate(random);
        return y + (uniform_open(random) < 0.3 && shifted && u.sum() > 1 ? 5 : 0);
      };
    };
    const SingleRuns shifted(s + 1, response(true)), quiet(s + 1, response(false));
    noticed += scatter_exceeds_noise(shifted.study, *shifted.models);
    alarms += scatter_exceeds_noise(quiet.study, *quiet.models);
    EXPECT_FALSE(noise_exceeds_measurement(quiet.study, *quiet.models) &&
                 sample(quiet.points[0].finished({0, "y", "y"})).sd() < 0.6);
  }
  EXPECT_GE(noticed, 17);
  EXPECT_LE(alarms, 2);
}

TEST(SingleRuns, ThoseThatMeetTheTargetAreRepeated) {
  const SingleRuns runs(3, [](const VectorXd& u, std::mt19937_64& random) {
    return 10 * u[0] + 6 * u[1] + 0.1 * normal_deviate(random);
  });
  const auto chosen = points_to_repeat(runs.study, *runs.models, runs.points, 3);
  ASSERT_EQ(chosen.size(), 3u);
  const auto off = [&](const Point& p) { return std::abs(10 * p.u[0] + 6 * p.u[1] - 8); };
  for (const std::size_t i : chosen) {
    EXPECT_EQ(runs.points[i].seeds.size(), 1u);
    EXPECT_LT(off(runs.points[i]), 1);
  }
  EXPECT_EQ(points_to_repeat(runs.study, *runs.models, runs.points, 100).size(), 26u);
}

}  // namespace
}  // namespace firn
