// What a study leaves behind as a material record.
#include "calibrate/output/result_to_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/material_records/material_database.h"
#include "experiments/material_records/material_json.h"
#include "experiments/storage/sha256.h"
#include "tests/support/error_of.h"
#include "tests/support/fake_experiment.h"
#include "tests/support/replaced.h"

namespace firn {
namespace {

using test::replaced;
using testing::HasSubstr;
using Values = FakeExperiment::Values;

const std::string first_key = "interactions.ice-ice.static_friction";
const std::string second_key = "interactions.ice-plastic.static_friction";

// The fake study with keys of materials.
std::string study_text(const std::string& more = "") {
  return replaced(replaced(friction_study(angle_target + more), "a.mu1", first_key),
                  "a.mu2\", \"b.mu2",
                  second_key + "\", \"interactions.ice-plastic.dynamic_friction");
}

// One angle: a valley of frictions.
JobResult noisy(const Values& v, std::mt19937_64& random) {
  return finished({scalar(
      "aor", zhou_angle(v.at(first_key), v.at(second_key)) * (1 + 0.05 * normal_deviate(random)),
      "deg")});
}

StudySummary run_and_save(const std::string& file, const std::string& directory,
                          Executor& executor) {
  StudyOptions options;
  options.study_file = file;
  options.directory = directory;
  options.show_progress = false;
  options.plot = false;
  options.replace_executor = &executor;
  options.save = {"mine", "an engineer", "a remark", {{"temperature", "-10 C"}}};
  return calibrate(options);
}

TEST(StudyMaterial, KeepsTheFamilyWithItsProvenance) {
  const Folder folder("material");
  FakeExperiment experiment(noisy);
  const std::string file = folder.write("study.toml", study_text());
  const StudySummary s = run_and_save(file, folder / "out", experiment);
  ASSERT_TRUE(s.record) << s.not_saved << s.table;
  const MaterialRecord& r = *s.record;
  EXPECT_NO_THROW(check(r));
  EXPECT_EQ(r.kind, RecordKind::calibrated);
  EXPECT_EQ(r.materials, (std::vector<std::string>{"ice", "plastic"}));
  ASSERT_EQ(r.parameters.size(), 2u);
  EXPECT_EQ(r.parameters[1].keys.size(), 2u);
  EXPECT_EQ(r.scope.back().name, "temperature");
  // Moments of the kept samples are those of the whole posterior: 256 of them, by their weights.
  const PosteriorEnsemble& f = *r.ensemble;
  for (std::size_t i = 0; i < 2; ++i) {
    double mean = 0, square = 0, weight = 0;
    for (const EnsembleSample& p : f.samples) {
      weight += p.weight;
      mean += p.weight * std::log(p.values[i]);
      square += p.weight * std::pow(std::log(p.values[i]), 2);
    }
    EXPECT_NEAR(weight, 1, 1e-9);
    const double sd = std::sqrt(f.covariance[i][i]);
    EXPECT_NEAR(mean, f.axes[i].mean, 0.2 * sd);
    EXPECT_NEAR(std::sqrt(square - mean * mean), sd, 0.2 * sd);
  }
  EXPECT_LT(f.covariance[0][1], 0);  // more of the one wants less of the other
  ASSERT_EQ(f.combinations.size(), 2u);
  EXPECT_TRUE(f.combinations[0].identifiable);
  EXPECT_FALSE(f.combinations[1].identifiable);
  // Whatever is drawn meets the target as well as the study knows: 0.5 deg measured, noise besides.
  for (std::uint64_t k = 1; k <= 50; ++k) {
    MaterialChoice choice;
    choice.sample = k;
    const std::vector<double> v = chosen_values(r, choice);
    EXPECT_NEAR(zhou_angle(v[0], v[1]), 10, 4 * 0.7);
  }
  // The answer was simulated five times, with fresh seeds; every value is here.
  const ReferenceSet& answer = f.reference_sets.front();
  EXPECT_EQ(answer.name, "answer");
  EXPECT_EQ(answer.values[0], r.parameters[0].value);
  ASSERT_EQ(answer.runs.size(), 5u);
  EXPECT_EQ(answer.runs[0].seed, 1001u);
  EXPECT_EQ(answer.runs[0].responses.at(0).name, "aor");
  // Who, from what, by which program, measured how: nothing is left out.
  const Provenance& p = r.provenance;
  EXPECT_EQ(p.author, "an engineer");
  EXPECT_EQ(p.measurements.at(0).value, 10);
  EXPECT_EQ(p.estimators.at(0).method, "formula");
  EXPECT_THAT(p.seeds, testing::IsSupersetOf({1u, 2u, 3u, 1001u, 1005u}));
  ASSERT_EQ(p.cases.size(), 1u);
  EXPECT_THAT(p.cases[0].text, HasSubstr("case.seed = 1001"));
  EXPECT_EQ(p.cases[0].parameters, (std::vector<std::string>{"mu1", "mu2"}));
  EXPECT_THAT(p.command, HasSubstr("firn calibrate " + file));
  for (const RawData& d : p.raw_data) EXPECT_EQ(sha256(read_text(d.file)), d.sha256) << d.file;
  // The same study again, from its journal: the same record but for the time.
  const int runs = experiment.runs;
  StudySummary again = run_and_save(file, folder / "out", experiment);
  EXPECT_EQ(experiment.runs, runs);
  again.record->provenance.date = p.date;
  EXPECT_EQ(canonical_text(*again.record), canonical_text(r));
  MaterialDatabase database(folder / "m.db", MaterialDatabase::Access::write);
  EXPECT_EQ(database.add({r}).front().record.reference(), "mine@1");
}

TEST(StudyMaterial, KeepsTheDiscrepancyThatTheStudyAllowed) {
  const Folder folder("material-discrepancy");
  FakeExperiment experiment(noisy);
  const StudySummary s =
      run_and_save(folder.write("study.toml", study_text("discrepancy = \"0.7 deg\"\n")),
                   folder / "out", experiment);
  ASSERT_TRUE(s.record) << s.not_saved << s.table;
  EXPECT_EQ(s.record->provenance.measurements.at(0).uncertainty, 0.5);
  EXPECT_EQ(s.record->provenance.measurements.at(0).discrepancy, 0.7);
  EXPECT_THAT(s.record->scope.at(0).statement,
              HasSubstr("10 ± 0.5 deg (discrepancy of the simulation ± 0.7 deg)"));
  MaterialDatabase database(folder / "m.db", MaterialDatabase::Access::write);
  database.add({*s.record});
  EXPECT_EQ(database.find("mine").record.provenance.measurements.at(0).discrepancy, 0.7);
}

TEST(StudyMaterial, AnAnswerThatIsNoneIsNotSaved) {
  const Folder folder("material-none");
  FakeExperiment experiment([](const Values&, std::mt19937_64& random) {
    return finished({scalar("aor", 40 + normal_deviate(random), "deg")});
  });
  const StudySummary s =
      run_and_save(folder.write("study.toml", study_text()), folder / "out", experiment);
  EXPECT_EQ(s.verdict, StudyVerdict::infeasible);
  EXPECT_FALSE(s.record);
  EXPECT_THAT(s.not_saved, HasSubstr("material mine: not saved, because the study is infeasible"));
}

TEST(StudyMaterial, OtherKeysAreRefusedBeforeAnyRun) {
  const Folder folder("material-keys");
  FakeExperiment experiment(noisy);
  const std::string text = replaced(study_text(), first_key, "shapes.cube.rounding");
  EXPECT_THAT(test::error_of([&] {
                run_and_save(folder.write("study.toml", text), folder / "out", experiment);
              }),
              HasSubstr("parameters: mu1: \"shapes.cube.rounding\" is not a key of a"));
  EXPECT_EQ(experiment.runs, 0);
}

}  // namespace
}  // namespace firn
