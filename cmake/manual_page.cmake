# Writes PAGE, the manual page NAME of `FIRN COMMAND`, by HELP2MAN. What the help text says above its
# usage becomes the line that apropos and whatis search. COMMAND is empty for the program itself.
set(words ${FIRN})
set(call "${FIRN}")
if(COMMAND)
  list(APPEND words ${COMMAND})
  string(APPEND call " ${COMMAND}")
endif()
execute_process(COMMAND ${words} --help OUTPUT_VARIABLE help RESULT_VARIABLE status)
string(REGEX MATCH "^(.*)\nUsage:" matched "${help}")
string(REGEX REPLACE "[ \n]+" " " description "${CMAKE_MATCH_1}")
string(STRIP "${description}" description)
string(REGEX REPLACE "\\.$" "" description "${description}")
if(NOT status EQUAL 0 OR description STREQUAL "")
  message(FATAL_ERROR "${call} --help: no description above its usage")
endif()
# Not by --name of help2man: it writes "firn run", which is no name of a page.
file(WRITE ${PAGE}.name "[NAME]\n${NAME} \\- ${description}\n")
execute_process(COMMAND ${HELP2MAN} --no-info --no-discard-stderr --include=${PAGE}.name
  "--version-string=firn ${VERSION}" --output=${PAGE} "${call}" RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${HELP2MAN}: no manual page of ${call}")
endif()
