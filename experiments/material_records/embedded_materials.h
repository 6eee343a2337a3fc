// The files of data/materials/, compiled in (cmake/embed_files.cmake).
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace firn {

// File name and text of each.
std::span<const std::pair<std::string_view, std::string_view>> embedded_materials();

}  // namespace firn
