# The public library: cmake --install BUILD --component library. Headers, static libraries, and
# FirnConfig.cmake for find_package(Firn).
include(CMakePackageConfigHelpers)
set(firn_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Firn)
get_target_property(FIRN_INTERFACE_DEFINITIONS firn_flags INTERFACE_COMPILE_DEFINITIONS)
configure_package_config_file(cmake/FirnConfig.cmake.in ${PROJECT_BINARY_DIR}/FirnConfig.cmake
  INSTALL_DESTINATION ${firn_package_dir} PATH_VARS CMAKE_INSTALL_LIBDIR CMAKE_INSTALL_INCLUDEDIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/FirnConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/FirnConfig.cmake ${PROJECT_BINARY_DIR}/FirnConfigVersion.cmake
  DESTINATION ${firn_package_dir} COMPONENT library)
install(TARGETS firn_solver firn_version firn_experiments firn_experiments_library firn_calibrate firn_calibrate_library
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
install(DIRECTORY solver/include/firn library/include/firn DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  COMPONENT library FILES_MATCHING PATTERN "*.h")
install(DIRECTORY examples/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples COMPONENT library)
