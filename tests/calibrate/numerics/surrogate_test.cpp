// The model of a response: it interpolates, its derivatives are right, it knows what it does not
// know.
#include "calibrate/numerics/surrogate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/numerics/experimental_design.h"
#include "calibrate/numerics/optimize.h"
#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

SurrogateData sampled(int points, const std::function<double(const VectorXd&)>& f, double noise_sd,
                      std::uint64_t seed = 5) {
  SurrogateData data{MatrixXd(points, 2), VectorXd(points),
                     VectorXd::Constant(points, noise_sd * noise_sd)};
  std::mt19937_64 random(seed);
  const auto design = maximin_latin_hypercube(points, 2, seed, {});
  for (int i = 0; i < points; ++i) {
    data.u.row(i) = design[static_cast<std::size_t>(i)].transpose();
    data.y[i] = f(design[static_cast<std::size_t>(i)]) + noise_sd * normal_deviate(random);
  }
  return data;
}

double wavy(const VectorXd& u) { return 3 + std::sin(4 * u[0]) + u[1] * u[1]; }

const SurrogateForm forms[] = {{false, false, false}, {true, false, false}, {false, true, false},
                               {false, false, true},  {true, false, true},  {false, true, true}};

TEST(Surrogate, AGaussianProcessWithoutNoiseInterpolates) {
  const SurrogateData data = sampled(20, wavy, 0);
  const Surrogate s(data, {false, true, false});
  for (int i = 0; i < data.y.size(); ++i) {
    const Prediction p = s.predict(data.u.row(i).transpose());
    EXPECT_NEAR(p.mean, data.y[i], 1e-5);
    EXPECT_LT(std::sqrt(p.variance), 1e-3);
  }
  // Between the points it is near the truth, within what it says of itself.
  for (std::uint64_t i = 0; i < 50; ++i) {
    const VectorXd u = quasi_random_point(i, 2);
    const Prediction p = s.predict(u);
    EXPECT_NEAR(p.mean, wavy(u), 4 * std::sqrt(p.variance) + 1e-6);
  }
}

TEST(Surrogate, DerivativesMatchCeresForEveryForm) {
  const SurrogateData data = sampled(12, wavy, 0.05);
  for (const SurrogateForm& form : forms) {
    const Surrogate s(data, form);
    LeastSquaresProblem mean_and_variance;
    mean_and_variance.residuals = 2;
    mean_and_variance.evaluate = [&](const VectorXd& u, VectorXd& r, MatrixXd* jacobian) {
      const Prediction p = s.predict_with_gradients(u);
      r << p.mean, p.variance;
      if (jacobian != nullptr) {
        jacobian->row(0) = p.mean_gradient.transpose();
        jacobian->row(1) = p.variance_gradient.transpose();
      }
      return true;
    };
    for (std::uint64_t i = 0; i < 5; ++i)
      EXPECT_LT(jacobian_error(mean_and_variance, quasi_random_point(i, 2)), 2e-5)
          << form.describe();
  }
}

TEST(Surrogate, APowerLawIsLinearInItsLogarithm) {
  const auto law = [](const VectorXd& u) { return 10 * std::exp(1.5 * u[0] - 0.7 * u[1]); };
  SurrogateData data = sampled(8, law, 0);
  data.noise_variance.setConstant(1e-6);
  const SurrogateChoice choice = choose_surrogate(data);
  EXPECT_TRUE(choice.best.form().logarithm);
  EXPECT_FALSE(choice.best.form().quadratic);
  const Prediction p = choice.best.predict_with_gradients(Eigen::Vector2d(0.3, 0.6));
  EXPECT_NEAR(p.mean, law(Eigen::Vector2d(0.3, 0.6)), 0.02);
  EXPECT_NEAR(p.mean_gradient[0] / p.mean, 1.5, 0.01);
  EXPECT_NEAR(p.mean_gradient[1] / p.mean, -0.7, 0.01);
}

TEST(Surrogate, FewPointsGetNoGaussianProcess) {
  EXPECT_FALSE(choose_surrogate(sampled(8, wavy, 0.05)).best.form().matern);
}

TEST(Surrogate, ErrorsAreAsLargeAsItSays) {
  // Over many data sets, deviations from the truth over the predicted standard deviation have a
  // mean square near one: neither boasting nor useless.
  double squares = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 25; ++seed) {
    const SurrogateChoice choice = choose_surrogate(sampled(12, wavy, 0.15, seed));
    for (std::uint64_t i = 0; i < 10; ++i, ++count) {
      const VectorXd u = quasi_random_point(i, 2);
      const Prediction p = choice.best.predict(u);
      squares += std::pow(p.mean - wavy(u), 2) / p.variance;
    }
  }
  EXPECT_GT(squares / count, 0.3);
  EXPECT_LT(squares / count, 1.8);
}

