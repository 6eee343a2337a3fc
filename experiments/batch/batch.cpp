#include "experiments/batch/batch.h"

#include <fmt/format.h>

#include "experiments/batch/journal/outcome_tables.h"
#include "experiments/storage/version.h"
#include "experiments/system/interruption.h"

namespace firn {
namespace {

constexpr int most_crashes = 2;  // of the run itself: then the outcome is a crash
constexpr int most_losses = 5;   // of its process or machine: then the batch ends

}  // namespace

Batch::Batch(Executor& executor, Journal& journal, RunCache* store, BatchProgress& progress,
             const std::atomic<bool>* interrupt)
    : executor_(executor),
      journal_(journal),
      store_(store),
      progress_(progress),
      interrupt_(interrupt),
      program_(program_identity()) {}

BatchRun Batch::make(const std::string& case_file, const std::vector<Override>& overrides,
                     const std::string& folder, const RunLabel& label,
                     const MaterialRequest& materials) const {
  BatchRun run;
  run.job.case_file = case_file;
  run.job.overrides = overrides;
  ResolvedCase resolved = executor_.resolve(case_file, overrides, materials);
  run.job.text = std::move(resolved.text);
  run.job.key = run_key(resolved.identity, program_);
  run.job.folder = folder;
  run.planned = {run.job.key, run.job.text, program_, label};
  return run;
}

BatchRun Batch::make(const ProgramRun& program, const std::string& folder,
                     const RunLabel& label) const {
  BatchRun run;
  run.job.text = program_run_text(program);
  run.job.key = run_key(run.job.text, user_program_identity);
  run.job.folder = folder;
  run.job.user_program = true;
  run.planned = {run.job.key, run.job.text, user_program_identity, label};
  return run;
}

void Batch::run(const std::vector<BatchRun>& runs, const Check& check) {
  std::vector<Job> jobs;
  std::vector<PlannedRun> planned;
  RunsByKey by_key;
  for (const BatchRun& run : runs) {
    if (!by_key.emplace(run.job.key, &run).second) continue;
    planned.push_back(run.planned);
    jobs.push_back(run.job);
  }
  journal_.plan(planned);
  std::erase_if(jobs, [&](const Job& job) {
    const BatchRun& run = *by_key.at(job.key);
    const auto known = known_outcome(run);
    if (!known) return false;
    outcomes_.insert_or_assign(job.key, *known);
    if (check) check(run, *known);
    progress_.found(run.planned, *known);
    return true;
  });
  simulate(std::move(jobs), by_key, check);
}

// The outcome from the journal, or else from the cache that batches share. An outcome of the cache
// is copied to the journal, so that the folder is complete without the cache. The outcome of a run
// that a limit cut short is valid only while the limit is not higher.
std::optional<JobResult> Batch::known_outcome(const BatchRun& run) {
  const auto is_valid = [&](const std::optional<JobResult>& r) {
    return r && holds_within(run.job.limits, *r);
  };
  const auto here = outcomes_.find(run.job.key);
  auto known =
      here != outcomes_.end() ? std::optional(here->second) : journal_.outcome(run.job.key);
  if (is_valid(known)) return known;
  if (store_ == nullptr || !is_valid(known = store_->find(run.job.key))) return std::nullopt;
  journal_.finish(run.job.key, *known);
  return known;
}

void Batch::simulate(std::vector<Job> jobs, const RunsByKey& runs, const Check& check) {
  std::map<std::string, int> crashes, losses;
  std::map<std::string, double> reached;  // s simulated
  while (!jobs.empty()) {
    std::vector<Job> again;
    JobEvents events;
    events.started = [&](const Job& job) {
      journal_.start(job.key);
      progress_.started(runs.at(job.key)->planned);
    };
    events.ended = [&](const Job& job, const JobResult& reported) {
      const JobResult result = plausible(reported);
      const BatchRun& run = *runs.at(job.key);
      const bool lost = result.status == JobStatus::lost;
      // Losses count only while the run makes no progress between them.
      if (lost && result.simulated > reached[job.key]) losses[job.key] = 0;
      if (lost) reached[job.key] = result.simulated;
      if (lost && ++losses[job.key] == most_losses)
        throw RunError(fmt::format(
            "run {}: {}, {} times in a row; everything finished is kept, and the same command "
            "resumes from there",
            job.key, result.reason, most_losses));
      // The cause of a crash can lie outside the run: it is repeated a limited number of times.
      if (lost || (result.status == JobStatus::crashed && ++crashes[job.key] < most_crashes)) {
        again.push_back(job);
        return progress_.stopped(run.planned, result);
      }
      if (result.status == JobStatus::interrupted) return progress_.stopped(run.planned, result);
      journal_.finish(job.key, result);
      outcomes_.insert_or_assign(job.key, stored_form(result));
      if (store_ != nullptr) store_->add(run.planned, result);
      progress_.ended(run.planned, result);
      if (check) check(run, result);  // the first run decides, not the last
    };
    events.note = [&](const Job& job, const std::string& line) {
      progress_.note(runs.at(job.key)->planned, line);
    };
    events.tick = [&] { progress_.tick(); };
    {
      const interruption::Polled polled;
      executor_.run(jobs, events);
    }
    if (interrupt_ != nullptr && interrupt_->load()) throw BatchInterrupted{};
    jobs = std::move(again);
  }
}

}  // namespace firn
