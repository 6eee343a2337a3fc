#include "experiments/results/results_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/analysis/boundary_support.h"
#include "experiments/analysis/sample_statistics.h"
#include "experiments/case/samples.h"
#include "experiments/results/body_number.h"
#include "experiments/results/contact_statistics_results.h"
#include "experiments/results/results_schema.h"
#include "experiments/storage/version.h"
#include "firn/contact_model.h"

namespace firn {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

class Row {
 public:
  void add(double value) { values_.push_back(value); }
  void add(const Vec3& v) { values_.insert(values_.end(), {v.x(), v.y(), v.z()}); }
  void add(const Quat& q) { values_.insert(values_.end(), {q.w(), q.x(), q.y(), q.z()}); }
  void add_nan(int count) { values_.insert(values_.end(), static_cast<std::size_t>(count), kNaN); }
  std::vector<double> take() { return std::move(values_); }

 private:
  std::vector<double> values_;
};

void add_particles(Row& row, const Solver& solver) {
  const ParticleState& state = solver.particles();
  const int count = static_cast<int>(state.presence.size());
  const auto each = [&](int width, auto&& value) {
    for (int i = 0; i < count; ++i) {
      if (state.presence[static_cast<std::size_t>(i)] == Presence::present)
        row.add(value(i));
      else
        row.add_nan(width);
    }
  };
  const auto at = [](const std::vector<Vec3>& values) {
    return [&values](int i) -> const Vec3& { return values[static_cast<std::size_t>(i)]; };
  };
  each(3, at(state.position));
  each(4, [&](int i) { return solver.shape_orientation(i); });
  each(3, at(state.velocity));
  each(3, at(state.angular_velocity));
}

// Loads are means over the interval, s.
void add_frame(Row& row, const FrameState& frame, const std::optional<FreeBody>& free,
               double interval) {
  const double per_time = interval > 0 ? 1 / interval : 0;
  row.add(frame.position);
  row.add(frame.orientation);
  row.add(Vec3(frame.impulse * per_time));
  row.add(Vec3(frame.angular_impulse * per_time));
  if (!free) return;
  row.add(Vec3(frame.reaction_impulse * per_time));
  row.add(Vec3(frame.reaction_angular_impulse * per_time));
  if (free->free_rotation) row.add(frame.relative_angular_velocity);
  for (const FrameState::JointState& axis : frame.joints) row.add(axis.coordinate);
  for (const FrameState::JointState& axis : frame.joints) row.add(axis.rate);
  for (const FrameState::JointState& axis : frame.joints) row.add(axis.motor_impulse * per_time);
  for (const FrameState::JointState& axis : frame.joints) row.add(axis.limit_impulse * per_time);
  if (!free->has_joint_friction()) return;
  for (const FrameState::JointState& axis : frame.joints) row.add(axis.dissipated_friction);
}

void add_coupling(Row& row, const CouplingState& coupling, bool has_friction, double interval) {
  const double per_time = interval > 0 ? 1 / interval : 0;
  row.add(Vec3(coupling.impulse * per_time));
  row.add(Vec3(coupling.angular_impulse * per_time));
  if (has_friction) row.add(coupling.dissipated_friction);
}

void add_contact(Row& row, const BoundaryContactState& contact, double interval) {
  row.add(Vec3(contact.impulse * (interval > 0 ? 1 / interval : 0)));
  row.add(contact.peak_normal_force);
  row.add(contact.dissipated_normal + contact.dissipated_friction);
}

void add_boundary(Row& row, const BoundaryState& b, double interval) {
  const double per_time = interval > 0 ? 1 / interval : 0;
  row.add(Vec3(b.impulse * per_time));
  row.add(Vec3(b.angular_impulse * per_time));
  row.add(b.peak_normal_force);
  if (b.present) {
    row.add(b.position);
    row.add(b.orientation);
  } else {
    row.add_nan(7);
  }
}

// By boundary, whether a measure of the case needs the particles that it bears.
std::vector<bool> supporting_boundaries(const Case& c) {
  std::vector<bool> selected;
  for (const Boundary& boundary : c.model.boundaries)
    selected.push_back(std::ranges::any_of(c.measures, [&](const Measure& m) {
      return m.kind == Measure::Kind::above && m.boundary == boundary.name;
    }));
  return selected;
}

void add_support(Row& row, const BoundarySupport& support) {
  row.add(support.above_count);
  row.add(support.below_count);
  row.add(support.above_force);
}

}  // namespace

