#include "experiments/analysis/elementary_effects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "experiments/analysis/random_stream.h"

namespace firn {
namespace {

using Factors = std::vector<double>;  // 0 to 1

std::vector<double> values_of(const ScreeningDesign& design,
                              const std::function<double(const Factors&)>& function) {
  std::vector<double> y;
  for (const auto& point : design.points) {
    Factors x;
    for (std::size_t f = 0; f < point.size(); ++f)
      x.push_back(static_cast<double>(point[f]) / static_cast<double>(design.levels[f] - 1));
    y.push_back(function(x));
  }
  return y;
}

std::vector<std::size_t> random_levels(std::mt19937_64& random) {
  std::vector<std::size_t> levels(1 + random() % 12);
  for (std::size_t& n : levels) n = 2 * (1 + random() % 4);
  return levels;
}

TEST(ElementaryEffects, TrajectoriesStepOnceAlongEachFactor) {
  std::mt19937_64 random(7);
  for (std::uint64_t member = 0; member < 100; ++member) {
    const std::vector<std::size_t> levels = random_levels(random);
    const int count = 2 + static_cast<int>(random() % 9);
    const ScreeningDesign design = screening_design(levels, count, member);
    ASSERT_EQ(design.trajectories.size(), static_cast<std::size_t>(count));
    const std::set<std::vector<std::size_t>> different(design.points.begin(), design.points.end());
    EXPECT_EQ(different.size(), design.points.size());
    for (const auto& steps : design.trajectories) {
      ASSERT_EQ(steps.size(), levels.size());
      std::set<std::size_t> factors;
      for (std::size_t s = 0; s < steps.size(); ++s) {
        const ScreeningStep& step = steps[s];
        factors.insert(step.factor);
        const auto &low = design.points.at(step.lower), &high = design.points.at(step.upper);
        for (std::size_t f = 0; f < levels.size(); ++f) {
          EXPECT_LT(high[f], levels[f]);
          EXPECT_EQ(high[f], low[f] + (f == step.factor ? levels[f] / 2 : 0));
        }
        if (s == 0) continue;  // it begins where the one before has ended
        const ScreeningStep& last = steps[s - 1];
        const std::set<std::size_t> before = {last.lower, last.upper};
        EXPECT_EQ(before.count(step.lower) + before.count(step.upper), 1u);
      }
      EXPECT_EQ(factors.size(), levels.size());
    }
    EXPECT_EQ(screening_design(levels, count, member).points, design.points);
  }
}

TEST(ElementaryEffects, AllLevelsAreTakenEquallyOften) {
  constexpr int kTrajectories = 4000;
  const ScreeningDesign design = screening_design({4, 6, 2}, kTrajectories, 3);
  std::vector<std::vector<int>> lower(3, std::vector<int>(6, 0));
  for (const auto& steps : design.trajectories)
    for (const ScreeningStep& s : steps) ++lower[s.factor][design.points[s.lower][s.factor]];
  for (std::size_t f = 0; f < 3; ++f) {
    const std::size_t half = design.levels[f] / 2;
    const double expected = kTrajectories / static_cast<double>(half);
    for (std::size_t level = 0; level < half; ++level)
      EXPECT_NEAR(lower[f][level], expected, 5 * std::sqrt(expected)) << f << ' ' << level;
  }
}

// An effect is the change over the whole range, however many levels there are.
TEST(ElementaryEffects, OfALinearFunctionAreItsSlopes) {
  std::mt19937_64 random(11);
  for (std::uint64_t member = 0; member < 50; ++member) {
    const std::vector<std::size_t> levels = random_levels(random);
    Factors slopes;
    for (std::size_t f = 0; f < levels.size(); ++f) slopes.push_back(normal_deviate(random));
    const ScreeningDesign design = screening_design(levels, 4, member);
    const auto effects = elementary_effects(design, values_of(design, [&](const Factors& x) {
                                              double y = 3;
                                              for (std::size_t f = 0; f < x.size(); ++f)
                                                y += slopes[f] * x[f];
                                              return y;
                                            }));
    for (std::size_t f = 0; f < levels.size(); ++f) {
      EXPECT_EQ(effects[f].count, 4);
      EXPECT_NEAR(effects[f].mean, slopes[f], 1e-12);
      EXPECT_NEAR(effects[f].mean_absolute, std::abs(slopes[f]), 1e-12);
      EXPECT_NEAR(effects[f].standard_deviation, 0, 1e-12);
      EXPECT_NEAR(effects[f].lower, std::abs(slopes[f]), 1e-12);
      EXPECT_NEAR(effects[f].upper, std::abs(slopes[f]), 1e-12);
    }
  }
}

// y = a b: the effect of a is the value of b, whose four levels are 0, 1/3, 2/3, 1.
TEST(ElementaryEffects, ScatterWhereFactorsInteract) {
  const ScreeningDesign design = screening_design({4, 4}, 3000, 5);
  const auto effects =
      elementary_effects(design, values_of(design, [](const Factors& x) { return x[0] * x[1]; }));
  for (const ElementaryEffects& e : effects) {
    EXPECT_NEAR(e.mean, 0.5, 0.04);
    EXPECT_NEAR(e.standard_deviation, std::sqrt(5.0 / 36), 0.02);
    EXPECT_NEAR(e.upper - e.mean_absolute, 1.96 * e.standard_deviation / std::sqrt(3000.0), 1e-3);
  }
}

// Signs cancel in the mean, not in the mean of absolute values.
TEST(ElementaryEffects, OfAFactorThatActsBothWaysCount) {
  const ScreeningDesign design = screening_design({2, 2}, 400, 5);
  const auto effects = elementary_effects(
      design, values_of(design, [](const Factors& x) { return x[0] * (x[1] > 0.5 ? 1 : -1); }));
  EXPECT_NEAR(effects[0].mean, 0, 0.2);
  EXPECT_NEAR(effects[0].mean_absolute, 1, 1e-12);
}

// The function of Morris (1991): factors 1 to 10 of 20 matter.
TEST(ElementaryEffects, FindTheFactorsOfMorris) {
  const auto function = [](const Factors& x) {
    std::mt19937_64 random(1991);
    Factors w;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const bool bent = i == 2 || i == 4 || i == 6;
      w.push_back(2 * ((bent ? 1.1 * x[i] / (x[i] + 0.1) : x[i]) - 0.5));
    }
    double y = normal_deviate(random);
    for (std::size_t i = 0; i < 20; ++i) {
      y += (i < 10 ? 20 : normal_deviate(random)) * w[i];
      for (std::size_t j = i + 1; j < 20; ++j) {
        y += (j < 6 ? -15 : normal_deviate(random)) * w[i] * w[j];
        for (std::size_t k = j + 1; k < 5; ++k) {
          y += -10 * w[i] * w[j] * w[k];
          for (std::size_t l = k + 1; l < 4; ++l) y += 5 * w[i] * w[j] * w[k] * w[l];
        }
      }
    }
    return y;
  };
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const ScreeningDesign design = screening_design(std::vector<std::size_t>(20, 4), 8, seed);
    const auto effects = elementary_effects(design, values_of(design, function));
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (std::size_t f = 0; f < 20; ++f) {
      if (f < 10) least = std::min(least, effects[f].mean_absolute);
      if (f >= 10) most = std::max(most, effects[f].mean_absolute);
    }
    EXPECT_GT(least, most) << seed;
    // Of those that matter, 8 to 10 act alone.
    EXPECT_LT(effects[8].standard_deviation, 0.5 * effects[8].mean_absolute) << seed;
    EXPECT_GT(effects[1].standard_deviation, effects[8].standard_deviation) << seed;
  }
}

