// The state of a run step by step as text, and what parts two runs first.
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
  std::uint64_t every = 1;  // a line each how many steps
  // Steps for which the trace has numbers in addition to hashes: bodies, pairs, patches, points.
  std::uint64_t numbers_from = std::numeric_limits<std::uint64_t>::max(), numbers_to = 0;
};

// Writes one line a step: its number, the time, and the hash of every group of the state
// (Solver::group_hashes). Numbers are written in hexadecimal: every bit is there.
//   # firn trace 1
//   # case <hash of the case>
//   # groups time,positions and velocities,...
//   step 12 0x1.5p-10 <hash> <hash> ...
//   particle 3 position_x=0x1p-3 ...
//   boundary floor position_x=...
//   pair 3 17 patch 0 normal_force=... ;  pair 3 17 patch 0 point 1 gap=...
class TraceWriter {
 public:
  // Throws as OutputFile. The file grows while the run is under way.
  TraceWriter(const Case& c, const TraceOptions& options);
  // With each step, in order.
  void see(const Solver& solver, bool last);
  // Throws WriteError when something could not be written.
  void close();

 private:
  void write_numbers(const Solver& solver);

  TraceOptions options_;
  OutputFile out_;
  bool begun_ = false;
};

// Where two traces part.
struct TraceDifference {
  bool equal = false;     // in every step that both have
  bool same_case = true;  // both say they are of the same case
  std::size_t steps_compared = 0;
  std::uint64_t last_equal = 0;  // step, when steps_compared > 0 and the first one is equal
  bool any_equal = false;
  std::uint64_t step = 0;           // the first that differs
  double time = 0;                  // s
  std::vector<std::string> groups;  // of the state, that differ then
  bool has_numbers = false;         // both traces hold the numbers of that step
  // The first that differ, as "particle 17: angular_velocity_x 0.1 against 0.2"; and how many in
  // all.
  std::vector<std::string> numbers;
  std::size_t number_count = 0;
  // Steps that only one of them has, because the other was sparser, shorter or began elsewhere.
  std::size_t only_first = 0, only_second = 0;
};

// Throws InputError for a file that is no trace, for traces of other groups (another version of the
// program) and for two without a common step. Lists up to `listed` numbers.
TraceDifference compare_traces(const std::string& first, const std::string& second,
                               std::size_t listed);

}  // namespace firn