std::vector<Column> result_columns(const Case& c) {
  const Model& model = c.model;
  const std::vector<bool> supporting = supporting_boundaries(c);
  const std::size_t n = model.particles.size();
  std::vector<Column> columns = {{"/frames/time", "s", {}},
                                 {"/frames/position", "m", {n, 3}},
                                 {"/frames/orientation", "1", {n, 4}},
                                 {"/frames/velocity", "m/s", {n, 3}},
                                 {"/frames/angular_velocity", "rad/s", {n, 3}}};
  for (std::size_t b = 0; b < model.boundaries.size(); ++b) {
    const std::string group = "/boundaries/" + model.boundaries[b].name;
    columns.push_back({group + "/force", "N", {3}});
    columns.push_back({group + "/torque", "N m", {3}});
    columns.push_back({group + "/peak_normal_force", "N", {}});
    columns.push_back({group + "/position", "m", {3}});
    columns.push_back({group + "/orientation", "1", {4}});
    if (!supporting[b]) continue;
    columns.push_back({group + "/above_count", "1", {}});
    columns.push_back({group + "/below_count", "1", {}});
    columns.push_back({group + "/above_force", "N", {}});
  }
  for (const MotionFrame& frame : model.frames) {
    const std::string group = "/motion_frames/" + frame.name;
    columns.push_back({group + "/position", "m", {3}});
    columns.push_back({group + "/orientation", "1", {4}});
    columns.push_back({group + "/force", "N", {3}});
    columns.push_back({group + "/torque", "N m", {3}});
    if (!frame.free) continue;
    columns.push_back({group + "/reaction_force", "N", {3}});
    columns.push_back({group + "/reaction_torque", "N m", {3}});
    if (frame.free->free_rotation) columns.push_back({group + "/angular_velocity", "rad/s", {3}});
    if (frame.free->joints.empty()) continue;
    const std::size_t axes = frame.free->joints.size();
    for (const char* name : {"coordinate", "rate", "motor_load", "limit_load"})
      columns.push_back({group + "/" + name, "SI", {axes}});
    if (frame.free->has_joint_friction())
      columns.push_back({group + "/dissipated_friction", "J", {axes}});
  }
  for (const Coupling& coupling : model.couplings) {
    const std::string group = "/couplings/" + coupling.name;
    columns.push_back({group + "/force", "N", {3}});
    columns.push_back({group + "/torque", "N m", {3}});
    if (coupling.has_friction()) columns.push_back({group + "/dissipated_friction", "J", {}});
  }
  for (const BoundaryContact& contact : model.boundary_contacts) {
    const std::string group = "/boundary_contacts/" + contact.name;
    columns.push_back({group + "/force", "N", {3}});
    columns.push_back({group + "/peak_normal_force", "N", {}});
    columns.push_back({group + "/dissipated", "J", {}});
  }
  for (const char* name :
       {"kinetic", "gravitational", "elastic", "dissipated", "dissipated_normal",
        "dissipated_friction", "dissipated_boundaries", "boundary_work", "removed"})
    columns.push_back({std::string("/energy/") + name, "J", {}});
  if (!model.bonds.empty()) columns.push_back({"/energy/dissipated_bonds", "J", {}});
  if (has_free_body(model.frames)) {
    for (const EnergyTerm& term : energy_terms(FreeBodyEnergy{}))
      columns.push_back({std::string("/energy/") + term.name, "J", {}});
  }
  columns.push_back({"/diagnostics/largest_overlap", "m", {}});
  for (const char* name : {"overlap_now", "overlap_p99", "overlap_median"})
    columns.push_back({std::string("/diagnostics/") + name, "m", {}});
  columns.push_back({"/diagnostics/energy_error", "J", {}});
  for (const char* name : {"late_contacts", "patches", "points"})
    columns.push_back({std::string("/diagnostics/") + name, "1", {}});
  if (has_free_body(model.frames)) columns.push_back({"/diagnostics/unconverged_steps", "1", {}});
  return columns;
}

