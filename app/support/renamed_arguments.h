// Commands and options that have been renamed. Old names are read for one version, with a warning.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace firn {

struct RenamedArgument {
  std::string_view command;         // current name; empty: the command itself is renamed
  std::string_view old_name, name;  // "hashes", "--top", or an option with its value "--top 3"
};
std::span<const RenamedArgument> renamed_arguments();

// The arguments of the program, without its own name, in current names. Reports each rename once,
// in the order of the arguments.
std::vector<std::string> current_arguments(
    std::vector<std::string> arguments, const std::function<void(const RenamedArgument&)>& report);

}  // namespace firn
