#include <pybind11/stl.h>

#include <memory>

#include "firn/calibrate/calibrate.h"
#include "firn/math.h"
#include "python/src/arrays.h"
#include "python/src/bindings.h"

namespace firn::python {
namespace {

using namespace calibration;

// {"name": value} or {"name": (value, "unit")}
std::vector<Response> responses_of(const py::object& returned) {
  if (!py::isinstance<py::dict>(returned))
    throw InputError("the simulator returned " +
                     py::repr(py::type::of(returned)).cast<std::string>() +
                     "; expected a dict of responses");
  std::vector<Response> responses;
  for (const auto& [name, value] : returned.cast<py::dict>()) {
    if (py::isinstance<py::tuple>(value)) {
      const auto pair = value.cast<std::pair<double, std::string>>();
      responses.push_back({name.cast<std::string>(), pair.first, pair.second});
    } else {
      responses.push_back({name.cast<std::string>(), value.cast<double>(), "1"});
    }
  }
  return responses;
}

std::vector<Response> call(const py::object& simulator, const std::map<std::string, double>& values,
                           std::uint64_t seed, const py::object& run_error) {
  const py::gil_scoped_acquire lock;
  try {
    return responses_of(simulator(values, seed));
  } catch (py::error_already_set& e) {
    if (!e.matches(run_error)) throw;
    throw RunError(py::str(e.value()).cast<std::string>());
  } catch (const py::cast_error&) {
    throw InputError(
        "the simulator returned a response that is not a number; expected a number, or a pair of a "
        "number and a unit");
  }
}

}  // namespace

void bind_calibration(py::module_& m) {
  py::class_<Parameter>(m, "CoreParameter")
      .def(py::init([](const std::string& name, double min, double max, const std::string& unit,
                       bool logarithmic, std::optional<double> prior_mean,
                       std::optional<double> prior_sd) {
        return Parameter{name, min, max, unit, logarithmic, prior_mean, prior_sd};
      }));
  py::class_<Target>(m, "CoreTarget")
      .def(py::init([](const std::string& response, double value, double uncertainty,
                       const std::string& unit, double discrepancy) {
        return Target{response, value, uncertainty, unit, discrepancy};
      }));
  py::class_<Result>(m, "CoreCalibration")
      .def_readonly("verdict", &Result::verdict)
      .def_readonly("headline", &Result::headline)
      .def_readonly("runs", &Result::runs)
      .def_readonly("table", &Result::table)
      .def_readonly("json", &Result::json)
      .def_property_readonly("estimates",
                             [](const Result& r) {
                               py::list all;
                               for (const Estimate& e : r.estimates)
                                 all.append(py::make_tuple(e.parameter, e.unit, e.best, e.median,
                                                           e.low, e.high, e.at_min, e.at_max));
                               return all;
                             })
      .def_property_readonly(
          "samples", [](const Result& r) { return table_of(r.samples, r.estimates.size()); })
      .def_property_readonly("weights", [](const Result& r) { return array_of(r.weights); });

  m.def("calibrate", [run_error = py::object(m.attr("RunError"))](
                         const std::string& name, const std::vector<Parameter>& parameters,
                         const std::vector<Target>& targets, int runs, std::uint64_t seed,
                         const py::object& simulator, const std::string& directory,
                         const std::string& simulator_version, int jobs) {
    Problem problem;
    problem.name = name;
    problem.parameters = parameters;
    problem.targets = targets;
    problem.runs = runs;
    problem.seed = seed;
    Options options;
    options.directory = directory;
    options.simulator_version = simulator_version;
    options.jobs = jobs;
    options.keep_going = check_signals;
    const Simulator simulate = [&](const std::map<std::string, double>& values,
                                   std::uint64_t run_seed) {
      return call(simulator, values, run_seed, run_error);
    };
    const py::gil_scoped_release unlocked;
    return calibrate(problem, simulate, options);
  });
}

}  // namespace firn::python
