// Parts of the module firn._core.
#pragma once

#include <pybind11/pybind11.h>

namespace firn::python {

void bind_case(pybind11::module_& m);
void bind_run(pybind11::module_& m);
void bind_results(pybind11::module_& m);
void bind_calibration(pybind11::module_& m);

// False after Ctrl-C: throws KeyboardInterrupt. Takes the lock of the interpreter.
bool check_signals();

}  // namespace firn::python
