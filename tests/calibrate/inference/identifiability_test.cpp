// What the data determine, where the answer is known in closed form.
#include "calibrate/inference/identifiability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "calibrate/numerics/experimental_design.h"
#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

using Eigen::VectorXd;

// Two linear parameters on [0, 1] and targets that are linear in them.
struct Linear {
  // Target k: coefficients . u, measured as `value` with `uncertainty`.
  struct Line {
    double a, b, value, uncertainty;
  };
  explicit Linear(const std::vector<Line>& lines) {
    for (const char* name : {"p", "q"}) {
      Parameter parameter;
      parameter.name = name;
      parameter.max = 1;
      study.parameters.push_back(parameter);
    }
    for (std::size_t k = 0; k < lines.size(); ++k)
      study.targets.push_back({{0, std::string(1, static_cast<char>('a' + k)), "line"},
                               lines[k].value,
                               lines[k].uncertainty,
                               "1",
                               "",
                               0});
    study.experiments.push_back({"", "", {}, {true, true}});
    std::vector<Point> points;
    for (const VectorXd& u : maximin_latin_hypercube(20, 2, 1, {})) {
      Point point;
      point.u = u;
      point.results.resize(1);
      for (const double noise : {-1e-4, 1e-4}) {  // two seeds: hardly any noise
        JobResult r = finished({});
        for (std::size_t k = 0; k < lines.size(); ++k)
          r.responses.push_back(scalar(study.targets[k].response.name,
                                       lines[k].a * u[0] + lines[k].b * u[1] + noise, "1"));
        point.results[0].push_back(r);
      }
      points.push_back(point);
    }
    models = fit_response_models(study, points);
  }
  Study study;
  std::optional<ResponseModels> models;
};

TEST(Identify, TwoLinesThatCrossDetermineBothParameters) {
  // p = 0.4 ± 0.02 and q = 0.7 ± 0.05, straight.
  const Linear line({{1, 0, 0.4, 0.02}, {0, 1, 0.7, 0.05}});
  const NegativeLogPosterior misfit(line.study, *line.models);
  const VectorXd best = misfit.best().x;
  EXPECT_NEAR(best[0], 0.4, 1e-3);
  EXPECT_NEAR(best[1], 0.7, 1e-3);
  const auto c = combinations(line.study, *line.models, best);
  EXPECT_TRUE(c[0].identifiable && c[1].identifiable);
  EXPECT_NEAR(c[0].sd, 0.02, 1e-4);
  EXPECT_NEAR(c[1].sd, 0.05, 1e-4);
  EXPECT_NEAR(std::sqrt(c[1].split.measurement), 0.05, 1e-4);
  const Posterior posterior = sample_posterior(line.study, misfit);
  EXPECT_NEAR(posterior.marginals[0].sd, 0.02, 5e-4);
  EXPECT_NEAR(posterior.marginals[1].sd, 0.05, 2e-3);
  EXPECT_NEAR(posterior.marginals[0].posterior_to_prior_sd, 0.02 * std::sqrt(12), 2e-3);
  EXPECT_NEAR(posterior.marginals[1].median, 0.7, 2e-3);
  EXPECT_NEAR(posterior.marginals[1].low, 0.7 - 1.96 * 0.05, 3e-3);
}

