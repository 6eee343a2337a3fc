// The files of data/materials/, embedded in the program (cmake/embed_files.cmake).
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace firn {

// Name and text of each file.
std::span<const std::pair<std::string_view, std::string_view>> embedded_materials();

}  // namespace firn
