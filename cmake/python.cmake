# The Python package, where pybind11 and Python's headers are installed (scripts/packages.txt, [python]).
option(FIRN_PYTHON "build the Python package, where pybind11 is installed" ON)
if(FIRN_PYTHON)
  # That of the system, unless another one is given: it has the packages of [python], and the Debian
  # package is for it.
  if(NOT DEFINED Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
    set(Python3_EXECUTABLE /usr/bin/python3 CACHE FILEPATH "Python that the package is for")
  endif()
  find_package(Python3 QUIET COMPONENTS Interpreter Development.Module)
  find_package(pybind11 2.10 QUIET)
endif()
set(FIRN_HAS_PYTHON OFF)
if(FIRN_PYTHON AND pybind11_FOUND AND NOT FIRN_SANITIZE AND NOT FIRN_FUZZ)
  set(FIRN_HAS_PYTHON ON)
  add_subdirectory(python)
endif()
