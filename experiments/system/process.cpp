#include "experiments/system/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "experiments/system/input_file.h"
#include "experiments/system/output_file.h"

namespace firn {
namespace {

// Simulations give way to whatever else the user does on the machine.
constexpr int niceness = 10;
constexpr int kSignalStatus = 128;  // status of a command: this and the number of the signal

std::vector<char*> argument_list(const std::vector<std::string>& args) {
  std::vector<char*> list;
  list.reserve(args.size() + 1);
  for (const std::string& a : args) list.push_back(const_cast<char*>(a.c_str()));
  list.push_back(nullptr);
  return list;
}

[[noreturn]] void throw_spawn_error() {
  throw RunError(fmt::format("cannot start a process: {}", std::strerror(errno)));
}

// In the child, between fork and exec: only calls that are safe there.
void set_parent_death_signal(pid_t parent, int signal) {
  setpgid(0, 0);  // Ctrl-C reaches it through the parent, if at all
  prctl(PR_SET_PDEATHSIG, signal);
  ::signal(SIGPIPE, SIG_DFL);
  if (getppid() != parent) _exit(130);
}

void limit(int resource, rlim_t most, rlim_t hard) {
  const rlimit values{most, hard};
  if (most > 0) setrlimit(static_cast<__rlimit_resource>(resource), &values);
}

void keep_within(const ProcessLimits& limits) {
  // At the first limit SIGXCPU, at the second SIGKILL.
  limit(RLIMIT_CPU, limits.processor_time, limits.processor_time + 5);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  limit(RLIMIT_AS, limits.address_space, limits.address_space);
#endif
}

// Reads both pipes until they are closed.
void read_all(std::array<int, 2> pipes, std::array<std::string*, 2> texts) {
  std::array<pollfd, 2> waits = {pollfd{pipes[0], POLLIN, 0}, pollfd{pipes[1], POLLIN, 0}};
  while (waits[0].fd >= 0 || waits[1].fd >= 0) {
    if (poll(waits.data(), waits.size(), -1) < 0 && errno != EINTR) return;
    for (std::size_t i = 0; i < waits.size(); ++i) {
      if (waits[i].fd < 0 || waits[i].revents == 0) continue;
      char buffer[4096];
      const ssize_t n = read(waits[i].fd, buffer, sizeof(buffer));
      if (n > 0) texts[i]->append(buffer, static_cast<std::size_t>(n));
      if (n == 0 || (n < 0 && errno != EINTR)) waits[i].fd = -1;
      waits[i].revents = 0;
    }
  }
}

}  // namespace

pid_t start_process(const std::vector<std::string>& args, const std::string& log) {
  const std::vector<char*> argv = argument_list(args);
  const pid_t parent = getpid();
  const Descriptor out(open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
  if (out.number() < 0) throw WriteError(log, errno);
  const pid_t pid = fork();
  if (pid < 0) throw_spawn_error();
  if (pid > 0) return pid;
  set_parent_death_signal(parent, SIGINT);  // it saves its state and ends
  if (nice(niceness) == -1) errno = 0;      // a courtesy: going on without it is fine
  const int in = open("/dev/null", O_RDONLY);
  if (in < 0) _exit(126);
  dup2(in, STDIN_FILENO);
  dup2(out.number(), STDOUT_FILENO);
  dup2(out.number(), STDERR_FILENO);
  execv(argv[0], argv.data());
  _exit(127);
}

pid_t start_program(const std::vector<std::string>& args, const std::string& directory,
                    const std::string& out_file, const std::string& err_file) {
  const std::vector<char*> argv = argument_list(args);
  const pid_t parent = getpid();
  const auto create = [](const std::string& file) {
    Descriptor opened(open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (opened.number() < 0) throw WriteError(file, errno);
    return opened;
  };
  const Descriptor out = create(out_file), err = create(err_file);
  const pid_t pid = fork();
  if (pid < 0) throw_spawn_error();
  if (pid > 0) {
    setpgid(pid, pid);  // the group exists when this function returns
    return pid;
  }
  set_parent_death_signal(parent, SIGTERM);
  if (nice(niceness) == -1) errno = 0;
  const int in = open("/dev/null", O_RDONLY);
  if (in < 0 || chdir(directory.c_str()) != 0) _exit(126);
  dup2(in, STDIN_FILENO);
  dup2(out.number(), STDOUT_FILENO);
  dup2(err.number(), STDERR_FILENO);
  execvp(argv[0], argv.data());
  constexpr char cannot[] = "the program cannot be started\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, cannot, sizeof(cannot) - 1);
  _exit(127);
}

CommandResult run_command(const std::vector<std::string>& args, const std::string& directory,
                          const ProcessLimits& limits) {
  const std::vector<char*> argv = argument_list(args);
  std::vector<char*> environment;
  for (const std::string& one : limits.environment)
    environment.push_back(const_cast<char*>(one.c_str()));
  for (char** one = environ; *one; ++one) environment.push_back(*one);
  environment.push_back(nullptr);
  int out[2], err[2];
  if (pipe2(out, O_CLOEXEC) != 0) throw_spawn_error();
  if (pipe2(err, O_CLOEXEC) != 0) {
    close(out[0]);
    close(out[1]);
    throw_spawn_error();
  }
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid == 0) {
    set_parent_death_signal(parent, SIGKILL);
    dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
    dup2(out[1], STDOUT_FILENO);
    dup2(err[1], STDERR_FILENO);
    if (!directory.empty() && chdir(directory.c_str()) != 0) _exit(126);
    keep_within(limits);
    execvpe(argv[0], argv.data(), environment.data());
    _exit(127);
  }
  close(out[1]);
  close(err[1]);
  CommandResult result;
  if (pid > 0) read_all({out[0], err[0]}, {&result.out, &result.err});
  close(out[0]);
  close(err[0]);
  if (pid < 0) throw_spawn_error();
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  result.status = WIFSIGNALED(status) ? kSignalStatus + WTERMSIG(status) : WEXITSTATUS(status);
  return result;
}

bool ended_from_outside(const CommandResult& result) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGKILL})
    if (result.status == kSignalStatus + signal) return true;
  return false;
}

