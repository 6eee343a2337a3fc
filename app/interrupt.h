// Ctrl-C and SIGTERM ask the work under way to save and stop; a second one kills at once.
#pragma once

#include <atomic>

namespace firn {

// Set by the signal handler, which this installs on its first call.
const std::atomic<bool>& interrupt_flag();

}  // namespace firn
