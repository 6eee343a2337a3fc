// Priors and constraints: densities, inequalities, and studies that have them.
#include "calibrate/study/prior.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "calibrate/study/read_parameters.h"
#include "experiments/material_records/material_database.h"
#include "experiments/text/csv/csv_reader.h"
#include "tests/support/environment.h"
#include "tests/support/fake_experiment.h"
#include "tests/support/replaced.h"

namespace firn {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::json;
using test::replaced;
using testing::HasSubstr;

double uniform(std::mt19937_64& random, double from = 0, double to = 1) {
  return from + (to - from) * (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53;
}

Parameter parameter(const std::string& name, double min, double max, bool logarithmic) {
  Parameter p;
  p.name = name;
  p.min = min;
  p.max = max;
  p.logarithmic = logarithmic;
  return p;
}

// Expectation of f(value) under a prior, over the range.
template <class F>
double expectation(const Prior& prior, const Parameter& p, F f) {
  double w = 0, sum = 0;
  constexpr int cells = 20000;
  for (int i = 0; i < cells; ++i) {
    const double u = (i + 0.5) / cells;
    const double density = std::exp(-0.5 * prior_cost({prior}, {p}, VectorXd::Constant(1, u)));
    w += density;
    sum += density * f(p.from_unit(u));
  }
  return sum / w;
}

TEST(Prior, IsADensityOfTheValueOnEitherScale) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 200; ++i) {
    Prior prior;
    prior.parameters = {0};
    const bool logarithmic = i % 2 == 0;
    // Ranges that hold all of the density.
    prior.a = uniform(random, 0.5, 2);
    prior.b = uniform(random, 0.02, 0.08);
    const Parameter wide = parameter("a", 0.05, 6, logarithmic);
    EXPECT_NEAR(expectation(prior, wide, [](double x) { return x; }), prior.a, 1e-4);
    EXPECT_NEAR(expectation(prior, wide, [&](double x) { return std::pow(x - prior.a, 2); }),
                prior.b * prior.b, 1e-5);
    prior.kind = Prior::Kind::log_normal;
    prior.a = std::log(prior.a);
    EXPECT_NEAR(expectation(prior, wide, [](double x) { return std::log(x); }), prior.a, 1e-4);
    EXPECT_NEAR(
        expectation(prior, wide, [&](double x) { return std::pow(std::log(x) - prior.a, 2); }),
        prior.b * prior.b, 1e-5);
    prior.kind = Prior::Kind::beta;
    prior.a = uniform(random, 1.2, 6);
    prior.b = uniform(random, 1.2, 6);
    EXPECT_NEAR(expectation(prior, wide, [&](double x) { return wide.to_unit(x); }),
                prior.a / (prior.a + prior.b), 1e-3);
  }
}

TEST(Prior, ResidualsAreTheRootsOfItsCost) {
  std::mt19937_64 random(8);
  const std::vector<Parameter> all = {parameter("a", 0.1, 2, false), parameter("b", 0.1, 2, true),
                                      parameter("c", 1, 3, false)};
  for (int i = 0; i < 500; ++i) {
    Prior prior;
    prior.kind = static_cast<Prior::Kind>(i % 4);
    prior.parameters = {static_cast<std::size_t>(random() % 3)};
    prior.a =
        prior.kind == Prior::Kind::log_normal ? uniform(random, -1, 0.5) : uniform(random, 1.1, 2);
    prior.b = prior.kind == Prior::Kind::beta ? uniform(random, 1.1, 4) : uniform(random, 0.1, 0.5);
    if (prior.kind == Prior::Kind::joint) {
      prior.parameters = {2, 0};
      prior.mean = VectorXd::NullaryExpr(2, [&] { return uniform(random); });
      const MatrixXd m = MatrixXd::NullaryExpr(2, 2, [&] { return uniform(random, -0.3, 0.3); });
      prior.covariance = m * m.transpose() + 0.001 * MatrixXd::Identity(2, 2);
    }
    const VectorXd u = VectorXd::NullaryExpr(3, [&] { return uniform(random, 0.05, 0.95); });
    VectorXd r, there;
    MatrixXd jacobian, unused;
    prior_residuals(prior, all, u, r, jacobian);
    EXPECT_NEAR(r.squaredNorm(), prior_cost({prior}, all, u), 1e-9 * (1 + r.squaredNorm()));
    if (prior.kind == Prior::Kind::joint) {
      const VectorXd off{{u[2] - prior.mean[0], u[0] - prior.mean[1]}};
      EXPECT_NEAR(r.squaredNorm(), off.dot(prior.covariance.inverse() * off),
                  1e-6 * (1 + r.squaredNorm()));
    }
    for (Eigen::Index k = 0; k < 3; ++k) {
      VectorXd v = u;
      v[k] += 1e-5;
      prior_residuals(prior, all, v, there, unused);
      for (Eigen::Index n = 0; n < r.size(); ++n)
        EXPECT_NEAR((there[n] - r[n]) / 1e-5, jacobian(n, k),
                    1e-2 * (1 + std::abs(jacobian(n, k))));
    }
  }
}

