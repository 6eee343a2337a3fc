#include "firn/solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "solver/contact_detection/obstacle.h"
#include "solver/state/snapshot.h"
#include "solver/state/workspace.h"
#include "solver/statistics/contact_events.h"
#include "solver/statistics/contact_statistics.h"
#include "solver/statistics/triangle_loads.h"
#include "solver/step/bond_forces.h"
#include "solver/step/boundary_contacts.h"
#include "solver/step/contact_info.h"
#include "solver/step/free_body_energy.h"
#include "solver/step/initial_state.h"
#include "solver/step/kernels.h"
#include "solver/step/moving_boundaries.h"
#include "solver/step/removed_bodies.h"
#include "solver/step/state_checks.h"

namespace firn {

struct Solver::Impl {
  std::shared_ptr<const Model> owner;
  const Model& model;
  const Kernels& kernels = choose_kernels();
  Workspace workspace;
  State state;
  std::vector<PhaseTime> profile;
  // Copies of the state for accessors, made on request. Several threads may request them.
  mutable std::mutex copying;
  mutable ParticleState particles;
  mutable std::vector<BoundaryState> boundaries;
  mutable bool particles_current = false, boundaries_current = false;

  Impl(std::shared_ptr<const Model> m, int threads)
      : owner(std::move(m)), model(*owner), workspace(model, threads) {}

  // True between step_deferred() and the second half kick of that step. The next step makes that
  // half kick in one pass with its first one, unless complete_step() is called before.
  bool half_kick_pending = false;

  template <class Phase>
  void timed(const char* name, Phase&& phase) {
    const auto begin = std::chrono::steady_clock::now();
    phase();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    const auto same = [&](const PhaseTime& p) { return p.name == name; };
    auto at = std::ranges::find_if(profile, same);
    if (at == profile.end()) at = profile.insert(at, {name, 0});
    at->seconds += took.count();
  }

  // Call before a change of velocities or of the state.
  void complete_step() {
    if (!std::exchange(half_kick_pending, false)) return;
    timed("half kick", [&] { kernels.finish_velocities(model, workspace, state); });
    changed();
  }
  // Call before a read of velocities, loads of particles or the whole state.
  void require_complete() const {
    if (half_kick_pending)
      throw std::logic_error("the last step is deferred; call complete_step() before this read");
  }

