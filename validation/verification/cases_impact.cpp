// One contact of spheres: normal and oblique impact against closed forms and published tables.
#include <algorithm>
#include <cmath>

#include "validation/verification/check.h"
#include "validation/verification/scenes.h"

namespace firn::verification {
namespace {

// Restitution of the hysteretic spring with its unloading floor lambda. Unloading from s_max along
// K / e^2 meets the floor lambda K s at r s_max, r = (1 - e^2) / (1 - lambda e^2); the work
// returned over the work put in is e'^2 = (1 + lambda r)(1 - r) + lambda r^2 = 1 - r (1 - lambda).
double restitution_with_floor(double e, double lambda = 0.001) {
  const double r = (1 - e * e) / (1 - lambda * e * e);
  return std::sqrt(1 - r * (1 - lambda));
}

}  // namespace

std::vector<VerificationCase> impact_cases() {
  return {{.name = "impact.floor",
           .title = "Restitution with the unloading floor",
           .reference = "e'^2 = 1 - r (1 - lambda), r = (1 - e^2) / (1 - lambda e^2)",
           .remark = "",
           .tier = Tier::quick,
           .run = [] {
             return std::vector<Check>{{.what = "e = 0.5, lambda = 0.001",
                                        .measured = restitution_with_floor(0.5),
                                        .expected = 0.500562,
                                        .tolerance = 1e-6,
                                        .bound = Bound::absolute}};
           }}};
}

}  // namespace firn::verification