TEST(ElementaryEffects, OfNoiseAloneAreAsStated) {
  std::mt19937_64 random(2);
  const ScreeningDesign design = screening_design({4, 2, 8}, 3000, 1);
  // Three factors have few points, which the trajectories share: each gets separate noise.
  std::vector<double> y(design.points.size()), sum(3, 0);
  for (const auto& steps : design.trajectories) {
    for (double& v : y) v = 0.3 * normal_deviate(random);
    ScreeningDesign one = design;
    one.trajectories = {steps};
    const auto effects = elementary_effects(one, y);
    for (std::size_t f = 0; f < 3; ++f) sum[f] += effects[f].mean_absolute / 3000;
  }
  const std::vector<double> expected = noise_effects(design, 0.3);
  for (std::size_t f = 0; f < 3; ++f) EXPECT_NEAR(sum[f], expected[f], 0.06 * expected[f]);
}

TEST(ElementaryEffects, LeaveUndefinedResponsesOut) {
  const ScreeningDesign design = screening_design({2}, 2, 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto none = elementary_effects(design, std::vector<double>(design.points.size(), nan));
  EXPECT_EQ(none[0].count, 0);
  EXPECT_TRUE(std::isnan(none[0].mean_absolute));
  EXPECT_TRUE(std::isnan(none[0].upper));
  ScreeningDesign one = design;
  one.trajectories.resize(1);
  std::vector<double> y(design.points.size(), 0);
  y[one.trajectories[0][0].upper] = 2;
  const auto single = elementary_effects(one, y);
  EXPECT_DOUBLE_EQ(single[0].mean_absolute, 2);
  EXPECT_TRUE(std::isnan(single[0].upper));
}

}  // namespace
}  // namespace firn
