// The files and comparisons that are made from a finished study.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "calibrate/numerics/sobol_indices.h"
#include "calibrate/output/study_comparison.h"
#include "experiments/storage/hdf5_file.h"
#include "experiments/system/process.h"
#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// Two responses that cross at mu1 = 0.06 * shift, mu2 = 0.15.
FakeExperiment crossing(double shift = 1) {
  return FakeExperiment([shift](const FakeExperiment::Values& v, std::mt19937_64& random) {
    const double x = v.at("a.mu1") / (0.06 * shift), y = v.at("a.mu2") / 0.15;
    return finished(
        {scalar("aor", 10 * std::pow(x, 0.5) * std::pow(y, 0.2) + 0.3 * normal_deviate(random),
                "deg"),
         scalar("rate", 40 * std::pow(x, -0.2) * std::pow(y, -0.4) + 0.8 * normal_deviate(random),
                "g/s")});
  });
}

const std::string targets =
    "[[targets]]\nresponse = \"aor\"\nvalue = \"10 deg\"\nuncertainty = \"0.5 deg\"\n"
    "[[targets]]\nresponse = \"rate\"\nvalue = \"40 g/s\"\nuncertainty = \"1 g/s\"\n";

class FinishedStudies : public testing::Test {
 protected:
  std::string study(const std::string& name, double shift = 1) {
    FakeExperiment experiment = crossing(shift);
    run_study(folder.write(name + ".toml", friction_study(targets)), folder / name, experiment);
    return folder / name;
  }
  Folder folder{"finished"};
};

TEST_F(FinishedStudies, HaveAnInferenceDataFile) {
  const std::string directory = study("one");
  const std::string path = directory + "/posterior.nc";
  const json results = json::parse(read_text(directory + "/results.json"));
  const hdf5::File file = hdf5::File::open(path, hdf5::File::Access::read);
  const hdf5::Shape shape = {1, 4096};
  EXPECT_EQ(file.shape("/posterior/mu1"), shape);
  EXPECT_EQ(file.shape("/sample_stats/lp"), shape);
  EXPECT_EQ(file.shape("/posterior_predictive/aor"), (hdf5::Shape{1, 4096, 1}));
  EXPECT_EQ(file.read<double>("/observed_data/rate"), std::vector<double>{40});
  // The draws have the quantiles of the report.
  for (std::size_t i = 0; i < 2; ++i) {
    const json& p = results["parameters"][i];
    std::vector<double> draws = file.read<double>("/posterior/" + p["name"].get<std::string>());
    std::ranges::sort(draws);
    EXPECT_NEAR(draws[2048] / p["median"].get<double>(), 1, 0.02);
    EXPECT_NEAR(draws[102] / p["interval_95"][0].get<double>(), 1, 0.05);
    EXPECT_NEAR(draws[3993] / p["interval_95"][1].get<double>(), 1, 0.05);
  }
  // Replicates of a target that is met scatter around it by the measurement and more.
  const std::vector<double> replicates = file.read<double>("/posterior_predictive/aor");
  double mean = 0, square = 0;
  for (const double y : replicates) mean += y / 4096;
  for (const double y : replicates) square += (y - mean) * (y - mean) / 4096;
  EXPECT_NEAR(mean, 10, 0.3);
  EXPECT_GT(std::sqrt(square), 0.5);
  EXPECT_LT(std::sqrt(square), 1.2);
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
}

TEST_F(FinishedStudies, PredictTheTargetsAlikeInBothFiles) {
  const std::string directory = study("one");
  const json results = json::parse(read_text(directory + "/results.json"));
  const hdf5::File file = hdf5::File::open(directory + "/posterior.nc", hdf5::File::Access::read);
  for (const json& target : results["targets"])
    for (const auto& [key, suffix] :
         {std::pair("mean_response", "_mean"), std::pair("single_run", "_run")}) {
      std::vector<double> draws = file.read<double>("/posterior_predictive/" +
                                                    target["response"].get<std::string>() + suffix);
      ASSERT_EQ(draws.size(), 4096u);
      std::ranges::sort(draws);
      const std::vector<double> q = target["posterior_predictive"][key]["quantiles"];
      const double sd = (q[3] - q[1]) / 2;
      EXPECT_NEAR(draws[102], q[0], 0.15 * sd) << key;
      EXPECT_NEAR(draws[655], q[1], 0.1 * sd) << key;
      EXPECT_NEAR(draws[2048], q[2], 0.1 * sd) << key;
      EXPECT_NEAR(draws[3440], q[3], 0.1 * sd) << key;
      EXPECT_NEAR(draws[3993], q[4], 0.15 * sd) << key;
    }
}

