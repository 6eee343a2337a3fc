#include "solver/contact/patch_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "solver/collision/contact_region.h"
#include "solver/contact/coplanar_contacts.h"
#include "solver/contact/patch_history.h"

namespace firn {

namespace {

constexpr double kSameFace = 0.9962;  // cosine of 5 degrees: one region whatever else
constexpr double kSamePatch = 0.9;    // cosine: normals further apart are never one region
constexpr double kLikeArea = 0.1;     // ratio of areas that share stiffness fairly
constexpr double kSamePlane = 1e-3;   // of the contact margin

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

// m, by which a point moves when its normal becomes that of the patch: it turns about the center of
// the rounding of the more rounded part. A sphere keeps its center in the line of force, so that
// facets with different normals do not turn it.
Vec3 turned_about_rounding(const PartContact& c, const ManifoldPoint& p, const Vec3& patch_normal) {
  const double lever = c.radius_a > c.radius_b   ? c.radius_a + 0.5 * p.gap
                       : c.radius_b > c.radius_a ? -c.radius_b - 0.5 * p.gap
                                                 : 0;
  return lever * (patch_normal - c.manifold.normal);
}

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

// Sums over the contacts of a group.
struct GroupSums {
  Vec3 normals = Vec3::Zero();  // weighted by depth below the contact margin
  Moments moments;
};

// Lists the contacts in group `g` in scratch.stack. Sets the parts of the patch.
GroupSums collect_group(const PatchInput& in, PatchScratch& scratch, int g, ContactPatch& patch) {
  std::vector<int>& members = scratch.stack;
  members.clear();
  for (std::size_t i = 0; i < in.contacts.size(); ++i) {
    if (scratch.group[i] == g) members.push_back(static_cast<int>(i));
  }
  GroupSums sums;
  for (const int i : members) {
    const PartContact& c = in.contacts[i];
    patch.parts_a |= part_bit(c.a) | c.other_a;
    patch.parts_b |= part_bit(c.b) | c.other_b;
    sums.moments.add(c.manifold);
    double depth = 0;
    for (const ManifoldPoint& p : c.manifold.points)
      depth += p.weight * (in.law.contact_margin - p.gap);
    sums.normals += depth * c.manifold.normal;
  }
  return sums;
}

// Adds the points of the contacts listed in scratch.stack to a patch with this normal (axes of a).
// Coplanar contacts contribute the hull of their points. Empties the list.
void add_points(const PatchInput& in, PatchScratch& scratch, const Vec3& normal,
                std::uint32_t first_point, std::vector<ContactPoint>& points) {
  const double contact_margin = in.law.contact_margin;
  std::vector<int>& rest = scratch.stack;
  const auto add = [&](const PartContact& c, const ManifoldPoint& p) {
    if (p.gap < contact_margin)
      add_point(points, first_point, p.position + turned_about_rounding(c, p, normal), p.gap,
                p.weight, in.law.merge_distance);
  };
  while (!rest.empty()) {
    const PartContact& first = in.contacts[rest[0]];
    const auto others = std::stable_partition(rest.begin(), rest.end(), [&](int i) {
      return i == rest[0] ||
             is_coplanar(first.manifold, in.contacts[i].manifold, kSamePlane * contact_margin);
    });
    const std::span<const int> alike(rest.begin(), others);
    scratch.hull.clear();
    if (alike.size() > 1) merge_coplanar_contacts(in.contacts, alike, scratch.hull);
    const bool has_hull = std::ranges::any_of(
        scratch.hull, [contact_margin](const ManifoldPoint& p) { return p.gap < contact_margin; });
    for (const ManifoldPoint& p : scratch.hull) add(first, p);
    for (const int i : alike) {
      if (has_hull) break;
      for (const ManifoldPoint& p : in.contacts[i].manifold.points) add(in.contacts[i], p);
    }
    rest.erase(rest.begin(), others);
  }
}

// Turns the weights of points into shares of the stiffness, and moves the points from the axes of a
// to world axes about their pressure center. Returns that center, m, axes of a; empty: nothing
// within the margin has an area.
std::optional<Vec3> share_stiffness(const PatchInput& in, std::span<ContactPoint> points,
                                    double& area) {
  double sum = 0, square = 0;
  Vec3 center = Vec3::Zero();
  for (const ContactPoint& p : points) {
    const double d = in.law.contact_margin - p.gap;
    area += p.stiffness_fraction;
    sum += p.stiffness_fraction * d;
    square += p.stiffness_fraction * d * d;
    center += p.stiffness_fraction * d * p.offset;
  }
  if (!(sum > 0)) return std::nullopt;
  center /= sum;
  for (ContactPoint& p : points) {
    p.stiffness_fraction *= square / (sum * sum);
    p.offset = in.rotation_a * (p.offset - center);
  }
  return center;
}

// One patch of the contacts in group `g`, without history.
void make_patch(const PatchInput& in, PatchScratch& scratch, int g, PatchBuffer& out) {
  ContactPatch patch;
  PatchDetail detail;
  patch.first_point = static_cast<std::uint32_t>(out.points.size());
  const GroupSums sums = collect_group(in, scratch, g, patch);
  const Vec3 normal = sums.normals.normalized();
  add_points(in, scratch, normal, patch.first_point, out.points);
  const std::size_t count = out.points.size() - patch.first_point;
  if (count > std::numeric_limits<std::uint16_t>::max())
    throw RunError("more than 65535 contact points between two bodies");
  patch.point_count = static_cast<std::uint16_t>(count);
  const std::optional<Vec3> center =
      share_stiffness(in, {out.points.data() + patch.first_point, count}, detail.area);
  if (!center || !(sums.normals.squaredNorm() > 0)) {
    out.points.resize(patch.first_point);
    return;
  }
  patch.normal = in.rotation_a * normal;
  patch.arm = in.rotation_a * *center;
  patch.torsion_radius = sums.moments.torsion_radius();
  const ContactBasis basis(patch.normal);
  patch.elongation = sums.moments.elongation(in.rotation_a.transpose() * basis.u,
                                             in.rotation_a.transpose() * basis.v);
  out.patches.push_back(patch);
  out.details.push_back(detail);
}

}  // namespace

int build_patches(const PatchInput& in, PatchScratch& scratch, PatchBuffer& out) {
  out.clear();
  if (in.contacts.empty()) return 0;
  const int groups = group_contacts(in, scratch);
  for (int g = 0; g < groups; ++g) make_patch(in, scratch, g, out);

  scratch.has_parent.assign(out.patches.size(), 0);
  transfer_history(in, scratch, out);

  int deep = 0;
  for (std::size_t i = 0; i < out.patches.size(); ++i) {
    if (scratch.has_parent[i]) continue;
    const ContactPatch& patch = out.patches[i];
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
