// Record, table and limits of the coverage studies, without carrying out studies.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "experiments/analysis/random_stream.h"
#include "experiments/system/output_file.h"
#include "tests/calibration_proof/coverage_record.h"
#include "tests/calibration_proof/coverage_table.h"
#include "tests/calibration_proof/process_tasks.h"
#include "tests/support/error_of.h"
#include "tests/support/read_text.h"
#include "tests/support/scratch_folder.h"

namespace firn::proof {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr const char* kProblems = FIRN_SOURCE_DIR "/tests/calibration_proof/problems.toml";
constexpr const char* kRecord = FIRN_SOURCE_DIR "/tests/calibration_proof/coverage_record.csv";

RecordedStudy study(const std::string& problem, int index, double level,
                    const std::string& engine = "0123456789ab") {
  RecordedStudy s;
  s.key = {engine, problem, "border", "89abcdef", index};
  s.outcome.verdict = "calibrated";
  s.outcome.level = level;
  s.outcome.ideal_level = 0.5;
  s.outcome.width = 1.25;
  s.outcome.parameters = s.outcome.intervals = 2;
  s.outcome.confirmed_z = {-1.5, 0.25};
  s.outcome.model_z = {1e-7};
  s.outcome.cost = 40;
  return s;
}

// A problem of one parameter, with these responses.
std::vector<CoveredProblem> read_problem(const std::string& responses) {
  const test::ScratchFolder folder("problems");
  const std::string file = folder / "problems.toml";
  write_file(file,
             "[[problems]]\nname = \"one\"\ntruths = [\"prior\", \"border\"]\n"
             "parameters = [{ name = \"a\", min = 0, max = 1 }]\n" +
                 responses);
  return read_covered_problems(file);
}

TEST(CoverageRecord, IsReadBackAndSorted) {
  const test::ScratchFolder folder("record");
  const std::string file = folder / "record.csv";
  EXPECT_THAT(read_coverage_record(file), IsEmpty());
  RecordedStudy without_posterior = study("plain", 7, 0);
  without_posterior.outcome = {};
  without_posterior.outcome.verdict = "too few runs";
  const std::vector<RecordedStudy> studies = {study("two, or three", 12, 0.43219),
                                              study("two, or three", 9, 0.95),
                                              study("a \"quoted\" one", 0, 1), without_posterior};
  for (const RecordedStudy& one : studies) add_to_coverage_record(file, {one});
  EXPECT_EQ(test::read_text(file), coverage_record_text(studies));
  const std::vector<RecordedStudy> back = read_coverage_record(file);
  ASSERT_EQ(back.size(), 4u);
  EXPECT_EQ(coverage_record_text(back), coverage_record_text(studies));
  EXPECT_EQ(back[0].key, studies[2].key);
  EXPECT_EQ(back[1].key, studies[1].key);
  EXPECT_EQ(back[2].key, studies[0].key);
  EXPECT_EQ(back[2].outcome.level, 0.43219);
  EXPECT_THAT(back[2].outcome.confirmed_z, ElementsAre(-1.5, 0.25));
  EXPECT_THAT(back[2].outcome.model_z, ElementsAre(1e-7));
  EXPECT_EQ(back[3].key, without_posterior.key);
  EXPECT_FALSE(back[3].outcome.level);
  EXPECT_THAT(back[3].outcome.model_z, IsEmpty());
}

TEST(CoverageRecord, PiecesMergeByConcatenation) {
  const test::ScratchFolder folder("record");
  const std::string file = folder / "record.csv";
  const std::vector<RecordedStudy> all = {study("a", 0, 0.1), study("a", 1, 0.2),
                                          study("b", 0, 0.3)};
  write_file(file, coverage_record_text({all[2], all[0]}) + coverage_record_text({all[1], all[0]}));
  EXPECT_EQ(read_coverage_record(file).size(), 3u);
  add_to_coverage_record(file, {});
  EXPECT_EQ(test::read_text(file), coverage_record_text(all));
  add_to_coverage_record(file, {study("a", 1, 0.9)});  // of equal studies, the first one counts
  EXPECT_EQ(test::read_text(file), coverage_record_text(all));
  add_to_coverage_record(file, {study("a", 1, 0.9, "ffffffffffff")});
  EXPECT_EQ(read_coverage_record(file).size(), 4u);
}

TEST(CoverageRecord, RefusesWrongLines) {
  const test::ScratchFolder folder("record");
  const std::string file = folder / "record.csv";
  const std::string good = coverage_record_text({study("a", 0, 0.1)});
  write_file(file, good + "0123,a,border\n");
  EXPECT_THAT(test::error_of([&] { read_coverage_record(file); }),
              HasSubstr("record.csv:4: has 3 fields; expected 18"));
  std::string bad = good;
  bad.replace(bad.find("0.10000"), 7, "0.1a000");
  write_file(file, bad);
  EXPECT_THAT(test::error_of([&] { read_coverage_record(file); }),
              HasSubstr("record.csv:3: level is \"0.1a000\"; expected a number"));
}

// What is drawn for a study depends on problem, place and index alone, and studies share no seeds.
TEST(CoverageStudy, IsDrawnByNamesAndIndex) {
  const std::vector<CoveredProblem> problems = read_covered_problems(kProblems);
  EXPECT_GE(problems.size(), 20u);
  std::set<int> seeds;
  int rows = 0;
  for (const CoveredProblem& p : problems)
    for (const std::string& truth : p.truths) {
      ++rows;
      for (const int index : {3, 0, 199}) {
        const StudyDraw one = draw_study(p, truth, index), again = draw_study(p, truth, index);
        EXPECT_EQ(one.truth, again.truth);
        EXPECT_EQ(one.target, again.target);
        EXPECT_EQ(one.seed, again.seed);
        EXPECT_GT(one.seed, 0);
        EXPECT_TRUE(seeds.insert(one.seed).second) << p.name << ", " << truth << " " << index;
        EXPECT_GE(one.u.minCoeff(), 0);
        EXPECT_LE(one.u.maxCoeff(), 1);
      }
    }
  EXPECT_EQ(seeds.size(), static_cast<std::size_t>(3 * rows));
}

// A record recognizes a problem by what its studies depend on.
TEST(CoverageStudy, KeyDependsOnTheDefinition) {
  const std::string response = "responses = [{ name = \"y\", value = \"a\", uncertainty = 0.1 }]\n";
  const auto key = [](const std::string& responses) {
    return study_key(read_problem(responses)[0], "prior", 0);
  };
  const StudyKey one = key(response);
  EXPECT_EQ(one.engine.size(), 12u);
  EXPECT_EQ(one.definition.size(), 8u);
  EXPECT_EQ(one, key("# a comment\n" + response));
  EXPECT_EQ(one, key("responses = [{ uncertainty = 0.1, value = \"a\",   name = \"y\", "
                     "noise = \"0\" }]\n"));
  EXPECT_NE(one, key("responses = [{ name = \"y\", value = \"2*a\", uncertainty = 0.1 }]\n"));
  EXPECT_NE(one, key("responses = [{ name = \"y\", value = \"a\", uncertainty = 0.2 }]\n"));
  EXPECT_NE(one, key("low_fidelity_cost = 0.5\n" + response));
}

TEST(CoverageStudy, RefusesTwoProblemsOfOneName) {
  const std::string second =
      "responses = [{ name = \"y\", value = \"a\", uncertainty = 0.1 }]\n"
      "[[problems]]\nname = \"one\"\nparameters = [{ name = \"a\", min = 0, max = 1 }]\n"
      "responses = [{ name = \"y\", value = \"a\", uncertainty = 0.1 }]\n";
  EXPECT_THAT(test::error_of([&] { read_problem(second); }), HasSubstr("expected different names"));
}

TEST(CoverageTable, MarksOlderEnginesAndTexts) {
  const std::vector<CoveredProblem> problems =
      read_problem("responses = [{ name = \"y\", value = \"a\", uncertainty = 0.1 }]\n");
  std::vector<RecordedStudy> record;
  const auto add = [&](StudyKey key, int count) {
    for (key.index = 0; key.index < count; ++key.index) {
      record.push_back(study("one", 0, key.index == 0 ? 0.97 : 0.6));
      record.back().key = key;
    }
  };
  const StudyKey prior = study_key(problems[0], "prior", 0);
  const StudyKey border = study_key(problems[0], "border", 0);
  add(prior, 4);
  add({"000000000000", "one", "prior", prior.definition, 0}, 4);  // not more than the present ones
  add(border, 1);
  add({border.engine, "one", "border", "00000000", 0}, 3);
  add({"111111111111", "one", "border", border.definition, 0}, 2);
  add({border.engine, "another", "prior", border.definition, 0}, 5);  // not in the file
  const std::vector<CoverageRow> rows = coverage_rows(record, problems);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].truth + rows[0].older, "border");
  EXPECT_EQ(rows[0].counts.studies, 1);
  EXPECT_EQ(rows[1].truth + ", " + rows[1].older, "border, older text");
  EXPECT_EQ(rows[1].counts.studies, 3);
  EXPECT_EQ(rows[2].truth + rows[2].older, "prior");
  const std::string table = coverage_table(rows);
  EXPECT_THAT(table, HasSubstr("\n| one, prior | 4 | 75.0 (19.4 to 99.4) | 100.0 | 75.0 | 100.0 | "
                               "100.0 | 1.25 | 0 of 0 | 1.08 | 0.00 | 40 |  |\n"));
  EXPECT_THAT(table, HasSubstr("\n| one, border | 3 | 66.7 (9.4 to 99.2) |"));
  EXPECT_THAT(table, HasSubstr("| older text |\n"));
  EXPECT_THAT(table, HasSubstr("\n| all | 5 | 60.0 ("));
  EXPECT_THAT(table, HasSubstr("\n| all of older engines | 3 | 66.7 ("));
  record.erase(record.begin(), record.begin() + 9);  // the present ones among others
  const std::string older = coverage_table(coverage_rows(record, problems));
  EXPECT_THAT(older, Not(HasSubstr("\n| all | ")));
  EXPECT_THAT(coverage_table({}), Not(HasSubstr("|")));
}

