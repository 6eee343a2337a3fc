# cmake --install, and packages by cpack -G DEB.
include(GNUInstallDirs)
install(TARGETS firn RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
# Where experiments/meshes/mesh_program.cpp searches for them.
install(TARGETS firn-repair-mesh firn-unite-mesh RUNTIME DESTINATION libexec/firn)
install(FILES LICENSE README.md CHANGELOG.md CONTRIBUTING.md SECURITY.md CITATION.cff cmake/copyright
  DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY LICENSES DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs
  FILES_MATCHING PATTERN "*.md" PATTERN "*.png" PATTERN "*.svg")
install(FILES scripts/bash-completion DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME firn)
# Shipped cases, to be copied and run.
install(DIRECTORY cases/ DESTINATION ${CMAKE_INSTALL_DATADIR}/firn/cases
  FILES_MATCHING PATTERN "*.toml" PATTERN "README.md" PATTERN "*.py" PATTERN "*.jpg" PATTERN "in.*" PATTERN "templates" EXCLUDE)
install(DIRECTORY data/ DESTINATION ${CMAKE_INSTALL_DATADIR}/firn/data FILES_MATCHING PATTERN "*.json")
# Manual pages from the help texts, where help2man is there (scripts/packages.txt, [package]).
find_program(HELP2MAN help2man)
if(HELP2MAN)
  set(man_pages "")
  foreach(command "" new run measure calibrate shape export view sweep optimize validate report verify contacts
          compare-traces materials)
    set(name firn)
    if(command)
      set(name firn-${command})
    endif()
    set(page ${PROJECT_BINARY_DIR}/man/${name}.1)
    add_custom_command(OUTPUT ${page}
      COMMAND ${CMAKE_COMMAND} -DHELP2MAN=${HELP2MAN} -DFIRN=$<TARGET_FILE:firn> -DCOMMAND=${command} -DNAME=${name}
              -DVERSION=${PROJECT_VERSION} -DPAGE=${page} -P ${PROJECT_SOURCE_DIR}/cmake/manual_page.cmake
      DEPENDS firn ${PROJECT_SOURCE_DIR}/cmake/manual_page.cmake VERBATIM)
    list(APPEND man_pages ${page})
  endforeach()
  add_custom_target(man DEPENDS ${man_pages})
  install(FILES ${man_pages} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 OPTIONAL)
endif()

set(CPACK_PACKAGE_NAME firn)
set(CPACK_PACKAGE_VENDOR "The Firn maintainers")
set(CPACK_PACKAGE_CONTACT "The Firn maintainers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "calibration and validation of discrete element simulations of ice")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS gnuplot-nox)
# Of the Python package.
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-numpy, python3-pandas")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS chromium)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
include(CPack)
