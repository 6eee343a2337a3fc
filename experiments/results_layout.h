// What a results file holds and under which name: docs/results.md, kept in one place.
#pragma once

#include <string>
#include <vector>

#include "experiments/case.h"
#include "experiments/recorder.h"
#include "experiments/recording.h"
#include "experiments/response.h"
#include "solver/solver.h"

namespace firn {

// The columns of a run over this model, and one row of them all from the solver's state.
// `interval` (s) is the time since the boundary loads were last cleared; 0: none, loads are 0.
std::vector<Column> result_columns(const Model& model);
std::vector<double> result_row(const Solver& solver, double interval);

// Attributes of the file and what never changes.
void write_header(hdf5::File& file, const Case& c);

// Per particle, s; NaN: not yet.
struct Passages {
  std::vector<double> exit_time;  // removed by an outlet
  std::vector<double> door_time;  // centre of mass first below the floor's underside
};
void write_particles(hdf5::File& file, const std::vector<double>& peak_normal_force,
                     const Passages& passages);

// Stages of the case in order; those not reached yet keep NaN times.
std::vector<Stage> stages_of(const Case& c);  // the case's, or one until its end
void write_stages(hdf5::File& file, const std::vector<Stage>& stages,
                  const std::vector<StageRecord>& entered);

void write_responses(hdf5::File& file, const std::vector<Response>& responses);

}  // namespace firn
