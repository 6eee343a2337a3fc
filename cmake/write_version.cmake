# Run at every build (cmake -P): writes OUTPUT, and touches it only when the answer changed.
# Takes SOURCE_DIR, VERSION, BUILD_FACTS (a file), OUTPUT.
execute_process(COMMAND git --no-optional-locks -c safe.directory=* -C ${SOURCE_DIR} describe --always --dirty --abbrev=12 --exclude=*
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(commit unknown)
endif()

# The identity covers the folders whose code decides the numbers of a run. The commit is no part of it,
# because documentation and other folders change it as well. experiments/batch starts runs and stores
# their answers; it computes none. The identity depends on contents only: a file that moves keeps it.
file(GLOB_RECURSE sources ${SOURCE_DIR}/solver/*.cpp ${SOURCE_DIR}/solver/*.h ${SOURCE_DIR}/solver/CMakeLists.txt
  ${SOURCE_DIR}/experiments/*.cpp ${SOURCE_DIR}/experiments/*.h)
list(FILTER sources EXCLUDE REGEX "/experiments/batch/")
list(LENGTH sources count)
if(count LESS 100)
  message(FATAL_ERROR "write_version.cmake found ${count} sources under ${SOURCE_DIR}, expected at least 100: "
    "were solver/ or experiments/ moved? Stores would serve results of other solvers as current ones.")
endif()
set(hashes "")
foreach(source IN LISTS sources)
  file(SHA256 ${source} hash)
  list(APPEND hashes ${hash})
endforeach()
list(SORT hashes)
file(SHA256 ${BUILD_FACTS} program)
string(APPEND program " ${hashes}")
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
