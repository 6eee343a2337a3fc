// Studies of a parameter with choices: which choice is the truth, and how sure a study is of it.
#include "calibrate/choices.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "experiments/analysis/random_stream.h"
#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

using Eigen::VectorXd;
using nlohmann::json;
using testing::HasSubstr;
using Values = FakeExperiment::Values;

const std::string numbers_of_runs =
    "center_replicates = 3\ndesign_points = 7\nreplicates_per_point = 2\n"
    "confirmation_replicates = 3\n";

// One parameter a on [0, 1] and a law; the targets x and z.
std::string law_study(const std::string& choices, double x, double z, double uncertainty = 0.3,
                      const std::string& budget = numbers_of_runs) {
  return fmt::format(
      "[study]\nname = \"fake\"\ncase = \"case.toml\"\n[budget]\n{}"
      "[[parameters]]\nname = \"law\"\nkeys = [\"law\"]\n{}"
      "[[parameters]]\nname = \"a\"\nkeys = [\"a\"]\nmin = 0\nmax = 1\n"
      "[[targets]]\nresponse = \"x\"\nvalue = {}\nuncertainty = {}\n"
      "[[targets]]\nresponse = \"z\"\nvalue = {}\nuncertainty = {}\n",
      budget, choices, x, uncertainty, z, uncertainty);
}

// z grows with a by the first law and falls by the second.
JobResult two_laws(const Values& v, std::mt19937_64& random) {
  const double a = v.at("a"), sign = v.at("law") == 1 ? 1 : -1;
  return finished({scalar("x", 10 + 8 * a + 0.2 * normal_deviate(random), "1"),
                   scalar("z", 5 + 4 * sign * a + 0.2 * normal_deviate(random), "1")});
}

// The law makes no difference.
JobResult one_law(const Values& v, std::mt19937_64& random) {
  return finished({scalar("x", 10 + 8 * v.at("a") + 0.2 * normal_deviate(random), "1"),
                   scalar("z", 5 + 4 * v.at("a") + 0.2 * normal_deviate(random), "1")});
}

struct LawOutcome {
  StudySummary summary;
  json j;
  double probability(std::size_t i) const { return j["choice"]["choices"][i]["probability"]; }
};
LawOutcome carry_out_law_study(const std::string& text, const FakeExperiment::Formula& formula) {
  const Folder folder("law");
  FakeExperiment experiment(formula);
  LawOutcome o;
  o.summary = run_study(folder.write("study.toml", text), folder / "out", experiment);
  o.j = json::parse(o.summary.json);
  return o;
}

TEST(Choices, OneThatGivesOtherResponsesIsRecognized) {
  const Folder folder("law-two");
  std::map<double, int> runs;
  FakeExperiment experiment([&](const Values& v, std::mt19937_64& random) {
    ++runs[v.at("law")];
    return two_laws(v, random);
  });
  // The truth: the second law, a = 0.4.
  const std::string file = folder.write("study.toml", law_study("choices = [1, 2]\n", 13.2, 3.4));
  const StudySummary s = run_study(file, folder / "out", experiment);
  EXPECT_EQ(s.verdict, StudyVerdict::calibrated) << s.table;
  const json j = json::parse(s.json);
  const json& choice = j["choice"];
  EXPECT_EQ(choice["parameter"], "law");
  EXPECT_EQ(choice["best"], "2");
  EXPECT_GT(choice["choices"][1]["probability"], 0.999);
  EXPECT_LT(choice["choices"][0]["probability"], 0.001);
  EXPECT_EQ(choice["choices"][0]["verdict"], "infeasible");
  EXPECT_FALSE(choice["choices"][0]["goodness_of_fit"]["acceptable"].get<bool>());
  EXPECT_EQ(choice["choices"][1]["prior"], 0.5);
  // The parameters given the choice.
  const json& a = choice["choices"][1]["parameters"]["a"];
  EXPECT_LT(a["interval_95"][0], 0.4);
  EXPECT_GT(a["interval_95"][1], 0.4);
  ASSERT_EQ(j["parameters"].size(), 1u);
  EXPECT_EQ(j["parameters"][0]["interval_95"], a["interval_95"]);
  EXPECT_THAT(s.headline, HasSubstr("law = 2 (probability 1): calibrated: a = 0."));
  EXPECT_THAT(s.table, HasSubstr("Choices of law"));
  EXPECT_THAT(s.table, HasSubstr("all that follows is for law = 2"));
  // Either gets as many runs; one point of the design is the middle.
  EXPECT_GE(runs.at(1), 3 + 6 * 2 + 3);
  EXPECT_GE(runs.at(2), 3 + 6 * 2 + 3);
  EXPECT_EQ(j["runs"]["total"], experiment.runs);
  const std::string csv = read_text(folder / "out/runs.csv");
  EXPECT_THAT(csv, HasSubstr(" law=1"));
  EXPECT_THAT(csv, HasSubstr(" law=2"));
  // The same command repeats no run and ends in the same answer.
  const int made = experiment.runs;
  json again = json::parse(run_study(file, folder / "out", experiment).json);
  EXPECT_EQ(experiment.runs, made);
  EXPECT_EQ(again, j);
}

