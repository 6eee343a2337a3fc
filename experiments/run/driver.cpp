#include "experiments/run/driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/case_reader/read_case.h"
#include "experiments/run/placement.h"

namespace firn {
namespace {

// Steps between two checks of outlets, the door, rest and the clock: far below any time of
// interest, and enough that the cost per step is negligible.
constexpr std::uint64_t kEventInterval = 16;
// Time between two checks for interference of parts, rounded up to a multiple of kEventInterval: a
// part at 1 m/s moves by 1 mm.
constexpr double kInterferenceEvery = 1e-3;  // s
constexpr double kReportEvery = 0.2;         // s of wall time

int find_boundary(const Model& model, const std::string& name, const std::string& source) {
  for (std::size_t i = 0; i < model.boundaries.size(); ++i)
    if (model.boundaries[i].name == name) return static_cast<int>(i);
  throw InputError(fmt::format("{}: stages: no boundary is named \"{}\"", source, name));
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void put(ByteWriter& out, const DriverState& state) {
  out.put(state.frames);
  out.put(state.loads_cleared);
  out.put(state.stage_start);
  out.put<std::uint64_t>(state.stages.size());
  for (const StageRecord& stage : state.stages) {
    out.put(stage.name);
    out.put(stage.start);
    out.put(stage.end);
    out.put(stage.end_reason);
  }
  out.put(state.statistics);
}

void get(ByteReader& in, DriverState& state) {
  in.get(state.frames);
  in.get(state.loads_cleared);
  in.get(state.stage_start);
  std::uint64_t stages = 0;
  in.get(stages);
  for (std::uint64_t i = 0; i < stages; ++i) {
    StageRecord& stage = state.stages.emplace_back();
    in.get(stage.name);
    in.get(stage.start);
    in.get(stage.end);
    in.get(stage.end_reason);
  }
  in.get(state.statistics);
}

// The same walk writes and reads.
template <class Each, class T, class P>
void walk(const Each& each, T& flow, P& watch) {
  each(flow.fill_batches);
  each(flow.inlet_batches);
  auto& p = flow.passages;
  for (auto* times : {&p.exit_time, &p.discharge_time, &p.insert_time}) each(*times);
  for (auto* numbers : {&p.outlet, &p.batch, &p.tag}) each(*numbers);
  for (auto& times : p.sensor_time) each(times);
  for (auto* since : {&watch.rest_since, &watch.force_since, &watch.torque_since,
                      &watch.filled_since, &watch.driven_since})
    each(*since);
  each(watch.driven_from);
  each(watch.stalled);
  each(watch.empty);
  each(watch.passed);
  each(watch.above_since);
  each(watch.closed);
  each(watch.changes);
}

template <class Each, class T>
void walk(const Each& each, T& samples) {
  each(samples.started);
  each(samples.last_step);
  each(samples.rows);
  each(samples.taken);
}

// Whether every list of a checkpoint is as long as the case needs it.
bool fits(const Case& c, std::size_t stages, const DriverState& state,
          const ParticleFlowState& flow) {
  const std::size_t n = c.model.particles.size();
  const ParticleEvents& p = flow.passages;
  const auto is_whole = [&](const auto& list) { return list.size() == n; };
  return !state.stages.empty() && state.stages.size() <= stages &&
         flow.fill_batches.size() == c.fills.size() &&
         flow.inlet_batches.size() == c.inlets.size() && is_whole(p.exit_time) &&
         is_whole(p.discharge_time) && is_whole(p.insert_time) && is_whole(p.outlet) &&
         is_whole(p.batch) && is_whole(p.tag) && p.sensor_time.size() == c.sensors.size() &&
         std::ranges::all_of(p.sensor_time, is_whole);
}

}  // namespace

Driver::Driver(const Case& c, const RunOptions& options, Recorder* recorder, RunObserver observer)
    : case_(c),
      options_(options),
      recorder_(recorder),
      observer_(std::move(observer)),
      solver_(unowned(c.model), options.threads),
      stages_(stages_of(c)),
      particle_flow_(c),
      watch_(c),
      interference_(c),
      sampler_(c, std::max<std::uint64_t>(1, to_steps(c, c.samples.interval))) {
  last_step_ = to_steps(case_, c.duration);
  // Without an interval, the first and the last frame alone.
  frame_steps_ = c.frame_interval > 0
                     ? std::max<std::uint64_t>(1, to_steps(case_, c.frame_interval))
                     : std::max<std::uint64_t>(1, last_step_);
  const std::uint64_t rounds = to_steps(case_, kInterferenceEvery) / kEventInterval;
  interference_steps_ = kEventInterval * std::max<std::uint64_t>(1, rounds);
  if (recorder_ && c.state_interval > 0)
    state_steps_ = std::max<std::uint64_t>(1, to_steps(case_, c.state_interval));
}

// A checkpoint of a case without samples has no bytes for them.
std::vector<std::byte> Driver::pack() const {
  ByteWriter out;
  put(out, state_);
  const auto put_value = [&](const auto& value) { out.put(value); };
  if (case_.samples.interval > 0) walk(put_value, sampler_.state);
  walk(put_value, particle_flow_.state, watch_.state);
  out.put(solver_.save());
  return out.take();
}

// Changes nothing if the bytes are invalid.
void Driver::unpack(const std::vector<std::byte>& payload) {
  ByteReader in(payload);
  DriverState state;
  get(in, state);
  SampleState samples;
  const auto get_value = [&](auto& value) { in.get(value); };
  if (case_.samples.interval > 0) walk(get_value, samples);
  ParticleFlowState flow = particle_flow_.state;
  StageEventState watch = watch_.state;
  walk(get_value, flow, watch);
  std::vector<std::byte> bytes;
  in.get(bytes);
  if (!fits(case_, stages_.size(), state, flow) || !sampler_.fits(samples) ||
      watch.closed.size() != case_.limit_switches.size() ||
      watch.above_since.size() != case_.limit_switches.size() ||
      std::ranges::any_of(watch.changes, [&](const SwitchChange& change) {
        return change.index < 0 || change.index >= std::ssize(case_.limit_switches);
      }))
    throw RunError("checkpoint does not fit the case");
  solver_.restore(bytes);
  state_ = std::move(state);
  particle_flow_.state = std::move(flow);
  watch_.state = std::move(watch);
  sampler_.state = std::move(samples);
  resumed_ = true;
  save_wanted_ = false;
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
      unpack(checkpoint.payload);
      safe_time_ = now();
      recorder_->truncate(state_.frames);
      recorder_->with_file([&](hdf5::File& file) {
        truncate_statistics(file, case_, state_.statistics);
        sampler_.truncate(file);
      });
      checkpoints_ = checkpoint.sequence;
      advise();
      return;
    } catch (const WriteError&) {
      throw;
    } catch (const RunError& e) {
      why = e.what();
    }
  }
  throw InputError(fmt::format("{}: cannot be resumed: {}", options_.results_file, why));
}

