// Writes the contents of a results file (docs/results.md).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/recorder.h"
#include "experiments/results/response.h"
#include "experiments/results/results_file.h"
#include "firn/solver.h"

namespace firn {

// The columns of the results file of a case, and the concatenated rows of all columns for the
// state of a solver of its model. `interval` (s): time since the boundary loads were cleared; 0:
// loads are 0.
std::vector<Column> result_columns(const Case& c);
std::vector<double> frame_row(const Solver& solver, const Case& c, double interval);

// The columns under /samples, the time first, then boundaries and motion frames in the order of
// Case::samples. Empty without [output.samples].
std::vector<Column> sample_columns(const Case& c);

// Writes attributes of the file and constant data.
void write_header(hdf5::File& file, const Case& c);

// Events and labels of particles [particles]. Times in s; NaN: not yet.
struct ParticleEvents {
  ParticleEvents() = default;
  explicit ParticleEvents(const Case& c);  // before the start

  std::vector<double> exit_time;       // removed by an outlet
  std::vector<double> discharge_time;  // center of mass first below the lower side of the floor
  std::vector<double> insert_time;     // 0 for [[particles]], below 0 for [initial_state]
  std::vector<int> outlet;             // index, -1: none
  std::vector<int> batch;              // batch of the fill or inlet, from 0; -1: [[particles]]
  std::vector<int> tag;                // current
  std::vector<std::vector<double>> sensor_time;  // [sensors][particles] first inside
};

// A change of a limit switch.
struct SwitchChange {
  std::int64_t index = 0;    // of the case's limit switches
  double time = 0;           // s
  std::uint64_t closed = 0;  // 1: closed, 0: opened
};
void write_switches(hdf5::File& file, const Case& c, const std::vector<SwitchChange>& changes);

// Writes bonds and their state; nothing for a case without bonds.
void write_bonds(hdf5::File& file, const Case& c, const std::vector<BondRecord>& records);

void write_particles(hdf5::File& file, const std::vector<double>& peak_normal_force,
                     const ParticleEvents& passages);

// The stages of the case; without any, one stage until its end.
std::vector<Stage> stages_of(const Case& c);
// Writes all stages in order; times of stages that were not reached are NaN.
void write_stages(hdf5::File& file, const std::vector<Stage>& stages,
                  const std::vector<StageRecord>& entered);

void write_responses(hdf5::File& file, const std::vector<Response>& responses);

}  // namespace firn
