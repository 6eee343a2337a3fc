// Range of the options that count.
#pragma once

#include <cstdint>

namespace firn {

// CLI11 reads a number beyond the range of its type as the largest one of the type. A bound below
// that refuses it.
inline constexpr std::int64_t kLargestCount = 9'000'000'000'000'000'000;

}  // namespace firn
