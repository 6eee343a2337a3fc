#include "experiments/batch/execution/run_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "experiments/batch/execution/execution_settings.h"
#include "experiments/results/results_file.h"
#include "experiments/results/results_lock.h"
#include "experiments/system/output_file.h"
#include "experiments/system/process.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

// A run beyond its time limit is asked to save its state. It is killed if it takes longer than
// this.
constexpr auto save_timeout = std::chrono::seconds(60);
constexpr std::size_t probe_size = 1 << 20;  // bytes

// nullopt for a run that has not ended, or whose responses are not measured.
std::optional<JobResult> outcome(const std::string& results) {
  if (has_saved_copy(results)) return std::nullopt;
  const Recording recording(results);
  const std::string status = recording.status();
  JobResult r;
  r.wall = recording.wall_time();
  r.results_file = results;
  if (status == "finished") {
    if (!recording.measured()) return std::nullopt;
    r.status = JobStatus::finished;
    r.responses = recording.responses();
    for (const Response& response : r.responses)
      if (response.name == "arched" && !response.value.empty() && response.value[0] >= 0.5) {
        r.status = JobStatus::arched;
        r.reason = "the flow arched";
      }
    return r;
  }
  constexpr std::string_view failed = "failed";
  if (!status.starts_with(failed)) return std::nullopt;
  r.reason = status.size() > failed.size() + 2 ? status.substr(failed.size() + 2) : status;
  return r;
}

// Removes the files of a run that has saved nothing.
void remove_results(const std::string& results) {
  remove_if_there(results);
  remove_if_there(saved_copy(results));
}

std::string free_name(const std::string& file) {
  std::error_code error;
  std::string name = file + ".unreadable";
  for (int i = 2; fs::exists(name, error); ++i) name = fmt::format("{}.unreadable-{}", file, i);
  return name;
}

// Renames results that cannot be opened, and their copy: they may hold what other programs can
// recover. Empty files are removed. The new names, comma-separated; empty: none was worth keeping.
std::string set_aside(const std::string& results) {
  std::string names;
  for (const std::string& file : {results, saved_copy(results)}) {
    std::error_code error;
    if (fs::is_regular_file(file, error) && fs::file_size(file, error) > 0) {
      const std::string name = free_name(file);
      if (rename(file.c_str(), name.c_str()) != 0) throw WriteError(file, errno);
      names += (names.empty() ? "" : ", ") + name;
    } else {
      remove_if_there(file);
    }
  }
  return names;
}

// One line about results that were set aside because of `reason`; empty when none were.
std::string set_aside_line(const std::string& results, const std::string& reason) {
  const std::string names = set_aside(results);
  if (names.empty()) return {};
  return fmt::format("{}; renamed to {}; the run starts from its beginning", reason, names);
}

}  // namespace

JobFiles::JobFiles(const Job& job) {
  const fs::path folder(job.folder);
  case_file = (folder / (job.key + ".toml")).string();
  results = (folder / (job.key + ".h5")).string();
  log = (folder / (job.key + ".log")).string();
}

std::optional<JobResult> existing_result(const Job& job) {
  if (job.user_program) return std::nullopt;
  const std::string results = JobFiles(job).results;
  if (!fs::exists(results)) return std::nullopt;
  try {
    return outcome(results);
  } catch (const InputError&) {
    return std::nullopt;  // cut short before anything was worth keeping
  }
}

double simulated_time(const Job& job) {
  try {
    const std::vector<double> times = Recording(JobFiles(job).results).frame_times();
    return times.empty() ? 0 : times.back();
  } catch (const InputError&) {
    return 0;
  }
}

void require_writable(const std::string& folder) {
  const std::string file = (fs::path(folder) / "write_test").string();
  make_own_folder(folder);
  const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  const std::vector<char> bytes(probe_size);
  ssize_t written = -1;
  if (descriptor >= 0) {
    written = write(descriptor, bytes.data(), bytes.size());
    if (written >= 0 && fsync(descriptor) != 0) written = -1;
  }
  const int why = written >= 0 ? ENOSPC : errno;
  if (descriptor >= 0) close(descriptor);
  unlink(file.c_str());
  if (written != static_cast<ssize_t>(bytes.size())) throw WriteError(folder, why);
}

RunProcess::RunProcess(const Job& job, const std::string& program, Note print_note)
    : job_(job), files_(job), print_note_(std::move(print_note)), start_(Clock::now()) {
  std::error_code unreadable;
  if (fs::exists(files_.results, unreadable) || has_saved_copy(files_.results)) {
    try {
      const Recording recording(files_.results);
      resumed_ = recording.has_checkpoint() || recording.status() == "finished";
      earlier_ = resumed_ ? recording.wall_time() : 0;
      if (!resumed_) remove_results(files_.results);
    } catch (const InputError& e) {
      resumed_ = false;
      note(set_aside_line(files_.results, e.what()));
    }
  }
  make_own_folder(job_.folder);
  write_own_file(files_.case_file, job_.text, OutputFile::When::unsynced);
  std::vector<std::string> args = {program, "run"};
  if (resumed_)
    args.insert(args.end(), {"--resume", files_.results});
  else
    args.insert(args.end(), {files_.case_file, "-o", files_.results});
  args.insert(args.end(), {"--threads", std::to_string(job_.threads)});
  pid_ = start_process(args, files_.log);
}

