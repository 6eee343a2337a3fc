// Contacts between two bodies: patches, contact points, contact history and the force law.
//
// The contact of two bodies consists of one or more patches. A patch is a connected touching region
// with one normal and the full stiffness K of the pair, however many convex parts, facets or
// clipped vertices lie under it. Its points share K in proportion to their areas. Each point has
// its own hysteretic normal force, so that a flat face resists tilting and dissipates rocking
// energy. Friction is one tangential and one torsional spring per patch, with a common limit. See
// docs/contact.md.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "solver/core/simd.h"

namespace firn {

// Coefficients of the force law for a pair of shapes (or shape and boundary), computed once from
// the model.
struct PairCoefficients {
  double stiffness = 0;                  // N/m, K_nl of equation (4)
  double unloading_stiffness_ratio = 1;  // K_nu / K_nl = 1 / epsilon^2, equation (5)
  double minimum_unloading_ratio = 0;    // lambda of equation (3)
  double tangential_stiffness = 0;       // N/m, K_tau
  double static_friction = 0;
  double dynamic_friction = 0;
  double restick_velocity = 0;         // m/s
  double rolling_limit = 0;            // m: rolling moment limit / normal force
  double contact_margin = 0;           // m
  double contact_update_distance = 0;  // m of relative motion between two searches for contacts
  double merge_distance = 0;           // m, points of one search closer than this are merged
  double match_distance = 0;      // m, a point closer than this to an old one inherits its history
  double late_overlap = 0;        // m, larger overlap of a new patch: late contact
  double overlap_limit = 0;       // m
  double adhesion_force = 0;      // N, of a patch that touches as a whole
  double adhesion_fraction = 0;   // of K
  bool has_only_base_law = true;  // neither rolling resistance nor adhesion
};

struct ContactPoint {
  Vec3 offset = Vec3::Zero();     // m, from the patch's reference point, world axes
  double gap = 0;                 // m; negative: overlap
  double force = 0;               // N, normal, never attractive
  double stiffness_fraction = 0;  // of the stiffness K of the pair
};

// How elongated the touching region of a patch is: e = (I1 - I2) / (I1 + I2) of its principal
// second moments, 0 for a square and 1 for a line. Its long axis is at the angle `a` from u towards
// v of tangent_basis(normal).
struct Elongation {
  float cosine = 0, sine = 0;  // e cos 2a, e sin 2a
};

// Two cache lines: a bed at rest spends most of its time reading patches.
struct alignas(64) ContactPatch {
  // Groups of four numbers, each read by one wide load (see PatchBlock).
  Vec3 normal = Vec3::UnitZ();     // unit, from a to b, world
  double torsion = 0;              // N m, about the normal, on a
  Vec3 arm = Vec3::Zero();         // m, reference point (pressure center) minus center of a, world
  double torsion_radius = 0;       // m
  Vec3 tangential = Vec3::Zero();  // N, friction force on a
  double normal_force = 0;         // N

