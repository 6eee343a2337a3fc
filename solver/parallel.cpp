#include "solver/parallel.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>

namespace firn {

void for_ranges(int threads, std::size_t n, std::size_t grain,
                const std::function<void(std::size_t, std::size_t)>& body) {
  const std::size_t ranges = (n + grain - 1) / grain;
  const auto one = [&](std::size_t k) { body(k * grain, std::min(n, (k + 1) * grain)); };
  if (threads <= 1 || ranges <= 1) {
    for (std::size_t k = 0; k < ranges; ++k) one(k);
    return;
  }
  // As many threads as asked for, also where there are fewer cores.
  static thread_local std::unique_ptr<tbb::global_control> allowed;
  static thread_local std::unique_ptr<tbb::task_arena> arena;
  if (!arena || arena->max_concurrency() != threads) {
    allowed.reset();
    if (threads > tbb::info::default_concurrency()) {
      allowed = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                      static_cast<std::size_t>(threads));
    }
    arena = std::make_unique<tbb::task_arena>(threads);
  }
  arena->execute([&] { tbb::parallel_for(std::size_t{0}, ranges, one); });
}

}  // namespace firn
