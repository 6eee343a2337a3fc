// Appends formatted text to a buffer, for tables and scripts.
#pragma once

#include <fmt/format.h>

#include <iterator>
#include <string>
#include <utility>

namespace firn {

template <class... Args>
void print(fmt::memory_buffer& out, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(out), format, std::forward<Args>(args)...);
}

// The unit as files for programs have it: "1" for a dimensionless number.
inline std::string stored_unit(const std::string& unit) { return unit.empty() ? "1" : unit; }

}  // namespace firn