  Elongation elongation;      // of the touching region
  std::uint64_t parts_a = 0;  // bit i: part i (mod 64) of a takes part
  std::uint64_t parts_b = 0;
  std::uint32_t first_point = 0;
  std::uint16_t point_count = 0;
  std::uint8_t sliding = 0;         // 1: dynamic friction applies
  std::uint8_t gap_is_current = 1;  // 1: the force law must not advance the gaps
};
static_assert(sizeof(ContactPatch) == 128 && sizeof(ContactPoint) == 48);

// Data of a patch that most steps do not read.
struct PatchDetail {
  Vec3 rolling = Vec3::Zero();  // N m, rolling moment on a, world
  double area = 0;              // m^2, of the touching region
};

// N, minimum force of a point that has been loaded and still overlaps. It marks the state "in
// contact" and has no effect on a body. A force of exactly zero marks a point that touches for the
// first time.
inline constexpr double kInContact = 1e-150;

// Hysteretic linear spring, equation (3), for one point (T = double) or four (T = Simd4d): the
// force after the overlap grew by `ds` (m, positive: approaching) to `overlap`. Loading along K,
// unloading and reloading along K_u, never below lambda K s. A point that touches for the first
// time starts on the loading line.
template <class T>
[[gnu::always_inline]] inline void compute_normal_force(const T& previous, const T& stiffness,
                                                        const T& unloading_stiffness,
                                                        const T& floor, const T& overlap,
                                                        const T& ds, T& force) {
  // Branch-free: whether a point touches is unpredictable.
  const T zero{}, touching = zero + kInContact;
  const T infinite = zero + std::numeric_limits<double>::infinity();
  const T pressed = stiffness * overlap, loading = zero < pressed ? pressed : zero;
  const T from = previous > zero ? previous : infinite;
  const T low = floor * loading, least = low < touching ? touching : low;
  const T unloading = from + unloading_stiffness * ds;
  const T higher = unloading < least ? least : unloading;
  force = higher < loading ? higher : loading;
}

// Normal spring of a pair of shapes, of PairCoefficients, for one point or four.
template <class T>
struct NormalSpring {
  T stiffness, unloading_ratio, minimum_ratio;
};

// Advances the force of one point (T = double) or of four (T = Simd4d) with this share of the
// stiffness. `gap`: m, after the approach by `ds`. `work`: J, taken from the bodies in this step.
template <class T>
[[gnu::always_inline]] inline void advance_point(const NormalSpring<T>& spring, const T& share,
                                                 const T& gap, const T& ds, const T& previous,
                                                 T& force, T& work) {
  const T own = spring.stiffness * share, overlap = -gap;
  compute_normal_force(previous, own, T(own * spring.unloading_ratio), spring.minimum_ratio,
                       overlap, ds, force);
  work = 0.5 * (previous + force) * ds;
}

// Relative motion of the two bodies at a patch, over one step.
struct PatchMotion {
  double closing;  // m, of the reference point, along the normal
  Vec tilt;        // the point at offset o closes by `closing` + o . tilt
  Vec slip;        // m/s, across the normal
  double turn;     // rad, about the normal
};

// m, approach of a point in the step along the normal.
[[gnu::always_inline]] inline double closing_of(const PatchMotion& motion,
                                                const ContactPoint& point) {
  return motion.closing + dot(to_vec(point.offset), motion.tilt);
}

// velocity: m/s, of a's material point minus b's at the reference point.
// angular_velocity: rad/s, a minus b.
[[gnu::always_inline]] inline PatchMotion patch_motion(const Vec& normal, const Vec& velocity,
                                                       const Vec& angular_velocity, double dt) {
  const double closing = dot(velocity, normal);
  // (v + w x o) . n dt = v . n dt + o . (n x w) dt
  return {closing * dt, dt * cross(normal, angular_velocity), velocity - closing * normal,
          dot(angular_velocity, normal) * dt};
}

// Sums over the contact points of a patch.
struct NormalLoad {
  double force = 0;    // N
  Vec offset_force{};  // N m, sum of force times offset
  double overlap = 0;  // m, deepest point
  double work = 0;     // J taken from the bodies in this step: stored or lost
};

// Advances all points of a patch. PatchBlock does the same for many patches in vectors.
inline NormalLoad advance_points(const PairCoefficients& law, const ContactPatch& patch,
                                 ContactPoint* points, const PatchMotion& motion) {
  const NormalSpring<double> spring{law.stiffness, law.unloading_stiffness_ratio,
                                    law.minimum_unloading_ratio};
  NormalLoad out;
  for (std::uint32_t i = 0; i < patch.point_count; ++i) {
    ContactPoint& p = points[i];
    const Vec offset = to_vec(p.offset);
    const double ds = closing_of(motion, p);
    if (!patch.gap_is_current) p.gap -= ds;
    double force, work;
    advance_point(spring, p.stiffness_fraction, p.gap, ds, p.force, force, work);
    p.force = force;
    out.force += force;
    out.offset_force = out.offset_force + force * offset;
    out.overlap = std::max(out.overlap, -p.gap);
    out.work += work;
  }
  return out;
}

// Constants of friction, and its state: the tangential force, the torsion, and whether it slides
// (1) or sticks (0).
struct FrictionLaw {
  double stiffness, static_friction, dynamic_friction, restick_velocity;
};
struct FrictionState {
  Vec tangential;  // N, on a
  double torsion;  // N m, on a, about the normal
  double sliding;
};
struct FrictionStep {
  FrictionState state;
  double work;  // J taken from the bodies
};

// Touching region of a patch, for the friction limit.
struct FrictionRegion {
  Vec normal;           // unit, from a to b
  double radius;        // m, mean distance of its area from its centroid
  double cosine, sine;  // of Elongation
};

inline FrictionRegion friction_region(const ContactPatch& patch) {
  return {to_vec(patch.normal), patch.torsion_radius, patch.elongation.cosine,
          patch.elongation.sine};
}

// Mean distance of a uniform rectangle's area from its centroid, over its radius of gyration:
// within 0.1 % for all aspect ratios. `h` is the square of the elongation e.
inline double mean_distance(double h) {
  return 0.93743 + h * (-0.05493 + h * (0.02635 - h * 0.04111));
}

// Quantities of a friction force F with a torsion M on which the limit depends: squares of forces,
// and of torsions over the radius.
struct FrictionLoad {
  double force2, torsion2;  // |F|^2, (M / r)^2
  double along, across;  // |F|^2 e cos 2p, |F|^2 e sin 2p: F is at the angle p from the long axis