TEST(Constraint, HoldsForEveryPointThatIsRun) {
  std::mt19937_64 random(9);
  int seen = 0;
  for (int i = 0; i < 200; ++i) {
    const double low = uniform(random, 0.001, 1);
    const std::vector<Parameter> all = {
        parameter("a", low, low * uniform(random, 1.5, 50), random() % 2 == 0),
        parameter("b", low, low * uniform(random, 1.5, 50), random() % 2 == 0),
        parameter("c", 0, 1, false)};
    const double ca = uniform(random, -2, 2), cb = uniform(random, -2, 2);
    const double bound = uniform(random, -1, 1) * low;
    const bool at_most = random() % 2 == 0;
    const Constraint c =
        parse_constraint(fmt::format("{} a {} {:.6f}*b {} {:.6f} + 0 c", ca, cb < 0 ? '-' : '+',
                                     std::abs(cb), at_most ? "<=" : ">=", bound),
                         all);
    const Constraints constraints = make_constraints({c}, all);
    if (constraints.share == 0) continue;
    ++seen;
    for (int k = 0; k < 50; ++k) {
      const VectorXd u = VectorXd::NullaryExpr(3, [&] { return uniform(random); });
      EXPECT_EQ(allowed(constraints, all, u), violations(constraints, all, u).isZero(1e-6));
      const std::vector<double> v = allowed_values(constraints, all, u);
      const double sum =
          ca * v[0] + std::copysign(std::stod(fmt::format("{:.6f}", std::abs(cb))), cb) * v[1];
      const double limit = std::stod(fmt::format("{:.6f}", bound));
      EXPECT_LE(at_most ? sum - limit : limit - sum, 1e-9) << c.rule;
    }
    for (const VectorXd& u : spread_points(constraints, all, 8, {}))
      EXPECT_TRUE(allowed(constraints, all, u));
  }
  EXPECT_GT(seen, 100);
  const std::vector<Parameter> one = {parameter("a", 0, 1, false)};
  for (const char* bad : {"", "a", "a <", "a <= ", "<= a", "b <= 1", "a <= 1 2", "1 <= 2",
                          "a - a <= 0", "a <= 1e999", "a == 1", "2 a a <= 1", "a <= 1; b"})
    EXPECT_THROW(parse_constraint(bad, one), InputError) << bad;
}

// Two responses that cross at mu1 = 0.06, mu2 = 0.15.
JobResult crossing(const FakeExperiment::Values& v, std::mt19937_64& random) {
  const double x = v.at("a.mu1") / 0.06, y = v.at("a.mu2") / 0.15;
  return finished(
      {scalar("aor", 10 * std::pow(x, 0.5) * std::pow(y, 0.2) + 0.4 * normal_deviate(random),
              "deg"),
       scalar("rate", 40 * std::pow(x, -0.2) * std::pow(y, -0.4) + 0.8 * normal_deviate(random),
              "g/s")});
}
const std::string rate_target =
    "[[targets]]\nresponse = \"rate\"\nvalue = \"40 g/s\"\nuncertainty = \"1 g/s\"\n";

