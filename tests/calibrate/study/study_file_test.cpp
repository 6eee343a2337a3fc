// What a study file may contain, and the errors that are reported for anything else.
#include "calibrate/study/study_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/fake_experiment.h"
#include "tests/support/replaced.h"

namespace firn {
namespace {

using testing::AllOf;
using testing::HasSubstr;

using test::replaced;

TEST(StudyFile, ReadsEverything) {
  const Folder folder("file");
  const Study s = read_study(folder.write(
      "study.toml", friction_study(angle_target + "[[observe]]\nresponse = \"count\"\n"
                                                  "[[compare]]\nname = \"text\"\n"
                                                  "values = { mu1 = 0.1, mu2 = 0.3 }\n")));
  EXPECT_EQ(s.name, "fake");
  EXPECT_EQ(s.parameters.size(), 2u);
  EXPECT_EQ(s.parameters[1].keys, (std::vector<std::string>{"a.mu2", "b.mu2"}));
  EXPECT_TRUE(s.parameters[0].logarithmic);
  EXPECT_NEAR(s.parameters[0].to_unit(std::sqrt(0.01 * 0.3)), 0.5, 1e-12);
  EXPECT_EQ(s.targets[0].unit, "deg");
  EXPECT_EQ(s.targets[0].value, 10);
  ASSERT_EQ(s.observed.size(), 1u);
  EXPECT_EQ(s.observed[0].response.label, "count");
  EXPECT_EQ(s.compare[0].values, (std::vector<double>{0.1, 0.3}));
  // 3 at the center, 8 x 2, 3 x 2, 5, and one compared.
  EXPECT_EQ(s.largest_total(), 31);
}

TEST(StudyFile, TakesTheTargetFromAMeasurement) {
  const Folder folder("measurement");
  folder.write("angle.toml",
               "name = \"angle\"\nresponse = \"aor\"\nstatus = \"measured\"\nsource = \"here\"\n"
               "value = \"10 deg\"\nrepeats = 4\n[scatter]\nkind = \"standard deviation\"\n"
               "standard_deviation = \"3 deg\"\n");
  const Study s = read_study(
      folder.write("study.toml", friction_study("[[targets]]\nmeasurement = \"angle.toml\"\n")));
  EXPECT_EQ(s.targets[0].response.name, "aor");
  EXPECT_DOUBLE_EQ(s.targets[0].uncertainty, 1.5 * std::sqrt(3));  // 3 / sqrt(4), widened
}

TEST(StudyFile, TakesEarlierNamesOfResponsesOfCases) {
  const Folder folder("old-responses");
  folder.write("index.toml",
               "name = \"index\"\nresponse = \"low_fifo_index\"\nstatus = \"measured\"\n"
               "source = \"here\"\nvalues = [\"1\", \"2\"]\n");
  const std::string text = replaced(angle_target, "aor", "wall_rise") +
                           "[[targets]]\nmeasurement = \"index.toml\"\n[[observe]]\nresponse = "
                           "\"opposed_load_median\"\n";
  testing::internal::CaptureStderr();
  const Study s = read_study(folder.write("study.toml", friction_study(text)));
  const std::string warnings = testing::internal::GetCapturedStderr();
  EXPECT_EQ(s.targets.at(0).response.name, "wall_height_excess");
  EXPECT_EQ(s.targets.at(1).response.name, "low_order_index");
  EXPECT_EQ(s.observed.at(0).response.name, "compressive_load_median");
  EXPECT_THAT(warnings, HasSubstr("\"wall_rise\" is now \"wall_height_excess\""));
  EXPECT_THAT(warnings, HasSubstr("index.toml:2: response: \"low_fifo_index\" is now"));

  // A function or program of the user has the user's names.
  const std::string function =
      "[study]\nname = \"s\"\n[budget]\nruns = 20\n[[parameters]]\nname = \"p\"\nkeys = [\"p\"]\n"
      "min = 0\nmax = 1\n";
  EXPECT_EQ(read_function_study(function + replaced(angle_target, "aor", "wall_rise"), "f")
                .targets.at(0)
                .response.name,
            "wall_rise");
}

TEST(StudyFile, AScatterOfFewRepeatsIsItselfUncertain) {
  const Folder folder("repeats");
  const auto uncertainty = [&](const std::string& more) {
    folder.write("angle.toml",
                 "name = \"angle\"\nresponse = \"angle\"\nstatus = \"measured\"\nsource = \"\"\n" +
                     more + "[systematic]\nuncertainty = \"0.6 deg\"\nrationale = \"level\"\n");
    return read_study(folder.write("study.toml",
                                   friction_study("[[targets]]\nmeasurement = \"angle.toml\"\n")))
        .targets[0]
        .uncertainty;
  };
  // Seven repeats with a standard deviation of 2: Student's distribution with six degrees of
  // freedom has 6 / 4 of the variance.
  const std::string seven = "value = \"10 deg\"\nrepeats = 7\n[scatter]\n";
  EXPECT_NEAR(
      uncertainty(seven + "kind = \"standard deviation\"\nstandard_deviation = \"2 deg\"\n"),
      std::sqrt(4 / 7.0 * 6 / 4 + 0.36), 1e-12);
  EXPECT_NEAR(uncertainty("values = [\"8 deg\", \"10 deg\", \"10 deg\", \"10 deg\", \"12 deg\"]\n"),
              std::sqrt(2 / 5.0 * 4 / 2 + 0.36), 1e-12);
  // What is assumed is meant as it stands.
  EXPECT_NEAR(uncertainty(seven + "kind = \"not stated\"\nassumed_standard_deviation = \"2 deg\"\n"
                                  "assumption = \"a guess\"\n"),
              std::sqrt(4 / 7.0 + 0.36), 1e-12);
}

TEST(StudyFile, DimensionalParametersKeepTheirUnit) {
  const Folder folder("unit");
  const std::string text = replaced(friction_study(angle_target), "min = 0.01\nmax = 0.3\n",
                                    "min = \"1 mm\"\nmax = \"4 mm\"\n");
  EXPECT_EQ(read_study(folder.write("study.toml", text)).parameters[0].unit, "mm");
  EXPECT_THAT(folder.study_error(replaced(text, "4 mm", "4 m")), HasSubstr("the same unit"));
}

TEST(StudyFile, SaysWhatIsWrongAndWhere) {
  const Folder folder("wrong");
  const std::string good = friction_study(angle_target);
  const struct {
    std::string from, to, complaint;
  } cases[] = {
      {"seed = 1", "sede = 1", "sede"},
      {"max = 0.3", "max = 0.01", "max: 0.01 is not above min"},
      {"min = 0.01", "min = 0", "has no logarithm"},
      {"a.mu2", "a.mu1", "bound twice"},
      {"name = \"mu2\"", "name = \"mu1\"", "used twice"},
      {"design_points = 8", "design_points = 2", "cannot carry a fit of 2 parameters"},
      {"center_replicates = 3\ndesign_points = 8\nreplicates_per_point = 2",
       "center_replicates = 1\ndesign_points = 8\nreplicates_per_point = 1", "noise stays unknown"},
      {"case.toml", "other.toml", "does not exist"},
      {"a.mu1", "case.seed", "the study's own"},
      {"\"0.5 deg\"", "\"0.5 rad\"", "expected \"deg\" as the value has"},
      {"\"0.5 deg\"", "\"0 deg\"", "not above 0"},
      {"[[targets]]", "[[observe]]", "targets: is missing"},
  };
  for (const auto& c : cases)
    EXPECT_THAT(folder.study_error(replaced(good, c.from, c.to)),
                AllOf(HasSubstr("study.toml"), HasSubstr(c.complaint)));
  EXPECT_THAT(
      folder.study_error(good + "[[compare]]\nname = \"x\"\nvalues = { mu1 = 1, mu3 = 1 }\n"),
      HasSubstr("mu3"));
  EXPECT_THAT(folder.study_error(replaced(good, "max = 0.3", "max = 0.001")),
              HasSubstr("study.toml:18: "));
}

}  // namespace
}  // namespace firn
