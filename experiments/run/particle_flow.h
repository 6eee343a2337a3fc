// Who comes and goes in a run, and who has been where: fills, inlets, outlets, sensors and tags.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/results_writer.h"
#include "firn/solver.h"

namespace firn {

// What a checkpoint keeps of it.
struct ParticleFlowState {
  std::vector<std::uint64_t> fill_batches, inlet_batches;  // placed so far, [fills], [inlets]
  ParticleEvents passages;
};

class ParticleFlow {
 public:
  explicit ParticleFlow(const Case& c);

  ParticleFlowState state;

  // The stage under way and the step at which it began: what is bound to a stage comes by them.
  struct CurrentStage {
    const std::string* stage;
    std::uint64_t stage_start;
  };

  // Inserts the scheduled batches. Returns a description of what blocks an inlet, which ends the
  // run: its batch is not inserted. Throws InputError for a fill that does not fit, and for a
  // source in a wall.
  std::optional<std::string> place_due(Solver& solver, const CurrentStage& now);
  // True when no more particles are to be inserted during this stage.
  bool all_placed(const CurrentStage& now) const;

  // Notes who is inside a sensor or below the door for the first time, and removes what has passed
  // an outlet; true when something has.
  bool update(Solver& solver);

  // Tags by place as a stage begins.
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
