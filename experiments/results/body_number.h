// Numbers of bodies in a results file.
#pragma once

#include <cstddef>
#include <cstdint>

namespace firn {

// From a body of the solver (particles first, then boundaries) to a body in a file: the id of a
// particle, or -1 - the index of a boundary in order of the case.
inline std::int32_t number_of_body(std::int32_t body, std::size_t particles) {
  const auto n = static_cast<std::int32_t>(particles);
  return body < n ? body : n - 1 - body;
}

}  // namespace firn
