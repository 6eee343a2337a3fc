// Independent tasks in child processes.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace firn::proof {

struct ProcessTask {
  std::string name;
  std::function<void()> work;  // its results are files
};

struct ProcessCounts {
  int finished = 0, failed = 0;
  bool interrupted = false;
};

// Carries out tasks in their order, each in a child process, `jobs` at a time, and prints each end
// on standard error. After `seconds` it starts none. SIGINT and SIGTERM end the tasks at work. A
// task whose work throws fails; the others are carried out. Throws RunError.
ProcessCounts run_in_processes(const std::vector<ProcessTask>& tasks, int jobs, double seconds);

}  // namespace firn::proof