std::vector<Column> sample_columns(const Case& c) {
  std::vector<Column> columns;
  if (c.samples.interval == 0) return columns;
  columns.push_back({"/samples/time", "s", {}});
  const auto add = [&](const std::string& part, const MotionFrame* frame) {
    for (const SampledQuantity& q : sampled_quantities(frame)) {
      const std::size_t width = q.by_joint ? frame->free->joints.size() : 3;
      columns.push_back(
          {fmt::format("/samples/{}/{}", part, q.name), std::string(q.unit), {width}});
    }
  };
  for (int b : c.samples.boundaries)
    add("boundaries/" + c.model.boundaries[static_cast<std::size_t>(b)].name, nullptr);
  for (int f : c.samples.frames) {
    const MotionFrame& frame = c.model.frames[static_cast<std::size_t>(f)];
    add("motion_frames/" + frame.name, &frame);
  }
  return columns;
}

std::vector<double> frame_row(const Solver& solver, const Case& c, double interval) {
  Row row;
  row.add(solver.time());
  add_particles(row, solver);
  const std::vector<bool> supporting = supporting_boundaries(c);
  const std::vector<BoundarySupport> support = boundary_support(solver, supporting);
  const std::vector<BoundaryState>& boundaries = solver.boundaries();
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    add_boundary(row, boundaries[b], interval);
    if (supporting[b]) add_support(row, support[b]);
  }
  const std::vector<FrameState> frames = solver.frames();
  for (std::size_t f = 0; f < frames.size(); ++f) {
    add_frame(row, frames[f], solver.model().frames[f].free, interval);
  }
  const std::vector<CouplingState> couplings = solver.couplings();
  for (std::size_t k = 0; k < couplings.size(); ++k)
    add_coupling(row, couplings[k], solver.model().couplings[k].has_friction(), interval);
  for (const BoundaryContactState& contact : solver.boundary_contacts())
    add_contact(row, contact, interval);
  const Energy e = solver.energy();
  for (double value :
       {e.kinetic, e.gravitational, e.elastic,
        e.dissipated_normal + e.dissipated_friction + e.dissipated_bonds, e.dissipated_normal,
        e.dissipated_friction, e.dissipated_boundaries, e.boundary_work, e.removed})
    row.add(value);
  if (!solver.model().bonds.empty()) row.add(e.dissipated_bonds);
  if (has_free_body(solver.model().frames)) {
    for (const EnergyTerm& term : energy_terms(e.free_bodies)) row.add(term.value);
  }
  const Diagnostics& h = solver.diagnostics();
  row.add(h.largest_overlap);
  std::vector<double> overlaps = solver.contact_overlaps();
  std::sort(overlaps.begin(), overlaps.end());
  for (double share : {1.0, 0.99, 0.5}) row.add(quantile(overlaps, share, kNaN));
  for (double value : {h.energy_error, static_cast<double>(h.late_contacts),
                       static_cast<double>(h.patches), static_cast<double>(h.points)})
    row.add(value);
  if (has_free_body(solver.model().frames)) row.add(static_cast<double>(h.unconverged_steps));
  return row.take();
}

