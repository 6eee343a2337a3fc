// Number of threads of a simulation without --threads.
#pragma once

#include <algorithm>
#include <thread>

namespace firn {

// More than eight gain nothing on beds of some thousand particles.
inline int default_threads() {
  return static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, 8U));
}

}  // namespace firn
