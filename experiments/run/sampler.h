// Takes the samples of a run ([output.samples], docs/case-files.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/recorder.h"
#include "experiments/storage/hdf5_file.h"
#include "firn/solver.h"

namespace firn {

// What the remaining samples of a run depend on. Checkpoints store it.
struct SampleState {
  std::uint64_t started = 0;    // 1: the first interval has begun
  std::uint64_t last_step = 0;  // end of the last interval, or begin of the first
  std::uint64_t rows = 0;       // in the file
  // [values of a row but the time] of loads, their impulse since the boundary loads were cleared
  // that earlier intervals have; negative: what was cleared and belongs to this one. N s, N m s.
  std::vector<double> taken;
};

// Takes the samples of a run and writes them to its results file.
class Sampler {
 public:
  // `interval`: steps, at least 1.
  Sampler(const Case& c, std::uint64_t interval);

  // All with the solver's step complete.
  // When a stage of the case begins: begins the first interval if samples begin with the stage. Its
  // row has loads of 0. Rows are kept for write() if `kept`, here and below.
  void begin(const Solver& solver, int stage, bool kept);
  // Ends the interval and begins the next one.
  void take(const Solver& solver, bool kept);
  // Before Solver::clear_boundary_loads().
  void before_clearing(const Solver& solver);

  // Whether an interval ends with this step.
  bool ends_interval(std::uint64_t step) const;
  // Whether enough rows wait to be written.
  bool is_full() const;
  // Appends the rows that wait to the columns of the file.
  void write(hdf5::File& file);
  // Truncates the columns to the rows of `state`. Throws RunError when one has fewer rows.
  void truncate(hdf5::File& file) const;
  // Whether a state is one of this case.
  bool fits(const SampleState& other) const;

  SampleState state;

 private:
  const Case& case_;
  std::uint64_t interval_ = 0;   // steps
  std::vector<Column> columns_;  // sample_columns()
  std::vector<double> waiting_;  // rows
  std::size_t width_ = 0;        // values of a row
};

}  // namespace firn
