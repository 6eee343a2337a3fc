#include "solver/contact/patch_history.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace firn {
namespace {

constexpr double kSameHistory = 0.7;  // cosine: a patch may inherit from an old one

// Parts whose patches may inherit from an old patch: its own and their neighbors.
struct HeirParts {
  std::uint64_t a, b;

  HeirParts(const PatchInput& in, const ContactPatch& old)
      : a(dilated(old.parts_a, in.neighbors_a)),
        // A boundary without lists of neighbors has one surface.
        b(in.neighbors_b.empty() ? ~std::uint64_t{0} : dilated(old.parts_b, in.neighbors_b)) {}
  bool include(const ContactPatch& fresh) const {
    return (a & fresh.parts_a) != 0 && (b & fresh.parts_b) != 0;
  }

 private:
  static std::uint64_t dilated(std::uint64_t parts, std::span<const std::uint64_t> neighbors) {
    std::uint64_t all = parts;
    for (std::size_t i = 0; i < neighbors.size(); ++i)
      all |= neighbors[i] & -(parts >> (i & 63) & 1);
    return all;
  }
};

// True when `fresh` is at the position of `old`: same or neighboring parts on both bodies, similar
// normals.
bool can_inherit_history(const HeirParts& parts, const ContactPatch& old,
                         const ContactPatch& fresh) {
  return old.normal.dot(fresh.normal) >= kSameHistory && parts.include(fresh);
}

// Relative motion of the bodies at a patch in this step.
PatchMotion motion_at(const PatchInput& in, const ContactPatch& patch, const Vec3& velocity) {
  return patch_motion(to_vec(patch.normal), to_vec(velocity + in.angular_velocity.cross(patch.arm)),
                      to_vec(in.angular_velocity), in.dt);
}

// m, overlap of a point before the approach of this step.
double overlap_before(const ContactPoint& point, const PatchMotion& motion) {
  return std::max(0.0, -point.gap - motion.closing - dot(to_vec(point.offset), motion.tilt));
}

// J, work of the forces of an old patch over the approach of this step, at the arms of the step
// before.
double work_of_step(const PatchInput& in, const ContactPatch& old) {
  const PatchMotion motion = motion_at(in, old, in.velocity_before);
  const ContactPoint* points = in.old_points + old.first_point;
  double work = 0;
  for (std::uint32_t k = 0; k < old.point_count; ++k)
    work += points[k].force * closing_of(motion, points[k]);
  return work;
}

// Updates the match of each point of `fresh` if a point of `old` is nearer than the recorded one.
void match_points(const PatchInput& in, const ContactPatch& old, const ContactPatch& fresh,
                  const ContactPoint* points, PointMatch* matches) {
  // Of the loading line: points with less keep no stiffness fraction.
  constexpr double kLoaded = 0.01;
  for (std::uint32_t i = 0; i < fresh.point_count; ++i) {
    const Vec3 place = fresh.arm + points[i].offset - old.arm;
    for (std::uint32_t k = 0; k < old.point_count; ++k) {
      const ContactPoint& q = in.old_points[old.first_point + k];
      const double distance2 = (q.offset - place).squaredNorm();
      if (distance2 >= matches[i].distance2) continue;
      const double loading = in.law.stiffness * q.stiffness_fraction * -q.gap;
      const double part = loading > q.force ? q.force / loading : 1.0;
      const bool stays = distance2 < in.law.match_distance * in.law.match_distance &&
                         q.force > kInContact && part > kLoaded;
      matches[i] = {distance2, part, stays ? q.stiffness_fraction : 0, 0};
    }
  }
}

// The next stiffness fraction of a point: that of its match, changed towards the new one; without
// a match, the new one.
double next_fraction(const ContactPoint& point, const PointMatch& match) {
  constexpr double kMostChange = 1.25;  // in one search
  if (!(match.stiffness_fraction > 0)) return point.stiffness_fraction;
  return std::clamp(point.stiffness_fraction, match.stiffness_fraction / kMostChange,
                    match.stiffness_fraction * kMostChange);
}

// Energy that a patch can store, as a fraction of that of the whole stiffness at the contact
// margin.
double capacity(const PatchInput& in, const ContactPatch& patch, const ContactPoint* points,
                const PointMatch* matches) {
  const PatchMotion motion = motion_at(in, patch, in.velocity);
  double sum = 0;
  for (std::uint32_t i = 0; i < patch.point_count; ++i) {
    const double part = overlap_before(points[i], motion) / in.law.contact_margin;
    sum += next_fraction(points[i], matches[i]) * part * part;
  }
  return sum;
}

// Sets the forces of the points of a patch so that they store `energy` (J) and have the sum `force`
// (N). Both are those before this step, and so are the overlaps. Each point has the same fraction
// of its loading line as the point that it matches, times one factor. Where the loading line would
// be exceeded, stiffness fractions are scaled; then `energy` is met and `force` is not. `work` (J):
// of the old forces in this step.
void load_points(const PatchInput& in, double energy, double force, double work,
                 ContactPatch& patch, ContactPoint* points, PointMatch* matches) {
  constexpr double kMostShare = 4;  // a stiffer point needs a shorter time step
  // Of the nominal stiffness; a softer one has too large an overlap.
  constexpr double kLeastScale = 0.25;
  constexpr double kMostCorrection = 0.1;
  const PairCoefficients& law = in.law;
  const PatchMotion motion = motion_at(in, patch, in.velocity);
  double nominal = 0, before = 0, first = 0, second = 0, done = 0, most = 0, largest = 0;
  double change_from = 0, change_to = 0;
  double deepest = 0, step = 0;  // m, and how far that point has moved in this step
  for (std::uint32_t i = 0; i < patch.point_count; ++i) {
    PointMatch& match = matches[i];
    const double ds = closing_of(motion, points[i]);
    const double s = std::max(0.0, -points[i].gap - ds), part = match.part;
    match.overlap = s;
    const double own = points[i].stiffness_fraction,
                 old = match.stiffness_fraction > 0 ? match.stiffness_fraction : own;
    points[i].stiffness_fraction = next_fraction(points[i], match);
    if (!(s > 0)) continue;
    const double bears = points[i].stiffness_fraction * s * part;
    change_from += old * s * part;
    change_to += std::sqrt(old * points[i].stiffness_fraction) * s * part;
    nominal += own * s * s;
    before += points[i].stiffness_fraction * s * s;
    first += bears;
    second += bears * s * part;
    done += bears * ds;
    most = std::max(most, part);
    largest = std::max(largest, points[i].stiffness_fraction);
    step = s > deepest ? std::abs(ds) : step;
    deepest = std::max(deepest, s);
  }
  if (!(second > 0)) return;
  force *= change_to / change_from;  // the stiffness changes at constant energy
  // The energy of a contact that began in the last step or two is not known well.
  const double age = deepest / (step + std::numeric_limits<double>::min());  // steps, about
  const double range = 1 + age * age;
  const double least = std::clamp(kLeastScale * nominal / before, 1 / range, 1.0);
  const double limit = std::max(least, std::min(kMostShare / largest, range));
  double factor = 0, scale = 0;
  const auto solve = [&](double stored) {
    const double twice = 2 * stored * law.unloading_stiffness_ratio;
    factor = std::min(1 / most, twice * first / (force * second));
    const double wanted = twice / (factor * factor * law.stiffness * second);
    scale = std::clamp(wanted, least, limit);
    if (scale != wanted)
      factor = std::min(1 / most, std::sqrt(twice / (scale * law.stiffness * second)));
  };
  solve(energy);
  // The old forces did the first half of the work of this step, with the old normal and lever arms.
  // The difference from the work of the new forces is added to the energy. Of work on the loading
  // line, the fraction 1 / unloading_stiffness_ratio is recoverable.
  const double taken =
      0.5 * (work - factor * scale * law.stiffness * done) / law.unloading_stiffness_ratio;
  solve(energy + std::clamp(taken, -kMostCorrection * energy, kMostCorrection * energy));
  patch.normal_force = 0;
  for (std::uint32_t i = 0; i < patch.point_count; ++i) {
    const double s = matches[i].overlap;
    if (!(s > 0)) continue;
    points[i].stiffness_fraction *= scale;
    points[i].force = factor * matches[i].part * law.stiffness * points[i].stiffness_fraction * s;
    patch.normal_force += points[i].force;
  }
}

// Friction rotated into the plane of the new normal, with its magnitude.
Vec3 rotated_into_plane(const Vec3& t, const Vec3& normal) {
  const double size = t.norm();
  if (size == 0) return t;
  const Vec3 flat = t - normal * normal.dot(t);
  const double rest = flat.norm();
  return rest > 0 ? Vec3(flat * (size / rest)) : Vec3(Vec3::Zero());
}

}  // namespace

