// Child processes: simulations in the background, external programs, commands of a cluster.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <string>
#include <vector>

namespace firn {

// Starts a program in a new process group, with lower priority (nice), and appends its output to
// the file `log`. The program receives SIGINT when this process ends. Throws RunError when no
// process can be created. A program that cannot be started ends with status 127.
pid_t start_process(const std::vector<std::string>& args, const std::string& log);

// Starts a program, searched in PATH, in `directory`, with standard output and error in the files
// `out` and `err`; otherwise as start_process(). The program receives SIGTERM when this process
// ends. `err` has a message for a program that cannot be started.
pid_t start_program(const std::vector<std::string>& args, const std::string& directory,
                    const std::string& out, const std::string& err);

// Limits of a command; 0: those of this process.
struct ProcessLimits {
  unsigned processor_time = 0;           // s
  std::size_t address_space = 0;         // bytes; ignored with the address and thread sanitizers
  std::vector<std::string> environment;  // "NAME=value", added to that of this process
};

struct CommandResult {
  int status = 0;  // exit status; 128 + signal number after a signal
  std::string out, err;
};
// Runs a command and waits for its end. The program is searched in PATH; status 127 if it is
// missing. Ctrl-C is not passed to it; it is killed when this process ends. `directory`: working
// folder; empty: that of this process. Throws RunError when no process can be created.
CommandResult run_command(const std::vector<std::string>& args, const std::string& directory = {},
                          const ProcessLimits& limits = {});

// True for a command that SIGINT, SIGTERM, SIGHUP or SIGKILL has ended: another process or a lack
// of memory of the machine is the cause, not its input.
bool ended_from_outside(const CommandResult& result);
// run_command() for a command that may be repeated: up to three times, while it is ended from
// outside.
CommandResult run_repeatable_command(const std::vector<std::string>& args,
                                     const std::string& directory = {},
                                     const ProcessLimits& limits = {});
// Why a command has failed, in one line: the signal that has ended it, or its last message.
std::string failure_text(const CommandResult& result);

// Resident memory of a process, bytes; 0 after its end.
double resident_memory(pid_t pid);
// Resident memory of all processes of a group, bytes. What they share is counted once: the largest
// shared part of one of them.
double resident_memory_of_group(pid_t group);

// The last line that is not empty, of a text and of a file.
std::string last_line(const std::string& text);
std::string last_line_of_file(const std::string& file);

}  // namespace firn
