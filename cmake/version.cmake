# firn_version: a library of three strings: the project's version, the commit it is built from, and the
# identity of what decides the numbers of a run (experiments/storage/version.h).
set(version_source ${PROJECT_BINARY_DIR}/generated/version.cpp)
set(build_facts ${PROJECT_BINARY_DIR}/generated/build_facts.txt)
string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type)
file(GENERATE OUTPUT ${build_facts} CONTENT "${CMAKE_SYSTEM_PROCESSOR}
${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}
${CMAKE_CXX_STANDARD} ${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${build_type}}
$<TARGET_PROPERTY:firn_flags,INTERFACE_COMPILE_OPTIONS>
$<TARGET_PROPERTY:firn_flags,INTERFACE_COMPILE_DEFINITIONS>
${firn_solver_options} AVX2=${FIRN_AVX2}
Eigen ${Eigen3_VERSION} libccd ${CCD_VERSION} meshoptimizer ${meshoptimizer_VERSION} Simbody ${Simbody_VERSION}
")
add_custom_target(firn_version_source
  COMMAND ${CMAKE_COMMAND} -DSOURCE_DIR=${PROJECT_SOURCE_DIR} -DVERSION=${PROJECT_VERSION}
          -DBUILD_FACTS=${build_facts} -DOUTPUT=${version_source}
          -P ${PROJECT_SOURCE_DIR}/cmake/write_version.cmake
  BYPRODUCTS ${version_source})
add_library(firn_version STATIC ${version_source})
target_include_directories(firn_version PRIVATE ${PROJECT_SOURCE_DIR})
target_link_libraries(firn_version PRIVATE firn_flags)
add_dependencies(firn_version firn_version_source)
