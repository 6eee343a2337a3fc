# firn_unity(TARGET): compiles the sources of a folder as one unit. Most of the time of a build goes to
# the headers of the standard library, Eigen, fmt, nlohmann_json and CLI11; a unit parses and
# instantiates them once. Names in anonymous namespaces are therefore unique within a folder. The solver
# and the preset `tidy` compile each source alone, which finds missing #include lines.
option(FIRN_UNITY_BUILD "compile each folder as one unit, for a shorter fresh build" ON)
function(firn_unity target)
  if(NOT FIRN_UNITY_BUILD)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    get_filename_component(folder ${source} DIRECTORY)
    file(RELATIVE_PATH folder ${CMAKE_CURRENT_SOURCE_DIR} ${folder})
    # Generated sources lie outside of the folder of the target. Verification cases and
    # commands have the same short local names in each file.
    if(NOT folder MATCHES "^[.][.]|^verification|^commands")
      string(MAKE_C_IDENTIFIER "${folder}" group)
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP "folder_${group}")
    endif()
  endforeach()
endfunction()
