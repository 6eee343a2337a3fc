// Which Firn this is: kept in every results file, printed by `firn --version`.
#pragma once

namespace firn {

// Version of the project, e.g. "0.1.0".
const char* firn_version();

// Commit the program was built from, 12 hex digits, "-dirty" appended when tracked files differ
// from it; "unknown" outside a git checkout.
const char* firn_git_commit();

}  // namespace firn
