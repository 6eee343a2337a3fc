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

// The columns of a run over this model, and one row of them all from the solver's state.
// `interval` (s) is the time since the boundary loads were last cleared; 0: none, loads are 0.
std::vector<Column> result_columns(const Model& model);
std::vector<double> result_row(const Solver& solver, double interval);

// Attributes of the file and constant data.
void write_header(hdf5::File& file, const Case& c);

// Per particle; times in s, NaN: not yet.
struct ParticleEvents {
  ParticleEvents() = default;
  explicit ParticleEvents(const Case& c);  // before anything has happened

  std::vector<double> exit_time;       // removed by an outlet
  std::vector<double> discharge_time;  // centre of mass first below the floor's underside
  std::vector<double> insert_time;     // 0 for [[particles]], before 0 for those of [initial_state]
  std::vector<int> outlet;             // index, -1: none
  std::vector<int> batch;              // of its fill or inlet, from 0; -1: [[particles]]
  std::vector<int> tag;                // now
  std::vector<std::vector<double>> sensor_time;  // [sensors][particles], first inside
};

// A limit switch has closed or opened.
struct SwitchChange {
  std::int64_t index = 0;  // of the case's limit switches
  double time = 0;         // s
  std::uint64_t closed = 0;
};
void write_switches(hdf5::File& file, const Case& c, const std::vector<SwitchChange>& changes);

// Bonds and their state; nothing for a case without bonds.
void write_bonds(hdf5::File& file, const Case& c, const std::vector<BondRecord>& records);

void write_particles(hdf5::File& file, const std::vector<double>& peak_normal_force,
                     const ParticleEvents& passages);

// Stages of the case in order; those not reached yet keep NaN times.
std::vector<Stage> stages_of(const Case& c);  // the case's, or one until its end
void write_stages(hdf5::File& file, const std::vector<Stage>& stages,
                  const std::vector<StageRecord>& entered);

void write_responses(hdf5::File& file, const std::vector<Response>& responses);

}  // namespace firn