TEST(Choices, ThoseThatDoNotDifferAreAsProbableAsBefore) {
  const LawOutcome even = carry_out_law_study(law_study("choices = [1, 2]\n", 13.2, 6.6), one_law);
  EXPECT_NEAR(even.probability(0), 0.5, 0.15) << even.summary.table;
  EXPECT_NEAR(even.probability(0) + even.probability(1), 1, 1e-12);
  EXPECT_EQ(even.summary.verdict, StudyVerdict::not_identifiable);
  EXPECT_THAT(even.summary.headline,
              HasSubstr("the targets do not determine law (probabilities: "));
  EXPECT_THAT(even.summary.headline, HasSubstr("; with "));
  EXPECT_NEAR(even.j["estimate"]["parameters"]["a"].get<double>(), 0.4, 0.05);
  const LawOutcome believed = carry_out_law_study(
      law_study("choices = [1, 2, 3]\nprior = [0.1, 0.8, 0.1]\n", 13.2, 6.6), one_law);
  EXPECT_NEAR(believed.probability(1), 0.8, 0.12) << believed.summary.table;
  EXPECT_EQ(believed.j["choice"]["best"], "2");
}

// The law is drawn, too; laws differ by little more than the measurements are uncertain.
TEST(Choices, AreTheTruthAsOftenAsTheirProbabilitySays) {
  constexpr int studies = 12;
  double surplus = 0, variance = 0, of_the_truth = 0;
  std::mt19937_64 random(3);
  const auto z = [](double law) { return law == 1 ? 5.0 : 5.8; };
  for (int s = 0; s < studies; ++s) {
    const double law = uniform_open(random) < 0.5 ? 1 : 2, a = 0.2 + 0.6 * uniform_open(random);
    const LawOutcome o = carry_out_law_study(
        law_study("choices = [1, 2]\n", 10 + 8 * a + 0.4 * normal_deviate(random),
                  z(law) + 0.4 * normal_deviate(random), 0.4),
        [&](const Values& v, std::mt19937_64& noise) {
          return finished({scalar("x", 10 + 8 * v.at("a") + 0.05 * normal_deviate(noise), "1"),
                           scalar("z", z(v.at("law")) + 0.05 * normal_deviate(noise), "1")});
        });
    const double first = o.probability(0);
    surplus += (law == 1) - first;
    variance += first * (1 - first);
    of_the_truth += law == 1 ? first : 1 - first;
  }
  RecordProperty("surplus_in_deviations", fmt::format("{:.2f}", surplus / std::sqrt(variance)));
  RecordProperty("of_the_truth", fmt::format("{:.2f}", of_the_truth / studies));
  EXPECT_LT(std::abs(surplus), 3 * std::sqrt(variance));
  EXPECT_GT(of_the_truth / studies, 0.6);
}

TEST(Choices, DivideABudgetOfRuns) {
  const Folder folder("law-budget");
  const Study s = read_study(
      folder.write("study.toml", law_study("choices = [1, 2]\n", 13, 3, 0.3, "runs = 50\n")));
  EXPECT_EQ(s.budget.runs, 25);
  EXPECT_EQ(s.largest_total(), 50);
  const auto parts = parts_of(s);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].largest_total(), 25);
  const LawOutcome o =
      carry_out_law_study(law_study("choices = [1, 2]\n", 13.2, 3.4, 0.3, "runs = 50\n"), two_laws);
  EXPECT_LE(o.j["runs"]["total"], 50);
  EXPECT_EQ(o.j["budget"]["runs"], 50);
  EXPECT_EQ(o.j["budget"]["left"].get<int>() + o.j["runs"]["total"].get<int>(), 50);
}

