// Reads results files. docs/results.md describes the layout.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "firn/experiments/response.h"

namespace firn::experiments {

// One recorded state. Arrays have one row a particle [N], in order of the ids; NaN where a particle
// has not come yet or has left.
struct Frame {
  double time = 0;                                      // s
  std::vector<std::array<double, 3>> position;          // m, center of mass, world axes
  std::vector<std::array<double, 4>> orientation;       // w x y z, shape axes -> world axes
  std::vector<std::array<double, 3>> velocity;          // m/s, world axes
  std::vector<std::array<double, 3>> angular_velocity;  // rad/s, world axes
};

// What is constant, or known once for each particle [N].
struct Particles {
  std::vector<int> shape;                 // index into Results::shapes()
  std::vector<int> tag;                   // label given by the case
  std::vector<double> mass;               // kg
  std::vector<double> insert_time;        // s; NaN: never inserted
  std::vector<double> exit_time;          // s; NaN: never left through an outlet
  std::vector<double> peak_normal_force;  // N, largest contact force of all steps
};

struct Stage {
  std::string name;
  double start = 0, end = 0;  // s; end is NaN while the stage is under way
  std::string end_reason;     // "settled", "time", ...; empty while it is under way
};

// A quantity kept with every frame, or sample: shape [T, width], or [M, width], row by row.
struct Series {
  std::string path;  // "/energy/kinetic"
  std::string unit;  // "1" for a number
  std::size_t width = 1;
};

// A view of a file that is finished, interrupted or still being written. Reads on demand. Throws
// InputError with one line for a file that is missing, damaged or of another kind.
// A file from an untrusted source should be checked by `firn check-results FILE` first: HDF5 is not
// proof against damaged files, and a crash in it would end this process (SECURITY.md).
class Results {
 public:
  explicit Results(const std::string& file);

  std::string file() const;
  std::string status() const;   // "finished", "failed: ...", "running", "interrupted"
  std::string program() const;  // that wrote it: "Firn 0.1.0 (89ab...)"
  std::uint64_t seed() const;
  double timestep() const;                      // s
  double wall_time() const;                     // s, of all sessions
  std::string case_text() const;                // complete TOML text of the case
  std::vector<std::string> shapes() const;      // names
  std::vector<std::string> boundaries() const;  // names
  std::size_t particle_count() const;           // N
  Particles particles() const;
  std::vector<double> times() const;     // [T] s, of the frames
  Frame frame(std::size_t index) const;  // below T, else InputError
  std::vector<Stage> stages() const;
  std::vector<Response> responses() const;  // as stored when the run finished
  std::vector<Response> measure() const;    // measured now, by this version of the library
  std::vector<Series> series() const;
  std::vector<double> series(const std::string& path) const;  // [T * width]
  // What [output.samples] of the case recorded, under the paths of series. Empty without samples.
  std::vector<double> sample_times() const;  // [M] s
  std::vector<Series> samples() const;
  std::vector<double> samples(const std::string& path) const;  // [M * width]

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

// The text of a results.json file with the keys and words of this version for those of earlier
// ones. Text that is not JSON stays as it is.
std::string current_results_json(const std::string& text);

}  // namespace firn::experiments