TEST(CoverageTable, CountsNotices) {
  CoverageCounts t;
  CoverageOutcome o = study("one", 0, 0.5).outcome;
  t.add(o);
  o.verdict = "infeasible";
  o.ideal_infeasible = true;
  o.cautions = 2;
  t.add(o);
  o = {};
  o.verdict = "unconfirmed";
  t.add(o);
  EXPECT_THAT(coverage_table({{"one", "prior", "older engine 1", t}}),
              HasSubstr("| older engine 1, 1 infeasible (ideal 1), 1 unconfirmed, 1 with cautions "
                        "|\n"));
  EXPECT_EQ(t.studies, 3);
  EXPECT_EQ(t.region_95, 2);  // a study without a posterior holds no truth
}

// The row of a table with these shares of truths in both regions.
CoverageRow synthetic_row(int studies, int region_95, int region_68, const char* truth = "prior") {
  CoverageRow row{"one", truth};
  row.counts.studies = studies;
  row.counts.region_95 = region_95;
  row.counts.region_68 = region_68;
  row.counts.ideal_95 = static_cast<int>(std::lround(0.95 * studies));
  row.counts.ideal_68 = static_cast<int>(std::lround(0.68 * studies));
  return row;
}

// Chance that a row is found to exceed a limit whose regions hold the truth with these
// probabilities.
double chance_of_exceeding(int studies, double share_95, double share_68) {
  const auto probability = [&](int k, double share) {
    return std::exp(std::lgamma(studies + 1) - std::lgamma(k + 1) - std::lgamma(studies - k + 1) +
                    k * std::log(share) + (studies - k) * std::log(1 - share));
  };
  double none_95 = 0, none_68 = 0;  // independent
  for (int k = 0; k <= studies; ++k) {
    if (exceeded_limits(synthetic_row(studies, k, (68 * studies) / 100)).empty())
      none_95 += probability(k, share_95);
    if (exceeded_limits(synthetic_row(studies, (95 * studies) / 100, k)).empty())
      none_68 += probability(k, share_68);
  }
  return 1 - none_95 * none_68;
}

