#include "experiments/run/stage_events.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/case_reader/read_case.h"

namespace firn {
namespace {

using EndEvent = Stage::EndEvent;

constexpr double kStalled = 0.1;       // of a motor's speed
constexpr double kMaxRestSpeed = 0.1;  // m/s: a falling particle is faster after 0.5 mm

double kinetic_energy(const Shape& shape, const ParticleState& state, std::size_t i) {
  const Vec3 w = state.orientation[i].conjugate() * state.angular_velocity[i];  // body axes
  return 0.5 *
         (shape.mass * state.velocity[i].squaredNorm() + shape.inertia.dot(w.cwiseProduct(w)));
}

void keep_since(bool holds, const Solver& solver, std::int64_t& since) {
  if (!holds)
    since = -1;
  else if (since < 0)
    since = static_cast<std::int64_t>(solver.steps());
}

// The largest speed that motors of the axis drive at present; 0: none acts.
double driven_speed(const Case& c, const Stage& stage, const Solver& solver, int frame, int axis,
                    double stage_time) {
  double speed = 0;
  for (const Motor& d : c.model.frames[index(frame)].free->joints[index(axis)].motors)
    if (d.acts(solver.time())) speed = std::max(speed, std::abs(d.speed));
  for (const Stage::StageMotor& d : stage.motors) {
    if (d.frame == frame && d.axis == axis && d.motor.acts(stage_time))
      speed = std::max(speed, std::abs(d.motor.speed));
  }
  return speed;
}

}  // namespace

StageEvents::StageEvents(const Case& c) : case_(c) {
  state.above_since.assign(c.limit_switches.size(), -1);
  state.closed.assign(c.limit_switches.size(), 0);
}

void StageEvents::enter_stage() {
  state.rest_since = state.force_since = state.torque_since = -1;
  state.filled_since = state.driven_since = -1;
  state.empty = state.passed = state.stalled = 0;
}

void StageEvents::update_switches(const Solver& solver) {
  if (case_.limit_switches.empty()) return;
  const std::vector<FrameState> frames = solver.frames();
  for (std::size_t i = 0; i < case_.limit_switches.size(); ++i) {
    const LimitSwitch& s = case_.limit_switches[i];
    const FrameState& frame = frames[index(s.frame)];
    const double coordinate = frame.joints[index(s.axis)].coordinate;
    if (state.closed[i]) {
      if (coordinate >= s.opens_at) continue;
      state.closed[i] = 0;
      state.changes.push_back({static_cast<std::int64_t>(i), solver.time(), 0});
    }
    keep_since(coordinate >= s.closes_at && !frame.driven, solver, state.above_since[i]);
    const std::int64_t since = state.above_since[i];
    if (since < 0 || solver.steps() < static_cast<std::uint64_t>(since) + to_steps(case_, s.hold))
      continue;
    state.closed[i] = 1;
    state.above_since[i] = -1;
    state.changes.push_back({static_cast<std::int64_t>(i), solver.time(), 1});
  }
}

// A motor has stalled if it has moved its joint by less than a tenth of the commanded distance in
// the hold time. Only the distance between begin and end of the hold time counts.
void StageEvents::update_motor_progress(const Stage& stage, const Solver& solver,
                                        std::uint64_t stage_start) {
  const double stage_time =
      static_cast<double>(solver.steps() - stage_start) * case_.model.timestep;
  const double wanted =
      driven_speed(case_, stage, solver, stage.stall_frame, stage.stall_axis, stage_time);
  if (!(wanted > 0)) {
    state.driven_since = -1;
    return;
  }
  const double coordinate =
      solver.frames()[index(stage.stall_frame)].joints[index(stage.stall_axis)].coordinate;
  const auto step = static_cast<std::int64_t>(solver.steps());
  if (state.driven_since >= 0) {
    const auto hold = static_cast<std::int64_t>(to_steps(case_, stage.stall_hold));
    if (step < state.driven_since + hold) return;
    state.stalled = std::abs(coordinate - state.driven_from) < kStalled * wanted * stage.stall_hold;
  }
  state.driven_since = step;
  state.driven_from = coordinate;
}

// The mean kinetic energy of the present particles is below the stage's bound.
bool StageEvents::is_quiet(const Stage& stage, const Solver& solver) const {
  const Model& model = solver.model();
  const ParticleState& particles = solver.particles();
  double total = 0;
  std::size_t present = 0;
  for (std::size_t i = 0; i < particles.presence.size(); ++i) {
    if (particles.presence[i] != Presence::present) continue;
    total += kinetic_energy(model.shapes[index(model.particles[i].shape)], particles, i);
    ++present;
  }
  return total <= stage.settle_energy * static_cast<double>(present);
}

// A particle is also slow at its insertion and at the top of a bounce: hence the hold time.
bool StageEvents::is_filled(const Stage& stage, const Solver& solver) const {
  const Vec3 up = -case_.model.gravity.normalized();
  const ParticleState& particles = solver.particles();
  int above = 0;
  for (std::size_t i = 0; i < particles.presence.size(); ++i) {
    above += particles.presence[i] == Presence::present &&
             particles.position[i].dot(up) >= stage.fill_height &&
             particles.velocity[i].norm() < kMaxRestSpeed;
  }
  return above >= stage.fill_count;
}

void StageEvents::update(const Stage& stage, const Solver& solver, const ParticleFlow& flow,
                         const ParticleFlow::CurrentStage& now, bool left) {
  update_switches(solver);
  if (stage.ends_on(EndEvent::settled))
    keep_since(!left && flow.all_placed(now) && is_quiet(stage, solver), solver, state.rest_since);
  if (stage.ends_on(EndEvent::stalled)) update_motor_progress(stage, solver, now.stage_start);
  if (stage.ends_on(EndEvent::empty)) {
    state.empty = flow.all_placed(now) &&
                  std::ranges::none_of(solver.particles().presence,
                                       [](Presence p) { return p == Presence::present; });
  }
  if (stage.ends_on(EndEvent::passed)) {
    const double from = static_cast<double>(now.stage_start) * case_.model.timestep;
    state.passed = stage.count > 0
                       ? flow.passed(stage.sensor, from) >= static_cast<std::size_t>(stage.count)
                       : flow.passed_mass(stage.sensor, from) >= stage.mass;
  }
  if (stage.ends_on(EndEvent::force))
    keep_since(solver.frame_load(stage.force_frame).force.norm() > stage.force, solver,
               state.force_since);
  if (stage.ends_on(EndEvent::torque))
    keep_since(solver.frame_load(stage.torque_frame).moment.norm() > stage.torque, solver,
               state.torque_since);
  if (stage.ends_on(EndEvent::filled))
    keep_since(is_filled(stage, solver), solver, state.filled_since);
}

// "12 of 75 particles came through \"container\"": a closed outlet, or a jam.
std::string StageEvents::shortfall(const Stage& stage, const ParticleFlow& flow,
                                   const ParticleFlow::CurrentStage& now) const {
  const double from = static_cast<double>(now.stage_start) * case_.model.timestep;
  const std::string& sensor = case_.sensors[index(stage.sensor)].name;
  if (stage.count > 0)
    return fmt::format("{} of {} particles came through \"{}\"", flow.passed(stage.sensor, from),
                       stage.count, sensor);
  return fmt::format("{:.4g} of {:.4g} kg came through \"{}\"",
                     flow.passed_mass(stage.sensor, from), stage.mass, sensor);
}

std::optional<std::string> StageEvents::end_reason(const Stage& stage, const Solver& solver,
                                                   const ParticleFlow& flow,
                                                   const ParticleFlow::CurrentStage& now) const {
  const std::uint64_t step = solver.steps(), in_stage = step - now.stage_start;
  if (step >= to_steps(case_, case_.duration)) return "end of the case";
  if (stage.max_duration > 0 && in_stage >= to_steps(case_, stage.max_duration)) {
    const bool by_time = stage.end_when.empty() || stage.ends_on(EndEvent::time);
    if (by_time) return "time";
    if (stage.ends_on(EndEvent::passed)) return "time limit: " + shortfall(stage, flow, now);
    return "time limit";
  }
  if (in_stage < to_steps(case_, stage.min_duration)) return std::nullopt;
  const auto held = [&](EndEvent event, std::int64_t since, double hold) {
    return stage.ends_on(event) && since >= 0 &&
           step >= static_cast<std::uint64_t>(since) + to_steps(case_, hold);
  };
  if (held(EndEvent::settled, state.rest_since, stage.settle_time)) return "settled";
  if (state.stalled)
    return fmt::format("stalled: {}", describe_jam(case_, solver, stage.stall_frame));
  if (state.empty) return "empty";
  if (state.passed) return fmt::format("passed \"{}\"", case_.sensors[index(stage.sensor)].name);
  if (held(EndEvent::force, state.force_since, stage.force_hold)) return "force";
  if (held(EndEvent::torque, state.torque_since, stage.torque_hold)) return "torque";
  if (held(EndEvent::filled, state.filled_since, stage.fill_hold)) return "filled";
  if (stage.ends_on(EndEvent::switched) && state.closed[index(stage.closed_switch)])
    return fmt::format("switch \"{}\"", case_.limit_switches[index(stage.closed_switch)].name);
  return std::nullopt;
}

std::string describe_jam(const Case& c, const Solver& solver, int frame) {
  const auto carried = [&](int boundary) {
    return descends_from(c.model.frames, c.model.boundaries[index(boundary)].frame, frame);
  };
  const int n = static_cast<int>(c.model.particles.size());
  const std::vector<Contact> contacts = solver.contacts();
  const Contact* worst = nullptr;
  for (const Contact& contact : contacts) {
    if (contact.b < n || !carried(contact.b - n)) continue;
    if (worst == nullptr || contact.normal_force > worst->normal_force) worst = &contact;
  }
  if (worst == nullptr || worst->normal_force <= 0)
    return fmt::format("\"{}\" touches no particle", c.model.frames[index(frame)].name);
  // The largest other contact of the particle: the body that it jams against.
  const Contact* against = nullptr;
  for (const Contact& contact : contacts) {
    if (&contact == worst || (contact.a != worst->a && contact.b != worst->a)) continue;
    if (against == nullptr || contact.normal_force > against->normal_force) against = &contact;
  }
  const auto name = [&](int body) {
    return body < n ? fmt::format("particle {}", body)
                    : fmt::format("boundary \"{}\"", c.model.boundaries[index(body - n)].name);
  };
  std::string text = fmt::format("{} presses particle {} with {:.3g} N at ({:.3f} {:.3f} {:.3f}) m",
                                 name(worst->b), worst->a, worst->normal_force, worst->position.x(),
                                 worst->position.y(), worst->position.z());
  if (against != nullptr && against->normal_force > 0)
    text +=
        fmt::format(", against {} with {:.3g} N",
                    name(against->a == worst->a ? against->b : against->a), against->normal_force);
  return text;
}

}  // namespace firn
