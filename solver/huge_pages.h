// Large arrays in large pages.
#pragma once

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <cstdint>
#include <vector>

namespace firn {

// Room for n elements, and for `spare` more where it has to grow. An array that fills pages of 2 MB
// is asked for in such: a step walks through all of it, and looking up thousands of small pages
// would cost more than the walk.
template <class T>
void reserve_large(std::vector<T>& v, std::size_t n, std::size_t spare) {
  if (n <= v.capacity()) return;
  v.reserve(n + spare);
#ifdef __linux__
  constexpr std::uintptr_t kPage = std::uintptr_t{2} << 20;
  auto* const begin = reinterpret_cast<char*>(v.data());
  const auto before = static_cast<std::size_t>(-reinterpret_cast<std::uintptr_t>(begin) % kPage);
  const std::size_t bytes = v.capacity() * sizeof(T);
  // A wish: where it is not granted, nothing is lost.
  if (before + kPage <= bytes)
    (void)madvise(begin + before, (bytes - before) / kPage * kPage, MADV_HUGEPAGE);
#endif
}

// For arrays that grow again and again.
template <class T>
void reserve_large(std::vector<T>& v, std::size_t n) {
  reserve_large(v, n, n / 8);
}

template <class T>
void resize_large(std::vector<T>& v, std::size_t n) {
  reserve_large(v, n);
  v.resize(n);
}

// For arrays whose elements are all written anew.
template <class T>
void resize_afresh(std::vector<T>& v, std::size_t n) {
  if (n > v.capacity()) v = {};  // nothing to take along
  resize_large(v, n);
}

}  // namespace firn
