# firn_unity(TARGET [TOP] [JOIN FOLDER...]): compiles the sources of a folder as one unit; with TOP, those
# of a folder of the library with all folders in it. Folders after JOIN become one unit together; "."
# is the library's own. Most of the time of a build goes to the headers of the standard
# library, Eigen, fmt, nlohmann_json and CLI11; a unit parses and instantiates them once. Names in
# anonymous namespaces are therefore unique within a unit. The preset `tidy` compiles each source
# alone, which finds missing #include lines. Sources with special compile options stay alone.
option(FIRN_UNITY_BUILD "compile each folder as one unit, for a shorter fresh build" ON)
function(firn_unity target)
  cmake_parse_arguments(PARSE_ARGV 1 unity TOP "" JOIN)
  if(NOT FIRN_UNITY_BUILD)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    get_filename_component(folder ${source} DIRECTORY)
    get_filename_component(folder ${folder} ABSOLUTE)
    file(RELATIVE_PATH folder ${CMAKE_CURRENT_SOURCE_DIR} ${folder})
    if(folder MATCHES "^[.][.]")  # generated
      continue()
    endif()
    if(unity_TOP)
      string(REGEX REPLACE "/.*" "" folder "${folder}")
    endif()
    if("${folder}" STREQUAL "")
      set(folder .)
    endif()
    if(folder IN_LIST unity_JOIN)
      set(folder joined)
    endif()
    string(MAKE_C_IDENTIFIER "${folder}" group)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP "folder_${group}")
  endforeach()
endfunction()

# firn_quick_build(TARGET [LEVEL]): for tests and for targets that read, write and arrange. With -O1 they
# take a fifth less time to compile. With -Og, for what only reads and prints, they take a seventh less
# again; `firn verify` takes twice as long with it. What computes is in the solver and in inference and
# numerics of calibrate; no number depends on it.
function(firn_quick_build target)
  set(level -O1)
  if(ARGC GREATER 1)
    set(level ${ARGV1})
  endif()
  # GCC 12 then sees writes beyond the ends of short std::strings that do not happen.
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:${level}>
    $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds> $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow>)
endfunction()
