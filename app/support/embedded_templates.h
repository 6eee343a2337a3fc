// The files of cases/templates/, compiled in (cmake/embed_files.cmake).
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace firn {

// "TEMPLATE/FILE" and text of each.
std::span<const std::pair<std::string_view, std::string_view>> embedded_templates();

}  // namespace firn
