// Keeps a crash inside the HDF5 library away from this process.
#pragma once

#include <string>

namespace firn {

// From now on, each results file is checked by a child process, `program check-results FILE`,
// before this process opens it. Without a call, files are opened at once.
void guard_results_with(const std::string& program);

// Throws InputError when the child refuses the file, crashes, or needs more time or memory than the
// file explains. `name` is what the message calls the file. Returns at once for a file that has
// passed and has not changed since. Safe to call from any thread.
void check_in_child(const std::string& file, const std::string& name);

}  // namespace firn
