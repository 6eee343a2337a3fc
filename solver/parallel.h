// Work shared out between threads.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace firn {

// Which thread has done which range of a loop. One that is walked through again and again is shared
// out alike each time, as far as nobody is late: every thread has its ranges at hand.
class Shares {
 public:
  Shares();
  ~Shares();
  Shares(Shares&&) noexcept;
  Shares& operator=(Shares&&) noexcept;
  struct Impl;
  Impl& operator*() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

// Calls body(begin, end) for the ranges [0, grain), [grain, 2 grain) ... of [0, n), in order with
// one thread and in any order with more. The ranges do not depend on the number of threads.
void for_ranges(int threads, std::size_t n, std::size_t grain,
                const std::function<void(std::size_t, std::size_t)>& body,
                Shares* shares = nullptr);

// Whether a thread mostly goes on with the range behind the one that it has done. If not, another
// one is at work there, and to fetch what that will need would take it away from it.
inline bool goes_on(int threads, std::size_t n, std::size_t grain) {
  constexpr std::size_t kMany = 16;  // ranges a thread
  return threads <= 1 || n / grain >= kMany * static_cast<std::size_t>(threads);
}

// Something numbered, to be put in order.
struct Keyed {
  std::uint64_t key;
  std::int32_t number;
  auto operator<=>(const Keyed&) const = default;
};
// Sorts by key, then number. No two may be equal in both, so that there is one order only.
void sort_by_key(int threads, std::vector<Keyed>& list);

}  // namespace firn
