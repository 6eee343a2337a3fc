// Whether the targets can be met together: false alarms and power, held against problems whose
// truth is known.
#include "calibrate/inference/goodness_of_fit.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "experiments/analysis/random_stream.h"
#include "tests/calibrate/lab_study.h"

namespace firn {
namespace {

using namespace lab;
using nlohmann::json;
using testing::HasSubstr;

// t_k = 10 + s_k a + c_k b with directions spread over the half circle.
double fan(int k, int count, double a, double b) {
  const double angle = M_PI * (k + 0.3) / count;
  return 10 + 8 * (std::cos(angle) * a + std::sin(angle) * b);
}

// The shares of studies of `count` targets that are called infeasible, each measured with an
// independent error and `shift` on top, in standard deviations.
double share_rejected(int count, int studies, const std::function<double(int)>& shift) {
  int rejected = 0;
  for (int s = 0; s < studies; ++s) {
    std::mt19937_64 random(static_cast<std::uint64_t>(1000 * count + s));
    const double a = 0.1 + 0.8 * uniform_open(random), b = 0.1 + 0.8 * uniform_open(random);
    std::vector<Aim> aims;
    for (int k = 0; k < count; ++k)
      aims.push_back({fan(k, count, a, b) + 0.5 * (normal_deviate(random) + shift(k)), 0.5});
    const Outcome o = carry_out(
        study_text(unit_square, aims, 30, 1 + 10000 * s), [&](const Values& v, auto& noise) {
          std::vector<double> t;
          for (int k = 0; k < count; ++k)
            t.push_back(fan(k, count, v.at("a"), v.at("b")) + 0.3 * normal_deviate(noise));
          return t;
        });
    rejected += o.summary.verdict == StudyVerdict::infeasible ||
                o.summary.verdict == StudyVerdict::unconfirmed;
  }
  return static_cast<double>(rejected) / studies;
}

// y = 5 + 10 a + 6 b over a in 0..1 and b in 0..2: at least 5.
Outcome below_the_minimum(double target, int seed) {
  return carry_out(
      study_text({{"a", 0, 1}, {"b", 0, 2}}, {{target, 0.8}}, 40, seed),
      [](const Values& v, auto& random) {
        return std::vector{5 + 10 * v.at("a") + 6 * v.at("b") + normal_deviate(random)};
      });
}

TEST(NegativeLogPosterior, OutOfReachIsSaidOnlyOfWhatWasSimulated) {
  const Outcome near = below_the_minimum(5.149, 280197);
  EXPECT_NE(near.summary.verdict, StudyVerdict::infeasible) << near.summary.table;
  // Far below: said, and simulated there.
  const Outcome far = below_the_minimum(0.5, 1);
  EXPECT_EQ(far.summary.verdict, StudyVerdict::infeasible) << far.summary.table;
  EXPECT_THAT(far.summary.headline, HasSubstr("infeasible within the ranges: t0 = 0.5"));
  const json& nearest = far.j["estimate"];
  EXPECT_LT(nearest["parameters"]["a"], 0.05);
  EXPECT_LT(nearest["parameters"]["b"], 0.1);
  EXPECT_GE(nearest["runs"]["finished"], 3);
}

TEST(MisfitLong, ATargetUnderTheMinimumByItsErrorIsWithinReach) {
  int wrong = 0;
  for (int s = 0; s < 40; ++s)
    wrong += below_the_minimum(5 - 0.8 * (1.2 + 0.6 * s / 39), 1 + 1000 * s).summary.verdict ==
             StudyVerdict::infeasible;
  EXPECT_LE(wrong, 1);
}

TEST(NegativeLogPosterior, ChiSquareTailIsThatOfTheTables) {
  EXPECT_NEAR(chi_square_tail(3.841, 1), 0.05, 1e-4);
  EXPECT_NEAR(chi_square_tail(12.592, 6), 0.05, 1e-4);
  EXPECT_EQ(chi_square_tail(0, 3), 1);
  EXPECT_EQ(chi_square_tail(INFINITY, 3), 0);
}

TEST(NegativeLogPosterior, ResidualsOfOppositeSignsThatAreEachSmallAreTooMuchTogether) {
  std::vector<Aim> aims;
  for (int k = 0; k < 8; ++k)
    aims.push_back({fan(k, 8, 0.5, 0.5) + 0.5 * (k % 2 == 0 ? 1.9 : -1.9), 0.5});
  const Outcome o =
      carry_out(study_text(unit_square, aims, 30, 1), [](const Values& v, auto& random) {
        std::vector<double> t;
        for (int k = 0; k < 8; ++k)
          t.push_back(fan(k, 8, v.at("a"), v.at("b")) + 0.2 * normal_deviate(random));
        return t;
      });
  EXPECT_EQ(o.summary.verdict, StudyVerdict::infeasible) << o.summary.table;
  EXPECT_THAT(o.summary.headline, HasSubstr("meet all targets at once: chi-square"));
  EXPECT_NEAR(o.j["goodness_of_fit"]["degrees_of_freedom"].get<double>(), 6, 0.3);
}

TEST(MisfitLong, FalseAlarmsAndPower) {
  constexpr int studies = 24;
  fmt::print("targets: share rejected when right; one wrong by 5 sd; opposing by 2 sd\n");
  double alarms = 0;
  for (const int count : {1, 2, 3, 4, 6, 8, 12}) {
    const double right = share_rejected(count, studies, [](int) { return 0; });
    alarms += right * studies;
    fmt::print("{:>3}: {:.3f}", count, right);
    EXPECT_LE(right * studies, 0.05 * studies + 3 * std::sqrt(0.0475 * studies)) << count;
    if (count >= 6) {
      const double one = share_rejected(count, studies, [](int k) { return k == 0 ? 5 : 0; });
      const double opposing =
          share_rejected(count, studies, [](int k) { return k % 2 == 0 ? 2 : -2; });
      fmt::print("  {:.3f}  {:.3f}", one, opposing);
      EXPECT_GT(one, 0.8) << count;
      EXPECT_GT(opposing, 0.8) << count;
    }
    fmt::print("\n");
  }
  EXPECT_LE(alarms, 0.05 * 7 * studies + 2 * std::sqrt(0.0475 * 7 * studies));
}

TEST(NegativeLogPosterior, APriorThatConflictsWithTheDataIsNamed) {
  std::string text = study_text(unit_square, {{12, 0.3}, {15, 0.3}}, 40, 1);
  // The truth is at a = 0.2, b = 0.5; the prior wants a = 0.8.
  text.insert(text.find("max = 1\n"), "prior_mean = 0.8\nprior_sd = 0.03\n");
  const Outcome o = carry_out(text, [](const Values& v, auto& random) {
    return std::vector{10 + 10 * v.at("a") + 0.3 * normal_deviate(random),
                       10 + 10 * v.at("b") + 0.3 * normal_deviate(random)};
  });
  EXPECT_EQ(o.summary.verdict, StudyVerdict::prior_conflict) << o.summary.table;
  EXPECT_THAT(o.summary.headline, HasSubstr("the priors conflict with the targets"));
  EXPECT_TRUE(o.j["goodness_of_fit_without_priors"]["acceptable"].get<bool>());
}

}  // namespace
}  // namespace firn