void Driver::restore(const std::vector<std::byte>& payload) { unpack(payload); }

RunSummary Driver::run() {
  RunSummary summary;
  std::optional<interruption::Polled> polled;
  if (options_.interrupt) polled.emplace();
  try {
    const std::string end_reason = simulate();
    summary.status = end_reason.empty() ? RunStatus::interrupted : RunStatus::finished;
    summary.reason = end_reason.empty() ? "interrupted; the state is saved" : end_reason;
    if (summary.status == RunStatus::finished) {
      record_sample();
      record_frame();
    }
    finalize_results(to_string(summary.status));
  } catch (const WriteError& e) {
    summary.status = RunStatus::failed;
    summary.reason = WriteError(e, recovery_hint(e)).what();
    summary.write_failed = true;
  } catch (const RunError& e) {
    summary.status = RunStatus::failed;
    summary.reason = e.what();
    try {
      finalize_results(fmt::format("failed: {}", e.what()));
    } catch (const WriteError& write) {
      summary.reason = fmt::format("{}; {}; {}", e.what(), write.what(), recovery_hint(write));
    }
  } catch (const InputError& e) {
    finalize_results(fmt::format("failed: {}", e.what()));
    throw;
  }
  solver_.complete_step();
  if (options_.progress) report();
  summary.simulated = now();
  summary.wall = seconds_since(started_);
  summary.steps = solver_.steps();
  summary.energy = solver_.energy();
  summary.diagnostics = solver_.diagnostics();
  summary.profile = solver_.profile();
  summary.advice = advice_;
  return summary;
}