TEST(Choices, OneWithoutFinishedRunsIsNamed) {
  const LawOutcome o = carry_out_law_study(
      law_study("choices = [1, 2]\n", 13.2, 6.6), [](const Values& v, auto& random) {
        if (v.at("law") == 2) return JobResult{JobStatus::failed, "no such law", {}, 1};
        return two_laws(v, random);
      });
  EXPECT_EQ(o.summary.verdict, StudyVerdict::calibrated) << o.summary.table;
  EXPECT_TRUE(o.j["choice"]["choices"][1]["probability"].is_null());
  EXPECT_EQ(o.probability(0), 1);
  EXPECT_EQ(o.j["cautions"][0], "too few runs finished for law = 2");
  EXPECT_THAT(o.summary.headline, HasSubstr("too few runs finished for law = 2"));
}

TEST(Choices, RunsOfAnExperimentThatDoesNotTakeItAreMadeOnce) {
  std::string text = law_study("choices = [1, 2]\n", 13.2, 3.4);
  text.erase(text.find("case = \"case.toml\"\n"), 19);
  for (std::size_t at = 0; (at = text.find("response = \"x\"\n", at)) != text.npos; at += 40)
    text.insert(at, "experiment = \"tilt\"\n");
  text.insert(text.find("response = \"z\"\n"), "experiment = \"heap\"\n");
  text +=
      "[[experiments]]\nname = \"tilt\"\ncase = \"case.toml\"\nparameters = [\"a\"]\n"
      "[[experiments]]\nname = \"heap\"\ncase = \"case.toml\"\nparameters = [\"a\", \"law\"]\n"
      "set = { heap = 1 }\n";
  int tilts = 0, heaps = 0;
  const LawOutcome o = carry_out_law_study(text, [&](const Values& v, std::mt19937_64& random) {
    if (v.contains("heap")) {
      ++heaps;
      return two_laws(v, random);
    }
    ++tilts;
    EXPECT_FALSE(v.contains("law"));
    return finished({scalar("x", 10 + 8 * v.at("a") + 0.2 * normal_deviate(random), "1")});
  });
  EXPECT_EQ(o.j["choice"]["best"], "2") << o.summary.table;
  EXPECT_GE(heaps, 2 * (3 + 6 * 2 + 3));
  EXPECT_LE(tilts, 3 + 7 * 2 + 2 * (2 * 2 + 3));
}

TEST(Choices, TextsBecomeValuesOfTheCase) {
  const Folder folder("law-text");
  const Study s = read_study(folder.write(
      "study.toml", law_study("choices = [\"hertz\", \"two words\", 1.5, true]\n", 13, 3)));
  EXPECT_EQ(s.choice->labels, (std::vector<std::string>{"hertz", "two words", "1.5", "true"}));
  const auto parts = parts_of(s);
  EXPECT_EQ(parts[1].chosen_text(), "law=two words");
  const auto overrides = overrides_of(parts[1], parts[1].experiments[0], {0.25}, 7);
  EXPECT_THAT(overrides, testing::Contains(Override{"law", "'two words'"}));
  EXPECT_THAT(overrides, testing::Contains(Override{"a", "0.25"}));
  EXPECT_THAT(overrides_of(parts[2], parts[2].experiments[0], {0.25}, 7),
              testing::Contains(Override{"law", "1.5"}));
}

