// Distance and overlap of two convex parts, for callers outside the solver.
#pragma once

#include <optional>

#include "firn/convex_part.h"

namespace firn {

// Distance of the two core polyhedra without rounding, m; 0 when they overlap.
double core_distance(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a);

struct PartOverlap {
  double depth = 0;              // m, penetration along the minimum translation vector
  Vec3 position = Vec3::Zero();  // m, axes of a
};
// Overlap of the parts with rounding. Nothing if it is below `tolerance` (m).
std::optional<PartOverlap> part_overlap(const ConvexPart& a, const ConvexPart& b,
                                        const Pose& b_in_a, double tolerance);

}  // namespace firn
