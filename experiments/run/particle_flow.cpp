#include "experiments/run/particle_flow.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/case_reader/process/insertion.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/run/placement.h"
#include "experiments/system/interruption.h"

namespace firn {
namespace {

constexpr double kNever = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint64_t kNotNow = ~std::uint64_t{0};

// A body of an inlet may touch what holds it: this much overlap is none.
constexpr double kSeat = 0.2e-3;  // m

bool belongs(const std::string& stage, const ParticleFlow::CurrentStage& now) {
  return stage.empty() || stage == *now.stage;
}

}  // namespace

std::uint64_t batch_count(const Fill& fill) {
  return fill.batch > 0 ? static_cast<std::uint64_t>((fill.count + fill.batch - 1) / fill.batch)
                        : 1;
}

ParticleFlow::ParticleFlow(const Case& c) : case_(c) {
  first_of_source_ = first_inlet_particles(c);
  std::size_t next =
      first_of_source_.empty() ? c.model.particles.size() : index(first_of_source_.front());
  for (const Fill& fill : c.fills) next -= index(fill.count);
  for (const Fill& fill : c.fills) {
    first_of_fill_.push_back(static_cast<int>(next));
    next += index(fill.count);
  }
  state.fill_batches.assign(c.fills.size(), 0);
  state.inlet_batches.assign(c.inlets.size(), 0);
  state.passages = ParticleEvents(c);
}

std::uint64_t ParticleFlow::due(double start, double interval, std::uint64_t batch,
                                const std::string& stage, const CurrentStage& now) const {
  if (!belongs(stage, now)) return kNotNow;
  const std::uint64_t from = stage.empty() ? 0 : now.stage_start;
  return from + to_steps(case_, start + static_cast<double>(batch) * interval);
}

void ParticleFlow::record_batch(int first, int count, std::uint64_t batch, int tag, double time) {
  for (int i = first; i < first + count; ++i) {
    state.passages.insert_time[index(i)] = time;
    state.passages.batch[index(i)] = static_cast<int>(batch);
    state.passages.tag[index(i)] = tag;
  }
}

std::optional<std::string> ParticleFlow::place_due(Solver& solver, const CurrentStage& now) {
  for (std::size_t i = 0; i < case_.fills.size(); ++i) {
    const Fill& fill = case_.fills[i];
    std::uint64_t& placed = state.fill_batches[i];
    while (placed < batch_count(fill) &&
           solver.steps() >= due(fill.start, fill.interval, placed, fill.stage, now)) {
      const int size = fill.batch > 0 ? fill.batch : fill.count;
      const int before = static_cast<int>(placed) * size,
                count = std::min(size, fill.count - before);
      const int first = first_of_fill_[i] + before;
      {
        const interruption::NotPolled placing;
        place_batch(solver, case_, i, placed, first, count);
      }
      const int tag = fill.tag + (fill.tag_by_batch ? static_cast<int>(placed) : 0);
      record_batch(first, count, placed, tag, solver.time());
      ++placed;
    }
  }
  for (std::size_t i = 0; i < case_.inlets.size(); ++i) {
    const Inlet& source = case_.inlets[i];
    while (state.inlet_batches[i] < static_cast<std::uint64_t>(source.batches) &&
           solver.steps() >=
               due(source.start, source.interval, state.inlet_batches[i], source.stage, now)) {
      if (auto blocked = insert_inlet_batch(solver, i)) return blocked;
    }
  }
  return std::nullopt;
}

std::optional<std::string> ParticleFlow::insert_inlet_batch(Solver& solver, std::size_t number) {
  const Inlet& source = case_.inlets[number];
  std::uint64_t& placed = state.inlet_batches[number];
  const int count = static_cast<int>(source.batch_size());
  const int first = first_of_source_[number] + static_cast<int>(placed) * count;
  const int particles = static_cast<int>(case_.model.particles.size());
  std::vector<InletPose> poses;
  for (int i = 0; i < count; ++i) {
    poses.push_back(inlet_pose(source, index(i), first + i, case_.seed));
    const int shape = case_.model.particles[index(first + i)].shape;
    const auto body =
        solver.obstacle(shape, poses.back().position, poses.back().orientation, -kSeat);
    if (!body) continue;
    const std::string taken_by =
        *body < particles
            ? fmt::format("particle {}", *body)
            : fmt::format("boundary \"{}\"", case_.model.boundaries[index(*body - particles)].name);
    if (placed == 0 && (*body >= particles || solver.steps() == 0)) {
      const std::string place = number < case_.inlet_places.size() ? case_.inlet_places[number]
                                                                   : case_.source + ": inlets";
      throw InputError(
          fmt::format("{}: body {} of \"{}\" at t = {:.6g} s overlaps {}; expected a free place",
                      place, i + 1, source.name, solver.time(), taken_by));
    }
    return fmt::format("inlet \"{}\" is blocked: place {} of batch {} is taken by {}", source.name,
                       i + 1, placed + 1, taken_by);
  }
  for (int i = 0; i < count; ++i)
    solver.insert(first + i, poses[index(i)].position, poses[index(i)].orientation, source.velocity,
                  Vec3::Zero());
  const int tag = source.tag + (source.tag_by_batch ? static_cast<int>(placed) : 0);
  record_batch(first, count, placed, tag, solver.time());
  ++placed;
  return std::nullopt;
}

bool ParticleFlow::all_placed(const CurrentStage& now) const {
  for (std::size_t i = 0; i < case_.fills.size(); ++i) {
    if (belongs(case_.fills[i].stage, now) && state.fill_batches[i] < batch_count(case_.fills[i]))
      return false;
  }
  for (std::size_t i = 0; i < case_.inlets.size(); ++i) {
    if (belongs(case_.inlets[i].stage, now) &&
        state.inlet_batches[i] < static_cast<std::uint64_t>(case_.inlets[i].batches))
      return false;
  }
  return true;
}

bool ParticleFlow::update(Solver& solver) {
  const ParticleState& particles = solver.particles();
  const double now = solver.time();
  ParticleEvents& passages = state.passages;
  bool left = false;
  for (std::size_t i = 0; i < particles.presence.size(); ++i) {
    if (particles.presence[i] != Presence::present) continue;
    const Vec3 position = particles.position[i];
    double& discharge_time = passages.discharge_time[i];
    if (case_.drained_repose && std::isnan(discharge_time) &&
        position.z() < -case_.drained_repose->floor_thickness)
      discharge_time = now;
    for (std::size_t g = 0; g < case_.sensors.size(); ++g) {
      if (std::isnan(passages.sensor_time[g][i]) && case_.sensors[g].contains(position))
        passages.sensor_time[g][i] = now;
    }
    for (std::size_t o = 0; o < case_.outlets.size(); ++o) {
      const Outlet& outlet = case_.outlets[o];
      if ((position - outlet.point).dot(outlet.normal) <= 0) continue;
      passages.exit_time[i] = now;
      passages.outlet[i] = static_cast<int>(o);
      solver.remove_particle(static_cast<int>(i));
      left = true;
      break;
    }
  }
  return left;
}

void ParticleFlow::tag(const std::string& stage, const Solver& solver) {
  const ParticleState& particles = solver.particles();
  for (const TagRule& rule : case_.tag_rules) {
    if (rule.stage != stage) continue;
    const double from = rule.region_min[rule.axis], to = rule.region_max[rule.axis];
    for (std::size_t i = 0; i < particles.presence.size(); ++i) {
      if (particles.presence[i] != Presence::present) continue;
      const Vec3& p = particles.position[i];
      if ((p - rule.region_min).minCoeff() < 0 || (rule.region_max - p).minCoeff() < 0) continue;
      const int column = static_cast<int>((p[rule.axis] - from) / (to - from) * rule.bins);
      state.passages.tag[i] = rule.first + std::min(column, rule.bins - 1);
    }
  }
}

std::size_t ParticleFlow::passed(int sensor, double from) const {
  const std::vector<double>& times = state.passages.sensor_time[index(sensor)];
  return static_cast<std::size_t>(
      std::ranges::count_if(times, [&](double t) { return t >= from; }));
}

double ParticleFlow::passed_mass(int sensor, double from) const {
  const std::vector<double>& times = state.passages.sensor_time[index(sensor)];
  double mass = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!(times[i] >= from)) continue;
    mass += case_.model.shapes[index(case_.model.particles[i].shape)].mass;
  }
  return mass;
}

}  // namespace firn