std::string Driver::simulate() {
  if (options_.progress) report();
  if (!resumed_) {
    const interruption::NotPolled placing;
    place_start(solver_, case_);
    enter_stage(0);
  }
  while (true) {
    // The state is saved only here: at the begin of a step, before its events.
    const bool interrupted = options_.interrupt && *options_.interrupt;
    if (interrupted || save_wanted_) {
      // Before the first step there is no result to save: an interruption may end at once.
      std::optional<interruption::NotPolled> nothing_yet;
      if (solver_.steps() == 0) nothing_yet.emplace();
      save();
    }
    if (interrupted) return {};
    if (state_steps_ > 0 && solver_.steps() > 0 && solver_.steps() % state_steps_ == 0)
      save_state();
    if (const auto blocked = particle_flow_.place_due(solver_, stage_now())) {
      end_stage(*blocked);
      observe(true);
      record_frame();  // shows the particles in the way
      throw RunError(fmt::format("stage \"{}\" ended: {}", state_.stages.back().name, *blocked));
    }
    if (solver_.steps() % kEventInterval == 0) watch();
    if (solver_.steps() % interference_steps_ == 0) interference_.check(solver_);
    if (const auto by = watch_.end_reason(stage(), solver_, particle_flow_, stage_now())) {
      end_stage(*by);
      const bool last = state_.stages.size() == stages_.size();
      if (last || solver_.steps() >= last_step_) {
        observe(true);
        return fmt::format("stage \"{}\" ended: {}", state_.stages.back().name, *by);
      }
      enter_stage(state_.stages.size());
      save_wanted_ = true;
    }
    record_sample();
    if (solver_.steps() % frame_steps_ == 0) record_frame();
    if (!observe(false)) return {};
    solver_.step_deferred();
  }
}

bool Driver::observe(bool last) {
  if (!observer_.step) return true;
  solver_.complete_step();
  return observer_.step(solver_, last);
}

void Driver::watch() {
  solver_.complete_step();
  const bool left = particle_flow_.update(solver_);
  watch_.update(stage(), solver_, particle_flow_, stage_now(), left);
  if (seconds_since(saved_) >= options_.checkpoint_every) save_wanted_ = true;
  if (options_.progress && seconds_since(reported_) >= kReportEvery) report();
}

const Stage& Driver::stage() const {
  return stages_[std::max<std::size_t>(1, state_.stages.size()) - 1];
}

ParticleFlow::CurrentStage Driver::stage_now() const { return {&stage().name, state_.stage_start}; }

void Driver::end_stage(const std::string& by) {
  solver_.complete_step();  // the next stage may tag particles by their positions
  state_.stages.back().end = now();
  state_.stages.back().end_reason = by;
  solver_.stop_stage_motions(state_.stages.size(), now());
}

void Driver::enter_stage(std::size_t number) {
  const Stage& stage = stages_[number];
  state_.stages.push_back({stage.name, now(), std::numeric_limits<double>::quiet_NaN(), ""});
  state_.stage_start = solver_.steps();
  watch_.enter_stage();
  if (static_cast<int>(number) == case_.statistics_stage) solver_.start_statistics();
  sampler_.begin(solver_, static_cast<int>(number), recorder_ != nullptr);
  particle_flow_.tag(stage.name, solver_);
  for (const std::string& name : stage.remove)
    solver_.remove_boundary(find_boundary(case_.model, name, case_.source));
  const auto begin = [&](Schedule& schedule, bool ends_with_stage) {
    schedule.start += now();
    schedule.stop += now();
    return ends_with_stage ? static_cast<int>(number) + 1 : 0;
  };
  for (Stage::StartedMotion start : stage.motions) {
    const int group = begin(start.motion, start.ends_with_stage);
    if (start.frame >= 0)
      solver_.add_frame_motion(start.frame, start.motion, group);
    else
      solver_.add_motion(start.boundary, start.motion, group);
  }
  for (Stage::StageMotor start : stage.motors) {
    const int group = begin(start.motor, start.ends_with_stage);
    solver_.add_motor(start.frame, start.axis, start.motor, group);
  }
}

void Driver::record_frame() {
  const double interval =
      static_cast<double>(solver_.steps() - state_.loads_cleared) * case_.model.timestep;
  if (recorder_ || observer_.frame) {
    solver_.complete_step();
    std::vector<double> row = frame_row(solver_, case_, interval);
    if (observer_.frame) observer_.frame(state_.frames, row);
    if (recorder_) recorder_->push(std::move(row));
  }
  sampler_.before_clearing(solver_);
  solver_.clear_boundary_loads();
  state_.loads_cleared = solver_.steps();
  ++state_.frames;
}

