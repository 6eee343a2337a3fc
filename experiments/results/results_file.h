// Results files: a run writes them, everything else reads them. Layout: docs/results.md.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"
#include "firn/solver.h"

namespace firn {

// One trajectory frame, arrays in order of particle ids; NaN where a particle does not exist.
struct Frame {
  double time = 0;                                      // s
  std::vector<std::array<double, 3>> position;          // m, centre of mass, world
  std::vector<std::array<double, 4>> orientation;       // w x y z, shape axes -> world
  std::vector<std::array<double, 3>> velocity;          // m/s
  std::vector<std::array<double, 3>> angular_velocity;  // rad/s
};

struct StageRecord {
  std::string name;
  double start = 0, end = 0;  // s; end is NaN while the stage is under way
  // "settled", "empty", "time", "time limit", "end of the case"; none while it is under way.
  std::string end_reason;
};

// A time series kept with every frame.
struct Series {
  std::string path;       // HDF5 path, e.g. "/energy/kinetic"
  std::string unit;       // "1" for a bare number
  std::size_t width = 1;  // values a frame
};

// Where a boundary was at one frame, and its load over the interval that the frame ends.
struct BoundaryFrame {
  Vec3 position = Vec3::Zero();         // m, of its origin, world; NaN once removed
  Quat orientation = Quat::Identity();  // boundary axes -> world; NaN once removed
  Vec3 force = Vec3::Zero();            // N, mean
  Vec3 torque = Vec3::Zero();           // N m, mean, about the origin
  double peak_normal_force = 0;         // N, largest single contact
};

// Read-only view of a results file that keeps to the schema (results_schema.h). Throws InputError
// (one line) for a file that is missing, truncated, of another kind, or that breaks the schema.
// Values of datasets that grow with the run are checked when they are read. Where a kill in the
// middle of a flush left a file that cannot be read, the view is of the copy kept with the last
// checkpoint.
class Recording {
 public:
  explicit Recording(const std::string& file);
  ~Recording();
  Recording(Recording&&) noexcept;

  const std::string& file() const;
  // From the resolved text kept in the file. Throws InputError unless the file fits the case.
  Case read_case() const;
  std::string status() const;   // "finished", "failed: ...", "running", "interrupted"
  std::string program() const;  // what ran it, "Firn 0.1.0 (89ab...)"
  int contact_model() const;    // 1: the file does not state one
  std::uint64_t seed() const;
  double timestep() const;
  std::size_t particle_count() const;
  std::vector<int> shape() const, tag() const;    // [N]
  std::vector<double> mass() const;               // [N] kg
  std::vector<double> peak_normal_force() const;  // [N] N
  std::vector<double> exit_time() const;          // [N] s; NaN: never left through an outlet
  std::vector<double> discharge_time()
      const;  // [N] s, centre of mass first below the floor's underside; NaN
  std::vector<double> insert_time() const;  // [N] s; NaN: has not come
  std::vector<int> batch() const;           // [N] of its fill or inlet, from 0; -1: none
  std::vector<int> outlet() const;          // [N] index of the case's outlets; -1: none
  // [N] s, first inside that sensor of the case; NaN: never. Throws InputError for another name.
  std::vector<double> sensor_time(const std::string& sensor) const;
  std::vector<double> frame_times() const;  // [T] s
  Frame frame(std::size_t i) const;
  std::vector<StageRecord> stages() const;
  std::vector<Response> responses() const;  // as stored
  bool measured() const;                    // all responses are stored, not a part of them
  // Named time series [T] under an HDF5 path, e.g. "/energy/kinetic"; [T, width] row by row. Reads
  // a path of format 1 with a warning.
  std::vector<double> series(const std::string& path) const;
  std::vector<Series> series_list() const;  // all of them, in alphabetical order
  BoundaryFrame boundary(const std::string& name, std::size_t frame) const;
  // Datasets of the schema that are no series: whether there is one of this path, and its values;
  // of those that grow, whole rows, as many in each.
  bool contains(const std::string& path) const;
  std::vector<double> values(const std::string& path) const;
  std::vector<std::string> strings(const std::string& path) const;
  bool has_checkpoint() const;
  double wall_time() const;  // s, all sessions, up to the last checkpoint or the end

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