void transfer_history(const PatchInput& in, PatchScratch& scratch, PatchBuffer& out) {
  const auto points_of = [&](const ContactPatch& p) { return out.points.data() + p.first_point; };
  const auto matches_of = [&](const ContactPatch& p) {
    return scratch.matches.data() + p.first_point;
  };
  scratch.matches.assign(out.points.size(), PointMatch{});
  scratch.energy.assign(out.patches.size(), 0.0);
  scratch.work.assign(out.patches.size(), 0.0);
  for (std::size_t o = 0; o < in.old_patches.size(); ++o) {
    const ContactPatch& old = in.old_patches[o];
    const HeirParts parts(in, old);
    if (old.normal_force <= 0) {
      // Without load within the contact margin: a contact here was detected before it touched.
      for (std::size_t i = 0; i < out.patches.size(); ++i) {
        if (can_inherit_history(parts, old, out.patches[i])) scratch.has_parent[i] = 1;
      }
      continue;
    }
    // A single new patch takes all.
    scratch.capacity.assign(out.patches.size(), 0.0);
    double all = 0;
    for (std::size_t i = 0; i < out.patches.size(); ++i) {
      const ContactPatch& fresh = out.patches[i];
      if (!can_inherit_history(parts, old, fresh)) continue;
      match_points(in, old, fresh, points_of(fresh), matches_of(fresh));
      scratch.capacity[i] =
          out.patches.size() == 1 ? 1.0 : capacity(in, fresh, points_of(fresh), matches_of(fresh));
      all += scratch.capacity[i];
    }
    if (all <= 0) continue;
    const double energy = spring_energy(in.law, old, in.old_points + old.first_point);
    const double work = work_of_step(in, old);
    for (std::size_t i = 0; i < out.patches.size(); ++i) {
      ContactPatch& fresh = out.patches[i];
      if (!can_inherit_history(parts, old, fresh)) continue;
      const double f = scratch.capacity[i] / all;
      scratch.energy[i] += f * energy;
      scratch.work[i] += f * work;
      fresh.normal_force += f * old.normal_force;
      fresh.tangential += f * rotated_into_plane(old.tangential, fresh.normal);
      out.details[i].rolling += f * rotated_into_plane(in.old_details[o].rolling, fresh.normal);
      // A smaller patch has a shorter lever arm: the excess is lost as slip.
      const double lever =
          old.torsion_radius > 0 ? std::min(1.0, fresh.torsion_radius / old.torsion_radius) : 0;
      fresh.torsion += f * lever * lever * old.torsion;
      fresh.sliding |= old.sliding;
      scratch.has_parent[i] = 1;
    }
  }
  for (std::size_t i = 0; i < out.patches.size(); ++i) {
    ContactPatch& fresh = out.patches[i];
    if (!(fresh.normal_force > 0)) continue;
    load_points(in, scratch.energy[i], fresh.normal_force, scratch.work[i], fresh, points_of(fresh),
                matches_of(fresh));
  }
}

}  // namespace firn
