#include "solver/contact/patch_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/collision/contact_region.h"

namespace firn {

namespace {

constexpr double kSameFace = 0.9962;  // cosine of 5 degrees: one region whatever else
constexpr double kSamePatch = 0.9;    // cosine: normals further apart are never one region
constexpr double kLikeArea = 0.1;     // ratio of areas that share stiffness fairly
constexpr double kSamePlane = 1e-3;   // of the shell
constexpr double kSameHistory = 0.7;  // cosine: a patch may inherit from an old one

// True when two neighboring contacts belong to one region. Stiffness is distributed by
// area. A corner deeper than the adjacent face would get almost no stiffness and sink in: it is a
// separate region.
bool can_share_patch(const Manifold& c, const Manifold& d) {
  const double cosine = c.normal.dot(d.normal);
  if (cosine >= kSameFace) return true;
  if (cosine < kSamePatch) return false;
  const Manifold& smaller = c.area < d.area ? c : d;
  const Manifold& larger = c.area < d.area ? d : c;
  return smaller.area > kLikeArea * larger.area || smaller.gap >= larger.gap;
}

// Neighbors of the part `one` and of those in the mask `others`.
std::uint64_t neighbors_of(std::span<const std::uint64_t> neighbors, int one,
                           std::uint64_t others) {
  std::uint64_t all = neighbors[one];
  for (std::size_t i = 0; others != 0 && i < neighbors.size(); ++i)
    all |= neighbors[i] & -(others >> (i & 63) & 1);
  return all;
}

// Connected components of the contacts: neighboring parts on both bodies and like normals.
int group_contacts(const PatchInput& in, PatchScratch& scratch) {
  const int n = static_cast<int>(in.contacts.size());
  scratch.group.assign(n, -1);
  int groups = 0;
  for (int seed = 0; seed < n; ++seed) {
    if (scratch.group[seed] >= 0) continue;
    scratch.group[seed] = groups;
    scratch.stack.assign(1, seed);
    while (!scratch.stack.empty()) {
      const PartContact& c = in.contacts[scratch.stack.back()];
      scratch.stack.pop_back();
      const std::uint64_t near_a = neighbors_of(in.neighbors_a, c.a, c.other_a);
      const std::uint64_t near_b =
          in.neighbors_b.empty() ? ~std::uint64_t{0} : neighbors_of(in.neighbors_b, c.b, c.other_b);
      for (int k = 0; k < n; ++k) {
        if (scratch.group[k] >= 0) continue;
        const PartContact& d = in.contacts[k];
        if (!(near_a & (part_bit(d.a) | d.other_a)) || !(near_b & (part_bit(d.b) | d.other_b)))
          continue;
        if (!can_share_patch(c.manifold, d.manifold)) continue;
        scratch.group[k] = groups;
        scratch.stack.push_back(k);
      }
    }
    ++groups;
  }
  return groups;
}

// Moments of the touching region of a group, for torsion.
struct Moments {
  double area = 0;               // m^2
  Vec3 centroid = Vec3::Zero();  // m
  Mat3 second = Mat3::Zero();    // m^4, about the centroid

