// Distribution of work to threads.
#pragma once

#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace firn {

// Assignment of ranges of a loop to threads. A repeated loop gets the same assignment each time
// unless a thread is late, so that the data of a range stay in the cache of its thread.
class TaskAffinity {
 public:
  TaskAffinity();
  ~TaskAffinity();
  TaskAffinity(TaskAffinity&&) noexcept;
  TaskAffinity& operator=(TaskAffinity&&) noexcept;
  struct Impl;
  Impl& operator*() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

// Refers to a function body(begin, end) of ranges, which must outlive it. Allocates no memory.
class RangeFunction {
 public:
  template <class Body>
  RangeFunction(const Body& body)
      : body_(&body), call_([](const void* b, std::size_t begin, std::size_t end) {
          (*static_cast<const Body*>(b))(begin, end);
        }) {}
  void operator()(std::size_t begin, std::size_t end) const { call_(body_, begin, end); }

 private:
  const void* body_;
  void (*call_)(const void*, std::size_t, std::size_t);
};

// Calls body(begin, end) for the ranges [0, grain), [grain, 2 grain) ... of [0, n), in order with
// one thread and in any order with more. The ranges do not depend on the number of threads.
void parallel_for_blocks(int threads, std::size_t n, std::size_t grain, RangeFunction body,
                         TaskAffinity* shares = nullptr);

// Number of consecutive ranges for a task, so that it can prefetch the data of its next range,
// which no other thread uses. Small enough that every thread has several tasks, which balances the
// load.
inline std::size_t blocks_per_task(int threads, std::size_t ranges) {
  constexpr std::size_t kTasks = 16, kMany = 8;
  if (threads <= 1) return std::max<std::size_t>(ranges, 1);
  return std::clamp<std::size_t>(ranges / (kTasks * static_cast<std::size_t>(threads)), 1, kMany);
}

// A numbered element for sorting.
struct KeyIndex {
  std::uint64_t key;
  std::int32_t number;
  auto operator<=>(const KeyIndex&) const = default;
};
// Sorts by key, then number. No two may be equal in both, so that there is one order only.
void sort_by_key(int threads, std::vector<KeyIndex>& list);

}  // namespace firn
