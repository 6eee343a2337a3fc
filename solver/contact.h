// Contacts between two bodies: patches, their points, their memory, and the force law.
//
// What one body feels from another is one or more patches. A patch is a connected touching region
// with one normal and the full stiffness K of the pair, however many convex parts, facets or
// clipped vertices lie under it. Its points share K by the area they stand for; each carries its
// own hysteretic normal force, so that a flat face resists tilting and loses rocking energy.
// Friction is one tangential and one torsional spring per patch. See docs/contact.md.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "solver/types.h"

namespace firn {

// Constants of a pair of shapes (or shape and boundary), made once from the model.
struct PairLaw {
  double stiffness = 0;             // N/m, K_nl of equation (4)
  double unloading_ratio = 1;       // K_nu / K_nl = 1 / epsilon^2, equation (5)
  double floor = 0;                 // lambda of equation (3)
  double tangential_stiffness = 0;  // N/m, K_tau
  double static_friction = 0;
  double dynamic_friction = 0;
  double sliding_speed = 0;  // m/s
  double rolling_limit = 0;  // m: rolling moment limit / normal force
  double shell = 0;          // m
  double refresh = 0;        // m of relative motion between two searches for contacts
  double merge = 0;          // m, points nearer than this are one
  double deep = 0;           // m, overlap at birth that counts as late detection
  double overlap_limit = 0;  // m
};

struct ContactPoint {
  Vec3 offset = Vec3::Zero();  // m, from the patch's reference point, world axes
  double gap = 0;              // m; negative: overlap
  double share = 0;            // of K
  double force = 0;            // N, normal, never attractive
  double weight = 0;           // m^2, area it stands for
};

struct Patch {
  Vec3 normal = Vec3::UnitZ();     // unit, from a to b, world
  Vec3 arm = Vec3::Zero();         // m, reference point (pressure centre) minus centre of a, world
  Vec3 tangential = Vec3::Zero();  // N, friction force on a
  Vec3 rolling = Vec3::Zero();     // N m, rolling moment on a
  double torsion = 0;              // N m, about the normal, on a
  double torsion_radius = 0;       // m
  double normal_force = 0;         // N
  std::uint64_t parts_a = 0;       // bit i: part i (mod 64) of a takes part
  std::uint64_t parts_b = 0;
  std::uint32_t first_point = 0;
  std::uint32_t point_count = 0;
  std::uint32_t sliding = 0;  // 1: dynamic friction applies
  std::uint32_t fresh = 1;    // 1: gaps are those of this instant, not yet to be advanced
};

// Relative motion of the two bodies at a patch over one step.
struct RelativeMotion {
  Vec3 velocity = Vec3::Zero();  // m/s, of a's material point minus b's at the reference point
  Vec3 spin = Vec3::Zero();      // rad/s, of a minus b
};

struct PatchLoad {
  Vec3 force = Vec3::Zero();   // N, on a
  Vec3 moment = Vec3::Zero();  // N m, on a, about the reference point
  double normal_force = 0;     // N
  double overlap = 0;          // m, deepest point
  double work_normal = 0;      // J taken from the bodies in this step: stored or lost
  double work_friction = 0;    // J, the same of friction, torsion and rolling
};

// Hysteretic linear spring, equation (3), for one point: the force after the overlap grew by `ds`
// (m, positive: approaching) to `overlap`. Loading along K, unloading and reloading along K_u,
// never below lambda K s. A point that touches for the first time starts on the loading line.
[[gnu::always_inline]] inline double normal_force(double previous, double stiffness,
                                                  double unloading_stiffness, double floor,
                                                  double overlap, double ds) {
  if (overlap <= 0) return 0;
  const double loading = stiffness * overlap;
  if (previous <= 0) return loading;
  return std::min(loading, std::max(previous + unloading_stiffness * ds, floor * loading));
}

// Elastic-frictional tangential spring at the reference point, equations (8) and (9), with a static
// and a dynamic coefficient. Returns the friction limit in force, N.
[[gnu::always_inline]] inline double advance_friction(const PairLaw& law, Patch& patch,
                                                      const RelativeMotion& motion, double dt,
                                                      PatchLoad& out) {
  const Vec3 slip = motion.velocity - patch.normal * motion.velocity.dot(patch.normal);
  Vec3 trial = patch.tangential - (law.tangential_stiffness * dt) * slip;
  const double square = trial.squaredNorm();
  const double static_cap = law.static_friction * patch.normal_force;
  const double dynamic_cap = law.dynamic_friction * patch.normal_force;
  if (patch.sliding && square <= dynamic_cap * dynamic_cap &&
      slip.squaredNorm() < law.sliding_speed * law.sliding_speed) {
    patch.sliding = 0;
  }
  if (!patch.sliding && square > static_cap * static_cap) patch.sliding = 1;
  const double cap = patch.sliding ? dynamic_cap : static_cap;
  if (square > cap * cap) trial *= cap / std::sqrt(square);
  out.work_friction -= 0.5 * dt * (patch.tangential + trial).dot(slip);
  patch.tangential = trial;
  return cap;
}

// Torsion spring about the normal with the same slip limit at the patch's radius.
[[gnu::always_inline]] inline void advance_torsion(const PairLaw& law, Patch& patch,
                                                   const RelativeMotion& motion, double cap,
                                                   double dt, PatchLoad& out) {
  const double r = patch.torsion_radius;
  const double turn = motion.spin.dot(patch.normal) * dt;
  const double before = patch.torsion;
  patch.torsion = std::clamp(before - law.tangential_stiffness * r * r * turn, -cap * r, cap * r);
  out.work_friction -= 0.5 * (before + patch.torsion) * turn;
}

// Elastic-plastic rolling spring, N m/rad (after Wensrich and Katterfeld, Powder Technology 2012).
inline double rolling_stiffness(const PairLaw& law) {
  return 2.25 * law.stiffness * law.rolling_limit * law.rolling_limit;
}

inline void advance_rolling(const PairLaw& law, Patch& patch, const RelativeMotion& motion,
                            double dt, PatchLoad& out) {
  const Vec3 spin = motion.spin - patch.normal * motion.spin.dot(patch.normal);
  const Vec3 before = patch.rolling;
  patch.rolling -= (rolling_stiffness(law) * dt) * spin;
  const double limit = law.rolling_limit * patch.normal_force;
  const double m = patch.rolling.norm();
  if (m > limit) patch.rolling *= limit / m;
  out.moment += patch.rolling;
  out.work_friction -= 0.5 * dt * (before + patch.rolling).dot(spin);
}

// Advances one patch by `dt` and returns what it does to body a; body b feels the opposite.
[[gnu::always_inline]] inline PatchLoad advance_patch(const PairLaw& law, Patch& patch,
                                                      ContactPoint* points,
                                                      const RelativeMotion& motion, double dt) {
  PatchLoad out;
  const Vec3& n = patch.normal;
  const double approach = motion.velocity.dot(n) * dt;
  // The approach of a point at offset o is (v + w x o) . n dt = approach + o . (n x w) dt.
  const Vec3 tilt = n.cross(motion.spin) * dt;
  double total = 0;
  Vec3 offset_force = Vec3::Zero();
  for (std::uint32_t i = 0; i < patch.point_count; ++i) {
    ContactPoint& p = points[i];
    const double ds = approach + p.offset.dot(tilt);
    if (!patch.fresh) p.gap -= ds;
    const double before = p.force;
    const double k = law.stiffness * p.share;
    p.force = normal_force(before, k, k * law.unloading_ratio, law.floor, -p.gap, ds);
    total += p.force;
    offset_force += p.force * p.offset;
    out.overlap = std::max(out.overlap, -p.gap);
    out.work_normal += 0.5 * (before + p.force) * ds;
  }
  patch.fresh = 0;
  patch.normal_force = total;
  out.normal_force = total;
  if (total <= 0) {
    // The contact has ended and its memory with it; the points stay as near ones.
    patch.tangential.setZero();
    patch.rolling.setZero();
    patch.torsion = 0;
    patch.sliding = 0;
    return out;
  }

  const double cap = advance_friction(law, patch, motion, dt, out);
  if (patch.torsion_radius > 0) advance_torsion(law, patch, motion, cap, dt, out);
  out.force = patch.tangential - total * n;
  // Normal forces act at their points: moment sum o x (-f n).
  out.moment = n.cross(offset_force) + patch.torsion * n;
  if (law.rolling_limit > 0) advance_rolling(law, patch, motion, dt, out);
  return out;
}

// Recoverable energy of the springs of a patch, J.
struct StoredEnergy {
  double normal = 0, friction = 0;
};
inline StoredEnergy stored_energy(const PairLaw& law, const Patch& patch,
                                  const ContactPoint* points) {
  StoredEnergy e;
  for (std::uint32_t i = 0; i < patch.point_count; ++i) {
    const double ku = law.stiffness * points[i].share * law.unloading_ratio;
    if (ku > 0) e.normal += 0.5 * points[i].force * points[i].force / ku;
  }
  const double kt = law.tangential_stiffness;
  if (kt > 0) {
    e.friction += 0.5 * patch.tangential.squaredNorm() / kt;
    const double r = patch.torsion_radius;
    if (r > 0) e.friction += 0.5 * patch.torsion * patch.torsion / (kt * r * r);
  }
  if (law.rolling_limit > 0) {
    e.friction += 0.5 * patch.rolling.squaredNorm() / rolling_stiffness(law);
  }
  return e;
}

}  // namespace firn
