// Machines that cannot work, refused before a run begins.
#pragma once

#include "experiments/case/case.h"

namespace firn {

// Throws InputError `FILE:LINE: KEY: ...` when
// - two boundaries that can move against each other overlap by more than 0.1 mm: at the start;
// along
//   the prescribed motions of the case, and those that each stage starts, in their first period
//   (those that only an event ends have none); or where a free frame's drives can take it, one
//   frame at a time. Paths are sampled. Pairs named in `may_touch` are left out, and so is what is
//   fixed to each other.
// - a placed particle lies in a boundary, deeper than a twentieth of its smallest edge.
void check_machine(const Case& c);

}  // namespace firn
