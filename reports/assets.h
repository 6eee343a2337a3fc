// Files of reports/assets/ and libraries for pages, compiled in (cmake/embed_assets.cmake).
#pragma once

#include <string_view>

namespace firn {

// The text of a file by its name without folder. Throws std::logic_error for another name.
std::string_view asset(std::string_view name);

}  // namespace firn
