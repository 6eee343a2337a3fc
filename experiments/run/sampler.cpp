#include "experiments/run/sampler.h"

#include <algorithm>
#include <span>

#include "experiments/results/results_writer.h"

namespace firn {
namespace {

constexpr std::size_t kFullAt = std::size_t{128} * 1024;  // values: 1 MB

// The values of a row but the time: loads as impulses since they were cleared, the rest as it is.
class Reading {
 public:
  Reading(const Solver& solver, const Case& c) {
    const std::vector<BoundaryState>& boundaries = solver.boundaries();
    for (int b : c.samples.boundaries) {
      add_load(boundaries[static_cast<std::size_t>(b)].impulse);
      add_load(boundaries[static_cast<std::size_t>(b)].angular_impulse);
    }
    const std::vector<FrameState> frames = solver.frames();
    for (int f : c.samples.frames) {
      const FrameState& frame = frames[static_cast<std::size_t>(f)];
      add_load(frame.impulse);
      add_load(frame.angular_impulse);
      if (!c.model.frames[static_cast<std::size_t>(f)].free) continue;
      add_load(frame.reaction_impulse);
      add_load(frame.reaction_angular_impulse);
      for (const FrameState::JointState& joint : frame.joints) add(joint.coordinate, false);
      for (const FrameState::JointState& joint : frame.joints) add(joint.rate, false);
      for (const FrameState::JointState& joint : frame.joints) add(joint.motor_impulse, true);
    }
  }

  std::size_t size() const { return values_.size(); }
  double value(std::size_t k) const { return values_[k]; }
  bool is_load(std::size_t k) const { return is_load_[k]; }

 private:
  void add(double value, bool is_load) {
    values_.push_back(value);
    is_load_.push_back(is_load);
  }
  void add_load(const Vec3& impulse) {
    for (double component : impulse) add(component, true);
  }

  std::vector<double> values_;
  std::vector<bool> is_load_;
};

}  // namespace

Sampler::Sampler(const Case& c, std::uint64_t interval)
    : case_(c), interval_(interval), columns_(sample_columns(c)) {
  if (columns_.empty()) return;
  for (const Column& column : columns_) width_ += column.row.empty() ? 1 : column.row[0];
  state.taken.assign(width_ - 1, 0);
}

void Sampler::begin(const Solver& solver, int stage, bool kept) {
  if (columns_.empty() || stage != std::max(0, case_.samples.stage)) return;
  const Reading now(solver, case_);
  for (std::size_t k = 0; k < now.size(); ++k) state.taken[k] = now.is_load(k) ? now.value(k) : 0;
  state.started = 1;
  state.last_step = solver.steps();
  take(solver, kept);
}

bool Sampler::ends_interval(std::uint64_t step) const {
  return state.started != 0 && step - state.last_step >= interval_;
}

void Sampler::take(const Solver& solver, bool kept) {
  const Reading now(solver, case_);
  // At least a step: the loads of the first row, which ends no interval, are 0.
  const double duration =
      static_cast<double>(std::max<std::uint64_t>(1, solver.steps() - state.last_step)) *
      case_.model.timestep;
  if (kept) waiting_.push_back(solver.time());
  for (std::size_t k = 0; k < now.size(); ++k) {
    const double value = now.value(k);
    if (kept) waiting_.push_back(now.is_load(k) ? (value - state.taken[k]) / duration : value);
    if (now.is_load(k)) state.taken[k] = value;
  }
  state.last_step = solver.steps();
}

void Sampler::before_clearing(const Solver& solver) {
  if (state.started == 0) return;
  const Reading now(solver, case_);
  for (std::size_t k = 0; k < now.size(); ++k)
    if (now.is_load(k)) state.taken[k] -= now.value(k);
}

bool Sampler::is_full() const { return waiting_.size() >= kFullAt; }

void Sampler::write(hdf5::File& file) {
  if (waiting_.empty()) return;
  const std::size_t rows = waiting_.size() / width_;
  std::vector<double> values;
  std::size_t offset = 0;
  for (const Column& column : columns_) {
    const std::size_t size = column.row.empty() ? 1 : column.row[0];
    values.clear();
    for (std::size_t row = 0; row < rows; ++row) {
      const auto cells = std::span(waiting_).subspan(row * width_ + offset, size);
      values.insert(values.end(), cells.begin(), cells.end());
    }
    file.open_table(column.path).append(values);
    offset += size;
  }
  state.rows += rows;
  waiting_.clear();
}

void Sampler::truncate(hdf5::File& file) const {
  for (const Column& column : columns_) {
    hdf5::Table table = file.open_table(column.path);
    if (table.rows() < state.rows)
      throw RunError(column.path + " has fewer rows than its checkpoint");
    table.truncate(state.rows);
  }
}

bool Sampler::fits(const SampleState& other) const {
  return other.taken.size() == state.taken.size();
}

}  // namespace firn