TEST(StudyWithConstraints, KeepsThemInDesignPosteriorAndAnswer) {
  const Folder folder("constraints");
  FakeExperiment experiment(crossing);
  int runs = 0;
  experiment.on_run = [&](const Job& job) {
    double mu1 = 0, mu2 = 0;
    for (const auto& [key, value] : job.overrides) {
      if (key == "a.mu1") mu1 = std::stod(value);
      if (key == "a.mu2") mu2 = std::stod(value);
    }
    EXPECT_GE(mu1, 0.5 * mu2 - 1e-12);
    ++runs;
  };
  // The targets want mu1 = 0.4 mu2: the answer is on the border.
  const StudySummary s = run_study(
      folder.write("study.toml", friction_study(angle_target + rate_target +
                                                "[[constraints]]\nrule = \"mu1 >= 0.5 mu2\"\n")),
      folder / "out", experiment);
  EXPECT_GT(runs, 20);
  const json j = json::parse(s.json);
  const json values = j["estimate"]["parameters"];
  EXPECT_GE(values["mu1"].get<double>(), 0.5 * values["mu2"].get<double>() - 1e-12);
  EXPECT_LT(values["mu1"].get<double>(), 0.65 * values["mu2"].get<double>()) << s.table;
  EXPECT_EQ(j["constraints"][0], "mu1 >= 0.5 mu2");
  const std::vector<CsvRow> samples = read_csv_table(folder / "out/posterior.csv");
  ASSERT_GT(samples.size(), 1000u);
  for (std::size_t i = 1; i < samples.size(); ++i)
    ASSERT_GE(std::stod(samples[i].fields[0]), 0.5 * std::stod(samples[i].fields[1]) * (1 - 1e-9));
}

TEST(StudyWithPriors, AnotherStudysPosteriorStandsForItsTarget) {
  const Folder folder("prior-study");
  FakeExperiment experiment(crossing);
  const auto answer = [&](const std::string& name, const std::string& more) {
    const StudySummary s =
        run_study(folder.write(name + ".toml", friction_study(more)), folder / name, experiment);
    return json::parse(s.json);
  };
  answer("angle", angle_target);
  const json chained = answer("chained", rate_target + "[[priors]]\nstudy = \"angle\"\n");
  const json both = answer("both", angle_target + rate_target);
  const json alone = answer("alone", rate_target);
  EXPECT_THAT(chained["priors"][0]["prior"].get<std::string>(),
              HasSubstr("posterior of the study"));
  for (std::size_t i = 0; i < 2; ++i) {
    const auto width = [&](const json& j) {
      return std::log(j["parameters"][i]["interval_95"][1].get<double>() /
                      j["parameters"][i]["interval_95"][0].get<double>());
    };
    EXPECT_LT(width(chained), 0.7 * width(alone)) << i;
    EXPECT_NEAR(width(chained) / width(both), 1, 0.4) << i;
    const double truth = i == 0 ? 0.06 : 0.15;
    EXPECT_LT(chained["parameters"][i]["interval_95"][0].get<double>(), truth);
    EXPECT_GT(chained["parameters"][i]["interval_95"][1].get<double>(), truth);
  }
}

TEST(StudyWithPriors, AMaterialRecordAndStatedKindsNarrowTheAnswer) {
  const Folder folder("prior-record");
  MaterialRecord record;
  record.name = "my-pair";
  record.title = "for a test";
  record.materials = {"ice", "steel"};
  record.kind = RecordKind::assumed;
  record.parameters = {
      {"friction", {"interactions.ice-steel.static_friction"}, 0.06, "1", 0.006, {}, ""}};
  record.scope = {{"temperature", "any"}};
  record.provenance.author = "test";
  record.provenance.date = "2026-11-21";
  record.provenance.source = "test";
  const std::string file = folder / "materials.db";
  MaterialDatabase(file, MaterialDatabase::Access::write).add({record});
  const std::string wanted = "interactions.ice-steel.static_friction";
  const std::string text = replaced(
      friction_study(angle_target + "[[priors]]\nmaterial = \"my-pair\"\n"), "a.mu1", wanted);
  FakeExperiment experiment([&](const FakeExperiment::Values& v, std::mt19937_64& random) {
    FakeExperiment::Values renamed = v;
    renamed["a.mu1"] = v.contains(wanted) ? v.at(wanted) : v.at("a.mu1");
    return crossing(renamed, random);
  });
  const json from_record = [&] {
    const test::EnvironmentVariable database("FIRN_MATERIALS", file);
    return json::parse(run_study(folder.write("r.toml", text), folder / "r", experiment).json);
  }();
  const json stated = json::parse(
      run_study(
          folder.write("s.toml",
                       friction_study(angle_target +
                                      "[[priors]]\nparameter = \"mu1\"\nkind = "
                                      "\"log-normal\"\nmedian = 0.06\nfactor = 1.1\n"
                                      "[[priors]]\nparameter = \"mu2\"\nkind = \"uniform\"\n")),
          folder / "s", experiment)
          .json);
  // 0.06 ± 10 %, and the angle determines the other friction: within 10 % / 0.2 * 0.5 and 5 % /
  // 0.2.
  for (const json& j : {from_record, stated}) {
    const auto end = [&](std::size_t i, std::size_t k) {
      return j["parameters"][i]["interval_95"][k].get<double>();
    };
    EXPECT_NEAR(end(0, 0), 0.06 / 1.2, 0.004);
    EXPECT_NEAR(end(0, 1), 0.06 * 1.2, 0.004);
    EXPECT_LT(end(1, 0), 0.15);
    EXPECT_GT(end(1, 1), 0.15);
  }
}

