// Processes: simulations in the background, and the commands of a cluster.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <string>
#include <vector>

namespace firn {

// Starts a program in a new process group, niced, with its output appended to `log`. It gets
// SIGINT when this process dies. Throws RunError when no process can be made; a program that cannot
// be started ends with status 127.
pid_t start_process(const std::vector<std::string>& args, const std::string& log);

// Starts a program, looked up in PATH, in `directory`, with its output in two separate files;
// otherwise as start_process(). It gets SIGTERM when this process dies. Throws RunError when no
// process can be made; a program that cannot be started says so in `err` and ends with status 127.
pid_t start_program(const std::vector<std::string>& args, const std::string& directory,
                    const std::string& out, const std::string& err);

// What a command may use; 0: as much as this process.
struct ProcessLimits {
  unsigned processor_time = 0;           // s
  std::size_t address_space = 0;         // bytes; not with the address or thread sanitizer
  std::vector<std::string> environment;  // "NAME=value", added to that of this process
};

struct CommandResult {
  int status = 0;  // exit status; 128 + signal for one that was killed
  std::string out, err;
};
// Runs a command to its end; the program is looked up in PATH, 127 when it is not there. Ctrl-C
// does not reach it; it dies with this process. It runs in `directory`, if one is given. Throws
// RunError when no process can be made.
CommandResult run_command(const std::vector<std::string>& args, const std::string& directory = {},
                          const ProcessLimits& limits = {});

// Bytes of main memory that the process has now; 0 when it is gone.
double resident_memory(pid_t pid);

// The last line that is not empty.
std::string last_line(const std::string& text);
std::string last_line_of_file(const std::string& file);

}  // namespace firn
