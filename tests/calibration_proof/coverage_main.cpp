// Coverage of the calibration over the problems of a text file (problems.toml): how often regions
// and intervals hold the truth, how wide they are relative to the posterior with the exact
// responses, and whether stated errors are right. Prints a Markdown table.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "experiments/analysis/sample_statistics.h"
#include "firn/math.h"
#include "tests/calibration_proof/coverage_engine.h"
#include "tests/calibration_proof/coverage_record.h"
#include "tests/calibration_proof/coverage_table.h"
#include "tests/calibration_proof/process_tasks.h"
#include "tests/support/scratch_folder.h"

namespace firn::proof {
namespace {

struct CoverageOptions {
  std::string file, record;
  std::vector<std::string> names;  // of problems; empty: all
  int first = 0, studies = 10, runs = coverage_runs, jobs = 1;
  int from = 0, to = 1000;
  double minutes = 0;  // 0: no limit
  bool table = false, check = false;
};

std::vector<CoveredProblem> selected_problems(const CoverageOptions& o) {
  const std::vector<CoveredProblem> all = read_covered_problems(o.file);
  for (const std::string& name : o.names)
    if (std::ranges::find(all, name, &CoveredProblem::name) == all.end())
      throw InputError(fmt::format("--problem: \"{}\" is not in {}; expected the name of a problem",
                                   name, o.file));
  std::vector<CoveredProblem> selected;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const int number = static_cast<int>(i);
    if (number < o.from || number > o.to) continue;
    if (o.names.empty() || std::ranges::count(o.names, all[i].name) > 0) selected.push_back(all[i]);
  }
  return selected;
}

// Those that the record lacks. The lowest indices come first, so that all rows grow alike.
std::vector<ProcessTask> missing_studies(const std::vector<CoveredProblem>& problems,
                                         const CoverageOptions& o, const std::string& record) {
  std::set<StudyKey> known;
  for (const RecordedStudy& study : read_coverage_record(record)) known.insert(study.key);
  std::vector<ProcessTask> tasks;
  for (int i = o.first; i < o.studies; ++i)
    for (const CoveredProblem& p : problems)
      for (const std::string& truth : p.truths) {
        const StudyKey key = study_key(p, truth, i);
        if (known.contains(key)) continue;
        tasks.push_back(
            {fmt::format("{}, {}, study {}", p.name, truth, i), [&p, key, record, runs = o.runs] {
               const CoverageOutcome outcome = cover(p, key.truth, key.index, runs);
               add_to_coverage_record(record, {RecordedStudy{key, outcome}});
             }});
      }
  return tasks;
}

// 0, 2 if a study failed, 130 after an interruption.
int run_studies(const std::vector<CoveredProblem>& problems, const CoverageOptions& o,
                const std::string& record) {
  add_to_coverage_record(record, {});  // sorts it, and shows whether it can be written
  const ProcessCounts counts =
      run_in_processes(missing_studies(problems, o, record), o.jobs,
                       o.minutes > 0 ? 60 * o.minutes : std::numeric_limits<double>::infinity());
  if (counts.interrupted) return 130;
  return counts.failed > 0 ? 2 : 0;
}

// The engine may be conservative; more misses than chance explains once in a thousand are a
// defect, which is printed on standard error.
bool holds_enough_truths(const std::vector<CoverageRow>& rows) {
  constexpr double least = 0.90;
  CoverageCounts all;
  for (const CoverageRow& row : rows)
    if (row.older.empty()) all.add(row.counts);
  if (binomial_interval(all.region_95, all.studies, 0.998).high >= least) return true;
  fmt::print(stderr, "firn: the 95 % regions hold {} of {} truths; expected at least {:.0f} %\n",
             all.region_95, all.studies, 100 * least);
  return false;
}

// 1 if a row exceeds its limits.
int check_rows(const std::vector<CoverageRow>& rows) {
  int checked = 0, exceeding = 0;
  for (const CoverageRow& row : rows) {
    checked += row.older.empty() && row.counts.studies >= coverage_least_studies;
    const std::vector<std::string> exceeded = exceeded_limits(row);
    exceeding += exceeded.empty() ? 0 : 1;
    for (const std::string& one : exceeded) fmt::print("{}, {}: {}\n", row.problem, row.truth, one);
  }
  fmt::print("engine {}: {} rows have {} studies or more, {} of them exceed limits\n",
             coverage_engine(), checked, coverage_least_studies, exceeding);
  return exceeding > 0 ? 1 : 0;
}

int run_coverage(const CoverageOptions& o) {
  const std::vector<CoveredProblem> problems = selected_problems(o);
  // Holds the files of studies, also of those that are interrupted.
  const test::ScratchFolder scratch("coverage-proof");
  ::setenv("TMPDIR", scratch.path().c_str(), 1);
  const std::string record = o.record.empty() ? scratch / "record.csv" : o.record;
  const bool measures = !o.table && !o.check;
  const int status = measures ? run_studies(problems, o, record) : 0;
  if (status == 130) return status;
  const std::vector<CoverageRow> rows = coverage_rows(read_coverage_record(record), problems);
  if (o.check) return check_rows(rows);
  fmt::print("{}", coverage_table(rows));
  if (status != 0 || o.table) return status;
  return holds_enough_truths(rows) ? 0 : 1;
}

}  // namespace
}  // namespace firn::proof

int main(int argc, char** argv) {
  CLI::App app("How often do regions and intervals hold the truth?");
  firn::proof::CoverageOptions o;
  app.add_option("PROBLEMS.toml", o.file)->required();
  CLI::Option* const record = app.add_option(
      "--record", o.record, "CSV file of finished studies: those in it are not repeated");
  app.add_option("--studies", o.studies,
                 "of each problem and place of the truth: numbers 0 to STUDIES - 1")
      ->capture_default_str();
  app.add_option("--first", o.first, "lowest number of these studies that is carried out")
      ->capture_default_str();
  app.add_option("--runs", o.runs, "of each study")->capture_default_str()->excludes(record);
  app.add_option("--problem", o.names, "of this name alone; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--from", o.from, "first problem, by number")->capture_default_str();
  app.add_option("--to", o.to, "last problem, by number")->capture_default_str();
  app.add_option("--jobs", o.jobs, "studies side by side")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--minutes", o.minutes, "start no study after this time; 0: no limit");
  CLI::Option* const table =
      app.add_flag("--table", o.table, "print the table of the record, without studies");
  table->needs(record);
  app.add_flag("--check", o.check, "end with status 1 if a row of the record exceeds its limits")
      ->needs(record)
      ->excludes(table);
  CLI11_PARSE(app, argc, argv);
  try {
    return firn::proof::run_coverage(o);
  } catch (const std::exception& e) {
    fmt::print(stderr, "firn: {}\n", e.what());
    return 2;
  }
}
