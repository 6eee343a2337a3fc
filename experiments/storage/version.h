// Version and identity of the program: stored in results files, printed by `firn --version`.
#pragma once

namespace firn {

// Version of the project, e.g. "0.1.0".
const char* firn_version();

// Commit of the sources, 12 hex digits; with "-dirty" if tracked files differ from it. "unknown"
// outside of a git checkout.
const char* firn_git_commit();

// Identity of everything that determines the numbers of a run: a hash, 16 hex digits, over the
// sources of solver/ and experiments/, the compiler and its flags, and the versions of the
// numerical libraries. Programs with equal identities give equal results on the same kind of
// machine.
const char* program_identity();

}  // namespace firn
