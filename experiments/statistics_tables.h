// Statistics of contacts in a results file: docs/statistics.md, kept in one place.
#pragma once

#include <cstdint>
#include <vector>

#include "experiments/hdf5_file.h"
#include "experiments/recording.h"
#include "solver/solver.h"

namespace firn {

// How much of them is in the file: what a checkpoint must know to go on.
struct StatisticsRows {
  std::uint64_t events = 0;
};

// Empty tables for what the model asks for; nothing where it asks for none.
void create_statistics(hdf5::File& file, const Model& model);
// Cuts the tables back. Throws RunError when one has fewer rows.
void truncate_statistics(hdf5::File& file, const Model& model, const StatisticsRows& rows);
// Appends what the solver has finished since it was asked last; at the end of a run also what is
// under way then.
void append_statistics(hdf5::File& file, Solver& solver, bool at_end, StatisticsRows& rows);

// The contacts of a file, in order of their ends, those under way at the end of the run last.
// Empty when the case did not ask for them.
std::vector<ContactEvent> contact_events(const Recording& recording);

}  // namespace firn