  // Part of the torsion, 0 to 1.
  double t() const {
    const double sum = force2 + torsion2;
    return torsion2 / (sum > 0 ? sum : 1.0);
  }
  // e cos 2p and e sin 2p
  double q() const { return along / (force2 > 0 ? force2 : 1.0); }
  double q_across() const { return across / (force2 > 0 ? force2 : 1.0); }
};
[[gnu::always_inline]] inline FrictionLoad friction_load(const FrictionRegion& region, double u,
                                                         double v, double torsion) {
  const double difference = u * u - v * v, product = 2 * u * v;
  return {u * u + v * v, torsion * torsion, region.cosine * difference + region.sine * product,
          region.cosine * product - region.sine * difference};
}

// Friction limit of a uniform face under a force f and a torsion m, each relative to its limit
// alone:
//   f^2 + m^2 = g(t, q),  g = 1 - (p0 + p1 t + p2 t^2 + q (d0 + d1 t + d2 t^2)) t (1 - t)
//   t = m^2 / (f^2 + m^2),  q = e cos 2p
// with the elongation e and the angle p of the force from the long axis. The coefficients p depend
// on h = e^2. All are fitted to Coulomb's law, integrated over rectangles that turn while they
// slide in each direction. The fit deviates by at most 4 % in f and m up to an aspect ratio of 10.
struct FrictionLimit {
  static constexpr double d0 = -1.2298, d1 = 2.0085, d2 = -1.4664;
  double p0, p1, p2;

  [[gnu::always_inline]] explicit FrictionLimit(double h)
      : p0(0.7265 + h * 0.0576), p1(-0.7068 - h * 0.8443), p2(0.5128 + h * 0.6508) {}
  // g
  [[gnu::always_inline]] double size(double t, double q) const {
    return 1 - polynomial(t, q) * (t * (1 - t));
  }
  // Derivative of g with respect to t.
  [[gnu::always_inline]] double slope(double t, double q) const {
    return -(p1 + q * d1 + 2 * t * (p2 + q * d2)) * (t * (1 - t)) - polynomial(t, q) * (1 - 2 * t);
  }
  // Derivative of g with respect to q, divided by 1 - t.
  [[gnu::always_inline]] static double turn(double t) { return -(d0 + t * (d1 + t * d2)) * t; }

