#include "experiments/text/alias.h"

#include <fmt/format.h>

#include <mutex>
#include <set>

#include "experiments/system/terminal.h"

namespace firn {

std::string old_name_warning(std::string_view old_name, std::string_view name) {
  return fmt::format("\"{}\" is now \"{}\"; the old name is read by this version only", old_name,
                     name);
}

void warn_of_old_name(const std::string& place, const OldNameUse& use) {
  const std::string where = use.path.empty() ? place : fmt::format("{}: {}", place, use.path);
  const std::string line =
      fmt::format("firn: warning: {}: {}\n", where, old_name_warning(use.old_name, use.name));
  static std::mutex mutex;
  static std::set<std::string> printed;
  constexpr std::size_t kMost = 1000;
  const std::lock_guard lock(mutex);
  if (printed.size() < kMost && printed.insert(line).second) print_lines(stderr, "{}", line);
}

}  // namespace firn
