// The events that end the stages of a run.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/run/particle_flow.h"
#include "firn/solver.h"

namespace firn {

// State of StageEvents in a checkpoint. Steps since which a condition has held continuously; -1: it
// does not hold.
struct StageEventState {
  std::int64_t rest_since = -1, force_since = -1, torque_since = -1, filled_since = -1;
  // Step since which the motor of the stage drives, or of the last check of its displacement.
  std::int64_t driven_since = -1;
  double driven_from = 0;                           // m or rad, joint coordinate at that step
  std::uint8_t empty = 0, passed = 0, stalled = 0;  // 1: true at the last update
  std::vector<std::int64_t> above_since;            // [limit switches] step
  std::vector<std::uint8_t> closed;                 // [limit switches] 1: closed
  std::vector<SwitchChange> changes;                // of all limit switches, in order of time
};

class StageEvents {
 public:
  explicit StageEvents(const Case& c);

  StageEventState state;

  void enter_stage();
  // To be called every few steps. `left`: a particle has left since the last call.
  void update(const Stage& stage, const Solver& solver, const ParticleFlow& flow,
              const ParticleFlow::CurrentStage& now, bool left);
  // The event that ended the stage, if any.
  std::optional<std::string> end_reason(const Stage& stage, const Solver& solver,
                                        const ParticleFlow& flow,
                                        const ParticleFlow::CurrentStage& now) const;

 private:
  void update_switches(const Solver& solver);
  void update_motor_progress(const Stage& stage, const Solver& solver, std::uint64_t stage_start);
  bool is_quiet(const Stage& stage, const Solver& solver) const;
  bool is_filled(const Stage& stage, const Solver& solver) const;
  std::string shortfall(const Stage& stage, const ParticleFlow& flow,
                        const ParticleFlow::CurrentStage& now) const;

  const Case& case_;
};

// One sentence that names the largest contacts on the frame of a stalled motor.
std::string describe_jam(const Case& c, const Solver& solver, int frame);

}  // namespace firn
