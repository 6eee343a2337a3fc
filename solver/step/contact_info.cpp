#include "solver/step/contact_info.h"

#include <algorithm>
#include <tuple>

namespace firn {

namespace {

// The forces are those that the last step has put on the bodies: see wrench() and PatchBlock.
Contact contact_of(const State& s, const PairCoefficients& law, const Pair& pair, int number) {
  const std::size_t place = pair.first_patch + static_cast<std::uint32_t>(number);
  const ContactPatch& patch = s.patches[place];
  const PatchDetail& detail = s.patch_details[place];
  const Vec3& center_a = s.motion[pair.a].position;
  const Vec3& center_b = s.motion[pair.b].position;
  Contact c;
  c.a = pair.a;
  c.b = pair.b;
  c.patch = number;
  c.position = center_a + patch.arm;
  c.normal = patch.normal;
  c.normal_force = patch.normal_force;
  c.sliding = patch.sliding != 0;
  c.friction_limit = (c.sliding ? law.dynamic_friction : law.static_friction) * patch.normal_force;
  c.torsion_limit = c.friction_limit * patch.torsion_radius;
  c.stiffness = law.stiffness;
  c.unloading_stiffness_ratio = law.unloading_stiffness_ratio;
  c.gap = std::numeric_limits<double>::infinity();
  Vec3 offset_force = Vec3::Zero();
  const double shares = sum_of_fractions(patch, s.points.data() + patch.first_point);
  for (std::uint32_t i = 0; i < patch.point_count; ++i) {
    const ContactPoint& p = s.points[patch.first_point + i];
    c.points.push_back({c.position + p.offset, p.gap, p.stiffness_fraction, p.force,
                        detail.area * p.stiffness_fraction / shares});
    c.gap = std::min(c.gap, p.gap);
    offset_force += p.force * p.offset;
  }
  c.overlap = std::max(0.0, -c.gap);
  if (!(patch.normal_force > 0)) return c;  // a patch that bears nothing does nothing
  c.friction = patch.tangential;
  c.torsion = patch.torsion;
  c.rolling = detail.rolling;
  const NormalLoad pull =
      adhesion_of(law, patch, s.points.data() + patch.first_point, PatchMotion{});
  c.adhesion = pull.force;
  offset_force -= to_eigen(pull.offset_force);
  c.force = patch.tangential - (patch.normal_force - pull.force) * patch.normal;
  // Normal forces act at their points: about the reference point, sum o x (-f n) = n x sum f o.
  const Vec3 moment = patch.normal.cross(offset_force) + patch.torsion * patch.normal + c.rolling;
  c.moment_a = moment + patch.arm.cross(c.force);
  c.moment_b = -moment - (c.position - center_b).cross(c.force);
  return c;
}

}  // namespace

std::vector<Contact> contacts_of(const Workspace& w, const State& s) {
  std::vector<Contact> out;
  for (const Pair& pair : s.pairs) {
    for (std::uint32_t k = 0; k < pair.patch_count; ++k)
      out.push_back(
          contact_of(s, w.laws[static_cast<std::size_t>(pair.law)], pair, static_cast<int>(k)));
  }
  std::sort(out.begin(), out.end(), [](const Contact& c, const Contact& d) {
    return std::tie(c.a, c.b, c.patch) < std::tie(d.a, d.b, d.patch);
  });
  return out;
}

std::vector<double> overlaps_of(const State& s) {
  std::vector<double> out;
  for (const Pair& pair : s.pairs) {
    for (std::uint32_t k = pair.first_patch; k < pair.first_patch + pair.patch_count; ++k) {
      const ContactPatch& patch = s.patches[k];
      if (patch.normal_force <= 0) continue;
      double gap = 0;
      for (std::uint32_t i = 0; i < patch.point_count; ++i)
        gap = std::min(gap, s.points[patch.first_point + i].gap);
      out.push_back(-gap);
    }
  }
  return out;
}

}  // namespace firn
