#include "firn/distance.h"

#include "solver/collision/gjk.h"

namespace firn {

double core_distance(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a) {
  GjkCache cold;
  return core_distance(a, b, b_in_a, cold);
}

std::optional<PartOverlap> part_overlap(const ConvexPart& a, const ConvexPart& b,
                                        const Pose& b_in_a, double tolerance) {
  const double swept = a.radius + b.radius;
  const double apart = core_distance(a, b, b_in_a);
  if (apart > swept - tolerance && apart > 0) return std::nullopt;
  if (apart > 0) return PartOverlap{swept - apart, a.center};
  const CoreContact contact = penetration(a, b, b_in_a);
  const double depth = swept - contact.distance;
  if (depth < tolerance) return std::nullopt;
  return PartOverlap{depth, contact.point_a};
}

}  // namespace firn