 private:
  [[gnu::always_inline]] double polynomial(double t, double q) const {
    return p0 + q * d0 + t * (p1 + q * d1 + t * (p2 + q * d2));
  }
};

[[gnu::always_inline]] inline FrictionLimit friction_limit(const FrictionRegion& region) {
  return FrictionLimit(region.cosine * region.cosine + region.sine * region.sine);
}

// Factors that return a trial force and torsion to the limit: the new force is `along` times the
// trial force plus `across` times the trial force turned by 90 degrees about the normal.
struct FrictionScale {
  double along, across, torsion;
};
// Returns a trial to the limit surface along the normal of that surface, the direction of slip at
// the limit. The normal is evaluated at the previous state: after some steps of sliding, the state
// lies exactly on the limit. `excess`: the trial over the limit in its direction, above 1.
[[gnu::always_inline]] inline FrictionScale friction_scale(const FrictionLimit& limit,
                                                           const FrictionLoad& trial,
                                                           const FrictionLoad& before,
                                                           double limit2, double excess) {
  // A small part of the trial is added: from rest, the trial gives the direction instead of a
  // rounding error.
  const double over = excess > 1 ? excess : 1.0, share = 0.01 / (over * over), surplus = over - 1;
  const FrictionLoad at = {
      before.force2 + share * trial.force2, before.torsion2 + share * trial.torsion2,
      before.along + share * trial.along, before.across + share * trial.across};
  const double t = at.t(), q = at.q(), size = limit.size(t, q);
  const double relative = limit.slope(t, q) / size;
  // The normal's force is (1 + t relative) F + turn n x F; its torsion follows.
  const double stretch = 1 + surplus * (1 + t * relative);
  const double turn = surplus * (FrictionLimit::turn(t) * at.q_across() / size);
  const double both = 1 / (stretch * stretch + turn * turn);
  const double along = stretch * both, across = -turn * both;
  const double torsion = 1 / (1 + surplus * (1 - (1 - t) * relative));
  // F is turned by an angle whose cosine and sine are `along` and `across` over their root.
  const double cosine = along * along - across * across, sine = 2 * along * across;
  const FrictionLoad back = {trial.force2 * (along * along + across * across),
                             trial.torsion2 * torsion * torsion,
                             trial.along * cosine - trial.across * sine, 0};
  const double sum = back.force2 + back.torsion2;
  const double scale = std::sqrt(limit2 * limit.size(back.t(), back.q()) / (sum > 0 ? sum : 1.0));
  return {scale * along, scale * across, scale * torsion};
}

// FrictionLoad of a force (N) with a torsion (N m).
[[gnu::always_inline]] inline FrictionLoad friction_load(const FrictionRegion& region,
                                                         const Vec& tangential, double torsion) {
  const TangentBasis basis = tangent_basis(region.normal);
  const double lever = region.radius > 0 ? 1 / region.radius : 0.0;
  return friction_load(region, dot(tangential, basis.u), dot(tangential, basis.v), torsion * lever);
}

// Trial of a friction step: force and torsion as if the patch stuck, and the limit for them.
struct FrictionTrial {
  Vec tangential;  // N, on a
  double torsion;  // N m, on a, about the normal
  double sliding;  // 1: dynamic friction applies
  double needed2;  // N^2, square of the limit that would hold force and torsion
  double limit2;   // N^2, square of the limit that applies

