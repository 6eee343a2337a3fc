# The libraries are linked into programs and into the Python module alike: position-independent code.
# Hidden symbols keep calls between their units direct, and out of the way of other libraries.
foreach(library firn_solver firn_avx2 firn_experiments firn_calibrate firn_calibrate_numerics firn_version
    firn_experiments_library firn_calibrate_library)
  if(TARGET ${library})
    set_target_properties(${library} PROPERTIES POSITION_INDEPENDENT_CODE ON
      CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  endif()
endforeach()
