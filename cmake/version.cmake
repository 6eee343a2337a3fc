# firn_version: a library of two strings, the project's version and the commit it is built from.
set(version_source ${PROJECT_BINARY_DIR}/generated/version.cpp)
add_custom_target(firn_version_source
  COMMAND ${CMAKE_COMMAND} -DSOURCE_DIR=${PROJECT_SOURCE_DIR} -DVERSION=${PROJECT_VERSION}
          -DOUTPUT=${version_source} -P ${PROJECT_SOURCE_DIR}/cmake/write_version.cmake
  BYPRODUCTS ${version_source})
add_library(firn_version STATIC ${version_source})
target_include_directories(firn_version PRIVATE ${PROJECT_SOURCE_DIR})
target_link_libraries(firn_version PRIVATE firn_flags)
add_dependencies(firn_version firn_version_source)