  bool beyond() const { return needed2 > limit2; }
};

// Elastic-frictional tangential spring at the reference point, equations (8) and (9), with a static
// and a dynamic coefficient, and a torsional spring about the normal at the radius of the patch.
// Both share one limit. Branch-free, as above.
[[gnu::always_inline]] inline FrictionTrial friction_trial(const FrictionLaw& law,
                                                           const FrictionState& before,
                                                           double normal_force,
                                                           const FrictionRegion& region,
                                                           const PatchMotion& motion, double dt) {
  const Vec trial = before.tangential - (law.stiffness * dt) * motion.slip;
  const double free = before.torsion - law.stiffness * region.radius * region.radius * motion.turn;
  const FrictionLoad load = friction_load(region, trial, free);
  const double needed2 =
      (load.force2 + load.torsion2) / friction_limit(region).size(load.t(), load.q());
  const double static_cap = law.static_friction * normal_force;
  const double dynamic_cap = law.dynamic_friction * normal_force;
  const bool slow = square(motion.slip) < law.restick_velocity * law.restick_velocity;
  const bool held = needed2 <= dynamic_cap * dynamic_cap;
  double sliding = held ? (slow ? 0.0 : before.sliding) : before.sliding;
  sliding = needed2 > static_cap * static_cap ? 1.0 : sliding;
  const double cap = sliding > 0 ? dynamic_cap : static_cap;
  // Component by component: a copy of the whole vector keeps the compiler from vectorizing.
  return {{trial.x, trial.y, trial.z}, free, sliding, needed2, cap * cap};
}

// Factors that return a trial from `before` to its limit, if it is beyond.
[[gnu::always_inline]] inline FrictionScale friction_scale(const FrictionRegion& region,
                                                           const FrictionState& before,
                                                           const FrictionTrial& trial) {
  const double limit2 = trial.limit2;
  return friction_scale(friction_limit(region),
                        friction_load(region, trial.tangential, trial.torsion),
                        friction_load(region, before.tangential, before.torsion), limit2,
                        std::sqrt(trial.needed2 / (limit2 > 0 ? limit2 : 1.0)));
}

// The state after the step: the trial with factors of friction_scale(), or with {1, 0, 1} for a
// trial within its limit. Without a normal force, both springs are reset.
[[gnu::always_inline]] inline FrictionStep friction_step(
    const FrictionState& before, const FrictionTrial& trial, const FrictionScale& scale,
    double normal_force, const FrictionRegion& region, const PatchMotion& motion, double dt) {
  const bool bears = normal_force > 0;
  FrictionStep out;
  out.state.tangential =
      scale.along * trial.tangential + scale.across * cross(region.normal, trial.tangential);
  out.state.torsion = region.radius > 0 ? scale.torsion * trial.torsion : 0.0;
  out.state.sliding = bears ? trial.sliding : 0.0;
  const double work = -0.5 * dt * dot(before.tangential + out.state.tangential, motion.slip) -
                      0.5 * (before.torsion + out.state.torsion) * motion.turn;
  out.work = bears ? work : 0.0;
  return out;
}

// One step of friction of one patch. PatchBlock does the same for many patches in vectors.
inline FrictionStep advance_friction(const FrictionLaw& law, const FrictionState& before,
                                     double normal_force, const FrictionRegion& region,
                                     const PatchMotion& motion, double dt) {
  const FrictionTrial trial = friction_trial(law, before, normal_force, region, motion, dt);
  const FrictionScale scale =
      trial.beyond() ? friction_scale(region, before, trial) : FrictionScale{1, 0, 1};
  return friction_step(before, trial, scale, normal_force, region, motion, dt);
}

// Force on a, and moment on a about the reference point. The load on b is opposite.
struct Wrench {
  Vec force, moment;  // N, N m
};
[[gnu::always_inline]] inline Wrench wrench(const Vec& normal, double normal_force,
                                            const Vec& offset_force,
                                            const FrictionState& friction) {
  // Normal forces act at their points: moment sum o x (-f n).
  return {friction.tangential - normal_force * normal,
          cross(normal, offset_force) + friction.torsion * normal};
}

// Elastic-plastic rolling spring, N m/rad (after Wensrich and Katterfeld, Powder Technology 2012).
inline double rolling_stiffness(const PairCoefficients& law) {
  return 2.25 * law.stiffness * law.rolling_limit * law.rolling_limit;
}

// Advances the rolling moment (on a). Returns the work that it takes from the bodies, J.
inline double advance_rolling(const PairCoefficients& law, const ContactPatch& patch, Vec3& rolling,
                              const Vec3& angular_velocity, double dt) {
  const Vec3 across = angular_velocity - patch.normal * angular_velocity.dot(patch.normal);
  const Vec3 before = rolling;
  rolling -= (rolling_stiffness(law) * dt) * across;
  const double limit = law.rolling_limit * patch.normal_force;
  const double m = rolling.norm();
  if (m > limit) rolling *= limit / m;
  return patch.normal_force > 0 ? -0.5 * dt * (before + rolling).dot(across) : 0;
}

// Adhesion acts at the points that overlap. The constant force is distributed by area over all
// points of the patch. The other force is proportional to the overlap, with the stiffness of the
// point. The sum therefore does not depend on the number of points. Both are functions of the
// overlap alone and have a negative potential.
inline double sum_of_fractions(const ContactPatch& patch, const ContactPoint* points) {
  double sum = 0;
  for (std::uint32_t i = 0; i < patch.point_count; ++i) sum += points[i].stiffness_fraction;
  return sum;
}
struct Adhesion {
  double force, potential;  // N, J
};
// Of one point at this gap; `sum` is that of the shares.
inline Adhesion adhesion_of(const PairCoefficients& law, const ContactPoint& point, double gap,
                            double sum) {
  const double overlap = std::max(0.0, -gap);
  const double constant =
      overlap > 0 && sum > 0 ? law.adhesion_force * point.stiffness_fraction / sum : 0;
  const double stiffness = law.adhesion_fraction * law.stiffness * point.stiffness_fraction;
  return {constant + stiffness * overlap, -(constant + 0.5 * stiffness * overlap) * overlap};
}
// Of the whole patch after its points have been advanced: force, sum of force times offset, and the
// work that it takes from the bodies, below zero as they come together. `overlap` is not computed.
inline NormalLoad adhesion_of(const PairCoefficients& law, const ContactPatch& patch,
                              const ContactPoint* points, const PatchMotion& motion) {
  NormalLoad out;
  const double sum = sum_of_fractions(patch, points);
  for (std::uint32_t i = 0; i < patch.point_count; ++i) {
    const ContactPoint& p = points[i];
    const Vec offset = to_vec(p.offset);
    const double ds = closing_of(motion, p);
    const double force = adhesion_of(law, p, p.gap, sum).force;
    out.force += force;
    out.offset_force = out.offset_force + force * offset;
    out.work -= 0.5 * (adhesion_of(law, p, p.gap + ds, sum).force + force) * ds;
  }
  return out;
}

// J, recoverable from the normal springs of a patch.
inline double spring_energy(const PairCoefficients& law, const ContactPatch& patch,
                            const ContactPoint* points) {
  double energy = 0;
  for (std::uint32_t i = 0; i < patch.point_count; ++i) {
    const double ku = law.stiffness * points[i].stiffness_fraction * law.unloading_stiffness_ratio;
    if (ku > 0) energy += 0.5 * points[i].force * points[i].force / ku;
  }
  return energy;
}

// Recoverable energy of the springs of a patch, J.
struct StoredEnergy {
  double normal = 0, friction = 0;
};
inline StoredEnergy stored_energy(const PairCoefficients& law, const ContactPatch& patch,
                                  const Vec3& rolling, const ContactPoint* points) {
  StoredEnergy e;
  e.normal = spring_energy(law, patch, points);
  const double kt = law.tangential_stiffness;
  if (kt > 0) {
    e.friction += 0.5 * patch.tangential.squaredNorm() / kt;
    const double r = patch.torsion_radius;
    if (r > 0) e.friction += 0.5 * patch.torsion * patch.torsion / (kt * r * r);
  }
  if (law.adhesion_force > 0 || law.adhesion_fraction > 0) {
    const double sum = sum_of_fractions(patch, points);
    for (std::uint32_t i = 0; i < patch.point_count; ++i)
      e.normal += adhesion_of(law, points[i], points[i].gap, sum).potential;
  }
  if (law.rolling_limit > 0) {
    e.friction += 0.5 * rolling.squaredNorm() / rolling_stiffness(law);
  }
  return e;
}

}  // namespace firn
