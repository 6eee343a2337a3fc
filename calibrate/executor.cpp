#include "calibrate/executor.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <thread>

#include "experiments/recording.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// Simulations give way to whatever else the user does on the machine.
constexpr int niceness = 10;

struct JobFiles {
  explicit JobFiles(const Job& job) {
    const fs::path folder(job.folder);
    case_file = (folder / (job.key + ".toml")).string();
    results = (folder / (job.key + ".h5")).string();
    log = (folder / (job.key + ".log")).string();
  }
  std::string case_file, results, log;
};

std::string last_line(const std::string& file) {
  std::ifstream in(file);
  std::string line, last;
  while (std::getline(in, line))
    if (!line.empty()) last = line;
  return last;
}

// What a results file says of its run; nothing while it has not come to an end.
std::optional<JobResult> read_outcome(const std::string& results) {
  const Recording recording(results);
  const std::string status = recording.status();
  JobResult r;
  if (status == "finished") {
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

class LocalExecutor final : public Executor {
 public:
  explicit LocalExecutor(const LocalExecutorOptions& options) : options_(options) {
    if (options_.program.empty()) options_.program = fs::read_symlink("/proc/self/exe").string();
    if (options_.jobs <= 0)
      options_.jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  }

  std::string resolve(const std::string& case_file,
                      const std::vector<Override>& overrides) override {
    return read_case(case_file, overrides).resolved;
  }

  void run(const std::vector<Job>& jobs, const JobEvents& events) override {
    std::deque<Job> waiting(jobs.begin(), jobs.end());
    Children children;
    bool told_to_stop = false;
    while (!waiting.empty() || !children.empty()) {
      const bool stop = options_.interrupt != nullptr && options_.interrupt->load();
      if (stop) waiting.clear();
      if (stop && !told_to_stop) {
        for (const Child& c : children) kill(c.pid, SIGINT);  // they save and end
        told_to_stop = true;
      }
      while (!waiting.empty() && static_cast<int>(children.size()) < options_.jobs) {
        start(waiting.front(), events, children);
        waiting.pop_front();
      }
      collect(events, children);
      if (events.tick) events.tick();
      if (!children.empty()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }

 private:
  struct Child {
    pid_t pid;
    Job job;
    Clock::time_point start;
  };
  // Should somebody throw while they run, they save their state and end.
  struct Children : std::vector<Child> {
    ~Children() {
      for (const Child& c : *this) kill(c.pid, SIGINT);
      for (const Child& c : *this) waitpid(c.pid, nullptr, 0);
    }
  };

  void start(const Job& job, const JobEvents& events, Children& children) {
    const JobFiles files(job);
    events.started(job);
    bool go_on = false;
    if (fs::exists(files.results)) {
      try {
        if (const auto known = read_outcome(files.results)) {  // ended unseen: nothing to repeat
          events.ended(job, *known);
          return;
        }
        go_on = Recording(files.results).has_checkpoint();
      } catch (const InputError&) {
        // Cut short before anything was worth keeping.
      }
      if (!go_on) fs::remove(files.results);
    }
    fs::create_directories(job.folder);
    std::ofstream(files.case_file) << job.text;
    std::vector<std::string> args = {options_.program, "run"};
    if (go_on)
      args.insert(args.end(), {"--resume", files.results});
    else
      args.insert(args.end(), {files.case_file, "-o", files.results});
    args.insert(args.end(), {"--threads", std::to_string(job.threads)});
    children.push_back({spawn(args, files.log), job, Clock::now()});
  }

  static pid_t spawn(const std::vector<std::string>& args, const std::string& log) {
    std::vector<char*> argv;
    for (const std::string& a : args) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    const pid_t parent = getpid();
    const pid_t pid = fork();
    if (pid < 0) throw RunError(fmt::format("cannot start a process: {}", std::strerror(errno)));
    if (pid > 0) return pid;
    // Child: only calls that are safe between fork and exec.
    setpgid(0, 0);                    // Ctrl-C reaches it through the parent, once
    prctl(PR_SET_PDEATHSIG, SIGINT);  // and should the parent be killed, it saves and ends
    if (getppid() != parent) _exit(130);
    if (nice(niceness) == -1) errno = 0;  // a courtesy: going on without it is fine
    const int out = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
    const int in = open("/dev/null", O_RDONLY);
    if (out < 0 || in < 0) _exit(127);
    dup2(in, STDIN_FILENO);
    dup2(out, STDOUT_FILENO);
    dup2(out, STDERR_FILENO);
    execv(argv[0], argv.data());
    _exit(127);
  }

  static void collect(const JobEvents& events, Children& children) {
    for (std::size_t i = 0; i < children.size();) {
      int status = 0;
      if (waitpid(children[i].pid, &status, WNOHANG) == 0) {
        ++i;
        continue;
      }
      const Child child = children[i];
      children.erase(children.begin() + static_cast<std::ptrdiff_t>(i));
      JobResult result = outcome(JobFiles(child.job), status);
      result.wall = std::chrono::duration<double>(Clock::now() - child.start).count();
      events.ended(child.job, result);
    }
  }

  static JobResult outcome(const JobFiles& files, int status) {
    if (WIFSIGNALED(status))
      return {
          JobStatus::crashed,
          fmt::format("killed by signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status))),
          {},
          0};
    const int code = WEXITSTATUS(status);
    if (code == 130) return {JobStatus::interrupted, "interrupted", {}, 0};
    if (code == 0 || code == 1) {
      try {
        if (const auto known = read_outcome(files.results)) return *known;
      } catch (const InputError& e) {
        return {JobStatus::failed, e.what(), {}, 0};
      }
    }
    return {
        JobStatus::failed, fmt::format("exit status {}: {}", code, last_line(files.log)), {}, 0};
  }

  LocalExecutorOptions options_;
};

}  // namespace

const char* to_string(JobStatus status) {
  switch (status) {
    case JobStatus::finished:
      return "finished";
    case JobStatus::arched:
      return "arched";
    case JobStatus::failed:
      return "failed";
    case JobStatus::crashed:
      return "crashed";
    case JobStatus::timed_out:
      return "timed out";
    case JobStatus::out_of_memory:
      return "out of memory";
    case JobStatus::interrupted:
      return "interrupted";
  }
  return "";
}

std::unique_ptr<Executor> local_executor(const LocalExecutorOptions& options) {
  return std::make_unique<LocalExecutor>(options);
}

}  // namespace firn