  void changed() { particles_current = boundaries_current = false; }
};

namespace {

std::shared_ptr<const Model> checked(Model model) {
  validate(model);
  return std::make_shared<const Model>(std::move(model));
}

}  // namespace

Solver::Solver(Model model) : Solver(checked(std::move(model)), 0) {}
Solver::Solver(std::shared_ptr<const Model> model, int threads)
    : impl_(std::make_unique<Impl>(std::move(model), threads)) {
  initialize(impl_->model, impl_->state);
}
Solver::~Solver() = default;
Solver::Solver(Solver&&) noexcept = default;
Solver& Solver::operator=(Solver&&) noexcept = default;

const Model& Solver::model() const { return impl_->model; }

void Solver::step() {
  step_deferred();
  complete_step();
}

void Solver::complete_step() { impl_->complete_step(); }

void Solver::step_deferred() {
  Impl& i = *impl_;
  const Model& m = i.model;
  Workspace& w = i.workspace;
  State& s = i.state;
  const Kernels& k = i.kernels;
  i.timed("advance boundaries", [&] { advance_boundaries(m, w, s); });
  const bool both = std::exchange(i.half_kick_pending, false);
  i.timed("kicks and drift", [&] { k.integrate_positions(m, w, s, both); });
  if (s.neighbor_list_invalid) add_work_of_removed_bodies(m, w, s);
  i.timed("neighbor list", [&] { k.update_neighbor_list(m, w, s); });
  i.timed("find contacts", [&] { k.find_contacts(m, w, s); });
  i.timed("contact forces", [&] { k.contact_forces(m, w, s); });
  if (!m.boundary_contacts.empty())
    i.timed("boundary contacts", [&] { firn::boundary_contacts(m, w, s); });
  if (!m.bonds.empty()) i.timed("bonds", [&] { compute_bond_forces(m, w.threads, w.bonds, s); });
  if (m.statistics.any() && s.statistics.recording != 0)
    i.timed("statistics", [&] { update_statistics(m, w, s); });
  i.timed("finish frames", [&] { finish_frames(m, w, s); });
  i.half_kick_pending = true;
  i.changed();
  ++s.steps;
  s.time = static_cast<double>(s.steps) * m.timestep;
  if (is_check_step(s)) {
    i.complete_step();
    i.timed("check state", [&] { check_state(m, w, s); });
  }
}

void Solver::insert(int particle, const Vec3& center_of_mass, const Quat& orientation,
                    const Vec3& velocity, const Vec3& angular_velocity) {
  impl_->complete_step();
  State& s = impl_->state;
  if (particle < 0 || particle >= static_cast<int>(s.presence.size()) ||
      s.presence[particle] != Presence::pending) {
    throw std::logic_error(fmt::format("particle {} is not pending", particle));
  }
  const Shape& shape = impl_->model.shapes[impl_->model.particles[particle].shape];
  BodyMotion& m = s.motion[particle];
  m.position = center_of_mass;
  m.velocity = velocity;
  m.angular_velocity = angular_velocity;
  s.orientation[particle] = (orientation * shape.shape_from_body).normalized();
  s.angular_momentum[particle] =
      shape.inertia.cwiseProduct(rotation_of(s, particle).transpose() * angular_velocity);
  s.load[particle] = BodyLoad{};
  s.presence[particle] = Presence::present;
  begin_bonds(impl_->model, impl_->workspace.bonds, s, particle);
  s.removed_energy -= particle_energy(impl_->model, impl_->workspace, s, particle) +
                      bond_energy_of(impl_->model, impl_->workspace.bonds, s, particle);
  s.neighbor_list_invalid = true;
  impl_->changed();
}

void Solver::start_frame(const FrameStart& start) {
  if (impl_->state.steps > 0)
    throw std::logic_error("a frame can only start before the first step");
  firn::start_frame(impl_->model, start, impl_->state);
  impl_->changed();
}

void Solver::remove_particle(int particle) {
  impl_->complete_step();
  State& s = impl_->state;
  if (s.presence.at(particle) != Presence::present) {
    throw std::logic_error(fmt::format("particle {} is not there to be removed", particle));
  }
  s.removed_energy += particle_energy(impl_->model, impl_->workspace, s, particle) +
                      bond_energy_of(impl_->model, impl_->workspace.bonds, s, particle) -
                      last_work_of_bonds(impl_->model, impl_->workspace.bonds, s, particle);
  release_bonds(impl_->model, impl_->workspace.bonds, s, particle);
  s.presence[particle] = Presence::removed;
  s.neighbor_list_invalid = true;
  impl_->changed();
}

void Solver::remove_boundary(int boundary) {
  State& s = impl_->state;
  s.boundary_present.at(boundary) = 0;
  const int body = static_cast<int>(impl_->model.particles.size()) + boundary;
  s.removed_energy += bond_energy_of(impl_->model, impl_->workspace.bonds, s, body) -
                      last_work_of_bonds(impl_->model, impl_->workspace.bonds, s, body);
  release_bonds(impl_->model, impl_->workspace.bonds, s, body);
  s.neighbor_list_invalid = true;
  impl_->changed();
}

void Solver::add_motion(int boundary, const Motion& motion, int group) {
  impl_->state.stage_motions.push_back(motion);
  impl_->state.stage_motion_mover.push_back(boundary);
  impl_->state.stage_motion_group.push_back(group);
}

void Solver::add_frame_motion(int frame, const Motion& motion, int group) {
  add_motion(static_cast<int>(impl_->model.boundaries.size()) + frame, motion, group);
}

void Solver::add_motor(int frame, int joint, const Motor& motor, int group) {
  impl_->state.stage_motors.push_back(motor);
  impl_->state.stage_motor_joint.push_back(frame * kMaxJoints + joint);
  impl_->state.stage_motor_group.push_back(group);
}

void Solver::stop_stage_motions(int group, double time) {
  State& s = impl_->state;
  for (std::size_t i = 0; i < s.stage_motions.size(); ++i)
    if (s.stage_motion_group[i] == group) s.stage_motions[i].end = time;
  for (std::size_t i = 0; i < s.stage_motors.size(); ++i)
    if (s.stage_motor_group[i] == group) s.stage_motors[i].end = time;
}

bool Solver::overlaps(int shape, const Vec3& center_of_mass, const Quat& orientation,
                      double clearance) const {
  return obstacle(shape, center_of_mass, orientation, clearance).has_value();
}

std::optional<int> Solver::obstacle(int shape, const Vec3& center_of_mass, const Quat& orientation,
                                    double clearance) const {
  return find_obstacle(impl_->model, impl_->state, shape, center_of_mass, orientation, clearance);
}

double Solver::time() const { return impl_->state.time; }
std::uint64_t Solver::steps() const { return impl_->state.steps; }

const ParticleState& Solver::particles() const {
  const Impl& i = *impl_;
  i.require_complete();
  const std::scoped_lock lock(i.copying);
  if (std::exchange(i.particles_current, true)) return i.particles;
  const State& s = i.state;
  const std::size_t n = i.model.particles.size();
  i.particles.presence.assign(s.presence.begin(), s.presence.end());
  i.particles.peak_normal_force.assign(s.peak_normal_force.begin(), s.peak_normal_force.end());
  i.particles.position.resize(n);
  i.particles.velocity.resize(n);
  i.particles.angular_velocity.resize(n);
  i.particles.orientation.assign(s.orientation.begin(),
                                 s.orientation.begin() + static_cast<std::ptrdiff_t>(n));
  for (std::size_t k = 0; k < n; ++k) {
    i.particles.position[k] = s.motion[k].position;
    i.particles.velocity[k] = s.motion[k].velocity;
    i.particles.angular_velocity[k] = s.motion[k].angular_velocity;
  }
  return i.particles;
}

Quat Solver::shape_orientation(int particle) const {
  const Shape& shape = impl_->model.shapes[impl_->model.particles[particle].shape];
  return impl_->state.orientation[particle] * shape.shape_from_body.conjugate();
}

const std::vector<BoundaryState>& Solver::boundaries() const {
  const Impl& i = *impl_;
  const std::scoped_lock lock(i.copying);
  if (std::exchange(i.boundaries_current, true)) return i.boundaries;
  const State& s = i.state;
  const std::size_t n = i.model.particles.size();
  i.boundaries.resize(i.model.boundaries.size());
  for (std::size_t b = 0; b < i.boundaries.size(); ++b) {
    BoundaryState& w = i.boundaries[b];
    w.position = s.motion[n + b].position;
    w.orientation = s.orientation[n + b];
    w.velocity = s.motion[n + b].velocity;
    w.angular_velocity = s.motion[n + b].angular_velocity;
    w.present = s.boundary_present[b] != 0;
    w.impulse = s.boundary_impulse[b];
    w.angular_impulse = s.boundary_angular_impulse[b];
    w.peak_normal_force = s.boundary_peak[b];
  }
  return i.boundaries;
}

std::vector<FrameState> Solver::frames() const {
  const Impl& i = *impl_;
  std::vector<FrameState> out;
  for (std::size_t f = 0; f < i.state.frames.size(); ++f) {
    const FrameMotion& m = i.state.frames[f];
    FrameState& one = out.emplace_back();
    one.position = m.position;
    one.orientation = Quat(Mat3(Eigen::Map<const Mat3>(m.rotation))).normalized();
    one.velocity = m.velocity;
    one.angular_velocity = m.angular_velocity;
    one.driven = m.driven != 0;
    one.impulse = m.impulse;
    one.angular_impulse = m.angular_impulse;
    one.reaction_impulse = i.state.joint_reactions[f].impulse;
    one.reaction_angular_impulse = i.state.joint_reactions[f].angular_impulse;
    const std::optional<FreeBody>& free = i.model.frames[f].free;
    if (!free) continue;
    const std::size_t axes = free->joints.size();
    for (std::size_t k = 0; k < axes; ++k) {
      one.joints.push_back({m.coordinate[k], m.rate[k], m.motor_impulse[k], m.limit_impulse[k],
                            m.dissipated_friction[k]});
    }
    const int parent = i.model.frames[f].parent;
    const Mat3 above = parent < 0 ? Mat3(Mat3::Identity())
                                  : Mat3(Eigen::Map<const Mat3>(
                                        i.state.frames[static_cast<std::size_t>(parent)].rotation));
    if (free->free_rotation) one.relative_angular_velocity = above * Vec3(m.rate + axes);
  }
  return out;
}

std::vector<CouplingState> Solver::couplings() const {
  std::vector<CouplingState> out;
  for (const CouplingReaction& c : impl_->state.couplings)
    out.push_back({c.position, c.impulse, c.angular_impulse, c.dissipated_friction});
  return out;
}

std::vector<BoundaryContactState> Solver::boundary_contacts() const {
  std::vector<BoundaryContactState> out;
  for (std::size_t k = 0; k < impl_->state.boundary_contacts.size(); ++k)
    out.push_back(boundary_contact_state(impl_->workspace, impl_->state, k));
  return out;
}

void Solver::clear_boundary_loads() {
  State& s = impl_->state;
  for (JointReaction& joint : s.joint_reactions)
    joint.impulse = joint.angular_impulse = Vec3::Zero();
  for (CouplingReaction& coupling : s.couplings)
    coupling.impulse = coupling.angular_impulse = Vec3::Zero();
  for (BoundaryContactHistory& contact : s.boundary_contacts) {
    contact.impulse = Vec3::Zero();
    contact.peak_normal_force = 0;
  }
  for (FrameMotion& frame : s.frames) {
    frame.impulse = frame.angular_impulse = Vec3::Zero();
    std::fill_n(frame.motor_impulse, kMaxJoints, 0.0);
    std::fill_n(frame.limit_impulse, kMaxJoints, 0.0);
  }
  std::fill(s.boundary_impulse.begin(), s.boundary_impulse.end(), Vec3::Zero());
  std::fill(s.boundary_angular_impulse.begin(), s.boundary_angular_impulse.end(), Vec3::Zero());
  std::fill(s.boundary_peak.begin(), s.boundary_peak.end(), 0.0);
  impl_->changed();
}

Energy Solver::energy() const {
  impl_->require_complete();
  const Impl& i = *impl_;
  Energy energy = energy_of(i.model, i.workspace, i.state);
  energy.free_bodies = free_body_energy(i.model, i.workspace, i.state);
  return energy;
}

Diagnostics Solver::diagnostics() const {
  const State& s = impl_->state;
  const Workspace& w = impl_->workspace;
  // Steps keep the counts, so that a call after every step does not walk through all pairs.
  std::int64_t patches = w.patches, points = w.points;
  if (w.neighbor_list_rebuilt) {
    patches = points = 0;
    for (const Pair& pair : s.pairs) {
      patches += pair.patch_count;
      points += points_of(pair, s);
    }
  }
  Diagnostics diagnostics = s.diagnostics;
  diagnostics.pairs = s.pairs.size();
  diagnostics.patches = static_cast<std::uint64_t>(patches);
  diagnostics.points = static_cast<std::uint64_t>(points);
  return diagnostics;
}

std::vector<double> Solver::contact_overlaps() const { return overlaps_of(impl_->state); }

const std::vector<BondRecord>& Solver::bonds() const { return impl_->state.bonds; }

BondState Solver::bond(int number) const {
  impl_->require_complete();
  return bond_state(impl_->model, impl_->workspace.bonds, impl_->state,
                    static_cast<std::size_t>(number));
}

std::vector<Contact> Solver::contacts() const {
  return contacts_of(impl_->workspace, impl_->state);
}

void Solver::start_statistics() {
  Impl& i = *impl_;
  if (i.state.statistics.recording != 0)
    throw std::logic_error(
        "statistics have begun; expected StatisticsOptions::deferred, and one call");
  i.complete_step();
  i.state.statistics.recording = 1;
  i.state.statistics.interval_start = i.state.steps;
  std::ranges::fill(i.state.peak_normal_force, 0);
  i.changed();
}

std::vector<ContactEvent> Solver::take_events() {
  return std::exchange(impl_->state.statistics.finished, {});
}

std::vector<ContactEvent> Solver::open_events() const {
  return firn::open_events(impl_->model, impl_->state);
}

std::vector<LoadInterval> Solver::take_load_intervals(bool up_to_now) {
  StatisticsState& stats = impl_->state.statistics;
  if (stats.triangles.empty() || stats.recording == 0) return {};
  if (up_to_now && impl_->state.steps > stats.interval_start)
    end_load_interval(impl_->model, impl_->state.steps, stats);
  std::vector<LoadInterval> intervals(stats.finished_intervals.size() / 2);
  auto next = stats.finished_triangles.begin();
  for (std::size_t k = 0; k < intervals.size(); ++k) {
    const auto end = next + static_cast<std::ptrdiff_t>(stats.triangles.size());
    intervals[k] = {
        stats.finished_intervals[2 * k], stats.finished_intervals[2 * k + 1], {next, end}};
    next = end;
  }
  stats.finished_intervals.clear();
  stats.finished_triangles.clear();
  return intervals;
}

const std::vector<CompressiveLoad>& Solver::compressive_loads() const {
  return impl_->state.statistics.opposed;
}
const std::vector<SurfaceSums>& Solver::surface_sums() const {
  return impl_->state.statistics.surfaces;
}
const std::vector<EnergySums>& Solver::energy_sums() const {
  return impl_->state.statistics.energies;
}

Solver::Load Solver::load(int particle) const {
  impl_->require_complete();
  const BodyLoad& load = impl_->state.load.at(static_cast<std::size_t>(particle));
  return {load.force, load.torque};
}

Solver::Load Solver::frame_load(int frame) const {
  const BodyLoad load = load_on_frame(impl_->model, impl_->state, frame);
  return {load.force, load.torque};
}

std::vector<PhaseTime> Solver::profile() const { return impl_->profile; }

std::vector<std::byte> Solver::save() const {
  impl_->require_complete();
  return pack(impl_->model, impl_->state);
}

void Solver::restore(const std::vector<std::byte>& bytes) {
  unpack(bytes, impl_->model, impl_->state);
  impl_->half_kick_pending = false;
  impl_->workspace.neighbor_list_rebuilt = true;
  impl_->changed();
}

std::vector<GroupHash> Solver::group_hashes() const {
  impl_->require_complete();
  return hash_groups(impl_->state);
}

std::uint64_t Solver::hash() const { return combined(group_hashes()); }

}  // namespace firn
