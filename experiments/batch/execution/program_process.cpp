#include "experiments/batch/execution/program_process.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "experiments/batch/execution/execution_settings.h"
#include "experiments/batch/execution/run_process.h"
#include "experiments/system/output_file.h"
#include "experiments/system/process.h"
#include "experiments/system/text_encoding.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr auto kill_delay = std::chrono::seconds(2);  // between SIGTERM and SIGKILL

std::string folder_of(const Job& job) { return (fs::path(job.folder) / job.key).string(); }

std::string file_in(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / name).string();
}

void fill_folder(const Job& job, const ProgramRun& run, const std::string& folder) {
  std::error_code error;
  fs::remove_all(folder, error);
  if (error) throw WriteError(folder, error.value());
  make_own_folder(folder);
  for (const auto& [name, hash] : run.inputs) {
    const fs::path link = fs::path(folder) / name;
    make_own_folder(link.parent_path());
    fs::create_symlink(program_input_file(job.folder, hash), link, error);
    if (error) throw WriteError(link.string(), error.value());
  }
  if (run.input_name.empty()) return;
  make_own_folder((fs::path(folder) / run.input_name).parent_path());
  write_own_file(file_in(folder, run.input_name), run.input_text, OutputFile::When::unsynced);
}

// The last lines of a file that are not blank, as one.
std::string last_lines(const std::string& file) {
  constexpr std::streamoff tail = 4096;  // bytes
  constexpr std::size_t most_lines = 3, most_characters = 400;
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) return {};
  in.seekg(std::max(std::streamoff{0}, static_cast<std::streamoff>(in.tellg()) - tail));
  std::deque<std::string> lines;
  for (std::string line; std::getline(in, line);) {
    if (line.find_first_not_of(" \t\r") == line.npos) continue;
    lines.push_back(line);
    if (lines.size() > most_lines) lines.pop_front();
  }
  std::string text = fmt::format("{}", fmt::join(lines, " | "));
  if (text.size() > most_characters) text = "..." + text.substr(text.size() - most_characters);
  return encode::terminal(text);
}

// What the program printed last. Some print errors on standard output.
std::string last_output(const std::string& folder) {
  std::string text = last_lines(file_in(folder, "stderr.txt"));
  if (text.empty()) text = last_lines(file_in(folder, "stdout.txt"));
  return text.empty() ? "no message" : text;
}

}  // namespace

std::string program_input_file(const std::string& runs_folder, const std::string& hash) {
  return (fs::path(runs_folder) / "inputs" / hash).string();
}

JobResult finished_program(const Job& job) {
  const std::string folder = folder_of(job);
  JobResult r;
  try {
    r.responses = read_program_responses(file_in(folder, parse_program_run(job.text).responses));
    r.status = JobStatus::finished;
  } catch (const InputError& e) {
    r.status = JobStatus::failed;
    r.reason = fmt::format("{} (its last output: {})", e.what(), last_output(folder));
    return r;
  }
  for (const Response& response : r.responses)
    if (response.name == "arched" && response.value[0] >= 0.5) {
      r.status = JobStatus::arched;
      r.reason = "the flow arched";
    }
  return r;
}

ProgramProcess::ProgramProcess(const Job& job)
    : job_(job), folder_(folder_of(job)), start_(Clock::now()) {
  const ProgramRun run = parse_program_run(job_.text);
  fill_folder(job_, run, folder_);
  pid_ = start_program(run.arguments, folder_, file_in(folder_, "stdout.txt"),
                       file_in(folder_, "stderr.txt"));
}

ProgramProcess::~ProgramProcess() {
  if (pid_ < 0) return;
  kill(-pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

void ProgramProcess::end() {
  if (pid_ < 0 || end_requested_) return;
  end_requested_ = Clock::now();
  kill(-pid_, SIGTERM);
}

void ProgramProcess::interrupt() {
  interrupted_ = true;
  end();
}

double ProgramProcess::wall() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

void ProgramProcess::watch_limits() {
  const RunLimits& limits = job_.limits;
  if (exceeded_ == Exceeded::nothing && limits.memory > 0 &&
      resident_memory_of_group(pid_) > limits.memory) {
    exceeded_ = Exceeded::memory;
    kill(-pid_, SIGKILL);
  }
  if (exceeded_ == Exceeded::nothing && limits.time > 0 && wall() > limits.time) {
    exceeded_ = Exceeded::time;
    end();
  }
  if (end_requested_ && Clock::now() - *end_requested_ > kill_delay) kill(-pid_, SIGKILL);
}

std::optional<JobResult> ProgramProcess::poll() {
  // The process is not reaped before its group has been killed: until then its number is its own.
  siginfo_t info{};
  if (waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) != 0 ||
      info.si_pid == 0) {
    watch_limits();
    return std::nullopt;
  }
  kill(-pid_, SIGKILL);
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  JobResult r = result(status);
  r.wall = wall();
  r.results_file = folder_;
  return r;
}

JobResult ProgramProcess::result(int status) const {
  const auto cut = [](JobStatus what, double limit, const std::string& text) {
    JobResult r{what, fmt::format("over its limit of {}", text), {}};
    r.limit = limit;
    return r;
  };
  if (exceeded_ == Exceeded::memory)
    return cut(JobStatus::out_of_memory, job_.limits.memory, memory_text(job_.limits.memory));
  if (exceeded_ == Exceeded::time)
    return cut(JobStatus::timed_out, job_.limits.time, time_text(job_.limits.time));
  if (interrupted_) return {JobStatus::interrupted, "interrupted", {}};
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    const std::string killed = fmt::format("killed by signal {} ({})", signal, strsignal(signal));
    if (signal == SIGKILL || signal == SIGTERM || signal == SIGHUP || signal == SIGINT)
      return {JobStatus::lost, killed, {}};
    require_writable(job_.folder);
    return {JobStatus::crashed, fmt::format("{}: {}", killed, last_output(folder_)), {}};
  }
  JobResult r =
      WEXITSTATUS(status) == 0
          ? finished_program(job_)
          : JobResult{JobStatus::failed,
                      fmt::format("exit status {}: {}", WEXITSTATUS(status), last_output(folder_)),
                      {}};
  // A failure on a full disk is no outcome.
  if (r.status == JobStatus::failed) require_writable(job_.folder);
  return r;
}

}  // namespace firn
