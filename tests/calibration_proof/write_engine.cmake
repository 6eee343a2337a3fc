# Writes OUTPUT, a C++ source with coverage_engine(): a hash over SOURCES (names of files, separated by
# commas). Names of files, #include lines, comments and the layout of lines play no part.
string(REPLACE "," ";" sources "${SOURCES}")
list(LENGTH sources count)
if(count LESS 60)
  message(FATAL_ERROR "write_engine.cmake got ${count} sources, expected at least 60: was calibrate/ moved? "
    "Studies of other engines would count as those of the present one.")
endif()
set(hashes "")
foreach(source IN LISTS sources)
  file(READ ${source} text)
  string(REGEX REPLACE "\n *# *include[^\n]*" "" text "\n${text}")
  # What follows a quote stays: it may be code behind a string that holds two slashes.
  string(REGEX REPLACE "[ \n]//[^\n\"]*" "" text "${text}")
  string(REGEX REPLACE "[ \n]+" " " text "${text}")
  string(SHA256 hash "${text}")
  list(APPEND hashes ${hash})
endforeach()
list(SORT hashes)
string(SHA256 engine "${hashes}")
string(SUBSTRING ${engine} 0 12 engine)
file(WRITE ${OUTPUT} "#include \"tests/calibration_proof/coverage_engine.h\"

namespace firn::proof {

const char* coverage_engine() { return \"${engine}\"; }

}  // namespace firn::proof
")
