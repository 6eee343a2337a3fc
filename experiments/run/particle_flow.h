// Insertion, removal and counting of particles: fills, inlets, outlets, sensors and tags.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/results_writer.h"
#include "firn/solver.h"

namespace firn {

// State of ParticleFlow in a checkpoint.
struct ParticleFlowState {
  std::vector<std::uint64_t> fill_batches, inlet_batches;  // placed so far, [fills], [inlets]
  ParticleEvents passages;                                 // of all particles so far
};

class ParticleFlow {
 public:
  explicit ParticleFlow(const Case& c);

  ParticleFlowState state;

  // Name of the current stage and the step at which it began. Fills and inlets of a stage depend on
  // both.
  struct CurrentStage {
    const std::string* stage;
    std::uint64_t stage_start;
  };

  // Inserts the scheduled batches. Returns a description of the obstacle when particles block an
  // inlet, whose batch is then not inserted; the run must end. Throws InputError for a fill that
  // does not fit and for an inlet inside a boundary.
  std::optional<std::string> place_due(Solver& solver, const CurrentStage& now);
  // True when no more particles are to be inserted during this stage.
  bool all_placed(const CurrentStage& now) const;

  // Records which particles are inside a sensor or below the door for the first time. Removes
  // particles that have passed an outlet; true when one has.
  bool update(Solver& solver);

  // Applies the tag rules (by position) at the beginning of a stage.
  void tag(const std::string& stage, const Solver& solver);

  // Particles, or their mass in kg, that have been in the sensor since `from` (s).
  std::size_t passed(int sensor, double from) const;
  double passed_mass(int sensor, double from) const;

 private:
  std::uint64_t due(double start, double interval, std::uint64_t batch, const std::string& stage,
                    const CurrentStage& now) const;
  void record_batch(int first, int count, std::uint64_t batch, int tag, double time);
  std::optional<std::string> insert_inlet_batch(Solver& solver, std::size_t source);

  const Case& case_;
  std::vector<int> first_of_fill_, first_of_source_;  // particle ids
};

// Number of batches of a fill.
std::uint64_t batch_count(const Fill& fill);

}  // namespace firn
