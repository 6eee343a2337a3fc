// Software prefetch of data that will be read soon.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace firn {

// Cache level. The first-level cache has few outstanding loads: a prefetch of scattered lines from
// memory into it has half the throughput of one into the second-level cache. Use it for data that
// is read within a microsecond.
enum class Cache { first, second };

// Prefetches every cache line of these bytes. Always inlined: the compiler removes calls of
// functions that only prefetch, because it sees no effect.
template <Cache cache = Cache::second>
[[gnu::always_inline]] inline void prefetch_bytes(const void* from, std::size_t bytes,
                                                  std::size_t alignment = 8) {
  constexpr std::size_t kLine = 64;
  // An integer, because pointer arithmetic on the null pointer of an empty array is undefined.
  const auto at = reinterpret_cast<std::uintptr_t>(from);
  const auto get = [&](std::size_t k) __attribute__((always_inline)) {
    // NOLINTNEXTLINE(performance-no-int-to-ptr): nothing is read through it.
    __builtin_prefetch(reinterpret_cast<const void*>(at + k), 0, cache == Cache::first ? 3 : 2);
  };
  for (std::size_t k = 0; k < bytes; k += kLine) get(k);
  const std::size_t rest = (bytes - 1) % kLine;  // from the last prefetched address to the end
  if (rest >= std::min(alignment, kLine)) get(bytes - 1);
}
template <Cache cache = Cache::second, class T>
[[gnu::always_inline]] inline void prefetch(const T* from, std::size_t count = 1) {
  prefetch_bytes<cache>(from, count * sizeof(T), alignof(T));
}

}  // namespace firn
