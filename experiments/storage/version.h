// Which Firn this is: kept in every results file, printed by `firn --version`.
#pragma once

namespace firn {

// Version of the project, e.g. "0.1.0".
const char* firn_version();

// Commit the program was built from, 12 hex digits, "-dirty" appended when tracked files differ
// from it; "unknown" outside a git checkout.
const char* firn_git_commit();

// Identity of what decides the numbers of a run: a hash over the sources of solver/ and
// experiments/, the compiler and its flags, and the versions of the libraries that compute. Two
// programs with the same one give the same results on the same kind of machine. 16 hex digits.
const char* firn_program();

}  // namespace firn
