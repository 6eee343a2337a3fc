// Exit statuses of the program. Part of the public interface: docs/command-line.md.
#pragma once

namespace firn {

struct ExitStatus {
  static constexpr int done = 0;
  static constexpr int failed = 1;     // the run went wrong
  static constexpr int bad_input = 2;  // or usage
  static constexpr int requirement_missed = 3;
  static constexpr int interrupted = 130;  // what was finished or saved is kept
};

}  // namespace firn