TEST(Identify, OneLineLeavesTheDirectionAlongItOpen) {
  const Linear line({{3, 4, 3.5, 0.1}});  // (3 p + 4 q) / 5 = 0.7 ± 0.02
  const NegativeLogPosterior misfit(line.study, *line.models);
  const VectorXd best = misfit.best().x;
  const auto c = combinations(line.study, *line.models, best);
  ASSERT_EQ(c.size(), 2u);
  EXPECT_TRUE(c[0].identifiable);
  EXPECT_NEAR(c[0].coefficients[0], 0.6, 1e-3);
  EXPECT_NEAR(c[0].coefficients[1], 0.8, 1e-3);
  EXPECT_NEAR(c[0].value, 0.7, 1e-3);
  EXPECT_NEAR(c[0].sd, 0.02, 2e-4);
  EXPECT_FALSE(c[1].identifiable);
  EXPECT_TRUE(std::isinf(c[1].sd));
  const Posterior posterior = sample_posterior(line.study, misfit);
  auto strayed = c;
  rms_over_posterior(posterior, line.study, strayed);
  EXPECT_NEAR(strayed[0].spread, 0.02, 1e-3);  // a straight valley
  EXPECT_NEAR(std::abs(posterior.longest[0]), 0.8, 0.02);
  for (const RidgeMember& member : ridge(line.study, misfit, posterior))
    EXPECT_NEAR(0.6 * member.u[0] + 0.8 * member.u[1], 0.7, 4e-3);  // a fifth of the band's 0.02
  // p may be anything: q from 0.125 to 0.875 makes up for it.
  EXPECT_GT(posterior.marginals[0].posterior_to_prior_sd, 0.9);
}

// Where a parameter may be at an end of its range, the other one may be at its end of the valley.
TEST(Identify, IntervalsHoldBothParametersAtTheEndsOfAValley) {
  std::mt19937_64 bits(815);
  const auto draw = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(bits() >> 11) * 0x1p-53;
  };
  int ends = 0;
  for (int k = 0; k < 12; ++k) {
    const double a = draw(1, 5), b = (k % 2 == 0 ? 1 : -1) * draw(1, 5);
    const double at_middle = 0.5 * (a + b), sd = draw(0.005, 0.05) * std::hypot(a, b);
    const Linear line({{a, b, at_middle, sd}});
    const Posterior posterior =
        sample_posterior(line.study, NegativeLogPosterior(line.study, *line.models));
    for (const double p : {0.0, 1.0}) {
      const double q = (at_middle - a * p) / b;
      if (q < 0.02 || q > 0.98) continue;  // q ends first
      ++ends;
      EXPECT_LE(posterior.marginals[1].low, q) << a << " p + " << b << " q ± " << sd;
      EXPECT_GE(posterior.marginals[1].high, q) << a << " p + " << b << " q ± " << sd;
    }
  }
  EXPECT_GE(ends, 6);
}

TEST(Identify, AWeakDirectionCountsAsOpenAlthoughNothingIsSingular) {
  // q moves its response by one standard deviation over the whole range: nothing to learn of it.
  const Linear line({{1, 0, 0.4, 0.02}, {0, 1, 0.5, 1.0}});
  const auto c = combinations(line.study, *line.models, Eigen::Vector2d(0.4, 0.5));
  EXPECT_TRUE(c[0].identifiable);
  EXPECT_FALSE(c[1].identifiable);
  EXPECT_NEAR(c[1].singular_value, 1, 0.01);
}

TEST(Identify, ResidualsHaveExactDerivatives) {
  Linear line({{3, 4, 3.5, 0.1}, {1, -2, 0, 0.3}});
  line.study.parameters[1].prior_mean = 0.3;
  line.study.parameters[1].prior_sd = 0.1;
  const NegativeLogPosterior misfit(line.study, *line.models);
  const VectorXd at = Eigen::Vector2d(0.3, 0.6);
  EXPECT_LT(jacobian_error(misfit.residuals(at), at), 1e-6);
}

TEST(Identify, SplittingPointsLieInTheValleyAndApart) {
  const Linear line({{3, 4, 3.5, 0.1}});
  const NegativeLogPosterior misfit(line.study, *line.models);
  const auto points =
      refinement_points(line.study, *line.models, sample_posterior(line.study, misfit),
                        misfit.best().x, FirstPoint::estimate_if_uncertain, {}, 3, 2);
  ASSERT_EQ(points.size(), 3u);
  for (const VectorXd& u : points) EXPECT_NEAR(0.6 * u[0] + 0.8 * u[1], 0.7, 0.1);
  EXPECT_GT((points[0] - points[1]).norm(), 0.3);
}

