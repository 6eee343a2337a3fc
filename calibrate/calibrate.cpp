#include "calibrate/calibrate.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "calibrate/calibration.h"
#include "calibrate/choices.h"
#include "calibrate/direct_search.h"
#include "calibrate/output/calibration_result.h"
#include "calibrate/output/result_to_record.h"
#include "experiments/batch/batch_folder.h"
#include "experiments/system/interruption.h"
#include "experiments/system/output_file.h"
#include "experiments/system/terminal.h"
#include "experiments/system/text_encoding.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

bool was_requested(const PartRuns& part_runs, const std::string& key) {
  return std::any_of(part_runs.begin(), part_runs.end(),
                     [&](const auto& runs) { return runs->was_requested(key); });
}

void count_runs(const std::vector<JournalRun>& runs, const PartRuns& part_runs,
                CalibrationResult& a) {
  for (const JournalRun& run : runs) {
    a.other_version +=
        run.program != part_runs.front()->program() && run.program != user_program_identity;
    if (!was_requested(part_runs, run.key)) continue;
    ++a.runs;
    a.finished += run.status == "finished";
    a.arched += run.status == "arched";
    a.failed += run.status == "failed";
    a.crashed += run.status == "crashed";
    a.timed_out += run.status == "timed out";
    a.out_of_memory += run.status == "out of memory";
    if (cut_short(run.result.status))
      a.cut_short.push_back(
          fmt::format("{} seed {}: {}", run.label.parameters, run.label.seed, run.result.reason));
    a.wall += run.result.wall;
  }
}

StudySummary summarize(const Study& study, CalibrationResult& result, Journal& journal,
                       const PartRuns& part_runs, const std::string& directory, bool plot) {
  journal.require_in_place();
  std::vector<JournalRun> runs = journal.runs();
  for (std::size_t i = 0; i < result.curves.size(); ++i) {
    const CurveTarget& c = study.curves[i];
    for (JournalRun& run : runs)
      if (run.label.experiment == study.experiments[c.experiment].name &&
          was_requested(part_runs, run.key))
        add_scores(c, result.curves[i], run.result);
  }
  count_runs(runs, part_runs, result);
  StudySummary s;
  s.verdict = result.verdict;
  s.headline = result.headline;
  s.table = render_table(study, result);
  s.document = study_document(study, result);
  s.json = render_json(s.document);
  s.directory = directory;
  const fs::path folder(directory);
  for (const JournalRun& run : runs) {
    // It may lie with another study, or this folder may have been moved since.
    for (const fs::path& results :
         {fs::path(run.result.results_file), folder / "runs" / (run.key + ".h5")}) {
      std::error_code unreadable;  // as a name that is too long
      if (run.label.phase == "confirm" && was_requested(part_runs, run.key) &&
          results.extension() == ".h5" && fs::exists(results, unreadable))
        s.example_run = results.string();
    }
  }
  write_own_file(folder / "results.json", s.json + "\n");
  write_own_file(folder / "runs.csv", render_runs_csv(study, runs));
  if (result.posterior) {
    write_own_file(folder / "posterior.csv", render_posterior_csv(study, result));
    write_inference_data(study, result, (folder / "posterior.nc").string());
  }
  write_own_file(folder / "report.md",
                 fmt::format("# {}\n\n{}\n\n{}", encode::markdown(study.name),
                             encode::markdown(s.headline), encode::markdown_block(s.table)));
  journal.require_in_place();
  if (!plot || !result.models) return s;
  if (const std::string trouble = plot_fitted_response(study, result, directory); !trouble.empty())
    print_lines(stderr, "firn: no plot of the fitted response: {}\n", trouble);
  return s;
}

}  // namespace

int StudySummary::exit_status() const {
  if (verdict == StudyVerdict::interrupted) return 130;
  return verdict == StudyVerdict::too_few_runs ? 1 : 0;
}

namespace {

StudySummary carry_out(Study& study, const StudyOptions& options, const std::string& directory) {
  if (options.time_limit > 0) study.execution.limits.time = options.time_limit;
  if (options.memory_limit > 0) study.execution.limits.memory = options.memory_limit;
  if (!options.save.name.empty()) require_material(study);
  BatchFolder batch(directory,
                    {"calibrate", study_identity(study.text, study.source), study.largest_total(),
                     study.execution.slurm},
                    options);
  const interruption::Advice advice(resume_hint(directory) + " from there");
  const std::vector<Study> parts = parts_of(study);
  PartRuns part_runs;
  for (const Study& part : parts)
    part_runs.push_back(std::make_unique<StudyRuns>(part, batch.executor(), batch.journal(),
                                                    batch.store(), batch.progress(), batch.runs(),
                                                    options.interrupt));
  CalibrationResult result;
  try {
    if (study.choice)
      result = calibrate_choices(parts, part_runs, batch.progress());
    else if (study.direct == DirectSearch::none)
      result = Calibration(study, *part_runs.front(), batch.progress()).result();
    else
      result = direct_search(study, *part_runs.front(), batch.progress());
  } catch (const BatchInterrupted&) {
    StudySummary s;
    s.headline = fmt::format("interrupted; {} from there", resume_hint(directory));
    s.json = R"({"verdict": "interrupted"})";
    s.directory = directory;
    return s;
  }
  batch.progress().done();
  const Study& best = result.study ? *result.study : parts[result.best_choice];
  StudySummary summary =
      summarize(best, result, batch.journal(), part_runs, directory, options.plot);
  if (options.on_result) options.on_result(best, result);
  if (!options.save.name.empty()) {
    try {
      std::vector<JournalRun> used = batch.journal().runs();
      std::erase_if(used,
                    [&](const JournalRun& run) { return !was_requested(part_runs, run.key); });
      summary.record =
          material_record(study, result, used, batch.executor(), directory, options.save);
    } catch (const InputError& e) {  // the study is reported without a record
      summary.not_saved = e.what();
    }
  }
  return summary;
}

}  // namespace

StudySummary calibrate(const StudyOptions& options) {
  return calibrate(read_study(options.study_file,
                              options.allow_programs ? Programs::allowed : Programs::refused),
                   options);
}

StudySummary calibrate(Study study, const StudyOptions& options) {
  const std::string directory =
      options.directory.empty() ? (fs::path("runs") / study.name).string() : options.directory;
  return with_kept_runs(directory, [&] { return carry_out(study, options, directory); });
}

}  // namespace firn
