#include "firn/experiments/case.h"

#include <pybind11/stl.h>

#include "firn/experiments/materials.h"
#include "python/src/arrays.h"
#include "python/src/bindings.h"

namespace firn::python {
namespace {

using experiments::Case;

py::dict shape_properties(const Shape& shape) {
  py::dict facts;
  facts["name"] = shape.name;
  facts["mass"] = shape.mass;
  facts["volume"] = shape.volume;
  facts["parts"] = shape.parts.size();
  facts["rounding"] = shape.rounding;
  facts["stiffness"] = shape.stiffness;
  facts["surface_deviation"] = shape.surface_deviation;
  facts["box"] = std::array<double, 3>{shape.box.x(), shape.box.y(), shape.box.z()};
  return facts;
}

// Vertices [V, 3] m and triangles [T, 3] of a shape, in shape axes.
py::tuple shape_mesh(const Case& c, std::size_t index) {
  const TriangleMesh& mesh = c.model().shapes.at(index).mesh;
  std::vector<std::array<double, 3>> vertices;
  vertices.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) vertices.push_back({v.x(), v.y(), v.z()});
  return py::make_tuple(array_of(std::move(vertices)), array_of(mesh.triangles));
}

}  // namespace

void bind_case(py::module_& m) {
  py::class_<Case>(m, "CoreCase")
      .def_static("load", &Case::load, py::arg("file"), py::arg("overrides"),
                  py::arg("material_records"), py::call_guard<py::gil_scoped_release>())
      .def_static("parse", &Case::parse, py::arg("text"), py::arg("directory"),
                  py::arg("overrides"), py::call_guard<py::gil_scoped_release>())
      .def("with_overrides", &Case::with, py::arg("overrides"),
           py::call_guard<py::gil_scoped_release>())
      .def_property_readonly("name", &Case::name)
      .def_property_readonly("duration", &Case::duration)
      .def_property_readonly("seed", &Case::seed)
      .def_property_readonly("timestep", &Case::timestep)
      .def_property_readonly("frame_interval", &Case::frame_interval)
      .def_property_readonly("text", &Case::text)
      .def_property_readonly("particle_count",
                             [](const Case& c) { return c.model().particles.size(); })
      .def_property_readonly("boundaries",
                             [](const Case& c) {
                               std::vector<std::string> names;
                               for (const Boundary& b : c.model().boundaries)
                                 names.push_back(b.name);
                               return names;
                             })
      .def_property_readonly("shapes",
                             [](const Case& c) {
                               py::list all;
                               for (const Shape& shape : c.model().shapes)
                                 all.append(shape_properties(shape));
                               return all;
                             })
      .def("shape_mesh", &shape_mesh, py::arg("index"));

  m.def("material_records", [](const std::string& database) {
    py::list all;
    for (const experiments::MaterialRecord& r : experiments::material_records(database))
      all.append(py::make_tuple(r.name, r.version, r.sha256, r.shipped, r.json));
    return all;
  });
}

}  // namespace firn::python