TEST(StudyWithIntegers, RunsWholeNumbers) {
  const Folder folder("integers");
  FakeExperiment experiment([](const FakeExperiment::Values& v, std::mt19937_64& random) {
    const double layers = v.at("a.mu1");
    EXPECT_EQ(layers, std::round(layers));
    return finished({scalar("aor", 2 * layers + 0.1 * normal_deviate(random), "deg"),
                     scalar("rate", 100 * v.at("a.mu2") + 0.5 * normal_deviate(random), "g/s")});
  });
  const std::string text = replaced(
      friction_study(angle_target + "[[targets]]\nresponse = \"rate\"\nvalue = \"20 g/s\"\n"
                                    "uncertainty = \"1 g/s\"\n"),
      "min = 0.01\nmax = 0.3\nscale = \"log\"\n", "min = 1\nmax = 12\ninteger = true\n");
  const json j =
      json::parse(run_study(folder.write("study.toml", text), folder / "out", experiment).json);
  EXPECT_EQ(j["estimate"]["parameters"]["mu1"], 5.0);
  EXPECT_NEAR(j["estimate"]["parameters"]["mu2"].get<double>(), 0.2, 0.02);
}

TEST(StudyWithPriors, MistakesHaveAPlace) {
  const Folder folder("prior-mistakes");
  const auto message = [&](const std::string& more) {
    return folder.study_error(friction_study(angle_target + more));
  };
  const std::string prior = "[[priors]]\nparameter = \"mu1\"\n";
  EXPECT_EQ(message(prior + "kind = \"normal\"\nmean = 0.1\nsd = 0.02\n"), "no complaint");
  for (const auto& [text, words] : std::vector<std::pair<std::string, std::string>>{
           {"[[priors]]\nparameter = \"x\"\nkind = \"normal\"\nmean = 1\nsd = 1\n",
            "is not a parameter"},
           {prior + "kind = \"gamma\"\n", "kind"},
           {prior + "kind = \"normal\"\nmean = \"1 mm\"\nsd = 1\n", "mean: has the unit"},
           {prior + "kind = \"normal\"\nmean = 1\nsd = 0\n", "sd: is 0"},
           {prior + "kind = \"log-normal\"\nmedian = 1\nfactor = 1\n", "factor: is 1"},
           {prior + "kind = \"beta\"\nalpha = 1\nbeta = 2\n", "alpha: is 1"},
           {prior + "kind = \"uniform\"\nmean = 1\n", "mean"},
           {"[[priors]]\nstudy = \"nowhere\"\n", "posterior.csv"},
           {"[[priors]]\nmaterial = \"nothing-of-that-name\"\n", "nothing-of-that-name"},
           {"[[constraints]]\nrule = \"mu1 <= mu3\"\n", "\"mu3\" is not a parameter"},
           {"[[constraints]]\nrule = \"mu1 >= 2 mu2 + 1\"\n", "leave 0 % of the ranges"}}) {
    const std::string m = message(text);
    EXPECT_THAT(m, HasSubstr(words)) << text;
    EXPECT_THAT(m, HasSubstr("study.toml:")) << text;
  }
  folder.write("posterior.csv", "x,weight,log_density\n1,1,0\n");
  EXPECT_THAT(message("[[priors]]\nstudy = \".\"\n"), HasSubstr("has no column for a parameter"));
}

}  // namespace
}  // namespace firn