void Driver::record_sample() {
  if (!sampler_.ends_interval(solver_.steps())) return;
  solver_.complete_step();
  sampler_.take(solver_, recorder_ != nullptr);
  if (sampler_.is_full()) write_samples();
}

void Driver::write_samples() {
  if (recorder_) recorder_->with_file([&](hdf5::File& file) { sampler_.write(file); });
}

void Driver::save() {
  save_wanted_ = false;
  saved_ = Clock::now();
  write_statistics(false);
  write_samples();
  if (!recorder_) return;
  solver_.complete_step();
  const std::vector<std::byte> payload = pack();
  recorder_->with_file([&](hdf5::File& file) {
    write_progress(file);
    write_checkpoint(file, {++checkpoints_, payload});
    recorder_->lock().save_copy();
  });
  safe_time_ = now();
  recorder_->lock().require_in_place();
  {
    const interruption::Uninterrupted kept;
    for (interruption::Temporary& file : unsaved_) file.keep();
    advise();
  }
  saved_ = Clock::now();
}

// The results file has a checkpoint from which a run can resume.
void Driver::advise() {
  if (!advice_)
    advice_ = std::make_shared<const interruption::Advice>("resume with: firn run --resume " +
                                                           options_.results_file);
}

// Writes the same bytes whether or not the run was interrupted: a resumed run writes some again.
void Driver::save_state() {
  solver_.complete_step();
  write_statistics(false);
  write_samples();
  const std::vector<std::byte> payload = pack();
  recorder_->with_file([&](hdf5::File& file) { write_state(file, solver_.steps(), payload); });
}

// Statistics that the solver has finished are written before the state. Without a results file they
// are dropped: observers do not use them.
void Driver::write_statistics(bool at_end) {
  if (!case_.model.statistics.any()) return;
  if (!recorder_) {
    solver_.take_events();
    solver_.take_load_intervals();
    return;
  }
  recorder_->with_file([&](hdf5::File& file) {
    append_statistics(file, case_, solver_, at_end, state_.statistics);
  });
}

void Driver::report() {
  Progress progress;
  progress.time = now();
  progress.end_time_limit =
      observer_.end_time_limit > 0 ? observer_.end_time_limit : case_.duration;
  progress.stage = stage().name;
  progress.wall = seconds_since(started_);
  for (Presence presence : solver_.particles().presence) {
    if (presence == Presence::present) ++progress.present;
    if (presence == Presence::pending) ++progress.waiting;
    if (presence == Presence::removed) ++progress.left;
  }
  for (std::size_t g = 0; g < case_.sensors.size(); ++g)
    progress.passed.push_back(
        {case_.sensors[g].name, particle_flow_.passed(static_cast<int>(g), 0)});
  options_.progress(progress);
  reported_ = Clock::now();
}

void Driver::write_progress(hdf5::File& file) {
  write_particles(file, solver_.particles().peak_normal_force, particle_flow_.state.passages);
  write_stages(file, stages_, state_.stages);
  write_switches(file, case_, watch_.state.changes);
  write_bonds(file, case_, solver_.bonds());
  file.set_attribute("/", "wall_time", wall_before_ + seconds_since(started_));
}

void Driver::finalize_results(const std::string& status) {
  if (!recorder_) return;
  solver_.complete_step();
  if (status != to_string(RunStatus::interrupted)) write_statistics(true);
  write_samples();
  recorder_->with_file([&](hdf5::File& file) {
    write_progress(file);
    file.flush();  // before the status: a full disk must not leave one without its data
    file.set_attribute("/", "status", status);
    file.flush();
    if (status == to_string(RunStatus::finished)) remove_checkpoints(file);
  });
  recorder_->close();
  concluded_ = true;
}

std::string Driver::recovery_hint(const WriteError& e) const {
  const std::string& file = options_.results_file;
  if (safe_time_ && has_saved_copy(file))
    return fmt::format(
        "the state at t = {:.4g} s is safe in {}: {}continue with firn run --resume {}",
        *safe_time_, saved_copy(file), remedy(e.error), file);
  return fmt::format("no state of the run was saved: {}start it again", remedy(e.error));
}

}  // namespace firn
