// Checks for interference of machine parts: before a run begins, and during a run.
#pragma once

#include <memory>

#include "experiments/case/case.h"

namespace firn {

// Throws InputError `FILE:LINE: KEY: ...` when
// - two boundaries that can move relative to each other overlap by more than 0.1 mm. Poses that are
//   tested: at the start; along the prescribed motions of the case and of each stage, in their
//   first period (not of motions that only an event ends); and along the motors of free frames, one
//   frame at a time. Paths are sampled. Pairs in `allow_overlap_with` and boundaries that are fixed
//   to each other are not tested. Pairs with a boundary contact are tested at the start only.
// - a placed particle overlaps a boundary, or another placed particle, by more than a twentieth of
//   the smallest edge.
void check_machine(const Case& c);

// Checks the same pairs during a run, except those with a boundary contact. The result depends on
// the current state only.
class InterferenceMonitor {
 public:
  explicit InterferenceMonitor(const Case& c);  // `c` must outlive the monitor
  ~InterferenceMonitor();

  // Throws RunError with position and time when two boundaries overlap by more than 0.1 mm.
  void check(const Solver& solver);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
