#include "solver/contact_detection/tunneling_guard.h"

#include <fmt/format.h>

#include <algorithm>

#include "solver/collision/gjk.h"

namespace firn {

namespace {

// Overlaps deeper than this fraction of the combined thickness are checked. From a half of it on,
// the minimum translation vector may lead to the far side, or through an internal face to an
// adjacent part.
constexpr double kWatched = 0.25;
constexpr double kSameSide = 0.7;  // cosine, kSameHistory of patch_history.cpp
constexpr double kOtherSide = -0.5;

std::uint64_t bit(std::uint32_t part) { return std::uint64_t{1} << (part & 63u); }

double watched_depth(const ConvexPart& a, const ConvexPart& b) {
  return kWatched * (a.thickness + b.thickness);
}

}  // namespace

double step_motion(const Model& model, const Workspace& w, const State& s, int a, int b) {
  const BodyMotion &ma = s.motion[a], &mb = s.motion[b];
  const Vec3 relative =
      ma.velocity - mb.velocity - mb.angular_velocity.cross(ma.position - mb.position);
  const double turning =
      (ma.angular_velocity - mb.angular_velocity).norm() * w.reach[model.particles[a].shape];
  return (relative.norm() + turning) * model.timestep;
}

TunnelingGuard::TunnelingGuard(const SideInput& input) : in_(input) {
  const auto& [model, w, s, pair] = in_;
  const int n = static_cast<int>(model.particles.size());
  const double thick_a = w.thinnest[model.particles[pair.a].shape];
  const double thick_b =
      pair.b < n ? w.thinnest[model.particles[pair.b].shape] : w.thinnest[w.shapes + pair.b - n];
  motion_ = step_motion(model, w, s, pair.a, pair.b);
  needs_sweep_ = motion_ > kWatched * (thick_a + thick_b);
}

const ConvexPart& TunnelingGuard::part_b(std::uint32_t index) const {
  const int n = static_cast<int>(in_.model.particles.size());
  const int b = in_.pair.b;
  return b < n ? in_.model.shapes[in_.model.particles[b].shape].parts[index]
               : in_.model.boundaries[b - n].parts[index];
}

// Pose of b's axes in a's axes, `seconds` before the end of the present step.
Pose TunnelingGuard::pose_before(double seconds) const {
  const State& s = in_.state;
  const auto place = [&](int body) {
    const BodyMotion& m = s.motion[body];
    const Vec3 turned = -seconds * m.angular_velocity;
    const double angle = turned.norm();
    Pose p{rotation_of(s, body), m.position - seconds * m.velocity};
    if (angle > 0) {
      p.rotation = Eigen::AngleAxisd(angle, turned / angle).toRotationMatrix() * p.rotation;
    }
    return p;
  };
  const Pose a = place(in_.pair.a), b = place(in_.pair.b);
  return {a.rotation.transpose() * b.rotation,
          a.rotation.transpose() * (b.translation - a.translation)};
}

// True when the patch is on part `b`: one of its points is in the part, with a tolerance of half
// the gap, the contact margin and the motion within a step. Needed for boundaries of more than 64
// parts, because the masks of a patch hold the part number modulo 64.
bool TunnelingGuard::covers_part(const ContactPatch& patch, const ConvexPart& b) const {
  const State& s = in_.state;
  const Mat3 axes = rotation_of(s, in_.pair.b);
  const Vec3 place = s.motion[in_.pair.a].position + patch.arm - s.motion[in_.pair.b].position;
  const double contact_margin = in_.workspace.laws[in_.pair.law].contact_margin;
  for (std::uint32_t i = patch.first_point; i < patch.first_point + patch.point_count; ++i) {
    const ContactPoint& point = s.points[i];
    const Vec3 at = axes.transpose() * (place + point.offset);
    const double near = 0.5 * std::abs(point.gap) + contact_margin + motion_;
    if (std::ranges::all_of(b.faces, [&](const ConvexPart::Face& face) {
          return face.normal.dot(at) - face.offset <= near;
        })) {
      return true;
    }
  }
  return false;
}

// Calls visit(patch) for each patch of the last search that is loaded and is on the same parts.
// `neighbors`: also on adjacent parts.
template <class Visit>
void TunnelingGuard::for_each_patch(const PartPair& parts, bool neighbors,
                                    const Visit& visit) const {
  const auto& [model, w, s, pair] = in_;
  const int n = static_cast<int>(model.particles.size());
  std::uint64_t mask_a = bit(parts.a), mask_b = bit(parts.b);
  bool ambiguous = pair.b >= n && model.boundaries[pair.b - n].parts.size() > 64;
  if (neighbors) {
    mask_a = model.shapes[model.particles[pair.a].shape].part_neighbors[parts.a];
    mask_b = pair.b < n ? model.shapes[model.particles[pair.b].shape].part_neighbors[parts.b]
                        : ~std::uint64_t{0};
    ambiguous = false;
  }
  for (std::uint32_t k = pair.first_patch; k < pair.first_patch + pair.patch_count; ++k) {
    const ContactPatch& patch = s.patches[k];
    if (!(patch.normal_force > 0) || !(patch.parts_a & mask_a) || !(patch.parts_b & mask_b)) {
      continue;
    }
    if (!ambiguous || covers_part(patch, part_b(parts.b))) visit(patch);
  }
}

// The patch of for_each_patch() whose normal is closest to `normal` (world). Null: no patch.
const ContactPatch* TunnelingGuard::nearest(const PartPair& parts, bool neighbors,
                                            const Vec3& normal) const {
  const ContactPatch* best = nullptr;
  for_each_patch(parts, neighbors, [&](const ContactPatch& patch) {
    if (!best || patch.normal.dot(normal) > best->normal.dot(normal)) best = &patch;
  });
  return best;
}

// Conservative advancement over the present step: true when the parts were apart at its beginning
// and met at the fraction `at` of it, with the normal (axes of body a, from a to b) of the gap
// that closed there.
bool TunnelingGuard::sweep_pair(const ConvexPart& a, const ConvexPart& b, Vec3& normal,
                                double& at) const {
  constexpr int kTries = 64;
  const double radii = a.radius + b.radius, dt = in_.model.timestep;
  const double touching = 1e-3 * watched_depth(a, b);
  GjkCache cache;
  at = 0;
  for (int i = 0; i < kTries; ++i) {
    const CoreContact contact = core_contact(a, b, pose_before((1 - at) * dt),
                                             std::numeric_limits<double>::infinity(), cache);
    const double gap = contact.distance - radii;
    if (i == 0 && gap <= 0) return false;
    if (contact.distance > contact_tolerance(a, b)) normal = contact.normal;
    if (gap <= touching) return true;
    at += gap / motion_;
    if (!(at < 1)) return false;
  }
  return true;
}

// Finds the side of contact from the part that was hit first in this step. A body that enters
// through one part and crosses an internal face within the step ends in parts that it entered
// through internal faces. Each of these parts leaves the contact to its neighbor.
bool TunnelingGuard::find_first_impact(const PartPair& parts, Vec3& side) const {
  const auto& [model, w, s, pair] = in_;
  const Shape& shape_a = model.shapes[model.particles[pair.a].shape];
  double first = std::numeric_limits<double>::infinity();
  for (std::uint32_t k = pair.first_part; k < pair.first_part + pair.part_count; ++k) {
    const PartPair& other = s.part_pairs[k];
    const bool near = other.a == parts.a ||
                      (other.b == parts.b && shape_a.part_neighbors[parts.a] & bit(other.a));
    if (!near) continue;
    Vec3 normal;
    double at;
    if (!sweep_pair(shape_a.parts[other.a], part_b(other.b), normal, at) || at >= first) continue;
    first = at;
    side = normal;
  }
  return std::isfinite(first);
}

bool TunnelingGuard::penetrates_during_step(const ConvexPart& a, const ConvexPart& b, double from,
                                            double deep) const {
  constexpr int kPlaces = 8;
  const double dt = in_.model.timestep;
  Manifold m;
  for (int i = 1; i < kPlaces; ++i) {
    const double at = from + (1 - from) * i / kPlaces;
    GjkCache cold;
    collide(a, b, pose_before((1 - at) * dt), 0, cold, m);
    if (-m.gap > deep) return true;
  }
  return false;
}

bool TunnelingGuard::enforce_contact_side(const PartPair& parts, const Pose& b_in_a,
                                          double contact_margin, Manifold& m) const {
  const auto& [model, w, s, pair] = in_;
  const ConvexPart& a = model.shapes[model.particles[pair.a].shape].parts[parts.a];
  const ConvexPart& b = part_b(parts.b);
  const Mat3 axes = rotation_of(s, pair.a);
  const double watched = watched_depth(a, b);
  const bool deep = -m.gap > watched;
  // Overlapping cores without contact points: the minimum translation vector leads through an
  // internal face, so the contact was left to the adjacent part. The adjacent part may leave it to
  // this part.
  const bool dropped = m.points.empty() && -m.gap > a.radius + b.radius;
  if (const ContactPatch* own = nearest(parts, false, axes * m.normal)) {
    const Vec3 side = axes.transpose() * own->normal;
    const double cosine = side.dot(m.normal);
    if (!dropped && (cosine > kSameSide || (cosine > 0 && !deep))) return true;
    if (m.gap >= 0)
      return cosine > kOtherSide && !(needs_sweep_ && penetrates_during_step(a, b, 0, watched));
    collide_with_side_hint(a, b, b_in_a, side, contact_margin, m);
    return true;
  }
  if (!deep && !dropped && !needs_sweep_) return true;
  Vec3 side;
  double at;
  if (sweep_pair(a, b, side, at) && !normal_exits_internal_face(a, side) &&
      !normal_exits_internal_face(b, -(b_in_a.rotation.transpose() * side))) {
    const double cosine = side.dot(m.normal);
    if (m.gap >= 0) return cosine > kOtherSide && !penetrates_during_step(a, b, at, watched);
    if (dropped || cosine < kSameSide)
      collide_with_side_hint(a, b, b_in_a, side, contact_margin, m);
    return true;
  }
  if (!deep && !dropped) return true;
  const ContactPatch* like = nearest(parts, true, axes * m.normal);
  if (!like) {
    if (dropped && find_first_impact(parts, side))
      collide_with_side_hint(a, b, b_in_a, side, contact_margin, m);
    return true;
  }
  if (!dropped && (axes.transpose() * like->normal).dot(m.normal) >= kSameSide) return true;
  // Tries the side of each loaded patch on these or adjacent parts, of which there are several in a
  // corner, and uses the one with the least penetration. A side is rejected if this part is far
  // deeper there than the patch.
  Manifold best, tried;
  for_each_patch(parts, true, [&](const ContactPatch& patch) {
    double depth = watched;
    for (std::uint32_t i = patch.first_point; i < patch.first_point + patch.point_count; ++i) {
      depth = std::max(depth, watched - in_.state.points[i].gap);
    }
    collide_with_side_hint(a, b, b_in_a, axes.transpose() * patch.normal, contact_margin, tried);
    if (-tried.gap <= depth && (best.points.empty() || tried.gap > best.gap))
      std::swap(best, tried);
  });
  if (!best.points.empty()) m = std::move(best);
  return true;
}

void check_step_lengths(const Model& model, const Workspace& w, const State& s) {
  const std::size_t n = model.particles.size();
  double walls = 0;  // m/s, maximum speed of a point of a boundary
  for (std::size_t b = 0; b < model.boundaries.size(); ++b) {
    if (!s.boundary_present[b] || model.boundaries[b].kind == Boundary::Kind::plane) continue;
    const BodyMotion& m = s.motion[n + b];
    walls = std::max(walls, m.velocity.norm() + m.angular_velocity.norm() * w.reach[w.shapes + b]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (s.presence[i] != Presence::present) continue;
    const double travel = (s.motion[i].velocity.norm() + walls) * model.timestep;
    const double size = w.smallest_part[model.particles[i].shape];
    if (travel > size) {
      throw RunError(fmt::format(
          "particle {} and a boundary move by up to {:.4g} m in one step at {:.6g} s, more than "
          "the radius {:.4g} m of the particle's smallest part: shorten the time step",
          i, travel, s.time, size));
    }
  }
}

}  // namespace firn
