// Checks for interference of machine parts: before a run begins, and during a run.
#pragma once

#include <memory>

#include "experiments/case/case.h"

namespace firn {

// Throws InputError `FILE:LINE: KEY: ...` when
// - two boundaries that can move against each other overlap by more than 0.1 mm: at the start;
// along
//   the prescribed motions of the case, and those that each stage starts, in their first period
//   (those that only an event ends have none); or where a free frame's motors can take it, one
//   frame at a time. Paths are sampled. Pairs named in `may_touch` are left out, and so is what is
//   fixed to each other. Pairs with a boundary contact are checked at the start alone.
// - a placed particle lies in a boundary, deeper than a twentieth of its smallest edge.
void check_machine(const Case& c);

// The same pairs, but for those with a contact, over a run. The outcome depends on the present
// state alone.
class InterferenceWatch {
 public:
  explicit InterferenceWatch(const Case& c);  // kept by reference
  ~InterferenceWatch();

  // Throws RunError with place and time when two parts overlap by more than 0.1 mm.
  void look(const Solver& solver);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
