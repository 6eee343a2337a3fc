// Searches of formulas whose best design is known.
#include "calibrate/optimization/optimize_design.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/optimization/optimization_document.h"
#include "tests/support/error_of.h"
#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

using testing::HasSubstr;
using Values = FakeExperiment::Values;

std::string file_text(const std::string& goal, const std::string& more,
                      const std::string& head = "") {
  return "[optimization]\nname = \"fake\"\ncase = \"case.toml\"\n" + goal + "\n" + head +
         "\n[[parameters]]\nname = \"pitch\"\nkeys = [\"auger.pitch\"]\nmin = 20\nmax = 40\n"
         "[[parameters]]\nname = \"width\"\nkeys = [\"outlet.width\"]\nmin = 50\nmax = 100\n" +
         more;
}

const std::string jam_limit = "[[limits]]\nresponse = \"jammed\"\nabove = 0.5\nprobability = 0.1\n";

double uniform(std::mt19937_64& random) {
  return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53;
}

// Largest at a pitch of 32 and a width of 70.
double rate(const Values& v) {
  const double a = (v.at("auger.pitch") - 32) / 20, b = (v.at("outlet.width") - 70) / 50;
  return 100 - 80 * a * a - 120 * b * b;
}

// Jams with a probability of 10 % at a pitch of 30, whatever the width, and of 50 % at 34.
double jam_probability(const Values& v) {
  return 1 / (1 + std::exp(-(v.at("auger.pitch") - 34) * std::log(9.0) / 4));
}

JobResult dispensing(const Values& v, std::mt19937_64& random) {
  const double jammed = uniform(random) < jam_probability(v) ? 1 : 0;
  return finished(
      {scalar("rate", rate(v) + 4 * normal_deviate(random), "g/s"), scalar("jammed", jammed, "1")});
}

OptimizationResult search(const std::string& text, Executor& executor, const Folder& folder,
                          const std::string& out = "out") {
  OptimizationOptions options;
  options.file = folder.write("optimization.toml", text);
  options.directory = folder / out;
  options.show_progress = false;
  options.replace_executor = &executor;
  return optimize_design(options);
}

class OptimizeDesign : public testing::TestWithParam<int> {
 protected:
  std::string seed() const { return "seed = " + std::to_string(100 * GetParam()) + "\n"; }
  Folder folder{"optimize-" + std::to_string(GetParam())};
  FakeExperiment experiment{dispensing};
};

TEST_P(OptimizeDesign, FindsTheLargestMean) {
  const OptimizationResult r =
      search(file_text("maximize = \"rate\"", "", "runs = 70\n" + seed()), experiment, folder);
  EXPECT_EQ(r.verdict, OptimizationVerdict::recommended) << render_table(r);
  ASSERT_TRUE(r.best);
  // Noise of 4 / sqrt(3) on 20 designs; a loss of 3 is one standard error of a design's mean.
  EXPECT_GT(rate({{"auger.pitch", r.best->values[0]}, {"outlet.width", r.best->values[1]}}), 97)
      << render_table(r);
  EXPECT_EQ(experiment.runs, 70);
  EXPECT_EQ(r.runs, 70);
}

// The same search when goal and sign of the response are both turned around.
TEST_P(OptimizeDesign, MinimizingTheNegativeIsTheSame) {
  const OptimizationResult up =
      search(file_text("maximize = \"rate\"", "", "runs = 40\n" + seed()), experiment, folder);
  FakeExperiment negative([](const Values& v, std::mt19937_64& random) {
    JobResult result = dispensing(v, random);
    result.responses[0].value[0] *= -1;
    return result;
  });
  const OptimizationResult down = search(
      file_text("minimize = \"rate\"", "", "runs = 40\n" + seed()), negative, folder, "down");
  ASSERT_TRUE(up.best && down.best);
  // Not to the last digit: a model of the logarithm is tried for positive responses only.
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_NEAR(
        up.best->values[i], down.best->values[i],
        0.15 * (up.optimization.study.parameters[i].max - up.optimization.study.parameters[i].min));
}

