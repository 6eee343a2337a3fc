// Files of reports/assets/ and libraries for pages, compiled in (cmake/embed_files.cmake).
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace firn {

// File name and text of each.
std::span<const std::pair<std::string_view, std::string_view>> embedded_assets();

// The text of a file by its name without folder. Throws std::logic_error for another name.
std::string_view asset(std::string_view name);

}  // namespace firn