// False alarms: at the nominal shares, and at the ends of what is tolerated.
TEST(CoverageLimits, FalseAlarmsAreRare) {
  for (const int studies : {100, 150, 200, 400}) {
    SCOPED_TRACE(studies);
    EXPECT_LT(chance_of_exceeding(studies, 0.95, 0.68), studies < 200 ? 6e-4 : 2e-4);
    for (const double share_95 : {0.93, 0.97})
      for (const double share_68 : {0.64, 0.72})
        EXPECT_LT(chance_of_exceeding(studies, share_95, share_68), 0.01);
  }
  // A table of 40 rows of 200 studies: less than one in a hundred.
  EXPECT_LT(1 - std::pow(1 - chance_of_exceeding(200, 0.95, 0.68), 40), 0.01);
}

TEST(CoverageLimits, WrongSharesAreFound) {
  EXPECT_GT(chance_of_exceeding(200, 0.85, 0.68), 0.8);
  EXPECT_GT(chance_of_exceeding(200, 0.95, 0.50), 0.8);
  EXPECT_GT(chance_of_exceeding(400, 0.85, 0.68), 0.98);
  EXPECT_GT(chance_of_exceeding(400, 0.95, 0.55), 0.8);
  EXPECT_GT(chance_of_exceeding(400, 0.95, 0.80), 0.8);
}