// The best design within the limit has a pitch of 30. One that jams as often as the limit allows
// is held to be recommended with a probability of one tenth: 0.2 is four times the odds of it.
TEST_P(OptimizeDesign, KeepsTheLimitOfAnEvent) {
  const std::string compared =
      "[[compare]]\nname = \"unlimited\"\nvalues = { pitch = 32, width = 70 }\n";
  const OptimizationResult r =
      search(file_text("maximize = \"rate\"", jam_limit + compared, "runs = 200\n" + seed()),
             experiment, folder);
  ASSERT_TRUE(r.best);
  EXPECT_LT(jam_probability({{"auger.pitch", r.best->values[0]}}), 0.2) << render_table(r);
  EXPECT_GT(rate({{"auger.pitch", r.best->values[0]}, {"outlet.width", r.best->values[1]}}), 75)
      << render_table(r);
  ASSERT_EQ(r.gains.size(), 1U);
  EXPECT_LT(r.gains[0].low, r.gains[0].mean);
  EXPECT_EQ(r.compared[0].name, "unlimited");
}

INSTANTIATE_TEST_SUITE_P(Seeds, OptimizeDesign, testing::Range(1, 4));

TEST(OptimizeDesignVerdict, NothingKeepsALimitThatIsAlwaysMissed) {
  const Folder folder("always-jams");
  FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
    return finished(
        {scalar("rate", rate(v), "g/s"), scalar("jammed", uniform(random) < 0.8 ? 1 : 0, "1")});
  });
  const OptimizationResult r =
      search(file_text("maximize = \"rate\"", jam_limit, "runs = 60\n"), experiment, folder);
  EXPECT_EQ(r.verdict, OptimizationVerdict::none_feasible) << render_table(r);
  EXPECT_THAT(r.headline, HasSubstr("no design within the ranges is likely to keep the limits"));
}

TEST(OptimizeDesignVerdict, RunsWithoutValuesEndIt) {
  const Folder folder("no-values");
  FakeExperiment experiment([](const Values&, std::mt19937_64&) {
    return JobResult{JobStatus::failed, "broken", {}, 1.0};
  });
  const OptimizationResult r =
      search(file_text("maximize = \"rate\"", "", "runs = 40\n"), experiment, folder);
  EXPECT_EQ(r.verdict, OptimizationVerdict::too_few_runs);
  EXPECT_EQ(r.not_finished, r.runs);
  EXPECT_FALSE(r.best);
}

// Stopped after any number of runs, the same command ends with the same result.
TEST(OptimizeDesignResume, GivesTheSameResult) {
  const std::string text = file_text("maximize = \"rate\"", jam_limit, "runs = 50\n");
  const Folder whole("whole");
  FakeExperiment experiment(dispensing);
  const std::string expected = render_json(search(text, experiment, whole));
  for (const int ended : {1, 12, 25, 41}) {
    const Folder folder("stopped-" + std::to_string(ended));
    FakeExperiment stopped(dispensing);
    std::atomic<bool> interrupt = false;
    stopped.on_ended = [&](const Job&) {
      if (stopped.runs == ended) interrupt = stopped.stop = true;
    };
    OptimizationOptions options;
    options.file = folder.write("optimization.toml", text);
    options.directory = folder / "out";
    options.show_progress = false;
    options.replace_executor = &stopped;
    options.interrupt = &interrupt;
    EXPECT_EQ(optimize_design(options).verdict, OptimizationVerdict::interrupted);
    FakeExperiment rest(dispensing);
    const OptimizationResult resumed = search(text, rest, folder);
    EXPECT_EQ(stopped.runs + rest.runs, experiment.runs);
    const auto without_folder = [](std::string json, const Folder& of) {
      const std::string path = of.path().string();
      for (std::size_t at; (at = json.find(path)) != std::string::npos;)
        json.erase(at, path.size());
      return json;
    };
    EXPECT_EQ(without_folder(render_json(resumed), folder), without_folder(expected, whole));
  }
}

