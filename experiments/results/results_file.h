// Reader of results files. Layout: docs/results.md.
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

// One frame. Arrays [particles] in the order of ids; NaN for a particle that is not in the
// simulation.
struct Frame {
  double time = 0;                                      // s
  std::vector<std::array<double, 3>> position;          // m, center of mass, world
  std::vector<std::array<double, 4>> orientation;       // w x y z, shape axes -> world
  std::vector<std::array<double, 3>> velocity;          // m/s
  std::vector<std::array<double, 3>> angular_velocity;  // rad/s
};

struct StageRecord {
  std::string name;
  double start = 0, end = 0;  // s; end is NaN during the stage
  // "settled", "empty", "time", "time limit", "end of the case", ...; empty during the stage.
  std::string end_reason;
};
// How many of `times` (s) lie at or after the begin of a stage, by its number in the case; NaN if
// it did not begin. `begun`: stages in order.
double count_since(const std::vector<StageRecord>& begun, std::size_t stage,
                   const std::vector<double>& times);

// A time series with one row per frame.
struct Series {
  std::string path;       // HDF5 path, e.g. "/energy/kinetic"
  std::string unit;       // "1" for a bare number
  std::size_t width = 1;  // values per frame
};

// Pose of a boundary in one frame, and its load over the interval before the frame.
struct BoundaryFrame {
  Vec3 position = Vec3::Zero();         // m, of its origin, world; NaN once removed
  Quat orientation = Quat::Identity();  // boundary axes -> world; NaN once removed
  Vec3 force = Vec3::Zero();            // N, mean
  Vec3 torque = Vec3::Zero();           // N m, mean, about the origin
  double peak_normal_force = 0;         // N, largest of a single contact
};

// Read-only view of a results file. Throws InputError (one line) for a file that is missing,
// truncated, of another kind, or that violates the schema (results_schema.h). Values of datasets
// that grow with the run are checked when they are read. If a kill during a flush has made the file
// unreadable, the copy of the last checkpoint is read instead.
class Recording {
 public:
  explicit Recording(const std::string& file);
  ~Recording();
  Recording(Recording&&) noexcept;

  const std::string& file() const;
  std::string case_text() const;  // resolved TOML text of the case
  // Throws InputError if the file has other numbers of particles, shapes, sensors, outlets, bonds
  // or boundaries than the case.
  void check_case(const Case& c) const;
  std::string status() const;   // "finished", "failed: ...", "running", "interrupted"
  std::string program() const;  // that ran it, "Firn 0.1.0 (89ab...)"
  int contact_model() const;    // 1: the file does not state one
  std::uint64_t seed() const;
  double timestep() const;  // s
  std::size_t particle_count() const;
  std::vector<int> shape() const, tag() const;    // [N]
  std::vector<double> mass() const;               // [N] kg
  std::vector<double> peak_normal_force() const;  // [N] N
  std::vector<double> exit_time() const;          // [N] s; NaN: never left through an outlet
  // [N] s, center of mass first below the lower side of the floor; NaN: never.
  std::vector<double> discharge_time() const;
  std::vector<double> insert_time() const;  // [N] s; NaN: not inserted
  std::vector<int> batch() const;           // [N] batch of the fill or inlet, from 0; -1: none
  std::vector<int> outlet() const;          // [N] index of the case's outlets; -1: none
  // [N] s, first time inside the sensor; NaN: never. Throws InputError for an unknown name.
  std::vector<double> sensor_time(const std::string& sensor) const;
  std::size_t frame_count() const;
  std::vector<double> frame_times() const;  // [T] s
  Frame frame(std::size_t i) const;
  std::vector<StageRecord> stages() const;
  std::vector<Response> responses() const;  // as stored
  bool measured() const;                    // true if all responses are stored, false for a part
  // Named time series [T] under an HDF5 path, e.g. "/energy/kinetic"; [T, width] row by row. Reads
  // a path of format 1 with a warning.
  std::vector<double> series(const std::string& path) const;
  std::vector<Series> series_list() const;  // all, in alphabetical order
  BoundaryFrame boundary(const std::string& name, std::size_t frame) const;
  // Whether the file has a dataset of the schema. The values of one that is not a series: datasets
  // that grow with the run have complete rows, equally many in all of one kind.
  bool contains(const std::string& path) const;
  std::vector<double> values(const std::string& path) const;
  std::vector<std::string> strings(const std::string& path) const;
  bool has_checkpoint() const;
  double wall_time() const;  // s, sum of all sessions up to the last checkpoint or the end

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
