// Work shared out between threads.
#pragma once

#include <cstddef>
#include <functional>

namespace firn {

// Calls body(begin, end) for the ranges [0, grain), [grain, 2 grain) ... of [0, n), in order with
// one thread and in any order with more. The ranges do not depend on the number of threads.
void for_ranges(int threads, std::size_t n, std::size_t grain,
                const std::function<void(std::size_t, std::size_t)>& body);

}  // namespace firn
