# firn_embed(OUTPUT_VARIABLE FUNCTION HEADER NAME=PATH...): a source that holds the texts of files,
# rebuilt when one of them changes. cmake/embed_files.cmake says what it declares.
function(firn_embed output function header)
  if(NOT ARGN)
    message(FATAL_ERROR "firn_embed(${function}): no files; were they moved?")
  endif()
  set(source ${PROJECT_BINARY_DIR}/generated/${function}.cpp)
  set(paths "")
  foreach(file ${ARGN})
    string(REGEX REPLACE "^[^=]+=" "" path "${file}")
    list(APPEND paths "${path}")
  endforeach()
  list(JOIN ARGN "," list)
  add_custom_command(OUTPUT ${source}
    COMMAND ${CMAKE_COMMAND} -DFILES=${list} -DOUTPUT=${source} -DFUNCTION=${function} -DHEADER=${header}
            -P ${PROJECT_SOURCE_DIR}/cmake/embed_files.cmake
    DEPENDS ${paths} ${PROJECT_SOURCE_DIR}/cmake/embed_files.cmake VERBATIM)
  set(${output} ${source} PARENT_SCOPE)
endfunction()
