// Arrays in huge pages, for data that every step reads.
#pragma once

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <algorithm>
#include <cstddef>
#include <new>
#include <vector>

namespace firn {

// Allocates arrays in pages of 2 MB if the array fills at least a quarter of each page. With small
// pages, address translation would cost more than reading the array. Results do not depend on the
// page size.
template <class T>
struct HugePageAllocator {
  using value_type = T;

  HugePageAllocator() = default;
  template <class U>
  HugePageAllocator(const HugePageAllocator<U>& /*other*/) {}

  T* allocate(std::size_t n) {
    const std::size_t bytes = n * sizeof(T), large = in_large_pages(bytes);
    void* const memory = ::operator new(std::max(bytes, large), alignment(large));
#ifdef __linux__
    if (large > 0) (void)madvise(memory, large, MADV_HUGEPAGE);
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t n) noexcept {
    ::operator delete(memory, alignment(in_large_pages(n * sizeof(T))));
  }
  friend bool operator==(const HugePageAllocator& /*a*/, const HugePageAllocator& /*b*/) {
    return true;
  }

 private:
  static constexpr std::size_t kPage = std::size_t{2} << 20;
  static std::size_t in_large_pages(std::size_t bytes) {
    return (bytes + 3 * kPage / 4) / kPage * kPage;
  }
  static std::align_val_t alignment(std::size_t large) {
    return std::align_val_t{large > 0 ? kPage : alignof(T)};
  }
};

template <class T>
using HugePageVector = std::vector<T, HugePageAllocator<T>>;

// Resizes an array without copying elements: the caller overwrites all of them. For arrays that
// grow repeatedly.
template <class T>
void resize_discarding(HugePageVector<T>& v, std::size_t n) {
  if (n > v.capacity()) {
    v = {};  // no elements to copy
    v.reserve(n + n / 8);
  }
  v.resize(n);
}

}  // namespace firn