TEST(Surrogate, AllPredictionsOfAPlaceAreEqual) {
  for (const SurrogateForm& form : forms) {
    const Surrogate one(sampled(15, wavy, 0.1), form);
    const Surrogate other(sampled(15, wavy, 0.1), SurrogateForm{!form.quadratic, !form.matern});
    for (const Surrogate& s : {one, one.mixed_with(other, 0.3)})
      for (std::uint64_t i = 0; i < 5; ++i) {
        const VectorXd u = quasi_random_point(i, 2);
        const Prediction plain = s.predict(u), noise = s.predict_with_noise(u),
                         all = s.predict_with_gradients(u);
        EXPECT_EQ(plain.noise_variance, 0);
        EXPECT_EQ(noise.mean, plain.mean);
        EXPECT_EQ(noise.variance, plain.variance);
        EXPECT_EQ(all.mean, plain.mean);
        EXPECT_EQ(all.variance, plain.variance);
        EXPECT_EQ(all.noise_variance, noise.noise_variance);
        EXPECT_EQ(s.predict_mean(u), plain.mean);
      }
  }
}

TEST(Surrogate, NoiseIsAPartOfTheVarianceAndShrinksWithSeeds) {
  const VectorXd u = Eigen::Vector2d(0.4, 0.5);
  for (const SurrogateForm& form : forms) {
    SurrogateData data = sampled(15, wavy, 0.1);
    const Prediction few = Surrogate(data, form).predict_with_noise(u);
    EXPECT_GT(few.noise_variance, 0);
    EXPECT_LE(few.noise_variance, few.variance);
    data.noise_variance /= 100;
    EXPECT_LT(Surrogate(data, form).predict_with_noise(u).noise_variance, few.noise_variance / 20);
  }
}

TEST(Surrogate, ABelievedPointLowersTheVarianceThereAndHardlyMovesTheMean) {
  const VectorXd u = Eigen::Vector2d(0.95, 0.05);
  for (const SurrogateForm& form : forms) {
    const Surrogate s(sampled(10, wavy, 0.1), form);
    const Prediction before = s.predict(u), after = s.with_fantasy_point(u, 0.01).predict(u);
    EXPECT_LT(after.variance, before.variance);
    // The members, which differ, are drawn to their mean, each as far as it is unsure.
    EXPECT_NEAR(after.mean, before.mean, 0.1 * std::sqrt(before.variance));
  }
}

// A logarithmic model predicts values above zero. Another kind of model with a share in the
// prediction may bring the mean below zero where the response is small.
TEST(Surrogate, TakesABelievedPointWhereItsMeanIsBelowZero) {
  const auto product = [](const VectorXd& u) { return 10 * u[0] * u[1]; };
  int below = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SurrogateData data = sampled(14, product, 0.6, seed);
    data.y = data.y.cwiseAbs();
    const SurrogateChoice choice = choose_surrogate(data);
    for (std::uint64_t k = 0; k < 30; ++k) {
      const VectorXd u = quasi_random_point(k, 2);
      below += choice.best.form().logarithm && choice.best.predict_mean(u) < 0;
      EXPECT_TRUE(std::isfinite(choice.best.with_fantasy_point(u, 0.36).predict_mean(u)));
    }
  }
  EXPECT_GT(below, 0);
}

TEST(Design, EveryLevelOnceAndFarApart) {
  const std::vector<VectorXd> taken = {Eigen::Vector2d(0.5, 0.5)};
  const auto points = maximin_latin_hypercube(8, 2, 3, taken);
  for (int k = 0; k < 2; ++k) {
    std::vector<double> levels;
    for (const VectorXd& p : points) levels.push_back(p[k]);
    std::sort(levels.begin(), levels.end());
    for (int i = 0; i < 8; ++i)
      EXPECT_NEAR(levels[static_cast<std::size_t>(i)], 0.05 + 0.9 * i / 7, 1e-12);
  }
  // Eight points and the center at the corners of a grid of nine would be 0.45 apart.
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_GT((points[i] - taken[0]).norm(), 0.2);
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT((points[i] - points[j]).norm(), 0.2);
  }
  EXPECT_EQ(points, maximin_latin_hypercube(8, 2, 3, taken));
}

TEST(Design, QuasiRandomPointsFillTheCube) {
  // Fraction in a corner box against its volume.
  int inside = 0;
  for (std::uint64_t i = 0; i < 4000; ++i) {
    const VectorXd u = quasi_random_point(i, 3);
    EXPECT_TRUE((u.array() >= 0).all() && (u.array() < 1).all());
    inside += (u.array() < 0.5).all();
  }
  EXPECT_NEAR(inside / 4000.0, 0.125, 0.004);
}

// Values that no arithmetic with doubles can take: any answer, but no abort.
TEST(Surrogate, EndsWithWhateverDataThereIs) {
  std::mt19937_64 random(11);
  const double extremes[] = {0,     1,     -1,     1e-320, 1e-300, 1e-200, 1e-100, 1e-30, 1e30,
                             1e100, 1e150, -1e150, 1e200,  -1e200, 1e300,  1e308,  -1e308};
  for (int i = 0; i < 200; ++i) {
    SurrogateData data = sampled(3 + static_cast<int>(random() % 10), wavy, 0.01);
    const int changed = 1 + static_cast<int>(random() % 3);
    for (int k = 0; k < changed; ++k)
      data.y[static_cast<Eigen::Index>(random() % static_cast<std::uint64_t>(data.y.size()))] =
          extremes[random() % std::size(extremes)];
    if (random() % 4 == 0) data.noise_variance[0] = extremes[random() % std::size(extremes)];
    const SurrogateChoice choice = choose_surrogate(data);
    choice.best.predict_with_gradients(data.u.row(0).transpose());
    choice.best.with_fantasy_point(data.u.row(1).transpose(), 0.01);
  }
}

}  // namespace
}  // namespace firn