// 30 more runs, and a confirmation of another best design: 40 at most.
TEST(OptimizeDesignResume, MoreRunsContinueTheSearch) {
  const Folder folder("more");
  FakeExperiment experiment(dispensing);
  OptimizationOptions options;
  options.show_progress = false;
  options.replace_executor = &experiment;
  options.store = folder / "store.db";
  const auto with_runs = [&](const char* runs) {
    options.file = folder.write("optimization.toml", file_text("maximize = \"rate\"", "", runs));
    options.directory = folder / runs;
    return optimize_design(options);
  };
  with_runs("runs = 49\n");
  EXPECT_EQ(experiment.runs, 49);
  const OptimizationResult more = with_runs("runs = 79\n");
  EXPECT_EQ(more.runs, 79);
  EXPECT_LE(experiment.runs, 49 + 40);
}

TEST(OptimizeDesignDocument, IsReadAsItIsWritten) {
  const Folder folder("document");
  FakeExperiment experiment(dispensing);
  const OptimizationResult r = search(
      file_text("maximize = \"rate\"", jam_limit, "runs = 50\nconfirmation_replicates = 8\n"),
      experiment, folder);
  const OptimizationDocument d =
      read_optimization_document(read_results_json(folder / "out/results.json"));
  EXPECT_EQ(d.verdict, to_string(r.verdict));
  EXPECT_EQ(d.objective, "rate");
  EXPECT_EQ(d.unit, "g/s");
  EXPECT_EQ(d.designs.size(), r.designs.size());
  ASSERT_TRUE(d.best && d.prediction);
  EXPECT_EQ(d.best->runs, 8);
  EXPECT_DOUBLE_EQ(d.best->mean, r.best->objective.mean);
  EXPECT_LT(d.prediction->interval_95.first, d.best->mean);
  ASSERT_EQ(d.slices.size(), 2U);
  EXPECT_EQ(d.slices[1].parameter, "width");
}

// Its runs are not counted twice, for the number of runs nor in the models.
TEST(OptimizeDesignDocument, TheSameDesignComparedTwiceIsOneDesign) {
  const std::string once = "[[compare]]\nname = \"old\"\nvalues = { pitch = 22, width = 60 }\n",
                    twice = once +
                            "[[compare]]\nname = \"same\"\nvalues = { pitch = 22, width = 60 }\n";
  const Folder folder("twice");
  FakeExperiment experiment(dispensing);
  const auto with = [&](const std::string& compared, const char* head, const char* out) {
    return search(file_text("maximize = \"rate\"", jam_limit + compared, head), experiment, folder,
                  out);
  };
  const OptimizationResult one = with(once, "runs = 50\n", "once"),
                           two = with(twice, "runs = 60\n", "twice");
  EXPECT_EQ(one.designs.size(), two.designs.size());
  EXPECT_EQ(one.runs, two.runs);
  ASSERT_TRUE(one.best && two.best);
  EXPECT_EQ(one.best->predicted->mean, two.best->predicted->mean);
  EXPECT_EQ(one.best->predicted->kept, two.best->predicted->kept);
  EXPECT_EQ(two.compared[0].objective.mean, two.compared[1].objective.mean);
}

struct Fault {
  const char *goal, *more, *head, *message;
};

class OptimizationFile : public testing::TestWithParam<Fault> {};

TEST_P(OptimizationFile, NamesTheFault) {
  const Folder folder("faults");
  const std::string file =
      folder.write("faulty.toml", file_text(GetParam().goal, GetParam().more, GetParam().head));
  const std::string message = test::error_of([&] { read_optimization(file); });
  EXPECT_THAT(message, HasSubstr(GetParam().message));
  EXPECT_THAT(message, HasSubstr("faulty.toml:"));
  EXPECT_THAT(message, HasSubstr("expected"));
}