TEST(CoverageLimits, AreThoseOfTheBinomialInterval) {
  const auto exceeds = [](const CoverageRow& row) { return !exceeded_limits(row).empty(); };
  EXPECT_TRUE(exceeds(synthetic_row(200, 175, 136)));
  EXPECT_FALSE(exceeds(synthetic_row(200, 176, 136)));
  EXPECT_FALSE(exceeds(synthetic_row(200, 199, 136)));
  EXPECT_TRUE(exceeds(synthetic_row(200, 200, 136)));
  EXPECT_TRUE(exceeds(synthetic_row(200, 190, 109)));
  EXPECT_FALSE(exceeds(synthetic_row(200, 190, 110)));
  EXPECT_FALSE(exceeds(synthetic_row(200, 190, 160)));
  EXPECT_TRUE(exceeds(synthetic_row(200, 190, 161)));
  EXPECT_FALSE(exceeds(synthetic_row(99, 0, 0)));  // too few
  CoverageRow older = synthetic_row(200, 0, 0);
  older.older = "older text";
  EXPECT_FALSE(exceeds(older));
  EXPECT_THAT(exceeded_limits(synthetic_row(200, 175, 109)),
              ElementsAre("the 95 % region holds 175 of 200 truths (99 % interval 80.3 to 92.8 %), "
                          "expected 93.0 to 97.0 %",
                          "the 68 % region holds 109 of 200 truths (99 % interval 45.2 to 63.6 %), "
                          "expected 64.0 to 72.0 %"));
}

TEST(CoverageLimits, WidthIsLimited) {
  CoverageRow row = synthetic_row(200, 190, 136);
  row.counts.parameters = 400;
  row.counts.log_width = 400 * std::log(1.149);
  EXPECT_THAT(exceeded_limits(row), IsEmpty());
  row.counts.log_width = 400 * std::log(1.151);
  EXPECT_EQ(exceeded_limits(row).size(), 1u);
  row.counts.log_width = 400 * std::log(1.16);
  EXPECT_THAT(exceeded_limits(row),
              ElementsAre("the width is 1.16 of the ideal, expected up to 1.15"));
}

