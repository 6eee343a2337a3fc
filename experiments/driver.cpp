#include "experiments/driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/placement.h"

namespace firn {
namespace {

// Steps between two looks at outlets, the door, rest and the clock: far below any time of interest,
// and so few that a step does not notice them.
constexpr std::uint64_t kWatchInterval = 16;
constexpr double kReportEvery = 0.2;  // s of wall time

constexpr std::size_t index(int i) { return static_cast<std::size_t>(i); }

int find_boundary(const Model& model, const std::string& name, const std::string& source) {
  for (std::size_t i = 0; i < model.boundaries.size(); ++i)
    if (model.boundaries[i].name == name) return static_cast<int>(i);
  throw InputError(fmt::format("{}: stages: no boundary is named \"{}\"", source, name));
}

double kinetic_energy(const Shape& shape, const ParticleState& state, std::size_t i) {
  const Vec3 w = state.orientation[i].conjugate() * state.angular_velocity[i];  // body axes
  return 0.5 *
         (shape.mass * state.velocity[i].squaredNorm() + shape.inertia.dot(w.cwiseProduct(w)));
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::vector<std::byte> pack(const DriverState& state, const std::vector<std::byte>& solver) {
  ByteWriter out;
  out.put(state.frames);
  out.put(state.loads_cleared);
  out.put(state.stage_start);
  out.put(state.rest_since);
  out.put<std::uint64_t>(state.stages.size());
  for (const StageRecord& stage : state.stages) {
    out.put(stage.name);
    out.put(stage.start);
    out.put(stage.end);
    out.put(stage.ended_by);
  }
  out.put(state.batches);
  out.put(state.passages.exit_time);
  out.put(state.passages.door_time);
  out.put(state.statistics);
  out.put(solver);
  return out.take();
}

DriverState unpack(const std::vector<std::byte>& payload, std::vector<std::byte>& solver) {
  ByteReader in(payload);
  DriverState state;
  in.get(state.frames);
  in.get(state.loads_cleared);
  in.get(state.stage_start);
  in.get(state.rest_since);
  std::uint64_t stages = 0;
  in.get(stages);
  for (std::uint64_t i = 0; i < stages; ++i) {
    StageRecord& stage = state.stages.emplace_back();
    in.get(stage.name);
    in.get(stage.start);
    in.get(stage.end);
    in.get(stage.ended_by);
  }
  in.get(state.batches);
  in.get(state.passages.exit_time);
  in.get(state.passages.door_time);
  in.get(state.statistics);
  in.get(solver);
  return state;
}

Model with_threads(Model model, int threads) {
  model.numerics.threads = threads;
  return model;
}

}  // namespace

Driver::Driver(const Case& c, const RunOptions& options, Recorder* recorder, Onlooker onlooker)
    : case_(c),
      options_(options),
      recorder_(recorder),
      onlooker_(std::move(onlooker)),
      solver_(with_threads(c.model, options.threads)),
      stages_(stages_of(c)) {
  const std::size_t particles = c.model.particles.size();
  std::size_t next = particles;
  for (const Fill& fill : c.fills) next -= index(fill.count);
  for (const Fill& fill : c.fills) {
    first_of_fill_.push_back(static_cast<int>(next));
    next += index(fill.count);
  }
  last_step_ = to_steps(c.duration);
  // Without an interval, the first and the last frame alone.
  frame_steps_ = c.frames_every > 0 ? std::max<std::uint64_t>(1, to_steps(c.frames_every))
                                    : std::max<std::uint64_t>(1, last_step_);
  if (recorder_ && c.states_every > 0)
    kept_steps_ = std::max<std::uint64_t>(1, to_steps(c.states_every));
  const std::vector<double> never(particles, std::numeric_limits<double>::quiet_NaN());
  state_.passages = {never, never};
  state_.batches.assign(c.fills.size(), 0);
}

void Driver::restore() {
  std::vector<Checkpoint> checkpoints;
  recorder_->with_file([&](hdf5::File& file) {
    checkpoints = read_checkpoints(file);
    wall_before_ = file.number_attribute("/", "wall_time").at(0);
  });
  std::string why = "it has no whole checkpoint";
  for (const Checkpoint& checkpoint : checkpoints) {
    try {
      std::vector<std::byte> bytes;
      DriverState state = unpack(checkpoint.payload, bytes);
      recorder_->truncate(state.frames);
      recorder_->with_file(
          [&](hdf5::File& file) { truncate_statistics(file, case_, state.statistics); });
      solver_.restore(bytes);
      state_ = std::move(state);
      checkpoints_ = checkpoint.sequence;
      resumed_ = true;
      save_wanted_ = false;
      return;
    } catch (const RunError& e) {
      why = e.what();
    }
  }
  throw InputError(fmt::format("{}: cannot be resumed: {}", options_.results_file, why));
}

void Driver::restore(const std::vector<std::byte>& payload) {
  std::vector<std::byte> bytes;
  state_ = unpack(payload, bytes);
  solver_.restore(bytes);
  resumed_ = true;
  save_wanted_ = false;
}

RunSummary Driver::run() {
  RunSummary summary;
  try {
    const std::string ended_by = simulate();
    summary.status = ended_by.empty() ? RunStatus::interrupted : RunStatus::finished;
    summary.reason = ended_by.empty() ? "interrupted; the state is saved" : ended_by;
    if (summary.status == RunStatus::finished) record_frame();
    conclude(to_string(summary.status));
  } catch (const WriteError& e) {
    // The file is left as a kill would leave it: once there is room again, the run can go on.
    summary.status = RunStatus::failed;
    summary.reason = e.what();
  } catch (const RunError& e) {
    summary.status = RunStatus::failed;
    summary.reason = e.what();
    try {
      conclude(fmt::format("failed: {}", e.what()));
    } catch (const RunError&) {
      // The results file itself is what failed; the summary says so.
    }
  } catch (const InputError& e) {
    conclude(fmt::format("failed: {}", e.what()));
    throw;
  }
  if (options_.progress) report();
  summary.simulated = now();
  summary.wall = seconds_since(started_);
  summary.steps = solver_.steps();
  summary.energy = solver_.energy();
  summary.health = solver_.health();
  summary.profile = solver_.profile();
  return summary;
}

std::string Driver::simulate() {
  if (options_.progress) report();
  if (!resumed_) {
    for (const Case::Placed& p : case_.placed)
      solver_.insert(p.particle, p.position, p.orientation, p.velocity, p.angular_velocity);
    enter_stage(0);
  }
  while (true) {
    // Nothing of this step has happened yet: the one place where the state is saved.
    if (options_.interrupt && *options_.interrupt) {
      save();
      return {};
    }
    if (save_wanted_) save();
    if (kept_steps_ > 0 && solver_.steps() > 0 && solver_.steps() % kept_steps_ == 0) keep_state();
    place_due_batches();
    if (solver_.steps() % kWatchInterval == 0) watch();
    if (const std::optional<std::string> ended_by = stage_end()) {
      state_.stages.back().end = now();
      state_.stages.back().ended_by = *ended_by;
      const bool last = state_.stages.size() == stages_.size();
      if (last || solver_.steps() >= last_step_) {
        look(true);
        return fmt::format("stage \"{}\" ended: {}", state_.stages.back().name, *ended_by);
      }
      enter_stage(state_.stages.size());
      save_wanted_ = true;
    }
    if (solver_.steps() % frame_steps_ == 0) record_frame();
    if (!look(false)) return {};
    solver_.step();
  }
}

bool Driver::look(bool last) { return !onlooker_.step || onlooker_.step(solver_, last); }

void Driver::place_due_batches() {
  for (std::size_t i = 0; i < case_.fills.size(); ++i) {
    const Fill& fill = case_.fills[i];
    std::uint64_t& placed = state_.batches[i];
    while (placed < batch_count(fill) &&
           solver_.steps() >= to_steps(fill.start + static_cast<double>(placed) * fill.interval)) {
      const int size = fill.batch > 0 ? fill.batch : fill.count;
      const int before = static_cast<int>(placed) * size;
      place_batch(solver_, case_, i, placed, first_of_fill_[i] + before,
                  std::min(size, fill.count - before));
      ++placed;
    }
  }
}

void Driver::watch() {
  const bool left = let_out();
  if (left || !is_quiet())
    state_.rest_since = -1;
  else if (state_.rest_since < 0)
    state_.rest_since = static_cast<std::int64_t>(solver_.steps());
  if (seconds_since(saved_) >= options_.checkpoint_every) save_wanted_ = true;
  if (options_.progress && seconds_since(reported_) >= kReportEvery) report();
}

// Notes passages through the door and removes what has passed an outlet; true when something has.
bool Driver::let_out() {
  const ParticleState& state = solver_.particles();
  bool left = false;
  for (std::size_t i = 0; i < state.presence.size(); ++i) {
    if (state.presence[i] != Presence::present) continue;
    const Vec3 position = state.position[i];
    double& door_time = state_.passages.door_time[i];
    if (case_.drained_repose && std::isnan(door_time) &&
        position.z() < -case_.drained_repose->floor_thickness)
      door_time = now();
    for (const Outlet& outlet : case_.outlets) {
      if ((position - outlet.point).dot(outlet.normal) <= 0) continue;
      state_.passages.exit_time[i] = now();
      solver_.remove_particle(static_cast<int>(i));
      left = true;
      break;
    }
  }
  return left;
}

// Everybody that is to come has been there.
bool Driver::all_placed() const {
  for (std::size_t i = 0; i < case_.fills.size(); ++i)
    if (state_.batches[i] < batch_count(case_.fills[i])) return false;
  return true;
}

// Everybody that is to come is there, and the mean kinetic energy is below the stage's bound.
bool Driver::is_quiet() const {
  const Stage& stage = this->stage();
  if (stage.until != Stage::Until::at_rest || !all_placed()) return false;
  const Model& model = solver_.model();
  const ParticleState& state = solver_.particles();
  double total = 0;
  std::size_t present = 0;
  for (std::size_t i = 0; i < state.presence.size(); ++i) {
    if (state.presence[i] != Presence::present) continue;
    total += kinetic_energy(model.shapes[index(model.particles[i].shape)], state, i);
    ++present;
  }
  return total <= stage.rest_kinetic_energy * static_cast<double>(present);
}

std::optional<std::string> Driver::stage_end() const {
  const Stage& stage = this->stage();
  const std::uint64_t step = solver_.steps();
  const std::uint64_t in_stage = step - state_.stage_start;
  if (step >= last_step_) return "end of the case";
  if (stage.max_duration > 0 && in_stage >= to_steps(stage.max_duration))
    return stage.until == Stage::Until::time ? "time" : "time limit";
  if (stage.until == Stage::Until::at_rest && state_.rest_since >= 0 &&
      in_stage >= to_steps(stage.min_duration) &&
      step >= static_cast<std::uint64_t>(state_.rest_since) + to_steps(stage.rest_hold))
    return "at rest";
  if (stage.until == Stage::Until::empty && in_stage >= to_steps(stage.min_duration) &&
      step % kWatchInterval == 0 && all_placed() &&
      std::ranges::none_of(solver_.particles().presence,
                           [](Presence p) { return p == Presence::present; }))
    return "empty";
  return std::nullopt;
}

const Stage& Driver::stage() const {
  return stages_[std::max<std::size_t>(1, state_.stages.size()) - 1];
}

void Driver::enter_stage(std::size_t number) {
  const Stage& stage = stages_[number];
  state_.stages.push_back({stage.name, now(), std::numeric_limits<double>::quiet_NaN(), ""});
  state_.stage_start = solver_.steps();
  state_.rest_since = -1;
  for (const std::string& name : stage.remove)
    solver_.remove_boundary(find_boundary(case_.model, name, case_.source));
  for (const auto& [name, relative] : stage.start_motions) {
    Motion motion = relative;
    motion.start += now();
    motion.stop += now();
    solver_.add_motion(find_boundary(case_.model, name, case_.source), motion);
  }
}

void Driver::record_frame() {
  const double interval =
      static_cast<double>(solver_.steps() - state_.loads_cleared) * case_.model.timestep;
  if (recorder_ || onlooker_.frame) {
    std::vector<double> row = result_row(solver_, interval);
    if (onlooker_.frame) onlooker_.frame(state_.frames, row);
    if (recorder_) recorder_->push(std::move(row));
  }
  solver_.clear_boundary_loads();
  state_.loads_cleared = solver_.steps();
  ++state_.frames;
}

void Driver::save() {
  save_wanted_ = false;
  saved_ = Clock::now();
  hand_over_statistics(false);
  if (!recorder_) return;
  const std::vector<std::byte> payload = pack(state_, solver_.save());
  recorder_->with_file([&](hdf5::File& file) {
    write_particles(file, solver_.particles().peak_normal_force, state_.passages);
    write_stages(file, stages_, state_.stages);
    file.set_attribute("/", "wall_time", wall_before_ + seconds_since(started_));
    write_checkpoint(file, {++checkpoints_, payload});
    keep_copy(options_.results_file);
  });
  saved_ = Clock::now();
}

// The same bytes whether or not the run was interrupted on its way: a resumed one writes some
// again.
void Driver::keep_state() {
  hand_over_statistics(false);
  const std::vector<std::byte> payload = pack(state_, solver_.save());
  recorder_->with_file([&](hdf5::File& file) { write_state(file, solver_.steps(), payload); });
}

// What the solver has finished goes into the file before its state does, or nowhere: whoever looks
// on has no use for it.
void Driver::hand_over_statistics(bool at_end) {
  if (!case_.model.statistics.any()) return;
  if (!recorder_) {
    solver_.take_events();
    solver_.take_load_intervals();
    return;
  }
  recorder_->with_file(
      [&](hdf5::File& file) { append_statistics(file, case_, solver_, at_end, state_.statistics); });
}

void Driver::report() {
  Progress progress;
  progress.time = now();
  progress.latest_end = onlooker_.latest_end > 0 ? onlooker_.latest_end : case_.duration;
  progress.stage = stage().name;
  progress.wall = seconds_since(started_);
  for (Presence presence : solver_.particles().presence) {
    if (presence == Presence::present) ++progress.present;
    if (presence == Presence::waiting) ++progress.waiting;
    if (presence == Presence::left) ++progress.left;
  }
  options_.progress(progress);
  reported_ = Clock::now();
}

void Driver::conclude(const std::string& status) {
  if (!recorder_) return;
  if (status != to_string(RunStatus::interrupted)) hand_over_statistics(true);
  recorder_->with_file([&](hdf5::File& file) {
    write_particles(file, solver_.particles().peak_normal_force, state_.passages);
    write_stages(file, stages_, state_.stages);
    file.set_attribute("/", "wall_time", wall_before_ + seconds_since(started_));
    file.flush();  // a full disk must not leave a run that says more than is there
    file.set_attribute("/", "status", status);
    file.flush();
    if (status == to_string(RunStatus::finished)) remove_checkpoints(file);
  });
  recorder_->close();
}

std::uint64_t Driver::to_steps(double seconds) const {
  return static_cast<std::uint64_t>(std::max(0LL, std::llround(seconds / case_.model.timestep)));
}

std::uint64_t Driver::batch_count(const Fill& fill) const {
  return fill.batch > 0 ? static_cast<std::uint64_t>((fill.count + fill.batch - 1) / fill.batch)
                        : 1;
}

}  // namespace firn