// A variable that is added for one target must not take the name of another.
TEST_F(FinishedStudies, OfTargetsNamedLikeVariablesHaveAnInferenceDataFile) {
  FakeExperiment experiment([](const FakeExperiment::Values& v, std::mt19937_64& random) {
    const double y = 10 * std::pow(v.at("a.mu1") / 0.06, 0.5) + 0.3 * normal_deviate(random);
    return finished({scalar("aor", y, "deg"), scalar("aor_mean", 2 * y, "deg")});
  });
  run_study(folder.write("names.toml",
                         friction_study("[[targets]]\nresponse = \"aor\"\nvalue = \"10 deg\"\n"
                                        "uncertainty = \"0.5 deg\"\n[[targets]]\nresponse = "
                                        "\"aor_mean\"\nvalue = \"20 deg\"\nuncertainty = "
                                        "\"1 deg\"\n")),
            folder / "names", experiment);
  const hdf5::File file = hdf5::File::open(folder / "names/posterior.nc", hdf5::File::Access::read);
  EXPECT_EQ(file.shape("/posterior_predictive/aor_mean"), (hdf5::Shape{1, 4096, 1}));
  for (const char* added : {"aor_mean_", "aor_run", "aor_mean_mean", "aor_mean_run"})
    EXPECT_EQ(file.shape(std::string("/posterior_predictive/") + added), (hdf5::Shape{1, 4096}));
}

TEST_F(FinishedStudies, NetcdfProgramsReadTheFile) {
  if (run_command({"ncdump", "-v"}).status == 127) GTEST_SKIP() << "netcdf-bin is not installed";
  const CommandResult header = run_command({"ncdump", "-h", study("one") + "/posterior.nc"});
  ASSERT_EQ(header.status, 0) << header.err;
  for (const char* words :
       {"group: posterior {", "chain = 1 ;", "draw = 4096 ;", "double mu1(chain, draw) ;",
        "group: sample_stats {", "double lp(chain, draw) ;", "group: observed_data {",
        "double aor(aor_dim_0) ;", "aor:units = \"deg\"", "group: posterior_predictive {",
        "double rate(chain, draw, rate_dim_0) ;"})
    EXPECT_THAT(header.out, HasSubstr(words));
}

TEST_F(FinishedStudies, AreCompared) {
  const std::string one = study("one"), again = study("again"), other = study("other", 2);
  const StudyComparison same = compare_studies(one, again);
  ASSERT_EQ(same.parameters.size(), 2u);
  for (const ParameterComparison& p : same.parameters) {
    EXPECT_NEAR(p.overlap, 1, 1e-9);
    EXPECT_NEAR(p.a_above_b, 0.5, 0.01);
  }
  EXPECT_NEAR(same.chi_square, 0, 1e-9);
  EXPECT_NEAR(same.probability, 1, 1e-9);
  const StudyComparison apart = compare_studies(one, other);
  EXPECT_LT(apart.parameters[0].overlap, 0.1);
  EXPECT_LT(apart.parameters[0].a_above_b, 0.01);
  EXPECT_GT(apart.parameters[1].overlap, 0.5);
  EXPECT_LT(apart.probability, 0.01);
  const StudyComparison swapped = compare_studies(other, one);
  EXPECT_NEAR(swapped.parameters[0].a_above_b, 1 - apart.parameters[0].a_above_b, 1e-9);
  EXPECT_NEAR(swapped.chi_square, apart.chi_square, 1e-9 * apart.chi_square);
  EXPECT_THAT(comparison_table(apart), HasSubstr("mu1"));
  const json j = json::parse(comparison_json(apart));
  EXPECT_EQ(j["parameters"][0]["overlap"].get<double>(), apart.parameters[0].overlap);
  EXPECT_THROW(compare_studies(one, folder / "nowhere"), InputError);
}

// g function of Sobol: its indices are known.
TEST(SobolIndices, IntervalsHoldTheTrueIndices) {
  const std::vector<double> a = {0, 1, 4.5, 9};
  const auto g = [&](const Eigen::VectorXd& u) {
    double product = 1;
    for (std::size_t i = 0; i < a.size(); ++i)
      product *= (std::abs(4 * u[static_cast<Eigen::Index>(i)] - 2) + a[i]) / (1 + a[i]);
    return product;
  };
  double all = 1;
  std::vector<double> parts;
  for (const double x : a) {
    parts.push_back(1 / (3 * (1 + x) * (1 + x)));
    all *= 1 + parts.back();
  }
  const SobolIndices s = sobol_indices(g, 4, 4096);
  for (Eigen::Index i = 0; i < 4; ++i) {
    const double part = parts[static_cast<std::size_t>(i)];
    EXPECT_LE(s.first_interval(i, 0), part / (all - 1));
    EXPECT_GE(s.first_interval(i, 1), part / (all - 1));
    const double total = part * all / (1 + part) / (all - 1);
    EXPECT_LE(s.total_interval(i, 0), total);
    EXPECT_GE(s.total_interval(i, 1), total);
    EXPECT_LT(s.total_interval(i, 1) - s.total_interval(i, 0), 0.1);
  }
}

}  // namespace
}  // namespace firn
