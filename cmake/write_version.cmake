# Run at every build (cmake -P): writes OUTPUT, and touches it only when the answer changed.
# Takes SOURCE_DIR, VERSION, BUILD_FACTS (a file), OUTPUT.
execute_process(COMMAND git --no-optional-locks -c safe.directory=* -C ${SOURCE_DIR} describe --always --dirty --abbrev=12 --exclude=*
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(commit unknown)
endif()

# What decides the numbers; not the commit, which documentation and other folders change as well.
file(GLOB sources RELATIVE ${SOURCE_DIR} ${SOURCE_DIR}/solver/*.cpp ${SOURCE_DIR}/solver/*.h
  ${SOURCE_DIR}/solver/CMakeLists.txt ${SOURCE_DIR}/experiments/*.cpp ${SOURCE_DIR}/experiments/*.h
  ${SOURCE_DIR}/experiments/machine/*.cpp ${SOURCE_DIR}/experiments/machine/*.h)
list(SORT sources)
file(SHA256 ${BUILD_FACTS} program)
foreach(source IN LISTS sources)
  file(SHA256 ${SOURCE_DIR}/${source} hash)
  string(APPEND program " ${source} ${hash}")
endforeach()
string(SHA256 program "${program}")
string(SUBSTRING ${program} 0 16 program)

set(text "#include \"experiments/version.h\"

namespace firn {

const char* firn_version() { return \"${VERSION}\"; }
const char* firn_git_commit() { return \"${commit}\"; }
const char* firn_program() { return \"${program}\"; }

}  // namespace firn
")
set(old "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} old)
endif()
if(NOT text STREQUAL old)
  file(WRITE ${OUTPUT} "${text}")
endif()
