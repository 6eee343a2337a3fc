#include "experiments/results/results_guard.h"

#include <fmt/format.h>

#include <cstring>
#include <mutex>
#include <set>

#include "experiments/system/input_file.h"
#include "experiments/system/process.h"
#include "firn/math.h"

namespace firn {
namespace {

std::mutex mutex;  // guards both
std::string checker;
std::set<FileStamp> passed;

ProcessLimits limits_for(double bytes) {
  ProcessLimits limits;
  limits.processor_time = static_cast<unsigned>(30 + bytes / 20e6);  // s
  limits.address_space = static_cast<std::size_t>(4e9 + 4 * bytes);
  // Memory that was never written is no zero: what depends on it fails in the child already.
  limits.environment = {"MALLOC_PERTURB_=165"};
  return limits;
}

}  // namespace

void guard_results_with(const std::string& program) {
  const std::lock_guard lock(mutex);
  checker = program;
}

void check_in_child(const std::string& file, const std::string& name) {
  std::string program;
  const FileStamp found = stamp_of(file);
  {
    const std::lock_guard lock(mutex);
    if (checker.empty() || !found.exists || passed.contains(found)) return;
    program = checker;
  }
  const CommandResult r = run_repeatable_command({program, "check-results", file}, {},
                                                 limits_for(static_cast<double>(found.size)));
  if (ended_from_outside(r))
    throw RunError(fmt::format("{}: the process that checks it: {}", name, failure_text(r)));
  if (r.status == 2 && !r.out.empty())
    throw InputError(fmt::format("{}: {}", name, last_line(r.out)));
  if (r.status == 126 || r.status == 127)
    throw RunError(fmt::format("{}: no process can be started to check it", name));
  if (r.status != 0) {
    const std::string how = r.status > 128 ? strsignal(r.status - 128) : "no result";
    throw InputError(fmt::format(
        "{}: damaged: the HDF5 library failed while reading it ({}); expected a whole file", name,
        how));
  }
  const std::lock_guard lock(mutex);
  passed.insert(found);
}

}  // namespace firn
