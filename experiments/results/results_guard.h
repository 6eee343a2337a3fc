// Checks results files in a child process, so that a crash in the HDF5 library does not end this
// one.
#pragma once

#include <string>

namespace firn {

// After the call, each results file is checked by a child process, `program check-results FILE`,
// before this process opens it. Without the call, files are not checked in this way.
void guard_results_with(const std::string& program);

// Throws InputError when the child rejects the file, crashes, or exceeds the limits of time and
// memory for the size of the file. `name`: name of the file in messages. Returns at once for an
// unchanged file that has passed. Thread-safe.
void check_in_child(const std::string& file, const std::string& name);

}  // namespace firn
