#include "tests/calibration_proof/process_tasks.h"

#include <fmt/format.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <map>
#include <utility>

#include "experiments/system/output_file.h"
#include "firn/math.h"

namespace firn::proof {
namespace {

volatile std::sig_atomic_t stop_signal = 0;

void note_stop_signal(int number) { stop_signal = number; }

// SIGINT and SIGTERM set stop_signal and end waitpid() while this exists.
class StopSignals {
 public:
  StopSignals() {
    stop_signal = 0;
    struct sigaction action = {};
    action.sa_handler = note_stop_signal;
    sigaction(SIGINT, &action, &interrupt_before_);
    sigaction(SIGTERM, &action, &terminate_before_);
  }
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;
  ~StopSignals() {
    sigaction(SIGINT, &interrupt_before_, nullptr);
    sigaction(SIGTERM, &terminate_before_, nullptr);
  }

 private:
  struct sigaction interrupt_before_ = {}, terminate_before_ = {};
};

[[noreturn]] void carry_out_in_child(const ProcessTask& task) {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  int status = 0;
  try {
    task.work();
  } catch (const std::exception& e) {
    fmt::print(stderr, "firn: {}: {}\n", task.name, e.what());
    status = 1;
  }
  _exit(status);  // destructors of objects of the parent process do not run
}

pid_t start_task(const ProcessTask& task) {
  const pid_t pid = ::fork();
  if (pid < 0) throw RunError("no process can be created: " + errno_text(errno));
  if (pid == 0) carry_out_in_child(task);
  return pid;
}

// The child that has ended, and whether its work was done; 0 after a signal.
std::pair<pid_t, bool> wait_for_child() {
  int status = 0;
  const pid_t pid = ::waitpid(-1, &status, 0);
  if (pid < 0 && errno != EINTR) throw RunError("no process to wait for: " + errno_text(errno));
  return {pid < 0 ? 0 : pid, WIFEXITED(status) && WEXITSTATUS(status) == 0};
}

}  // namespace

ProcessCounts run_in_processes(const std::vector<ProcessTask>& tasks, int jobs, double seconds) {
  using Clock = std::chrono::steady_clock;
  const StopSignals signals;
  const Clock::time_point begin = Clock::now();
  ProcessCounts counts;
  std::map<pid_t, const ProcessTask*> running;
  std::size_t next = 0;
  while (true) {
    if (stop_signal != 0)
      for (const auto& [pid, task] : running) ::kill(pid, SIGTERM);
    const double elapsed = std::chrono::duration<double>(Clock::now() - begin).count();
    const bool may_start = stop_signal == 0 && next < tasks.size() && elapsed < seconds &&
                           running.size() < static_cast<std::size_t>(jobs);
    if (may_start) {
      running[start_task(tasks[next])] = &tasks[next];
      ++next;
      continue;
    }
    if (running.empty()) break;
    const auto [pid, done] = wait_for_child();
    const auto ended = running.find(pid);
    if (ended == running.end()) continue;
    if (done || stop_signal == 0) {
      ++(done ? counts.finished : counts.failed);
      fmt::print(stderr, "{} of {}: {}{}\n", counts.finished + counts.failed, tasks.size(),
                 ended->second->name, done ? "" : ": failed");
    }
    running.erase(ended);
  }
  counts.interrupted = stop_signal != 0;
  return counts;
}

}  // namespace firn::proof
