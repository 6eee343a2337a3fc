# Writes OUTPUT, a C++ source that holds the texts of FILES (a list, separated by commas).
string(REPLACE "," ";" files "${FILES}")
set(entries "")
foreach(file ${files})
  get_filename_component(name ${file} NAME)
  # Not as a list: semicolons and brackets stay as they are.
  file(READ ${file} text)
  string(APPEND entries "    {\"${name}\", R\"asset(${text})asset\"},\n")
endforeach()
file(WRITE ${OUTPUT} "// Made by cmake/embed_assets.cmake.
#include \"reports/assets.h\"

#include <stdexcept>
#include <string>
#include <utility>

namespace firn {
namespace {

const std::pair<std::string_view, std::string_view> files[] = {
${entries}};

}  // namespace

std::string_view asset(std::string_view name) {
  for (const auto& [known, text] : files)
    if (known == name) return text;
  throw std::logic_error(\"no asset \" + std::string(name));
}

}  // namespace firn
")
