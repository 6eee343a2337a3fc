#include "experiments/analysis/boundary_support.h"

#include <algorithm>

namespace firn {
namespace {

constexpr double kHorizontal = 1e-6;  // vertical component over the sum of normal forces

}  // namespace

std::vector<BoundarySupport> boundary_support(const Solver& solver,
                                              const std::vector<bool>& selected) {
  const Model& model = solver.model();
  std::vector<BoundarySupport> support(model.boundaries.size());
  if (std::ranges::count(selected, true) == 0 || model.gravity.norm() == 0) return support;
  const Vec3 up = -model.gravity.normalized();
  const std::vector<Presence>& presence = solver.particles().presence;
  const int particles = static_cast<int>(model.particles.size());
  const std::vector<Contact> contacts = solver.contacts();
  // The patches of a pair follow each other.
  for (auto patch = contacts.begin(); patch != contacts.end();) {
    const int a = patch->a, b = patch->b;
    double upward = 0, total = 0;  // N
    for (; patch != contacts.end() && patch->a == a && patch->b == b; ++patch) {
      upward -= patch->normal_force * patch->normal.dot(up);
      total += patch->normal_force;
    }
    if (b < particles || !selected[static_cast<std::size_t>(b - particles)]) continue;
    if (presence[static_cast<std::size_t>(a)] != Presence::present) continue;
    BoundarySupport& s = support[static_cast<std::size_t>(b - particles)];
    if (upward > kHorizontal * total) {
      ++s.above_count;
      s.above_force += upward;
    } else if (upward < -kHorizontal * total) {
      ++s.below_count;
    }
  }
  return support;
}

}  // namespace firn