  void add(const Manifold& m) {
    if (m.area <= 0) return;
    const double sum = area + m.area;
    const Vec3 apart = m.centroid - centroid;
    second += m.moments + area * m.area / sum * apart * apart.transpose();
    centroid += apart * (m.area / sum);
    area = sum;
  }
  // In a basis across the normal, in the axes of the moments.
  Elongation elongation(const Vec3& u, const Vec3& v) const {
    const double uu = u.dot(second * u), vv = v.dot(second * v), uv = u.dot(second * v);
    const double polar = uu + vv;
    if (!(polar > 0)) return {};
    return {static_cast<float>((uu - vv) / polar), static_cast<float>(2 * uv / polar)};
  }
  // Mean distance from the centroid of a uniform rectangle with these moments.
  double torsion_radius() const {
    const double polar = second.trace();
    if (!(area > 0) || !(polar > 0)) return 0;
    const double h = std::clamp(2 * second.squaredNorm() / (polar * polar) - 1, 0.0, 1.0);
    return mean_distance(h) * std::sqrt(polar / area);
  }
};

// Adds a point, or merges it with a near one of the same patch: weights add, place and gap are
// weighted means. Nothing is dropped. Until the patch is complete, a point's share is its weight.
void add_point(std::vector<ContactPoint>& points, std::size_t first, const Vec3& place, double gap,
               double weight, double merge) {
  for (std::size_t i = first; i < points.size(); ++i) {
    ContactPoint& p = points[i];
    if ((p.offset - place).squaredNorm() < merge * merge) {
      const double sum = p.stiffness_fraction + weight;
      const double f = sum > 0 ? weight / sum : 0.5;
      p.offset += f * (place - p.offset);
      p.gap += f * (gap - p.gap);
      p.stiffness_fraction = sum;
      return;
    }
  }
  ContactPoint p;
  p.offset = place;
  p.gap = gap;
  p.stiffness_fraction = weight;
  points.push_back(p);
}

bool is_same_plane(const ConvexPart::Face* a, const ConvexPart::Face* b, double tolerance) {
  constexpr double kParallel = 1 - 1e-12;  // cosine
  if (a == b) return true;
  return a && b && a->normal.dot(b->normal) > kParallel &&
         std::abs(a->offset - b->offset) <= tolerance;
}

// Contacts of faces of one plane on each body: a face that is cut, or lies on a surface that is
// cut.
bool is_same_flat(const Manifold& c, const Manifold& d, double tolerance) {
  return !c.outline.empty() && !d.outline.empty() &&
         is_same_plane(c.feature_a.face, d.feature_a.face, tolerance) &&
         is_same_plane(c.feature_b.face, d.feature_b.face, tolerance);
}

// Moves the mean of the points to `centroid` by weights that change linearly with the place. Below
// this part of the extent, hull and faces have the same centroid but for rounding.
void move_centroid(Region& r, const PlanePoint& centroid, double extent) {
  constexpr double kSameCentroid = 1e-9, kLeastWeight = 0.05;
  double sum = 0, u = 0, v = 0;
  for (int i = 0; i < r.count; ++i) {
    sum += r.points[i].weight;
    u += r.points[i].weight * r.points[i].at.u;
    v += r.points[i].weight * r.points[i].at.v;
  }
  u /= sum;
  v /= sum;
  if (std::hypot(centroid.u - u, centroid.v - v) <= kSameCentroid * extent) return;
  double uu = 0, uv = 0, vv = 0;
  for (int i = 0; i < r.count; ++i) {
    const double du = r.points[i].at.u - u, dv = r.points[i].at.v - v, w = r.points[i].weight / sum;
    uu += w * du * du;
    uv += w * du * dv;
    vv += w * dv * dv;
  }
  const double determinant = uu * vv - uv * uv;
  if (!(determinant > 0)) return;
  const double du = centroid.u - u, dv = centroid.v - v;
  double slope_u = (vv * du - uv * dv) / determinant, slope_v = (uu * dv - uv * du) / determinant;
  double least = 1;
  for (int i = 0; i < r.count; ++i) {
    least =
        std::min(least, 1 + slope_u * (r.points[i].at.u - u) + slope_v * (r.points[i].at.v - v));
  }
  if (least < kLeastWeight) {  // no weight is negative
    slope_u *= (1 - kLeastWeight) / (1 - least);
    slope_v *= (1 - kLeastWeight) / (1 - least);
  }
  for (int i = 0; i < r.count; ++i) {
    r.points[i].weight *= 1 + slope_u * (r.points[i].at.u - u) + slope_v * (r.points[i].at.v - v);
  }
}

// Corners of the convex hull of the outlines of such contacts, weighed as one face: cuts have no
// effect on it. Their mean is the centroid of the faces, also where these are not convex together.
// Nothing if it has no area.
void hull_of_flat(const PatchInput& in, std::span<const int> contacts,
                  std::vector<ManifoldPoint>& out) {
  out.clear();
  const ContactBasis frame(in.contacts[contacts[0]].manifold.normal);
  std::vector<PlanePoint> places;
  std::vector<const ManifoldPoint*> points;
  for (const int i : contacts) {
    for (const ManifoldPoint& p : in.contacts[i].manifold.outline) {
      places.push_back(frame.flat(p.position));
      points.push_back(&p);
    }
  }
  double extent = 0;
  const std::vector<int> hull = hull_corners(places, extent);
  if (hull.size() < 3) return;
  Region region(static_cast<int>(hull.size()), extent);
  for (const int c : hull) region.add(places[c], 0, 0);
  compute_polygon_weights(region);
  if (!(region.area > std::pow(kEdgeWidth * extent, 2))) return;
  double area = 0;
  PlanePoint centroid{0, 0};
  for (const int i : contacts) {
    const Manifold& m = in.contacts[i].manifold;
    const PlanePoint at = frame.flat(m.centroid);
    area += m.area;
    centroid.u += m.area * at.u;
    centroid.v += m.area * at.v;
  }
  move_centroid(region, {centroid.u / area, centroid.v / area}, extent);
  for (std::size_t i = 0; i < hull.size(); ++i)
    out.push_back({points[hull[i]]->position, points[hull[i]]->gap, region.points[i].weight});
}

// One patch of the contacts in group `g`, without history.
void make_patch(const PatchInput& in, PatchScratch& scratch, int g, FoundPatches& out) {
  Patch patch;
  PatchDetail detail;
  patch.first_point = static_cast<std::uint32_t>(out.points.size());
  const double shell = in.law.contact_margin;
  Vec3 normal = Vec3::Zero();
  Moments moments;
  std::vector<int>& rest = scratch.stack;  // contacts of the group
  rest.clear();
  for (std::size_t i = 0; i < in.contacts.size(); ++i) {
    if (scratch.group[i] == g) rest.push_back(static_cast<int>(i));
  }
  for (const int i : rest) {
    const PartContact& c = in.contacts[i];
    patch.parts_a |= part_bit(c.a) | c.other_a;
    patch.parts_b |= part_bit(c.b) | c.other_b;
    moments.add(c.manifold);
    double depth = 0;
    for (const ManifoldPoint& p : c.manifold.points) depth += p.weight * (shell - p.gap);
    normal += depth * c.manifold.normal;
  }
  const auto add = [&](const ManifoldPoint& p) {
    if (p.gap < shell)
      add_point(out.points, patch.first_point, p.position, p.gap, p.weight, in.law.merge_distance);
  };
  while (!rest.empty()) {
    const Manifold& first = in.contacts[rest[0]].manifold;
    const auto others = std::stable_partition(rest.begin(), rest.end(), [&](int i) {
      return i == rest[0] || is_same_flat(first, in.contacts[i].manifold, kSamePlane * shell);
    });
    const std::span<const int> alike(rest.begin(), others);
    scratch.hull.clear();
    if (alike.size() > 1) hull_of_flat(in, alike, scratch.hull);
    const bool has_hull = std::ranges::any_of(
        scratch.hull, [shell](const ManifoldPoint& p) { return p.gap < shell; });
    for (const ManifoldPoint& p : scratch.hull) add(p);
    for (const int i : alike) {
      if (has_hull) break;
      for (const ManifoldPoint& p : in.contacts[i].manifold.points) add(p);
    }
    rest.erase(rest.begin(), others);
  }
  const std::size_t count = out.points.size() - patch.first_point;
  if (count > std::numeric_limits<std::uint16_t>::max())
    throw RunError("more than 65535 contact points between two bodies");
  patch.point_count = static_cast<std::uint16_t>(count);
  ContactPoint* points = out.points.data() + patch.first_point;

  double sum = 0, square = 0;
  Vec3 center = Vec3::Zero();
  for (std::uint32_t i = 0; i < patch.point_count; ++i) {
    const double d = shell - points[i].gap;
    detail.area += points[i].stiffness_fraction;
    sum += points[i].stiffness_fraction * d;
    square += points[i].stiffness_fraction * d * d;
    center += points[i].stiffness_fraction * d * points[i].offset;
  }
  if (!(sum > 0) || !(normal.squaredNorm() > 0)) {  // nothing within the margin that has an area
    out.points.resize(patch.first_point);
    return;
  }
  center /= sum;
  for (std::uint32_t i = 0; i < patch.point_count; ++i) {
    points[i].stiffness_fraction *= square / (sum * sum);
    points[i].offset = in.rotation_a * (points[i].offset - center);
  }
  patch.normal = in.rotation_a * normal.normalized();
  patch.arm = in.rotation_a * center;
  patch.torsion_radius = moments.torsion_radius();
  const ContactBasis basis(patch.normal);
  patch.elongation =
      moments.elongation(in.rotation_a.transpose() * basis.u, in.rotation_a.transpose() * basis.v);
  out.patches.push_back(patch);
  out.details.push_back(detail);
}

// True when `old` lies where `fresh` is: same or neighboring parts on both bodies, like normals.
bool inherits(const PatchInput& in, const Patch& old, const Patch& fresh) {
  if (old.normal.dot(fresh.normal) < kSameHistory) return false;
  const auto dilated = [](std::uint64_t parts, std::span<const std::uint64_t> neighbors) {
    std::uint64_t all = parts;
    for (std::size_t i = 0; i < neighbors.size(); ++i)
      all |= neighbors[i] & -(parts >> (i & 63) & 1);
    return all;
  };
  if (!(dilated(old.parts_a, in.neighbors_a) & fresh.parts_a)) return false;
  return in.neighbors_b.empty() || (dilated(old.parts_b, in.neighbors_b) & fresh.parts_b);
}

// How the bodies move against each other at a patch in this step.
PatchMotion motion_at(const PatchInput& in, const Patch& patch, const Vec3& velocity) {
  return patch_motion(plain(patch.normal), plain(velocity + in.angular_velocity.cross(patch.arm)),
                      plain(in.angular_velocity), in.dt);
}

// m, overlap of a point before the approach of this step.
double overlap_before(const ContactPoint& point, const PatchMotion& motion) {
  return std::max(0.0, -point.gap - motion.closing - dot(plain(point.offset), motion.tilt));
}

// J, work of the forces of an old patch over the approach of this step, at the arms of the step
// before.
double work_of_step(const PatchInput& in, const Patch& old) {
  const PatchMotion motion = motion_at(in, old, in.velocity_before);
  const ContactPoint* points = in.old_points + old.first_point;
  double work = 0;
  for (std::uint32_t k = 0; k < old.point_count; ++k)
    work += points[k].force * closing_of(motion, points[k]);
  return work;
}

// Records for each point of `fresh` the nearest point of `old`, unless a nearer one is recorded.
void match_points(const PatchInput& in, const Patch& old, const Patch& fresh,
                  const ContactPoint* points, PointMatch* matches) {
  constexpr double kLoaded = 0.01;  // part of the loading line below which a share is given up
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

// What a patch can hold of energy, over that of the whole stiffness at the shell.
double capacity(const PatchInput& in, const Patch& patch, const ContactPoint* points,
                const PointMatch* matches) {
  const PatchMotion motion = motion_at(in, patch, in.velocity);
  double sum = 0;
  for (std::uint32_t i = 0; i < patch.point_count; ++i) {
    const double part = overlap_before(points[i], motion) / in.law.contact_margin;
    sum += next_fraction(points[i], matches[i]) * part * part;
  }
  return sum;
}

// Loads the points of a patch so that they store `energy` (J) and press with `force` (N). Both are
// those before this step, so the overlaps before the approach of this step count. Each point bears
// the same part of its loading line as the point that it matches, times one factor. Where the
// loading line would be exceeded, shares are scaled and the energy comes first. `work` (J): what
// the old forces would do in this step.
void load_points(const PatchInput& in, double energy, double force, double work, Patch& patch,
                 ContactPoint* points, PointMatch* matches) {
  constexpr double kMostShare = 4;      // a stiffer point would need a shorter time step
  constexpr double kLeastScale = 0.25;  // of the nominal stiffness; a softer one would sink in
  constexpr double kMostCorrection = 0.1;
  const PairLaw& law = in.law;
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
  force *= change_to / change_from;  // a share changes at constant energy
  // The energy of a contact that began in the last step or two is not known well.
  const double age = deepest / (step + std::numeric_limits<double>::min());  // steps, about
  const double range = 1 + age * age;
  const double least = std::clamp(kLeastScale * nominal / before, 1 / range, 1.0);
  const double limit = std::max(least, std::min(kMostShare / largest, range));
  double factor = 0, scale = 0;
  const auto solve = [&](double stored) {
    const double twice = 2 * stored * law.unloading_ratio;
    factor = std::min(1 / most, twice * first / (force * second));
    const double wanted = twice / (factor * factor * law.stiffness * second);
    scale = std::clamp(wanted, least, limit);
    if (scale != wanted)
      factor = std::min(1 / most, std::sqrt(twice / (scale * law.stiffness * second)));
  };
  solve(energy);
  // The first half of this step's work was done along the old normal at the old arms. Of work on
  // the loading line, a part of 1 / unloading_ratio is recoverable.
  const double taken = 0.5 * (work - factor * scale * law.stiffness * done) / law.unloading_ratio;
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

// Friction carried over into the plane of the new normal, its size kept.
Vec3 turned_into_plane(const Vec3& t, const Vec3& normal) {
  const double size = t.norm();
  if (size == 0) return t;
  const Vec3 flat = t - normal * normal.dot(t);
  const double rest = flat.norm();
  return rest > 0 ? Vec3(flat * (size / rest)) : Vec3(Vec3::Zero());
}

// Transfers the state of the old patches to the new ones. A split shares what the old patch carries
// in proportion to what the parts can hold; a merge adds. Normal force and recoverable energy of a
// pair are continuous.
void transfer_history(const PatchInput& in, PatchScratch& scratch, FoundPatches& out) {
  const auto points_of = [&](const Patch& p) { return out.points.data() + p.first_point; };
  const auto matches_of = [&](const Patch& p) { return scratch.matches.data() + p.first_point; };
  scratch.matches.assign(out.points.size(), PointMatch{});
  scratch.energy.assign(out.patches.size(), 0.0);
  scratch.work.assign(out.patches.size(), 0.0);
  for (std::size_t o = 0; o < in.old_patches.size(); ++o) {
    const Patch& old = in.old_patches[o];
    if (old.normal_force <= 0) {
      // Near but without load: its place is known, so a touch there is no late detection.
      for (std::size_t i = 0; i < out.patches.size(); ++i) {
        if (inherits(in, old, out.patches[i])) scratch.has_parent[i] = 1;
      }
      continue;
    }
    // A lone patch takes all.
    scratch.capacity.assign(out.patches.size(), 0.0);
    double all = 0;
    for (std::size_t i = 0; i < out.patches.size(); ++i) {
      const Patch& fresh = out.patches[i];
      if (!inherits(in, old, fresh)) continue;
      match_points(in, old, fresh, points_of(fresh), matches_of(fresh));
      scratch.capacity[i] =
          out.patches.size() == 1 ? 1.0 : capacity(in, fresh, points_of(fresh), matches_of(fresh));
      all += scratch.capacity[i];
    }
    if (all <= 0) continue;
    const double energy = spring_energy(in.law, old, in.old_points + old.first_point);
    const double work = work_of_step(in, old);
    for (std::size_t i = 0; i < out.patches.size(); ++i) {
      Patch& fresh = out.patches[i];
      if (!inherits(in, old, fresh)) continue;
      const double f = scratch.capacity[i] / all;
      scratch.energy[i] += f * energy;
      scratch.work[i] += f * work;
      fresh.normal_force += f * old.normal_force;
      fresh.tangential += f * turned_into_plane(old.tangential, fresh.normal);
      out.details[i].rolling += f * turned_into_plane(in.old_details[o].rolling, fresh.normal);
      // A smaller patch has a shorter lever: what it cannot hold is lost as slip.
      const double lever =
          old.torsion_radius > 0 ? std::min(1.0, fresh.torsion_radius / old.torsion_radius) : 0;
      fresh.torsion += f * lever * lever * old.torsion;
      fresh.sliding |= old.sliding;
      scratch.has_parent[i] = 1;
    }
  }
  for (std::size_t i = 0; i < out.patches.size(); ++i) {
    Patch& fresh = out.patches[i];
    if (!(fresh.normal_force > 0)) continue;
    load_points(in, scratch.energy[i], fresh.normal_force, scratch.work[i], fresh, points_of(fresh),
                matches_of(fresh));
  }
}

}  // namespace

int build_patches(const PatchInput& in, PatchScratch& scratch, FoundPatches& out) {
  out.clear();
  if (in.contacts.empty()) return 0;
  const int groups = group_contacts(in, scratch);
  for (int g = 0; g < groups; ++g) make_patch(in, scratch, g, out);

  scratch.has_parent.assign(out.patches.size(), 0);
  transfer_history(in, scratch, out);

  int deep = 0;
  for (std::size_t i = 0; i < out.patches.size(); ++i) {
    if (scratch.has_parent[i]) continue;
    const Patch& patch = out.patches[i];
    for (std::uint32_t k = 0; k < patch.point_count; ++k) {
      if (-out.points[patch.first_point + k].gap > in.law.late_overlap) {
        ++deep;
        break;
      }
    }
  }
  return deep;
}

}  // namespace firn
