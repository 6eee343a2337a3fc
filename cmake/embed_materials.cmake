# Writes OUTPUT, a C++ source that holds the texts of FILES (a list, separated by commas).
string(REPLACE "," ";" files "${FILES}")
set(entries "")
foreach(file ${files})
  get_filename_component(name ${file} NAME)
  file(READ ${file} text)
  string(APPEND entries "    {\"experiments/materials/${name}\", R\"json(${text})json\"},\n")
endforeach()
file(WRITE ${OUTPUT} "// Made by cmake/embed_materials.cmake.
#include \"experiments/embedded_materials.h\"

namespace firn {
namespace {

constexpr std::pair<std::string_view, std::string_view> files[] = {
${entries}};

}  // namespace

std::span<const std::pair<std::string_view, std::string_view>> embedded_materials() {
  return files;
}

}  // namespace firn
")