RunProcess::~RunProcess() {
  if (pid_ < 0) return;
  send(SIGINT);
  waitpid(pid_, nullptr, 0);
}

void RunProcess::interrupt() {
  interrupted_ = true;
  send(SIGINT);
}

void RunProcess::note(const std::string& line) const {
  if (!line.empty() && print_note_) print_note_(line);
}

// Never signals a process that has ended: its id may be reused, and -1 addresses all processes.
void RunProcess::send(int signal) {
  if (pid_ > 0) kill(pid_, signal);
}

double RunProcess::wall() const {
  return earlier_ + std::chrono::duration<double>(Clock::now() - start_).count();
}

// Resident memory is what a run takes from others. Its address space (RLIMIT_AS) is many times as
// large, because threads and allocators reserve far more than they use.
void RunProcess::watch_limits() {
  const RunLimits& limits = job_.limits;
  if (exceeded_ == Exceeded::nothing && limits.memory > 0 &&
      resident_memory(pid_) > limits.memory) {
    exceeded_ = Exceeded::memory;  // saving would take more of it; the last checkpoint stays
    send(SIGKILL);
  }
  if (exceeded_ == Exceeded::nothing && limits.time > 0 && wall() > limits.time) {
    exceeded_ = Exceeded::time;
    deadline_notified_ = Clock::now();
    send(SIGINT);
  }
  if (exceeded_ == Exceeded::time && Clock::now() - deadline_notified_ > save_timeout)
    send(SIGKILL);
}

std::optional<JobResult> RunProcess::poll() {
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) == 0) {
    watch_limits();
    return std::nullopt;
  }
  pid_ = -1;
  JobResult r = result(status);
  r.wall = wall();
  r.results_file = files_.results;
  return r;
}

JobResult RunProcess::cut(JobStatus status, double limit, const std::string& limit_text) const {
  JobResult r;
  r.status = status;
  r.simulated = simulated_time(job_);
  r.limit = limit;
  r.reason = fmt::format("over its limit of {} at t = {:.4g} s", limit_text, r.simulated);
  return r;
}

JobResult RunProcess::result(int status) const {
  const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  const int code = WIFSIGNALED(status) ? 128 + signal : WEXITSTATUS(status);
  if (exceeded_ == Exceeded::memory)
    return cut(JobStatus::out_of_memory, job_.limits.memory, memory_text(job_.limits.memory));
  if (signal == 0 && (code == 0 || code == 1)) {
    try {
      if (const auto known = outcome(files_.results)) return *known;
    } catch (const InputError&) {
      // The results file cannot be read: the exit status decides below.
    }
  }
  if (exceeded_ == Exceeded::time)
    return cut(JobStatus::timed_out, job_.limits.time, time_text(job_.limits.time));
  if (code == 130 && interrupted_) return {JobStatus::interrupted, "interrupted", {}};
  const std::string last = last_line_of_file(files_.log);
  const std::string killed =
      signal == 0 ? "" : fmt::format("killed by signal {} ({})", signal, strsignal(signal));
  // A signal to the run alone does not end the batch. The run has saved its state and is repeated
  // from there.
  if (code == 130 && signal == 0)
    return {JobStatus::lost, "interrupted by a signal", {}, 0, simulated_time(job_)};
  if (signal == SIGKILL || signal == SIGTERM || signal == SIGHUP || signal == SIGINT)
    return {JobStatus::lost, killed, {}, 0, simulated_time(job_)};
  // A status below is a fault of the run only if its folder is writable.
  require_writable(job_.folder);
  if (signal == SIGXFSZ) throw WriteError(files_.results, EFBIG);
  if (code == 1) {
    if (const auto refused = write_error_in(last)) throw *refused;
    // An empty log: the message could not be written either.
    if (last.empty()) return {JobStatus::lost, "it ended without a message", {}};
  }
  if (code == 126 || code == 127)
    throw RunError(fmt::format(
        "exit status {}: the program cannot be started; everything finished is kept, and the same "
        "command resumes",
        code));
  if (signal != 0) return {JobStatus::crashed, killed, {}};
  if (code == 2 && resumed_) {  // the state of an earlier session is unusable: restart
    note(set_aside_line(files_.results, last));
    return {JobStatus::lost, last, {}};
  }
  // Status 2: the case cannot be run. Any other status without results is a crash.
  return {code == 2 ? JobStatus::failed : JobStatus::crashed,
          fmt::format("exit status {}: {}", code, last),
          {}};
}

}  // namespace firn