void write_header(hdf5::File& file, const Case& c) {
  const Model& model = c.model;
  file.set_attribute("/", "case", c.resolved);
  file.set_attribute("/", "git_commit", std::string(firn_git_commit()));
  file.set_attribute("/", "format_version", results::kFormat);
  file.set_attribute("/", "contact_model", static_cast<std::uint64_t>(kContactModel));
  file.set_attribute("/", "seed", c.seed);
  file.set_attribute("/", "timestep", model.timestep);
  file.set_attribute("/", "status", std::string("running"));
  file.set_attribute("/", "wall_time", 0.0);
  std::vector<int> id, shape;
  std::vector<double> mass;
  for (const Particle& particle : model.particles) {
    id.push_back(static_cast<int>(id.size()));
    shape.push_back(particle.shape);
    mass.push_back(model.shapes[static_cast<std::size_t>(particle.shape)].mass);
  }
  const hdf5::Shape all{id.size()};
  file.write<int>("/particles/id", all, id);
  file.write<int>("/particles/shape", all, shape);
  file.write<double>("/particles/mass", all, mass);
  file.set_attribute("/particles/mass", "unit", std::string("kg"));
  std::vector<std::string> shapes;
  std::vector<double> shape_mass, shape_volume;
  for (const Shape& s : model.shapes) {
    shapes.push_back(s.name);
    shape_mass.push_back(s.mass);
    shape_volume.push_back(s.volume);
  }
  file.write_strings("/shapes/name", shapes);
  file.write<double>("/shapes/mass", {shapes.size()}, shape_mass);
  file.write<double>("/shapes/volume", {shapes.size()}, shape_volume);
  file.set_attribute("/shapes/mass", "unit", std::string("kg"));
  file.set_attribute("/shapes/volume", "unit", std::string("m^3"));
  std::vector<std::string> sensors, outlets;
  for (const Sensor& sensor : c.sensors) sensors.push_back(sensor.name);
  for (const Outlet& outlet : c.outlets) outlets.push_back(outlet.name);
  if (!sensors.empty()) file.write_strings("/sensors/name", sensors);
  file.write_strings("/outlets/name", outlets);
  write_particles(file, std::vector<double>(id.size(), 0), ParticleEvents(c));
  file.set_attribute("/particles/peak_normal_force", "unit", std::string("N"));
  for (const char* time : {"exit_time", "discharge_time", "insert_time"})
    file.set_attribute(std::string("/particles/") + time, "unit", std::string("s"));
  if (!sensors.empty()) file.set_attribute("/particles/sensor_time", "unit", std::string("s"));
  write_stages(file, stages_of(c), {});
  write_bonds(file, c, {});
  create_statistics(file, c);
  for (const Column& column : sample_columns(c))
    file.create_table(column.path, column.row, column.unit);
  // Readers go by this attribute: everything else is there before it.
  file.flush();
  file.set_attribute("/", "firn_version", std::string(firn_version()));
}

void write_particles(hdf5::File& file, const std::vector<double>& peak_normal_force,
                     const ParticleEvents& passages) {
  const hdf5::Shape all{peak_normal_force.size()};
  file.write<double>("/particles/peak_normal_force", all, peak_normal_force);
  file.write<double>("/particles/exit_time", all, passages.exit_time);
  file.write<double>("/particles/discharge_time", all, passages.discharge_time);
  file.write<double>("/particles/insert_time", all, passages.insert_time);
  file.write<int>("/particles/outlet", all, passages.outlet);
  file.write<int>("/particles/batch", all, passages.batch);
  file.write<int>("/particles/tag", all, passages.tag);
  if (passages.sensor_time.empty()) return;
  std::vector<double> sensors;
  for (const std::vector<double>& times : passages.sensor_time)
    sensors.insert(sensors.end(), times.begin(), times.end());
  file.write<double>("/particles/sensor_time", {passages.sensor_time.size(), all[0]}, sensors);
}

ParticleEvents::ParticleEvents(const Case& c) {
  const std::size_t n = c.model.particles.size();
  exit_time = discharge_time = insert_time = std::vector<double>(n, kNaN);
  outlet = batch = std::vector<int>(n, -1);
  for (const Particle& p : c.model.particles) tag.push_back(p.tag);
  for (const Case::InitialParticle& p : c.placed) {
    insert_time[static_cast<std::size_t>(p.particle)] = p.insert_time;
    batch[static_cast<std::size_t>(p.particle)] = p.batch;
  }
  sensor_time.assign(c.sensors.size(), std::vector<double>(n, kNaN));
}

