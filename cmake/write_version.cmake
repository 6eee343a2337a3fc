# Run at every build (cmake -P): writes OUTPUT, and touches it only when the answer changed.
# Takes SOURCE_DIR, VERSION, BUILD_FACTS (a file), OUTPUT; LIST (a file) if its sources are asked for.
execute_process(COMMAND git --no-optional-locks -c safe.directory=* -C ${SOURCE_DIR} describe --always --dirty --abbrev=12 --exclude=*
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(commit unknown)
endif()

# The identity covers the folders whose code decides the numbers of a run. The commit is no part of it,
# because documentation and other folders change it as well. experiments/batch starts runs and stores
# their responses; it computes none. Names of files, comments and the layout of lines play no part:
# a file that moves keeps the identity. Of an #include, the code of the included file counts.
file(GLOB_RECURSE sources ${SOURCE_DIR}/solver/*.cpp ${SOURCE_DIR}/solver/*.h
  ${SOURCE_DIR}/experiments/*.cpp ${SOURCE_DIR}/experiments/*.h)
# Neither do processes, and what evaluates or displays the responses of finished runs.
list(FILTER sources EXCLUDE REGEX
  "/experiments/(batch/|system/process[.]|responses/response_(expression|order)[.]|analysis/(power_law|elementary_effects)[.])")
if(DEFINED LIST)  # of the files that take part
  file(WRITE ${LIST} "${sources}")
endif()
list(LENGTH sources count)
if(count LESS 100)
  message(FATAL_ERROR "write_version.cmake found ${count} sources under ${SOURCE_DIR}, expected at least 100: "
    "were solver/ or experiments/ moved? Stores would serve results of other solvers as current ones.")
endif()
foreach(source IN LISTS sources)
  file(READ ${source} text)
  string(REGEX MATCHALL "\n *# *include *\"[^\"]+" included "\n${text}")
  string(REGEX REPLACE "\n *# *include *\"[^\n]*" "" text "\n${text}")
  # What follows a quote stays: it may be code behind a string that holds two slashes.
  string(REGEX REPLACE "[ \n]//[^\n\"]*" "" text "${text}")
  string(REGEX REPLACE "[ \n]+" " " text "${text}")
  string(SHA256 code_${source} "${text}")
  set(included_${source} "${included}")
endforeach()
set(hashes "")
foreach(source IN LISTS sources)
  set(code_of_includes "")
  foreach(include IN LISTS included_${source})
    string(REGEX REPLACE "^[^\"]*\"" "" include "${include}")
    if(DEFINED code_${SOURCE_DIR}/${include})
      list(APPEND code_of_includes ${code_${SOURCE_DIR}/${include}})
    elseif(DEFINED code_${SOURCE_DIR}/solver/include/${include})
      list(APPEND code_of_includes ${code_${SOURCE_DIR}/solver/include/${include}})
    elseif(NOT EXISTS ${SOURCE_DIR}/${include})
      message(FATAL_ERROR "write_version.cmake: ${source} includes ${include}, which is not among the sources")
    endif()
  endforeach()
  list(SORT code_of_includes)
  string(SHA256 hash "${code_${source}} ${code_of_includes}")
  list(APPEND hashes ${hash})
endforeach()
list(SORT hashes)
# Options of the compiler in it count, names of files and folders do not.
file(READ ${SOURCE_DIR}/solver/CMakeLists.txt text)
string(REGEX REPLACE "#[^\n]*" "" text "${text}")
string(REGEX REPLACE "[^ \n()]+\\.(cpp|h|o)|[$]{PROJECT_SOURCE_DIR}[^ \n()]*" "" text "${text}")
string(REGEX REPLACE "[ \n]+" " " text "${text}")
string(SHA256 hash "${text}")
list(APPEND hashes ${hash})
file(SHA256 ${BUILD_FACTS} program)
string(APPEND program " ${hashes}")
string(SHA256 program "${program}")
string(SUBSTRING ${program} 0 16 program)

set(text "#include \"experiments/storage/version.h\"

namespace firn {

const char* firn_version() { return \"${VERSION}\"; }
const char* firn_git_commit() { return \"${commit}\"; }
const char* program_identity() { return \"${program}\"; }

}  // namespace firn
")
set(old "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} old)
endif()
if(NOT text STREQUAL old)
  file(WRITE ${OUTPUT} "${text}")
endif()
