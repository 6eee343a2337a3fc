# Run at every build (cmake -P): writes OUTPUT, and touches it only when the answer changed.
# Takes SOURCE_DIR, VERSION, OUTPUT.
execute_process(COMMAND git --no-optional-locks -c safe.directory=* -C ${SOURCE_DIR} describe --always --dirty --abbrev=12 --exclude=*
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(commit unknown)
endif()
set(text "#include \"experiments/version.h\"

namespace firn {

const char* firn_version() { return \"${VERSION}\"; }
const char* firn_git_commit() { return \"${commit}\"; }

}  // namespace firn
")
set(old "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} old)
endif()
if(NOT text STREQUAL old)
  file(WRITE ${OUTPUT} "${text}")
endif()