void write_switches(hdf5::File& file, const Case& c, const std::vector<SwitchChange>& changes) {
  if (c.limit_switches.empty()) return;
  std::vector<std::string> names;
  std::vector<double> times;
  std::vector<int> closed;
  for (const SwitchChange& change : changes) {
    names.push_back(c.limit_switches[static_cast<std::size_t>(change.index)].name);
    times.push_back(change.time);
    closed.push_back(static_cast<int>(change.closed));
  }
  for (const char* old : {"/limit_switches/name", "/limit_switches/time", "/limit_switches/closed"})
    if (file.contains(old)) file.remove(old);
  file.write_strings("/limit_switches/name", names);
  file.write<double>("/limit_switches/time", {times.size()}, times);
  file.write<int>("/limit_switches/closed", {closed.size()}, closed);
  file.set_attribute("/limit_switches/time", "unit", std::string("s"));
}

void write_bonds(hdf5::File& file, const Case& c, const std::vector<BondRecord>& records) {
  const Model& model = c.model;
  if (model.bonds.empty()) return;
  std::vector<std::string> law, mode;
  std::vector<int> a, b;
  std::vector<double> time, stress, place;
  for (std::size_t k = 0; k < model.bonds.size(); ++k) {
    const Bond& bond = model.bonds[k];
    const BondRecord record = records.empty() ? BondRecord{} : records[k];
    const bool ended = record.mode != BondMode::intact && record.mode != BondMode::removed,
               broken = ended && record.mode != BondMode::lifetime;
    law.push_back(model.beams[static_cast<std::size_t>(bond.law)].name);
    a.push_back(bond.a);
    b.push_back(number_of_body(bond.b, model.particles.size()));
    mode.emplace_back(to_string(record.mode));
    time.push_back(ended ? record.time : kNaN);
    stress.push_back(broken ? record.stress : kNaN);
    for (int axis = 0; axis < 3; ++axis) place.push_back(ended ? record.position[axis] : kNaN);
  }
  const hdf5::Shape all{a.size()};
  file.write_strings("/bonds/name", law);
  file.write<int>("/bonds/a", all, a);
  file.write<int>("/bonds/b", all, b);
  file.write_strings("/bonds/break_mode", mode);
  file.write<double>("/bonds/break_time", all, time);
  file.write<double>("/bonds/break_stress", all, stress);
  file.write<double>("/bonds/break_position", {a.size(), 3}, place);
  file.set_attribute("/bonds/break_time", "unit", std::string("s"));
  file.set_attribute("/bonds/break_stress", "unit", std::string("Pa"));
  file.set_attribute("/bonds/break_position", "unit", std::string("m"));
}

std::vector<Stage> stages_of(const Case& c) {
  if (!c.stages.empty()) return c.stages;
  Stage whole;
  whole.name = "run";
  return {whole};
}

void write_stages(hdf5::File& file, const std::vector<Stage>& stages,
                  const std::vector<StageRecord>& entered) {
  std::vector<std::string> name, end_reason(stages.size());
  std::vector<double> start(stages.size(), kNaN), end(stages.size(), kNaN);
  for (const Stage& stage : stages) name.push_back(stage.name);
  for (std::size_t i = 0; i < entered.size(); ++i) {
    start[i] = entered[i].start;
    end[i] = entered[i].end;
    end_reason[i] = entered[i].end_reason;
  }
  const hdf5::Shape all{stages.size()};
  file.write_strings("/stages/name", name);
  file.write_strings("/stages/end_reason", end_reason);
  file.write<double>("/stages/start", all, start);
  file.write<double>("/stages/end", all, end);
}

void write_responses(hdf5::File& file, const std::vector<Response>& responses) {
  for (const Response& r : responses) {
    const std::string path = "/responses/" + r.name;
    const hdf5::Shape shape = r.value.size() == 1 ? hdf5::Shape{} : hdf5::Shape{r.value.size()};
    file.write<double>(path, shape, r.value);
    file.set_attribute(path, "unit", r.unit);
    file.set_attribute(path, "method", r.method);
    file.set_attribute(path, "method_version", static_cast<std::uint64_t>(r.method_version));
    const std::vector<double> unknown(r.value.size(), kNaN);
    const std::vector<double>& uncertainty = r.uncertainty.empty() ? unknown : r.uncertainty;
    if (r.value.size() == 1)
      file.set_attribute(path, "uncertainty", uncertainty[0]);
    else
      file.set_attribute(path, "uncertainty", uncertainty);
  }
}

}  // namespace firn
