#pragma once

namespace firn::proof {

// Identifies the sources that determine the outcome of a coverage study: 12 hex digits
// (write_engine.cmake; the sources are listed in CMakeLists.txt).
const char* coverage_engine();

}  // namespace firn::proof
