// Options that several commands have, and their help texts.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "app/support/default_threads.h"

namespace firn {

inline constexpr const char* json_help = "Print JSON on standard output and nothing else";
inline constexpr const char* database_help =
    "File of your own material records; by default\n"
    "$FIRN_MATERIALS, else firn/materials.db in $XDG_DATA_HOME\n"
    "or ~/.local/share";
inline constexpr const char* quiet_help = "Print results, warnings and errors only";

inline constexpr const char* settings_help =
    "Override a value of the case by its TOML path, as for\n`firn run` (may be repeated)";

// --set KEY=VALUE. One value behind each --set: what follows is another argument.
inline CLI::Option* add_settings_option(CLI::App& command, std::vector<std::string>& settings,
                                        const char* help = settings_help) {
  return command.add_option("--set", settings, help)
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

// --threads N
inline CLI::Option* add_threads_option(CLI::App& command, int& threads) {
  return command
      .add_option("--threads", threads,
                  fmt::format("Threads of the simulation, 1 to 1024; {} by default.\nThe results "
                              "do not depend on it",
                              default_threads()))
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
}

}  // namespace firn