// Root mean square of both kinds of spread at `level`.
double average(const NoiseModel& noise, double level) {
  const double p = noise.relative_probability;
  return std::sqrt((1 - p) * std::pow(noise.constant_sd, 2) +
                   p * std::pow(noise.relative_sd * level, 2));
}

TEST(Noise, PoolsOverPointsAndNoticesThatItGrowsWithTheResponse) {
  // By hand: squares 2 x 0.5^2 and 2 x 1.5^2 over 2 degrees of freedom.
  const auto constant = pool_noise({sample({9.5, 10.5}), sample({8.5, 11.5}), sample({3})});
  ASSERT_TRUE(constant);
  EXPECT_EQ(constant->degrees_of_freedom, 2);
  EXPECT_NEAR(constant->constant_sd, std::sqrt((0.5 + 4.5) / 2), 1e-12);
  EXPECT_NEAR(constant->relative_sd, std::sqrt((0.5 + 4.5) / 2) / 10, 1e-12);
  // Both points have the same mean: they do not distinguish the two.
  EXPECT_NEAR(constant->relative_probability, 0.5, 1e-12);
  EXPECT_NEAR(constant->at(10), constant->constant_sd, 1e-12);
  EXPECT_NEAR(constant->at(20), average(*constant, 20), 1e-12);
  // By hand: squares 0.02, 2 and 200 about means of 1, 10 and 100.
  const auto relative = pool_noise({sample({0.9, 1.1}), sample({9, 11}), sample({90, 110})});
  EXPECT_TRUE(relative->is_relative());
  EXPECT_NEAR(relative->relative_sd, 0.1 * std::sqrt(2), 1e-12);
  EXPECT_NEAR(relative->constant_sd, std::sqrt(202.02 / 3), 1e-12);
  const double likelihood_ratio = std::sqrt(std::pow(202.02 / 3, 3) / (0.02 * 2 * 200));
  EXPECT_NEAR(relative->relative_probability, likelihood_ratio / (1 + likelihood_ratio), 1e-12);
  EXPECT_GT(relative->relative_probability, 0.99);
  EXPECT_NEAR(relative->at(50), average(*relative, 50), 1e-12);
  EXPECT_FALSE(pool_noise({sample({1}), sample({2})}));
  // A response that may be negative has no relative spread.
  EXPECT_EQ(pool_noise({sample({-1, 1}), sample({9, 11})})->relative_probability, 0);
}

// A few points that look proportional by chance do not make the noise vanish at small responses.
TEST(Noise, StaysWhereTheResponseIsSmall) {
  const auto noise = pool_noise({sample({4.8, 5.2}), sample({9.4, 10.6})});
  ASSERT_TRUE(noise);
  EXPECT_GT(noise->relative_probability, 0.5);
  EXPECT_GT(noise->at(0.5), 0.3 * noise->constant_sd);
}

TEST(Noise, ArchedRunsAreAFractionOfTheirNeighborhood) {
  Point flows, arches;
  flows.u = Eigen::Vector2d(0.1, 0.1);
  flows.results = {{finished({}), finished({})}};
  arches.u = Eigen::Vector2d(0.9, 0.9);
  arches.results = {{{JobStatus::arched, "", {}, 1}, {JobStatus::arched, "", {}, 1}}};
  const auto share = [](const std::vector<Point>& points) {
    return OutcomeProbability(points, 0, {JobStatus::arched}, {JobStatus::finished});
  };
  EXPECT_LT(share({flows, arches}).at(flows.u), 1e-6);
  EXPECT_NEAR(share({flows, arches}).at(arches.u), 2 / 2.5, 1e-6);
  EXPECT_EQ(share({flows}).at(arches.u), 0);
}

}  // namespace
}  // namespace firn