// The exact posterior of one parameter, with a truth at its border: the 95 % region holds it if
// the deviate of the measurement is below the 1/1.05 quantile, the 68 % region below that of
// 1/1.32. The limits allow for that, and for nothing beyond.
TEST(CoverageLimits, FollowTheIdealAtABorder) {
  const int studies = 10000;
  std::mt19937_64 random(1);
  CoverageRow row = synthetic_row(studies, 0, 0, "border");
  row.counts.ideal_95 = row.counts.ideal_68 = 0;
  for (int i = 0; i < studies; ++i) {
    const double below = uniform_open(random);
    row.counts.ideal_95 += below < 1 / 1.05;
    row.counts.ideal_68 += below < 1 / 1.32;
  }
  row.counts.region_95 = row.counts.ideal_95;
  row.counts.region_68 = row.counts.ideal_68;
  EXPECT_NEAR(row.counts.ideal_68, 7576, 200);
  EXPECT_THAT(exceeded_limits(row), IsEmpty());
  row.truth = "prior";
  EXPECT_EQ(exceeded_limits(row).size(), 1u);
  row.truth = "border";
  row.counts.region_68 = 8300;
  EXPECT_EQ(exceeded_limits(row).size(), 1u);
  row.counts.region_68 = 6200;
  EXPECT_EQ(exceeded_limits(row).size(), 1u);
}

TEST(ProcessTasks, AreCarriedOutInChildren) {
  const test::ScratchFolder folder("tasks");
  std::vector<ProcessTask> tasks;
  for (int i = 0; i < 5; ++i)
    tasks.push_back({fmt::format("task {}", i), [&folder, i] {
                       if (i == 2) throw std::runtime_error("this one fails");
                       add_to_coverage_record(folder / "record.csv", {study("a", i, 0.5)});
                     }});
  const double no_limit = std::numeric_limits<double>::infinity();
  const ProcessCounts counts = run_in_processes(tasks, 3, no_limit);
  EXPECT_EQ(counts.finished, 4);
  EXPECT_EQ(counts.failed, 1);
  EXPECT_FALSE(counts.interrupted);
  EXPECT_EQ(test::read_text(folder / "record.csv"),
            coverage_record_text(
                {study("a", 0, 0.5), study("a", 1, 0.5), study("a", 3, 0.5), study("a", 4, 0.5)}));
  EXPECT_EQ(run_in_processes(tasks, 3, 0).finished, 0);
  EXPECT_EQ(run_in_processes({}, 1, no_limit).finished, 0);
}

TEST(CoveragePage, IsMadeFromTheRecord) {
  const std::vector<CoveredProblem> problems = read_covered_problems(kProblems);
  const std::vector<RecordedStudy> record = read_coverage_record(kRecord);
  EXPECT_EQ(test::read_text(kRecord), coverage_record_text(record)) << "not sorted";
  for (const RecordedStudy& s : record) {
    const auto p = std::ranges::find(problems, s.key.problem, &CoveredProblem::name);
    EXPECT_TRUE(p != problems.end() && std::ranges::count(p->truths, s.key.truth) == 1)
        << s.key.problem << ", " << s.key.truth << " is not in the file of problems";
  }
  const std::string page = test::read_text(FIRN_SOURCE_DIR "/docs/calibration-proof.md");
  const std::string table = coverage_table(coverage_rows(record, problems));
  EXPECT_THAT(page, HasSubstr("<!-- coverage -->\n" + table + "<!-- end -->\n"))
      << "docs/calibration-proof.md is not up to date: run scripts/update-coverage-page.sh";
}

}  // namespace
}  // namespace firn::proof
