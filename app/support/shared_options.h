// Help texts of options that several commands have.
#pragma once

#include <fmt/format.h>

#include <string>

#include "app/support/default_threads.h"

namespace firn {

inline constexpr const char* json_help = "Print JSON on standard output and nothing else";
inline constexpr const char* database_help =
    "File of your own material records; by default\n"
    "$FIRN_MATERIALS, else firn/materials.db in $XDG_DATA_HOME\n"
    "or ~/.local/share";
inline constexpr const char* quiet_help = "Print results, warnings and errors only";

inline std::string threads_help() {
  return fmt::format(
      "Threads of the simulation, 1 to 1024; {} by default.\nThe results do not depend on it",
      default_threads());
}

}  // namespace firn
