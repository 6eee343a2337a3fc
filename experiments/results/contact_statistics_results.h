// Statistics of contacts in a results file (docs/statistics.md).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/results_file.h"
#include "experiments/storage/hdf5_file.h"
#include "firn/solver.h"

namespace firn {

// Number of rows in the file. Checkpoints store it, so that a resumed run appends after these rows.
struct StatisticsRows {
  std::uint64_t events = 0, intervals = 0;
};

// Creates empty tables and meshes for the statistics of the case; nothing for a case without
// statistics.
void create_statistics(hdf5::File& file, const Case& c);
// Truncates the tables to `rows`. Throws RunError when one has fewer rows.
void truncate_statistics(hdf5::File& file, const Case& c, const StatisticsRows& rows);
// Appends the events and intervals that ended since the last call; at the end of a run also the
// open ones. Updates the sums over the run.
void append_statistics(hdf5::File& file, const Case& c, Solver& solver, bool at_end,
                       StatisticsRows& rows);

// Readers of the statistics of a results file. Empty if the case has no statistics of the kind.

// Sorted by end time. Events that are open at the end of the run are last.
std::vector<ContactEvent> contact_events(const Recording& recording);
std::vector<CompressiveLoad> compressive_loads(const Recording& recording);  // [particles]

// Values on the triangles of a mesh.
struct TriangleField {
  std::string name, unit;
  std::vector<double> values;  // [intervals * triangles], or [triangles]
};
struct BoundaryLoads {
  std::string boundary;
  TriangleMesh mesh;                  // m, boundary axes
  std::vector<double> area;           // m^2, [triangles]
  std::vector<double> start, end;     // s, of the intervals
  std::vector<TriangleField> fields;  // [intervals * triangles]
};
std::vector<BoundaryLoads> boundary_loads(const Recording& recording);
struct SurfaceLoads {
  std::string shape;
  TriangleMesh mesh;  // m, shape axes
  std::vector<TriangleField> fields;
};
std::vector<SurfaceLoads> surface_loads(const Recording& recording);

// Histogram of the energy that ended contacts dissipated, for each kind of pair.
struct EnergySpectrum {
  std::vector<double> lower;      // J, lower bounds of the classes; the last one has no upper bound
  std::vector<std::string> kind;  // "particles", and names of boundaries
  std::vector<double> contacts, dissipated;  // [kinds * classes]; 1, J
};
std::optional<EnergySpectrum> energy_spectrum(const Recording& recording);

}  // namespace firn
