#include "solver/contact/contact_law_batch.h"

#include <algorithm>
#include <limits>

namespace firn {

namespace {

// Loads four rows from any addresses and transposes them into columns.
template <class RowOf>
[[gnu::always_inline]] inline void gather_four(int k, const RowOf& row_of, Simd4d& a, Simd4d& b,
                                               Simd4d& c, Simd4d& d) {
  get(row_of(k), a);
  get(row_of(k + 1), b);
  get(row_of(k + 2), c);
  get(row_of(k + 3), d);
  transpose(a, b, c, d);
}

using Two = double __attribute__((vector_size(16)));
using TwoInMemory __attribute__((vector_size(16), aligned(8), may_alias)) = double;

// Two neighboring numbers of each of four places: the first ones, and the second ones.
[[gnu::always_inline]] inline void get_twos(const double* const* from, Simd4d& first,
                                            Simd4d& second) {
  const auto two = [&](int k) { return Two(*reinterpret_cast<const TwoInMemory*>(from[k])); };
  const Simd4d even = __builtin_shufflevector(two(0), two(2), 0, 1, 2, 3);
  const Simd4d odd = __builtin_shufflevector(two(1), two(3), 0, 1, 2, 3);
  first = __builtin_shufflevector(even, odd, 0, 4, 2, 6);
  second = __builtin_shufflevector(even, odd, 1, 5, 3, 7);
}
[[gnu::always_inline]] inline void put_twos(const Simd4d& first, const Simd4d& second,
                                            double* const* to) {
  const Simd4d even = __builtin_shufflevector(first, second, 0, 4, 2, 6);
  const Simd4d odd = __builtin_shufflevector(first, second, 1, 5, 3, 7);
  *reinterpret_cast<TwoInMemory*>(to[0]) = __builtin_shufflevector(even, even, 0, 1);
  *reinterpret_cast<TwoInMemory*>(to[1]) = __builtin_shufflevector(odd, odd, 0, 1);
  *reinterpret_cast<TwoInMemory*>(to[2]) = __builtin_shufflevector(even, even, 2, 3);
  *reinterpret_cast<TwoInMemory*>(to[3]) = __builtin_shufflevector(odd, odd, 2, 3);
}

}  // namespace

void PatchBlock::advance(double dt) {
  pad();
  for (int k = 0; k < count_; k += 4) gather(k);
  compute_relative_motion(dt);
  compute_normal_forces();
  compute_friction(dt);
  for (int k = 0; k < count_; k += 4) scatter(k);
  if (with_rolling_or_adhesion_) add_rolling_and_adhesion(dt);
}

// Fills the columns behind the last patch, up to a multiple of four, with a padding patch.
void PatchBlock::pad() {
  for (int k = count_; k % 4 != 0; ++k) {
    law_[k] = law_[0];
    patch_[k] = &padding_patch_;
    points_[k] = &padding_point_;
    motion_[k] = motion_[0];
    needed2_[k] = limit2_[k] = 0;  // not beyond its friction limit
  }
}

template <class RowOf>
void PatchBlock::Columns::gather(int k, const RowOf& row_of) {
  Simd4d a, b, c, d;
  gather_four(k, row_of, a, b, c, d);
  put(a, x + k);
  put(b, y + k);
  put(c, z + k);
  put(d, w + k);
}

template <class RowOf>
void PatchBlock::Columns::scatter(int k, const RowOf& row_of) const {
  Simd4d a, b, c, d;
  get(x + k, a);
  get(y + k, b);
  get(z + k, c);
  get(w + k, d);
  transpose(a, b, c, d);
  put(a, row_of(k));
  put(b, row_of(k + 1));
  put(c, row_of(k + 2));
  put(d, row_of(k + 3));
}

void PatchBlock::gather(int k) {
  normal_.gather(k, [&](int i) { return &patch_[i]->normal; });
  arm_.gather(k, [&](int i) { return &patch_[i]->arm; });
  tangential_.gather(k, [&](int i) { return &patch_[i]->tangential; });
  spring_.gather(k, [&](int i) { return &law_[i]->stiffness; });
  friction_.gather(k, [&](int i) { return &law_[i]->tangential_stiffness; });
  velocity_.gather(k, [&](int i) { return &motion_[i].velocity; });
  angular_velocity_.gather(k, [&](int i) { return &motion_[i].angular_velocity; });
  center_offset_.gather(k, [&](int i) { return &motion_[i].apart; });
  for (int i = k; i < k + 4; ++i) {
    sliding_[i] = patch_[i]->sliding;
    elongation_cosine_[i] = patch_[i]->elongation.cosine;
    elongation_sine_[i] = patch_[i]->elongation.sine;
    advance_gap_[i] = 1 - patch_[i]->gap_is_current;
  }
}

void PatchBlock::scatter(int k) {
  tangential_.scatter(k, [&](int i) { return &patch_[i]->tangential; });
  force_on_a_.scatter(k, [&](int i) { return force_ + i; });
  moment_.scatter(k, [&](int i) { return moment_a_ + i; });
  moment_on_b_.scatter(k, [&](int i) { return moment_b_ + i; });
  for (int i = k; i < k + 4; ++i) {
    patch_[i]->torsion = torsion_[i];
    patch_[i]->sliding = sliding_[i] > 0;
    patch_[i]->gap_is_current = 0;
  }
}

void PatchBlock::compute_relative_motion(double dt) {
  for (int k = 0; k < count_; ++k) {
    const Vec angular_velocity = angular_velocity_.vec(k);
    const Vec velocity = velocity_.vec(k) + cross(angular_velocity, arm_.vec(k));
    const PatchMotion motion = patch_motion(normal_.vec(k), velocity, angular_velocity, dt);
    tilt_.set(k, motion.tilt, motion.closing);
    slip_.set(k, motion.slip, motion.turn);
  }
}

namespace {

// Four points of any patches, with the coefficients of their patches and laws.
struct FourPoints {
  Simd4d tilt_x, tilt_y, tilt_z, closing;  // of PatchMotion
  NormalSpring<Simd4d> spring;
  Simd4d gap_factor;  // see PatchBlock
};
struct FourLoads {
  Simd4d x, y, z, force;  // N m, force times offset; N
  Simd4d overlap, work;   // m, J
};

// advance_points() for one point each.
[[gnu::always_inline]] inline void compute_four_points(ContactPoint* const* points,
                                                       const FourPoints& in, FourLoads& out) {
  double *gaps[4], *forces[4];
  for (int i = 0; i < 4; ++i) {
    gaps[i] = &points[i]->gap;
    forces[i] = &points[i]->force;
  }
  Simd4d x, y, z, gap, before, share;
  gather_four(
      0, [&](int i) { return &points[i]->offset; }, x, y, z, gap);
  get_twos(forces, before, share);
  const Simd4d ds = in.closing + (x * in.tilt_x + y * in.tilt_y + z * in.tilt_z);
  gap -= in.gap_factor * ds;
  advance_point(in.spring, share, gap, ds, before, out.force, out.work);
  put_twos(gap, out.force, gaps);
  out.x = out.force * x;
  out.y = out.force * y;
  out.z = out.force * z;
  out.overlap = -gap;
}

}  // namespace

void PatchBlock::compute_further_point(int k, ContactPoint& p) {
  const Vec offset = to_vec(p.offset);
  const double ds = tilt_.w[k] + dot(offset, tilt_.vec(k));
  p.gap -= advance_gap_[k] * ds;
  const NormalSpring<double> spring{spring_.x[k], spring_.y[k], spring_.z[k]};
  double force, work;
  advance_point(spring, p.stiffness_fraction, p.gap, ds, p.force, force, work);
  p.force = force;
  const Vec offset_force = force * offset;
  normal_load_.set(k, normal_load_.vec(k) + offset_force, normal_load_.w[k] + force);
  deepest_ = std::max(deepest_, -p.gap);
  work_normal_[k] += work;
}

// advance_points() for all patches. The first points of the patches are computed four at a time.
// Fewer than half of the patches have further points. These are collected in one list, because the
// branch at the end of a loop over one, two or eight points would often be mispredicted.
void PatchBlock::compute_normal_forces() {
  Simd4d deepest = {0, 0, 0, 0};
  for (int k = 0; k < count_; k += 4) compute_first_points(k, deepest);
  deepest_ = std::max(std::max(deepest[0], deepest[1]), std::max(deepest[2], deepest[3]));
  constexpr int kListed = 3;  // of a patch; faces rarely share more than four corners
  struct FurtherPoint {
    ContactPoint* point;
    int patch;
  } further[kListed * capacity];
  int listed = 0, most = 0;
  for (int k = 0; k < count_; ++k) {
    const int others_of_k = patch_[k]->point_count - 1;
    // All three are written without a branch. Those beyond the count have no effect.
    for (int i = 0; i < kListed; ++i) further[listed + i] = {points_[k] + 1 + i, k};
    listed += std::min(others_of_k, kListed);
    most = std::max(most, others_of_k);
  }
  for (int i = 0; i < listed; ++i) compute_further_point(further[i].patch, *further[i].point);
  for (int k = 0; k < count_ && most > kListed; ++k) {
    for (int i = 1 + kListed; i < patch_[k]->point_count; ++i)
      compute_further_point(k, points_[k][i]);
  }
}

void PatchBlock::compute_first_points(int k, Simd4d& deepest) {
  FourPoints in;
  FourLoads load;
  get(tilt_.x + k, in.tilt_x);
  get(tilt_.y + k, in.tilt_y);
  get(tilt_.z + k, in.tilt_z);
  get(tilt_.w + k, in.closing);
  get(spring_.x + k, in.spring.stiffness);
  get(spring_.y + k, in.spring.unloading_ratio);
  get(spring_.z + k, in.spring.minimum_ratio);
  get(advance_gap_ + k, in.gap_factor);
  compute_four_points(points_ + k, in, load);
  deepest = deepest < load.overlap ? load.overlap : deepest;
  put(load.x, normal_load_.x + k);
  put(load.y, normal_load_.y + k);
  put(load.z, normal_load_.z + k);
  put(load.force, normal_load_.w + k);
  put(load.work, work_normal_ + k);
}

FrictionRegion PatchBlock::region(int k) const {
  return {normal_.vec(k), arm_.w[k], elongation_cosine_[k], elongation_sine_[k]};
}

// advance_friction() for all patches. Patches within their limit need no factors: those of four are
// computed only if one of the four is beyond.
void PatchBlock::compute_friction(double dt) {
  for (int k = 0; k < count_; ++k) {
    const PatchMotion motion{0, {}, slip_.vec(k), slip_.w[k]};
    const FrictionTrial trial = friction_trial(
        {friction_.x[k], friction_.y[k], friction_.z[k], friction_.w[k]},
        {tangential_.vec(k), normal_.w[k], sliding_[k]}, normal_load_.w[k], region(k), motion, dt);
    trial_.set(k, trial.tangential, trial.torsion);
    needed2_[k] = trial.needed2;
    limit2_[k] = trial.limit2;
    trial_sliding_[k] = trial.sliding;
  }
  for (int k = 0; k < count_; k += 4) {
    Simd4d needed2, limit2;
    get(needed2_ + k, needed2);
    get(limit2_ + k, limit2);
    if (movemask(needed2 > limit2) != 0) {
      compute_friction_scale(k);
    } else {
      put(Simd4d{1, 1, 1, 1}, scale_.x + k);
      put(Simd4d{}, scale_.y + k);
      put(Simd4d{1, 1, 1, 1}, scale_.z + k);
    }
  }
  for (int k = 0; k < count_; ++k) finish_friction(k, dt);
}

void PatchBlock::compute_friction_scale(int first) {
  for (int k = first; k < first + 4; ++k) {
    const FrictionTrial trial{trial_.vec(k), trial_.w[k], 0, needed2_[k], limit2_[k]};
    const FrictionScale scale =
        friction_scale(region(k), {tangential_.vec(k), normal_.w[k], 0}, trial);
    const bool beyond = trial.beyond();
    scale_.x[k] = beyond ? scale.along : 1.0;
    scale_.y[k] = beyond ? scale.across : 0.0;
    scale_.z[k] = beyond ? scale.torsion : 1.0;
  }
}

void PatchBlock::finish_friction(int k, double dt) {
  const double pressing = normal_load_.w[k];
  const PatchMotion motion{0, {}, slip_.vec(k), slip_.w[k]};
  const FrictionTrial trial{trial_.vec(k), trial_.w[k], trial_sliding_[k], 0, 0};
  const FrictionStep step =
      friction_step({tangential_.vec(k), normal_.w[k], 0}, trial,
                    {scale_.x[k], scale_.y[k], scale_.z[k]}, pressing, region(k), motion, dt);
  const Wrench on_a = wrench(normal_.vec(k), pressing, normal_load_.vec(k), step.state);
  const Vec moment = on_a.moment + cross(arm_.vec(k), on_a.force);
  const Vec counter = moment + cross(center_offset_.vec(k), on_a.force);  // arm_b = arm_a + apart
  tangential_.set(k, step.state.tangential, pressing);
  torsion_[k] = step.state.torsion;
  sliding_[k] = step.state.sliding;
  work_friction_[k] = step.work;
  force_on_a_.set(k, on_a.force, pressing);
  moment_.set(k, moment, 0);
  moment_on_b_.set(k, {-counter.x, -counter.y, -counter.z}, 0);
}

// Rolling resistance and adhesion.
void PatchBlock::add_rolling_and_adhesion(double dt) {
  for (int k = 0; k < count_; ++k) {
    if (!law_[k]->has_only_base_law) add_rolling_and_adhesion(k, dt);
  }
}

void PatchBlock::add_rolling_and_adhesion(int k, double dt) {
  const PairCoefficients& law = *law_[k];
  const ContactPatch& patch = *patch_[k];
  const auto add = [](const Vec& v, Vec4& to) { to = {to.x + v.x, to.y + v.y, to.z + v.z, to.w}; };
  if (law.rolling_limit > 0) {
    Vec3& rolling = details_[patch_[k] - patches_].rolling;
    work_friction_[k] +=
        advance_rolling(law, patch, rolling, to_eigen(to_vec(motion_[k].angular_velocity)), dt);
    add(to_vec(rolling), moment_a_[k]);
    add(-1.0 * to_vec(rolling), moment_b_[k]);
  }
  if (law.adhesion_force > 0 || law.adhesion_fraction > 0) {
    const PatchMotion motion{tilt_.w[k], tilt_.vec(k), {}, 0};
    const NormalLoad pull = adhesion_of(law, patch, points_[k], motion);
    work_normal_[k] += pull.work;
    const Vec normal = to_vec(patch.normal), force = pull.force * normal;
    const Vec moment = cross(to_vec(patch.arm), force) - cross(normal, pull.offset_force);
    add(force, force_[k]);
    add(moment, moment_a_[k]);
    add(-1.0 * (moment + cross(to_vec(motion_[k].apart), force)), moment_b_[k]);
  }
}

}  // namespace firn
