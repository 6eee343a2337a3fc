// Text traces of the state of a run, and the first difference between two traces.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/system/output_file.h"
#include "firn/solver.h"

namespace firn {

struct TraceOptions {
  std::string file;
  std::uint64_t every = 1;  // steps between two lines
  // First and last step for which the trace has the numbers of bodies, pairs, patches and points in
  // addition to the hashes.
  std::uint64_t numbers_from = std::numeric_limits<std::uint64_t>::max(), numbers_to = 0;
};

// Writes one line per step: its number, the time, and the hash of every group of the state
// (Solver::group_hashes). Numbers are hexadecimal and read back to the same bits.
//   # firn trace 1
//   # case <hash of the case>
//   # groups time,positions and velocities,...
//   step 12 0x1.5p-10 <hash> <hash> ...
//   particle 3 position_x=0x1p-3 ...
//   boundary floor position_x=...
//   pair 3 17 patch 0 normal_force=... ;  pair 3 17 patch 0 point 1 gap=...
class TraceWriter {
 public:
  // Throws as OutputFile. The file grows during the run.
  TraceWriter(const Case& c, const TraceOptions& options);
  // To be called with the state of each step, in order. `last`: no step follows.
  void add_step(const Solver& solver, bool last);
  // Throws WriteError when a write has failed.
  void close();

 private:
  void write_numbers(const Solver& solver);

  TraceOptions options_;
  OutputFile out_;
  bool begun_ = false;
};

// First divergence of two traces.
struct TraceDifference {
  bool equal = false;     // in every common step
  bool same_case = true;  // both state the same hash of the case
  std::size_t steps_compared = 0;
  std::uint64_t last_equal = 0;  // step; valid if any_equal
  bool any_equal = false;
  std::uint64_t step = 0;           // first that differs
  double time = 0;                  // s
  std::vector<std::string> groups;  // groups of the state that differ in that step
  bool has_numbers = false;         // both traces have the numbers of that step
  // The first numbers that differ, "particle 17: angular_velocity_x 0.1 against 0.2", and the count
  // of all that differ.
  std::vector<std::string> numbers;
  std::size_t number_count = 0;
  // Steps that only one trace has: the other one is sparser, shorter or starts at another step.
  std::size_t only_first = 0, only_second = 0;
};

// `listed`: largest size of TraceDifference::numbers. Throws InputError for a file that is not a
// trace, for traces with different groups (of different versions of the program) and for traces
// without a common step.
TraceDifference compare_traces(const std::string& first, const std::string& second,
                               std::size_t listed);

}  // namespace firn
