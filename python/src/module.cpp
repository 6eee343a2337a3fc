#include "firn/math.h"
#include "python/src/bindings.h"

namespace py = pybind11;

namespace firn::python {

bool check_signals() {
  const py::gil_scoped_acquire lock;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  return true;
}

}  // namespace firn::python

PYBIND11_MODULE(_core, m) {
  m.doc() = "Compiled part of the package firn.";
  py::register_exception<firn::InputError>(m, "InputError", PyExc_ValueError);
  py::register_exception<firn::RunError>(m, "RunError", PyExc_RuntimeError);
  firn::python::bind_case(m);
  firn::python::bind_run(m);
  firn::python::bind_results(m);
  firn::python::bind_calibration(m);
}
