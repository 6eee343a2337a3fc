#include "app/support/renamed_arguments.h"

#include <algorithm>

namespace firn {
namespace {

constexpr RenamedArgument kRenamedArguments[] = {
    {"", "hashes", "compare-traces"},
    {"compare-traces", "--top", "--limit"},
    {"contacts", "--top", "--limit"},
    {"export", "--parts", "--contact-shapes"},
    {"shape", "--repaired", "--repair-to"},
    {"calibrate", "--remark", "--note"},
    {"calibrate", "--store", "--cache"},
    {"calibrate", "--no-store", "--no-cache"},
    {"calibrate", "--progress people", "--progress text"},
    {"sweep", "--store", "--cache"},
    {"sweep", "--no-store", "--no-cache"},
    {"sweep", "--progress people", "--progress text"},
    {"validate", "--store", "--cache"},
    {"validate", "--no-store", "--no-cache"},
    {"validate", "--progress people", "--progress text"},
};

// An option alone, or with "=VALUE".
bool replace_option(std::string& argument, std::string_view from, std::string_view to) {
  if (!argument.starts_with(from)) return false;
  if (argument.size() > from.size() && argument[from.size()] != '=') return false;
  argument.replace(0, from.size(), to);
  return true;
}

// "--option value" in two arguments or as "--option=value".
bool replace_option_value(std::vector<std::string>& arguments, std::size_t i,
                          const RenamedArgument& renamed) {
  const std::size_t blank = renamed.old_name.find(' ');
  const std::string option(renamed.old_name.substr(0, blank));
  const std::string from(renamed.old_name.substr(blank + 1));
  const std::string to(renamed.name.substr(renamed.name.find(' ') + 1));
  if (arguments[i] == option + "=" + from) {
    arguments[i] = option + "=" + to;
    return true;
  }
  if (arguments[i] != option || i + 1 == arguments.size() || arguments[i + 1] != from) return false;
  arguments[i + 1] = to;
  return true;
}

}  // namespace

std::span<const RenamedArgument> renamed_arguments() { return kRenamedArguments; }

std::vector<std::string> current_arguments(
    std::vector<std::string> arguments, const std::function<void(const RenamedArgument&)>& report) {
  if (arguments.empty()) return arguments;
  for (const RenamedArgument& renamed : kRenamedArguments)
    if (renamed.command.empty() && arguments[0] == renamed.old_name) {
      arguments[0] = renamed.name;
      report(renamed);
    }
  std::vector<const RenamedArgument*> reported;
  for (std::size_t i = 1; i < arguments.size() && arguments[i] != "--"; ++i)
    for (const RenamedArgument& renamed : kRenamedArguments) {
      if (renamed.command.empty() || arguments[0] != renamed.command) continue;
      const bool with_value = renamed.old_name.find(' ') != std::string_view::npos;
      const bool replaced = with_value
                                ? replace_option_value(arguments, i, renamed)
                                : replace_option(arguments[i], renamed.old_name, renamed.name);
      if (!replaced) continue;
      if (std::ranges::find(reported, &renamed) == reported.end()) report(renamed);
      reported.push_back(&renamed);
    }
  return arguments;
}

}  // namespace firn
