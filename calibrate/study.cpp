#include "calibrate/study.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

#include "calibrate/answer.h"
#include "calibrate/calibration.h"
#include "calibrate/direct.h"
#include "calibrate/material.h"
#include "calibrate/slurm_executor.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

// One process at a time works in a directory. Simulations inherit the lock, so that those which
// outlive a killed study keep it until they have saved their state: these are waited for.
class DirectoryLock {
 public:
  explicit DirectoryLock(const std::string& directory) {
    const std::string file = (fs::path(directory) / "lock").string();
    descriptor_ = open(file.c_str(), O_RDWR | O_CREAT, 0644);
    if (descriptor_ < 0)
      throw InputError(fmt::format("{}: cannot be written; expected a directory of ours", file));
    for (int tries = 0; flock(descriptor_, LOCK_EX | LOCK_NB) != 0; ++tries) {
      pid_t owner = 0;
      std::ifstream(file) >> owner;
      if (tries == 300 || (tries == 10 && owner > 0 && kill(owner, 0) == 0)) {
        close(descriptor_);
        throw InputError(
            fmt::format("{}: another calibration is at work here; expected it to end "
                        "first, or another directory with -o",
                        directory));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    const std::string owner = fmt::format("{}\n", getpid());
    if (ftruncate(descriptor_, 0) != 0 || pwrite(descriptor_, owner.data(), owner.size(), 0) < 0) {
      close(descriptor_);
      throw RunError(fmt::format("{}: cannot be written: {}", file, std::strerror(errno)));
    }
  }
  ~DirectoryLock() { close(descriptor_); }
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

 private:
  int descriptor_ = -1;
};

void write_file(const fs::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  if (!out.flush()) throw RunError(fmt::format("{}: cannot be written", file.string()));
}

void count_runs(const std::vector<JournalRun>& runs, const Campaign& campaign, Answer& a) {
  for (const JournalRun& run : runs) {
    a.other_version += run.program != campaign.program();
    if (!campaign.asked_for(run.key)) continue;
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

StudySummary summarize(const Study& study, Answer& answer, Journal& journal,
                       const Campaign& campaign, const std::string& directory, bool plot) {
  const std::vector<JournalRun> runs = journal.runs();
  count_runs(runs, campaign, answer);
  StudySummary s;
  s.verdict = answer.verdict;
  s.headline = answer.headline;
  s.table = render_table(study, answer);
  s.json = render_json(study, answer);
  s.directory = directory;
  const fs::path folder(directory);
  for (const JournalRun& run : runs) {
    // It may lie with another study, or this folder may have been moved since.
    for (const fs::path& results :
         {fs::path(run.result.results_file), folder / "runs" / (run.key + ".h5")})
      if (run.label.phase == "confirm" && campaign.asked_for(run.key) && fs::exists(results))
        s.example_run = results.string();
  }
  write_file(folder / "results.json", s.json + "\n");
  write_file(folder / "runs.csv", render_runs_csv(study, runs));
  write_file(folder / "report.md",
             fmt::format("# {}\n\n{}\n\n```\n{}```\n", study.name, s.headline, s.table));
  if (!plot || !answer.knowledge) return s;
  if (const std::string trouble = plot_fitted_response(study, answer, directory); !trouble.empty())
    fmt::print(stderr, "firn: no plot of the fitted response: {}\n", trouble);
  return s;
}

}  // namespace

const char* to_string(StudyVerdict verdict) {
  switch (verdict) {
    case StudyVerdict::calibrated:
      return "calibrated";
    case StudyVerdict::undetermined:
      return "undetermined";
    case StudyVerdict::unconfirmed:
      return "unconfirmed";
    case StudyVerdict::out_of_reach:
      return "out of reach";
    case StudyVerdict::searched:
      return "searched";
    case StudyVerdict::too_few_runs:
      return "too few runs";
    case StudyVerdict::interrupted:
      return "interrupted";
  }
  return "";
}

int StudySummary::exit_status() const {
  if (verdict == StudyVerdict::interrupted) return 130;
  return verdict == StudyVerdict::too_few_runs ? 1 : 0;
}

namespace {

std::unique_ptr<Executor> make_executor(const Study& study, const StudyOptions& options,
                                        const std::string& directory, Journal& journal) {
  if (options.executor == "local")
    return local_executor({options.program, options.jobs, options.interrupt});
  if (options.executor != "slurm")
    throw InputError(
        fmt::format("--executor: \"{}\" is not known; expected local or slurm", options.executor));
  SlurmOptions slurm;
  slurm.settings = study.execution.slurm;
  slurm.program = options.program;
  slurm.folder = (fs::absolute(directory) / "slurm").lexically_normal().string();
  slurm.at_once = options.jobs;
  slurm.interrupt = options.interrupt;
  return slurm_executor(slurm, journal);
}

int side_by_side(const StudyOptions& options) {
  if (options.jobs > 0 || options.executor != "local") return options.jobs;
  return static_cast<int>(std::thread::hardware_concurrency());
}

ProgressStyle progress_style(const StudyOptions& options) {
  if (!options.show_progress) return ProgressStyle::none;
  return options.json_progress ? ProgressStyle::json : ProgressStyle::people;
}

}  // namespace

StudySummary calibrate(const StudyOptions& options) {
  Study study = read_study(options.study_file);
  const std::string directory =
      options.directory.empty() ? (fs::path("runs") / study.name).string() : options.directory;
  if (options.time_limit > 0) study.execution.limits.time = options.time_limit;
  if (options.memory_limit > 0) study.execution.limits.memory = options.memory_limit;
  if (!options.save.name.empty()) require_material(study);
  journal_file(directory, options.resume);  // the directory is there
  const DirectoryLock lock(directory);      // before the journal, which a study at work may hold
  Journal journal(directory, study_identity(study.text, study.source), options.resume);
  std::optional<RunStore> store;
  if (!options.store.empty()) store.emplace(options.store);
  std::unique_ptr<Executor> own;
  if (options.replace_executor == nullptr) own = make_executor(study, options, directory, journal);
  Executor& executor = own ? *own : *options.replace_executor;
  StudyProgress progress(progress_style(options), study.largest_total(), side_by_side(options));
  const std::string runs = (fs::absolute(directory) / "runs").lexically_normal().string();
  Campaign campaign(study, executor, journal, store ? &*store : nullptr, progress, runs,
                    options.interrupt);
  Answer answer;
  try {
    answer = study.direct == DirectSearch::none ? Calibration(study, campaign, progress).answer()
                                                : direct_search(study, campaign, progress);
  } catch (const StudyInterrupted&) {
    StudySummary s;
    s.headline = fmt::format(
        "interrupted; everything finished is kept in {}: the same command goes "
        "on from there",
        directory);
    s.json = R"({"verdict": "interrupted"})";
    s.directory = directory;
    return s;
  }
  progress.done();
  StudySummary summary = summarize(study, answer, journal, campaign, directory, options.plot);
  if (!options.save.name.empty()) {
    try {
      std::vector<JournalRun> used = journal.runs();
      std::erase_if(used, [&](const JournalRun& run) { return !campaign.asked_for(run.key); });
      summary.record = material_record(study, answer, used, executor, directory, options.save);
    } catch (const InputError& e) {  // the study is worth telling all the same
      summary.not_saved = e.what();
    }
  }
  return summary;
}

}  // namespace firn