CommandResult run_repeatable_command(const std::vector<std::string>& args,
                                     const std::string& directory, const ProcessLimits& limits) {
  constexpr int kTries = 3;
  CommandResult result;
  for (int tries = 0; tries < kTries; ++tries) {
    result = run_command(args, directory, limits);
    if (!ended_from_outside(result)) break;
  }
  return result;
}

std::string failure_text(const CommandResult& result) {
  if (result.status > kSignalStatus) {
    const int signal = result.status - kSignalStatus;
    return fmt::format("signal {} ({}) has ended it", signal, strsignal(signal));
  }
  const std::string last = last_line(result.err);
  return last.empty() ? "it failed without a message" : last;
}

namespace {

struct ResidentMemory {
  double whole = 0, shared = 0;  // bytes; `shared` is part of `whole`
};

ResidentMemory resident_parts(const std::string& pid) {
  std::ifstream statm("/proc/" + pid + "/statm");
  double total = 0, resident = 0, shared = 0;
  if (!(statm >> total >> resident >> shared)) return {};
  const auto page = static_cast<double>(sysconf(_SC_PAGESIZE));
  return {resident * page, shared * page};
}

// -1 after its end.
pid_t group_of(const std::string& pid) {
  std::ifstream stat("/proc/" + pid + "/stat");
  const std::string text{std::istreambuf_iterator<char>(stat), {}};
  // The name of the program, in parentheses, may hold blanks and parentheses.
  std::istringstream rest(text.substr(std::min(text.rfind(')') + 1, text.size())));
  char state = 0;
  pid_t parent = 0, group = -1;
  return rest >> state >> parent >> group ? group : -1;
}

}  // namespace

double resident_memory(pid_t pid) { return resident_parts(std::to_string(pid)).whole; }

double resident_memory_of_group(pid_t group) {
  double sum = 0, shared = 0;
  std::error_code error;
  for (std::filesystem::directory_iterator entry("/proc", error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string pid = entry->path().filename().string();
    if (pid.find_first_not_of("0123456789") != pid.npos || group_of(pid) != group) continue;
    const ResidentMemory memory = resident_parts(pid);
    sum += memory.whole - memory.shared;
    shared = std::max(shared, memory.shared);
  }
  return sum + shared;
}

std::string last_line(const std::string& text) {
  std::istringstream in(text);
  std::string line, last;
  while (std::getline(in, line))
    if (!line.empty()) last = line;
  return last;
}

std::string last_line_of_file(const std::string& file) { return last_line(read_own_file(file)); }

}  // namespace firn