TEST(Choices, AreRefusedWithOneLine) {
  const Folder folder("law-wrong");
  const auto message = [&](const std::string& choices, const std::string& more) {
    return folder.study_error(law_study(choices, 13, 3) + more);
  };
  const struct {
    std::string choices, more, complaint;
  } cases[] = {
      {"choices = []\n", "", "has 0 entries; expected 2 to 6"},
      {"choices = [\"a\"]\n", "", "study.toml:12: parameters.law.choices: has 1 entries"},
      {"choices = [1, 2, 3, 4, 5, 6, 7]\n", "", "has 7 entries; expected 2 to 6"},
      {"choices = \"a\"\n", "", "expected a list of values"},
      {"choices = [\"a\", \"a\"]\n", "", "has \"a\" twice; expected different values"},
      {"choices = [1, \"1\"]\n", "", "has \"1\" twice"},
      {"choices = [\"a\", [1]]\n", "", "cannot be shown on one line"},
      {"choices = [\"a\", { x = 1 }]\n", "", "cannot be shown on one line"},
      {"choices = [\"a\", \"\"]\n", "", "cannot be shown on one line"},
      {"choices = [\"a\", \"b\\u001b[2J\"]\n", "", "expected printable text"},
      {"choices = [\"a\", \"" + std::string(61, 'x') + "\"]\n", "", "at most 60 bytes"},
      {"choices = [1, 2]\nmin = 0\n", "", "min"},
      {"choices = [1, 2]\nprior = [0.5]\n", "", "no list of 2 probabilities above 0"},
      {"choices = [1, 2]\nprior = [0.5, 0.6]\n", "", "that add up to 1"},
      {"choices = [1, 2]\nprior = [1, 0]\n", "", "probabilities above 0"},
      {"choices = [1, 2]\nprior = [0.5, \"x\"]\n", "", "prior: \""},
      {"choices = [1, 2]\nprior = [nan, 0.5]\n", "", "prior: "},
      {"choices = [1, 2]\n", "[[parameters]]\nname = \"m\"\nkeys = [\"m\"]\nchoices = [1, 2]\n",
       "is given for \"law\" already; expected at most one parameter with choices"},
      {"choices = [1, 2]\n", "[[parameters]]\nname = \"law\"\nkeys = [\"m\"]\nmin = 0\nmax = 1\n",
       "used twice"},
      {"choices = [1, 2]\n", "[[parameters]]\nname = \"m\"\nkeys = [\"law\"]\nmin = 0\nmax = 1\n",
       "bound twice"},
      {"choices = [1, 2]\n", "[[compare]]\nname = \"c\"\nvalues = { a = 0.5 }\n",
       "is given in a study of a parameter with choices; expected no [[compare]]"},
      {"choices = [1, 2]\n", "[direct]\nsearch = \"crs\"\nevaluations = 20\n",
       "takes no parameter with choices"},
      {"choices = [1, 2]\n", "[[constraints]]\nrule = \"law <= a\"\n", "law"},
      {"choices = [1, 2]\n", "[[priors]]\nparameter = \"law\"\nkind = \"normal\"\n",
       "\"law\" is not a parameter"},
  };
  for (const auto& c : cases) {
    const std::string said = message(c.choices, c.more);
    EXPECT_THAT(said, HasSubstr(c.complaint)) << c.choices << c.more;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    EXPECT_THAT(said, HasSubstr("study.toml:")) << said;
  }
  std::string alone = law_study("choices = [1, 2]\n", 13, 3);
  const std::size_t a = alone.find("[[parameters]]\nname = \"a\"");
  alone.erase(a, alone.find("[[targets]]") - a);
  EXPECT_THAT([&] { read_study(folder.write("study.toml", alone)); },
              testing::ThrowsMessage<InputError>(HasSubstr("have choices alone; expected")));
}

TEST(Evidence, IsTheMeanOfTheLikelihood) {
  for (const double sd : {0.3, 0.05, 0.002}) {
    const Posterior p = sample_density(
        [&](const VectorXd& u) { return (u.array() - 0.5).square().sum() / (sd * sd); }, 2);
    const double inside = std::erf(0.5 / sd / std::sqrt(2));
    EXPECT_NEAR(p.log_evidence, 2 * std::log(std::sqrt(2 * M_PI) * sd * inside), 0.1) << sd;
  }
}

TEST(Noise, OfTwoSetsIsPooledWhereItAgrees) {
  const auto draw = [](double sd, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::vector<Sample> all;
    for (int i = 0; i < 30; ++i)
      all.push_back(sample({10 + sd * normal_deviate(random), 10 + sd * normal_deviate(random)}));
    return all;
  };
  const auto quiet = draw(0.1, 2), alike = draw(0.1, 3), loud = draw(1, 4);
  const auto together = pool_noise(quiet, alike), apart = pool_noise(quiet, loud);
  EXPECT_EQ(together->degrees_of_freedom, 60);
  EXPECT_EQ(apart->degrees_of_freedom, 30);
  EXPECT_EQ(apart->constant_sd, pool_noise(quiet)->constant_sd);
  EXPECT_EQ(pool_noise(quiet, std::vector<Sample>{})->constant_sd, pool_noise(quiet)->constant_sd);
  EXPECT_EQ(pool_noise(std::vector<Sample>{}, quiet)->degrees_of_freedom, 30);
}

}  // namespace
}  // namespace firn
