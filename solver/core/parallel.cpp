#include "solver/core/parallel.h"

#include <algorithm>

// Debian's oneTBB is built without thread sanitizer, which therefore does not see how oneTBB passes
// work to threads. It would report data races that do not exist. Builds with the sanitizer use
// std::jthread instead.
#ifdef __SANITIZE_THREAD__
#include <atomic>
#include <thread>
#include <vector>
#else
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>
#endif

namespace firn {

#ifdef __SANITIZE_THREAD__
struct TaskAffinity::Impl {};
#else
struct TaskAffinity::Impl {
  tbb::affinity_partitioner partitioner;
};
#endif
TaskAffinity::TaskAffinity() : impl_(std::make_unique<Impl>()) {}
TaskAffinity::~TaskAffinity() = default;
TaskAffinity::TaskAffinity(TaskAffinity&&) noexcept = default;
TaskAffinity& TaskAffinity::operator=(TaskAffinity&&) noexcept = default;

namespace {

#ifdef __SANITIZE_THREAD__
// Calls one(k) for every k below `ranges`.
template <class One>
void assign_tasks(int threads, std::size_t ranges, const One& one, TaskAffinity*) {
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t k = next++; k < ranges; k = next++) one(k);
  };
  std::vector<std::jthread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(work);
  work();
}

void sort_shared(int, std::vector<KeyIndex>& list) { std::sort(list.begin(), list.end()); }
#else
// Arena with the requested number of threads, even if there are fewer cores.
tbb::task_arena& arena_of(int threads) {
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
  return *arena;
}

template <class One>
void assign_tasks(int threads, std::size_t ranges, const One& one, TaskAffinity* shares) {
  const std::size_t from = 0;
  arena_of(threads).execute([&] {
    if (ranges <= static_cast<std::size_t>(threads)) {  // at most one range for each thread
      tbb::parallel_for(from, ranges, one, tbb::static_partitioner());
    } else if (shares) {
      tbb::parallel_for(from, ranges, one, (**shares).partitioner);
    } else {
      tbb::parallel_for(from, ranges, one);
    }
  });
}

void sort_shared(int threads, std::vector<KeyIndex>& list) {
  arena_of(threads).execute([&] { tbb::parallel_sort(list.begin(), list.end()); });
}
#endif

}  // namespace

void parallel_for_blocks(int threads, std::size_t n, std::size_t grain, RangeFunction body,
                         TaskAffinity* shares) {
  const std::size_t ranges = (n + grain - 1) / grain;
  const auto one = [&](std::size_t k) { body(k * grain, std::min(n, (k + 1) * grain)); };
  if (threads <= 1 || ranges <= 1) {
    for (std::size_t k = 0; k < ranges; ++k) one(k);
    return;
  }
  assign_tasks(threads, ranges, one, shares);
}

void sort_by_key(int threads, std::vector<KeyIndex>& list) {
  if (threads <= 1) {
    std::sort(list.begin(), list.end());
  } else {
    sort_shared(threads, list);
  }
}

}  // namespace firn
