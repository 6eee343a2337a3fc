#include "firn/experiments/run.h"

#include <pybind11/stl.h>

#include <limits>

#include "python/src/arrays.h"
#include "python/src/bindings.h"

namespace firn::python {
namespace {

using experiments::Response;
using experiments::RunOptions;
using experiments::RunResult;

constexpr double kUndefined = std::numeric_limits<double>::quiet_NaN();

// The solver at one frame; of no use after the callback.
class LiveFrame {
 public:
  explicit LiveFrame(const Solver& solver) : solver_(&solver) {}
  void end() { solver_ = nullptr; }

  const Solver& solver() const {
    if (!solver_)
      throw std::runtime_error("the frame is over; read what is needed during the callback");
    return *solver_;
  }
  // [N, 3]; NaN where a particle is not present.
  py::array_t<double> vectors(const std::vector<Vec3> ParticleState::*member) const {
    const ParticleState& state = solver().particles();
    std::vector<std::array<double, 3>> rows(state.presence.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const Vec3& v = (state.*member)[i];
      rows[i] = state.presence[i] == Presence::present
                    ? std::array<double, 3>{v.x(), v.y(), v.z()}
                    : std::array<double, 3>{kUndefined, kUndefined, kUndefined};
    }
    return array_of(std::move(rows));
  }
  // [N, 4] w x y z, shape axes -> world.
  py::array_t<double> orientation() const {
    const ParticleState& state = solver().particles();
    std::vector<std::array<double, 4>> rows(state.presence.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      rows[i].fill(kUndefined);
      if (state.presence[i] != Presence::present) continue;
      const Quat q = solver().shape_orientation(static_cast<int>(i));
      rows[i] = {q.w(), q.x(), q.y(), q.z()};
    }
    return array_of(std::move(rows));
  }
  py::array_t<bool> present() const {
    const ParticleState& state = solver().particles();
    py::array_t<bool> flags(static_cast<py::ssize_t>(state.presence.size()));
    auto row = flags.mutable_unchecked<1>();
    for (py::ssize_t i = 0; i < row.shape(0); ++i)
      row(i) = state.presence[static_cast<std::size_t>(i)] == Presence::present;
    return flags;
  }
  // Touching patches, one row each.
  py::dict contacts() const {
    std::vector<int> a, b;
    std::vector<double> normal_force, overlap;
    std::vector<std::array<double, 3>> position, force;
    for (const Contact& c : solver().contacts()) {
      if (!(c.normal_force > 0)) continue;
      a.push_back(c.a);
      b.push_back(c.b);
      normal_force.push_back(c.normal_force);
      overlap.push_back(c.overlap);
      position.push_back({c.position.x(), c.position.y(), c.position.z()});
      force.push_back({c.force.x(), c.force.y(), c.force.z()});
    }
    py::dict all;
    all["a"] = array_of(std::move(a));
    all["b"] = array_of(std::move(b));
    all["normal_force"] = array_of(std::move(normal_force));
    all["overlap"] = array_of(std::move(overlap));
    all["position"] = array_of(std::move(position));
    all["force"] = array_of(std::move(force));
    return all;
  }

