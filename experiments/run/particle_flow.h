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
  ParticleEvents passages;
};

class ParticleFlow {
 public:
  explicit ParticleFlow(const Case& c);

  ParticleFlowState state;

  // Name of the current stage and the step at which it began. Insertions that are bound to a stage
  // depend on them.
  struct CurrentStage {
    const std::string* stage;
    std::uint64_t stage_start;
  };

  // Inserts the scheduled batches. Returns a description of the obstacle when an inlet is blocked,
  // which ends the run. The batch of that inlet is not inserted. Throws InputError for a fill that
  // does not fit, and for an inlet in a wall.
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
  void note_batch(int first, int count, std::uint64_t batch, int tag, double time);
  std::optional<std::string> place_source(Solver& solver, std::size_t source);

  const Case& case_;
  std::vector<int> first_of_fill_, first_of_source_;  // particle ids
};

// Batches of a fill.
std::uint64_t batch_count(const Fill& fill);

}  // namespace firn