INSTANTIATE_TEST_SUITE_P(
    Faults, OptimizationFile,
    testing::Values(
        Fault{"", "", "runs = 60\n", "maximize: is missing"},
        Fault{"maximize = \"a\"\nminimize = \"b\"", "", "runs = 60\n", "together with minimize"},
        Fault{"maximize = \"a\"", "", "", "runs: missing"},
        Fault{"maximize = \"a\"", "", "runs = 12\n", "runs: 12 are too few"},
        Fault{"maximize = \"a\"", "", "runs = 60\nmaterial = \"ice#2\"\n", "names one draw"},
        Fault{"maximize = \"a\"", "", "runs = 60\nconfidence = 1.5\n", "above 0 and below 1"},
        Fault{"maximize = \"a\"", "", "runs = 60\nreplicates_per_design = 1\n",
              "replicates_per_design"},
        Fault{"maximize = \"a\"", "[[limits]]\nresponse = \"jammed\"\nprobability = 0.1\n",
              "runs = 60\n", "above: is missing"},
        Fault{"maximize = \"a\"",
              "[[limits]]\nresponse = \"jammed\"\nabove = 1\nbelow = 2\nprobability = 0.1\n",
              "runs = 60\n", "together with below"},
        Fault{"maximize = \"a\"", "[[limits]]\nresponse = \"jammed\"\nabove = 1\nprobability = 0\n",
              "runs = 60\n", "above 0 and below 1"},
        Fault{"maximize = \"a\"",
              "[[limits]]\nresponse = \"load\"\nabove = \"1 N\"\nprobability = 0.1\n"
              "[[limits]]\nresponse = \"load\"\nbelow = \"1 kN\"\nprobability = 0.1\n",
              "runs = 60\n", "expected one unit"},
        Fault{"maximize = \"a\"", "[[compare]]\nname = \"old\"\nvalues = { pitch = 30 }\n",
              "runs = 60\n", "width"}));

TEST(OptimizationFile, TakesNoPriors) {
  const Folder folder("priors");
  const std::string file = folder.write(
      "priors.toml", file_text("maximize = \"a\"",
                               "[[parameters]]\nname = \"x\"\nkeys = [\"x\"]\nmin = 0\nmax = 1\n"
                               "prior_mean = 0.5\nprior_sd = 0.1\n",
                               "runs = 60\n"));
  EXPECT_THROW(read_optimization(file), InputError);
}

// The posterior of two coefficients by quadrature.
TEST(EventProbability, AgreesWithQuadrature) {
  std::mt19937_64 random(7);
  for (int member = 0; member < 8; ++member) {
    const double middle = 3 * normal_deviate(random), slope = 2 * normal_deviate(random);
    std::vector<EventCount> counts;
    for (int i = 0; i < 12; ++i) {
      EventCount& c = counts.emplace_back();
      c.u = Eigen::VectorXd::Constant(1, uniform(random));
      c.runs = 6;
      for (int run = 0; run < c.runs; ++run)
        c.events += uniform(random) < 1 / (1 + std::exp(-middle - slope * (c.u[0] - 0.5))) ? 1 : 0;
    }
    const EventProbability model(counts, 1);
    for (const double at : {0.0, 0.3, 1.0}) {
      double weight = 0, mean = 0, below = 0;
      const double limit = 0.1;
      for (double b0 = -15; b0 <= 15; b0 += 0.1)
        for (double b1 = -25; b1 <= 25; b1 += 0.1) {
          double log_density = -0.5 * (b0 * b0 / 9 + b1 * b1 / 25);
          for (const EventCount& c : counts) {
            const double x = b0 + b1 * (c.u[0] - 0.5);
            log_density += c.events * x - c.runs * std::log1p(std::exp(x));
          }
          const double w = std::exp(log_density), p = 1 / (1 + std::exp(-b0 - b1 * (at - 0.5)));
          weight += w;
          mean += w * p;
          below += p <= limit ? w : 0;
        }
      const Eigen::VectorXd u = Eigen::VectorXd::Constant(1, at);
      const auto predicted = model.predict(u, limit);
      EXPECT_NEAR(predicted.mean, mean / weight, 0.01) << member << " " << at;
      EXPECT_NEAR(predicted.at_most, below / weight, 0.03) << member << " " << at;
    }
  }
}

}  // namespace
}  // namespace firn
