# Writes OUTPUT, a C++ source with a function FUNCTION() that returns names and texts of FILES, and is
# declared in HEADER. FILES: NAME=PATH, separated by commas.
string(REPLACE "," ";" files "${FILES}")
set(entries "")
foreach(file ${files})
  string(REGEX MATCH "^([^=]+)=(.+)$" matched "${file}")
  set(name "${CMAKE_MATCH_1}")
  # Not as a list: semicolons and brackets stay as they are.
  file(READ "${CMAKE_MATCH_2}" text)
  string(APPEND entries "    {\"${name}\", R\"embedded(${text})embedded\"},\n")
endforeach()
file(WRITE ${OUTPUT} "// Made by cmake/embed_files.cmake.
#include \"${HEADER}\"

namespace firn {
namespace {

const std::pair<std::string_view, std::string_view> files[] = {
${entries}};

}  // namespace

std::span<const std::pair<std::string_view, std::string_view>> ${FUNCTION}() {
  return files;
}

}  // namespace firn
")
