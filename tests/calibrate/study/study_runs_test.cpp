// What is said of a study that sets what its case does not take.
#include "calibrate/study/study_runs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/error_of.h"
#include "tests/support/fake_experiment.h"
#include "tests/support/replaced.h"
#include "tests/support/small_cases.h"

namespace firn {
namespace {

using test::replaced;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

// Reads cases as a run does, and runs none.
class CaseReader : public Executor {
 public:
  void run(const std::vector<Job>&, const JobEvents&) override {
    ADD_FAILURE() << "a run was started";
  }
};

// The error that ends the study `text` of the case of two boxes, which has no runs.
std::string error_of_study(const Folder& folder, const std::string& text) {
  folder.write("case.toml", cli::two_boxes);
  std::filesystem::remove_all(folder / "out");  // of another study
  CaseReader reader;
  return test::error_of(
      [&] { run_study(folder.write("study.toml", text), folder / "out", reader); });
}

// One parameter with this key on line 12, and `more` after its tables.
std::string one_key(const std::string& key, const std::string& range = "min = 0.1\nmax = 0.9\n",
                    const std::string& more = "") {
  return "[study]\nname = \"s\"\ncase = \"case.toml\"\n[budget]\ncenter_replicates = 3\n"
         "design_points = 8\nreplicates_per_point = 2\n"
         "[[parameters]]\nname = \"p\"\n" +
         range + "keys = [\"" + key +
         "\"]\n[[targets]]\nresponse = \"peak_normal_force\"\nvalue = \"6 N\"\n"
         "uncertainty = \"0.3 N\"\n" +
         more;
}

TEST(StudyRuns, AKeyThatTheCaseLacksIsNamedWithItsPlaceInTheStudy) {
  const struct {
    std::string key, advice;
  } cases[] = {
      {"interactions.ice-plastic.static_friktion", "did you mean \"static_friction\"?"},
      {"interactions.ice-plastic.rougness", "expected one of "},
      {"interactions.ice-plstic.static_friction", "did you mean \"ice-plastic\"?"},
      {"materials.ice.youngs_modulus", "did you mean \"young_modulus\"?"},
      {"numerics.dt", ""},
      {"intractions.ice-plastic.static_friction", "did you mean \"interactions\"?"},
      {"boundaries.flor.static_friction", "expected one of 0 (\"floor\")"},
      {"particles.7.mass", "expected one of 0, 1"},
  };
  const Folder folder("lacking-key");
  for (const auto& c : cases) {
    const std::string said = error_of_study(folder, one_key(c.key));
    EXPECT_THAT(said, StartsWith((folder / "study.toml") + ":12: parameters.p.keys: the case " +
                                 (folder / "case.toml") + " has no key \"" + c.key + "\"; "));
    EXPECT_THAT(said, HasSubstr(c.advice));
    EXPECT_THAT(said, Not(HasSubstr("--set")));
    EXPECT_THAT(said, Not(HasSubstr("\n")));
  }
}

// Of several keys, the one at fault.
TEST(StudyRuns, TheLackingOneOfSeveralKeysIsNamed) {
  const Folder folder("lacking-keys");
  const std::string second =
      "[[parameters]]\nname = \"q\"\nmin = 0.1\nmax = 0.9\n"
      "keys = [\"interactions.ice-ice.restitution\", "
      "\"interactions.ice-ice.restitutoin\"]\n";
  EXPECT_THAT(
      error_of_study(folder, one_key("interactions.ice-plastic.restitution",
                                     "min = 0.1\nmax = 0.9\n", second)),
      StartsWith((folder / "study.toml") + ":21: parameters.q.keys: the case " +
                 (folder / "case.toml") + " has no key \"interactions.ice-ice.restitutoin\"; "));
}

TEST(StudyRuns, AValueThatTheCaseRefusesIsNamedWithItsPlaceInTheStudy) {
  const Folder folder("refused-value");
  for (const auto& [key, range] :
       {std::pair("interactions.ice-plastic.restitution", "min = 1.5\nmax = 2.5\n"),
        std::pair("materials.ice.young_modulus", "min = \"1 m\"\nmax = \"2 m\"\n"),
        std::pair("case.duration", "min = 0.1\nmax = 0.9\n")})
    EXPECT_THAT(error_of_study(folder, one_key(key, range)),
                StartsWith((folder / "study.toml") + ":12: parameters.p.keys: the case " +
                           (folder / "case.toml") + " does not take \"" + key + "\" = "));
}

// Choices, and the tables that set keys themselves.
TEST(StudyRuns, OtherTablesOfAStudyNameTheirPlaces) {
  const Folder folder("lacking-set");
  const std::string good = one_key("interactions.ice-plastic.restitution");
  const std::string missing = "interactions.ice-ice.restitutoin";
  const auto expect = [&](const std::string& text, const std::string& place) {
    EXPECT_THAT(error_of_study(folder, text),
                StartsWith((folder / "study.toml") + ":" + place + ": the case " +
                           (folder / "case.toml") + " has no key \"" + missing + "\"; "));
  };
  expect(
      good + "[[parameters]]\nname = \"c\"\nchoices = [0.1, 0.2]\nkeys = [\"" + missing + "\"]\n",
      "20: parameters.c.keys");
  expect(good + "[[numerics]]\nname = \"n\"\nset = { \"" + missing + "\" = 0.1 }\n",
         "19: numerics.n.set");
  expect(good + "[low_fidelity]\nset = { \"" + missing + "\" = 0.1 }\n", "18: low_fidelity.set");
  expect(replaced(good, "case = \"case.toml\"\n", "") +
             "[[experiments]]\nname = \"e\"\ncase = \"case.toml\"\nset = { \"" + missing +
             "\" = 0.1 }\n",
         "19: experiments.e.set");
}

// What a case lacks by itself is an error of the case.
TEST(StudyRuns, AFaultOfTheCaseIsNotTheStudys) {
  const Folder folder("fault-of-case");
  folder.write("bad.toml", replaced(cli::two_boxes, "restitution = 0.3", "restitution = 3"));
  CaseReader reader;
  const std::string study = folder.write(
      "study.toml",
      replaced(one_key("interactions.ice-plastic.static_friction", "min = 0.3\nmax = 0.9\n"),
               "case.toml", "bad.toml"));
  EXPECT_THAT(test::error_of([&] { run_study(study, folder / "out", reader); }),
              StartsWith(folder / "bad.toml"));
}

}  // namespace
}  // namespace firn