 private:
  const Solver* solver_;
};

py::dict energy_dict(const Energy& e) {
  py::dict all;
  for (const EnergyTerm& term : energy_terms(e)) all[term.name] = term.value;
  for (const EnergyTerm& term : energy_terms(e.free_bodies)) all[term.name] = term.value;
  return all;
}

const char* status_text(const RunResult& r) {
  switch (r.status) {
    case RunResult::Status::finished:
      return "finished";
    case RunResult::Status::interrupted:
      return "interrupted";
    case RunResult::Status::failed:
      break;
  }
  return "failed";
}

RunOptions options_of(const std::string& results_file, int threads, double checkpoint_every,
                      const py::object& on_frame) {
  RunOptions options;
  options.results_file = results_file;
  options.threads = threads;
  options.checkpoint_every = checkpoint_every;
  options.on_progress = [](double) { return check_signals(); };
  if (!on_frame.is_none())
    // By reference: the caller keeps it alive, and its count changes only under the lock.
    options.on_frame = [&on_frame](const Solver& solver) {
      const py::gil_scoped_acquire lock;
      const auto frame = std::make_shared<LiveFrame>(solver);
      struct End {
        LiveFrame& frame;
        ~End() { frame.end(); }
      } const end{*frame};
      const py::object answer = on_frame(frame);
      return !(py::isinstance<py::bool_>(answer) && !answer.cast<bool>());
    };
  return options;
}

void bind_response(py::module_& m) {
  py::class_<Response>(m, "Response", "A quantity measured from a run.")
      .def_readonly("name", &Response::name)
      .def_readonly("unit", &Response::unit)
      .def_readonly("method", &Response::method)
      .def_property_readonly("values", [](const Response& r) { return array_of(r.value); })
      .def_property_readonly("uncertainties",
                             [](const Response& r) { return array_of(r.uncertainty); })
      .def_property_readonly("value",
                             [](const Response& r) {
                               if (r.value.size() != 1)
                                 throw py::value_error(r.name + " has " +
                                                       std::to_string(r.value.size()) +
                                                       " values; use .values");
                               return r.value[0];
                             })
      .def("__repr__", [](const Response& r) {
        return r.value.size() == 1
                   ? r.name + " = " + py::repr(py::float_(r.value[0])).cast<std::string>() + " " +
                         r.unit
                   : r.name + ": " + std::to_string(r.value.size()) + " values in " + r.unit;
      });
}

void bind_live_frame(py::module_& m) {
  py::class_<LiveFrame, std::shared_ptr<LiveFrame>>(m, "LiveFrame",
                                                    "State of a run under way, in a callback.")
      .def_property_readonly("time", [](const LiveFrame& f) { return f.solver().time(); })
      .def_property_readonly("steps", [](const LiveFrame& f) { return f.solver().steps(); })
      .def_property_readonly("present", &LiveFrame::present)
      .def_property_readonly("position",
                             [](const LiveFrame& f) { return f.vectors(&ParticleState::position); })
      .def_property_readonly("orientation", &LiveFrame::orientation)
      .def_property_readonly("velocity",
                             [](const LiveFrame& f) { return f.vectors(&ParticleState::velocity); })
      .def_property_readonly(
          "angular_velocity",
          [](const LiveFrame& f) { return f.vectors(&ParticleState::angular_velocity); })
      .def_property_readonly("energy",
                             [](const LiveFrame& f) { return energy_dict(f.solver().energy()); })
      .def("contacts", &LiveFrame::contacts);
}

void bind_run_result(py::module_& m) {
  py::class_<RunResult>(m, "CoreRunResult")
      .def_property_readonly("status", &status_text)
      .def_readonly("reason", &RunResult::reason)
      .def_readonly("responses", &RunResult::responses)
      .def_readonly("simulated", &RunResult::simulated)
      .def_readonly("wall", &RunResult::wall)
      .def_readonly("steps", &RunResult::steps)
      .def_readonly("results_file", &RunResult::results_file)
      .def_property_readonly("energy", [](const RunResult& r) { return energy_dict(r.energy); })
      .def_property_readonly("largest_overlap",
                             [](const RunResult& r) { return r.diagnostics.largest_overlap; });
}

}  // namespace

void bind_run(py::module_& m) {
  bind_response(m);
  bind_live_frame(m);
  bind_run_result(m);
  m.def("current_response_name", &experiments::current_response_name, py::arg("name"));
  m.def(
      "run",
      [](const experiments::Case& c, const std::string& results_file, int threads,
         double checkpoint_every, const py::object& on_frame) {
        const RunOptions options = options_of(results_file, threads, checkpoint_every, on_frame);
        const py::gil_scoped_release unlocked;
        return experiments::run(c, options);
      },
      py::arg("case"), py::arg("results_file"), py::arg("threads"), py::arg("checkpoint_every"),
      py::arg("on_frame"));
  m.def(
      "resume",
      [](const std::string& results_file, int threads, double checkpoint_every,
         const py::object& on_frame) {
        const RunOptions options = options_of(results_file, threads, checkpoint_every, on_frame);
        const py::gil_scoped_release unlocked;
        return experiments::resume(results_file, options);
      },
      py::arg("results_file"), py::arg("threads"), py::arg("checkpoint_every"),
      py::arg("on_frame"));
}

}  // namespace firn::python
