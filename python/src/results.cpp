#include "firn/experiments/results.h"

#include <pybind11/stl.h>

#include "python/src/arrays.h"
#include "python/src/bindings.h"

namespace firn::python {
namespace {

using experiments::Frame;
using experiments::Particles;
using experiments::Results;

// NumPy arrays of a frame, made once: they own the data of the frame.
struct FrameArrays {
  explicit FrameArrays(Frame f)
      : time(f.time),
        position(array_of(std::move(f.position))),
        orientation(array_of(std::move(f.orientation))),
        velocity(array_of(std::move(f.velocity))),
        angular_velocity(array_of(std::move(f.angular_velocity))) {}
  double time;
  py::array_t<double> position, orientation, velocity, angular_velocity;
};

py::dict particle_columns(const Results& results) {
  Particles p = results.particles();
  py::dict columns;
  columns["shape"] = array_of(std::move(p.shape));
  columns["tag"] = array_of(std::move(p.tag));
  columns["mass"] = array_of(std::move(p.mass));
  columns["insert_time"] = array_of(std::move(p.insert_time));
  columns["exit_time"] = array_of(std::move(p.exit_time));
  columns["peak_normal_force"] = array_of(std::move(p.peak_normal_force));
  return columns;
}

// Path, unit and width of each.
py::list list_of(const std::vector<experiments::Series>& series) {
  py::list all;
  for (const experiments::Series& s : series) all.append(py::make_tuple(s.path, s.unit, s.width));
  return all;
}

}  // namespace

void bind_results(py::module_& m) {
  py::class_<FrameArrays>(m, "Frame", "One recorded state; arrays have one row a particle.")
      .def_readonly("time", &FrameArrays::time)
      .def_readonly("position", &FrameArrays::position)
      .def_readonly("orientation", &FrameArrays::orientation)
      .def_readonly("velocity", &FrameArrays::velocity)
      .def_readonly("angular_velocity", &FrameArrays::angular_velocity);

  py::class_<Results>(m, "CoreResults")
      .def(py::init<const std::string&>(), py::arg("file"))
      .def_property_readonly("file", &Results::file)
      .def_property_readonly("status", &Results::status)
      .def_property_readonly("program", &Results::program)
      .def_property_readonly("seed", &Results::seed)
      .def_property_readonly("timestep", &Results::timestep)
      .def_property_readonly("wall_time", &Results::wall_time)
      .def_property_readonly("case_text", &Results::case_text)
      .def_property_readonly("shapes", &Results::shapes)
      .def_property_readonly("boundaries", &Results::boundaries)
      .def_property_readonly("particle_count", &Results::particle_count)
      .def("particle_columns", &particle_columns)
      .def("times", [](const Results& r) { return array_of(r.times()); })
      .def(
          "frame", [](const Results& r, std::size_t index) { return FrameArrays(r.frame(index)); },
          py::arg("index"))
      .def("stages",
           [](const Results& r) {
             py::list all;
             for (const experiments::Stage& s : r.stages())
               all.append(py::make_tuple(s.name, s.start, s.end, s.end_reason));
             return all;
           })
      .def("responses", &Results::responses)
      .def("measure", &Results::measure)
      .def("series_list", [](const Results& r) { return list_of(r.series()); })
      .def(
          "series",
          [](const Results& r, const std::string& path) -> py::array {
            for (const experiments::Series& s : r.series())
              if (s.path == path && s.width > 1) return table_of(r.series(path), s.width);
            std::vector<double> values = r.series(path);
            const std::size_t frames = r.times().size();
            // Under an earlier name, which the list lacks.
            if (frames > 0 && values.size() > frames)
              return table_of(std::move(values), values.size() / frames);
            return array_of(std::move(values));
          },
          py::arg("path"))
      .def("sample_times", [](const Results& r) { return array_of(r.sample_times()); })
      .def("sample_list", [](const Results& r) { return list_of(r.samples()); })
      .def(
          "samples",
          [](const Results& r, const std::string& path) -> py::array {
            std::vector<double> values = r.samples(path);
            for (const experiments::Series& s : r.samples())
              if (s.path == path && s.width > 1) return table_of(std::move(values), s.width);
            return array_of(std::move(values));
          },
          py::arg("path"));
  m.def("current_results_json", &experiments::current_results_json, py::arg("text"));
}

}  // namespace firn::python
