#include "solver/patch_block.h"

namespace firn {

// Both also move what lies behind the last patch, up to a multiple of four; nobody reads it.
void PatchBlock::spread(const Quad* rows, Columns& columns) const {
  for (int k = 0; k < count_; k += 4) {
    Four a, b, c, d;
    get(rows + k, a);
    get(rows + k + 1, b);
    get(rows + k + 2, c);
    get(rows + k + 3, d);
    transpose(a, b, c, d);
    put(a, columns.x + k);
    put(b, columns.y + k);
    put(c, columns.z + k);
    put(d, columns.w + k);
  }
}

void PatchBlock::collect(const Columns& columns, Quad* rows) const {
  for (int k = 0; k < count_; k += 4) {
    Four a, b, c, d;
    get(columns.x + k, a);
    get(columns.y + k, b);
    get(columns.z + k, c);
    get(columns.w + k, d);
    transpose(a, b, c, d);
    put(a, rows + k);
    put(b, rows + k + 1);
    put(c, rows + k + 2);
    put(d, rows + k + 3);
  }
}

void PatchBlock::advance(double dt) {
  spread(normal_rows_, normal_);
  spread(arm_rows_, arm_);
  spread(tangential_rows_, tangential_);
  spread(friction_rows_, friction_);
  spread(velocity_rows_, velocity_);
  spread(spin_rows_, spin_);
  spread(apart_rows_, apart_);
  approach_all(dt);
  press_all();
  rub_all(dt);
  collect(tangential_, tangential_rows_);
  collect(push_, force_);
  collect(moment_, moment_a_);
  collect(counter_, moment_b_);
  store_all(dt);
}

void PatchBlock::approach_all(double dt) {
  for (int k = 0; k < count_; ++k) {
    const Vec spin = spin_.vec(k);
    const Vec velocity = velocity_.vec(k) + cross(spin, arm_.vec(k));
    const Approach way = approach(normal_.vec(k), velocity, spin, dt);
    tilt_.set(k, way.tilt, way.closing);
    slip_.set(k, way.slip, way.turn);
  }
}

void PatchBlock::press_all() {
  for (int k = 0; k < count_; ++k) {
    const Approach way{tilt_.w[k], tilt_.vec(k), {}, 0};
    const NormalLoad load = advance_points(*law_[k], *patch_[k], points_[k], way);
    pressed_.set(k, load.offset_force, load.force);
    overlap_[k] = load.overlap;
    work_normal_[k] = load.work;
  }
}

void PatchBlock::rub_all(double dt) {
  for (int k = 0; k < count_; ++k) {
    const double pressing = pressed_.w[k];
    const Approach way{0, {}, slip_.vec(k), slip_.w[k]};
    const FrictionStep step = advance_friction(
        {friction_.x[k], friction_.y[k], friction_.z[k], friction_.w[k]},
        {tangential_.vec(k), normal_.w[k], sliding_[k]}, pressing, arm_.w[k], way, dt);
    const Wrench on_a = wrench(normal_.vec(k), pressing, pressed_.vec(k), step.state);
    const Vec moment = on_a.moment + cross(arm_.vec(k), on_a.force);
    const Vec counter = moment + cross(apart_.vec(k), on_a.force);  // arm_b = arm_a + apart
    tangential_.set(k, step.state.tangential, pressing);
    torsion_[k] = step.state.torsion;
    sliding_[k] = step.state.sliding;
    work_friction_[k] = step.work;
    push_.set(k, on_a.force, pressing);
    moment_.set(k, moment, 0);
    counter_.set(k, {-counter.x, -counter.y, -counter.z}, 0);
  }
}

void PatchBlock::store_all(double dt) {
  for (int k = 0; k < count_; ++k) {
    Patch& patch = *patch_[k];
    copy_four(&tangential_rows_[k], &patch.tangential);
    patch.torsion = torsion_[k];
    patch.sliding = sliding_[k] > 0;
    patch.fresh = 0;
    if (!law_[k]->is_plain) add_options(k, dt);
  }
}

void PatchBlock::add_options(int k, double dt) {
  const PairLaw& law = *law_[k];
  const Patch& patch = *patch_[k];
  const auto add = [](const Vec& v, Quad& to) { to = {to.x + v.x, to.y + v.y, to.z + v.z, to.w}; };
  if (law.rolling_limit > 0) {
    Vec3& rolling = rolling_[patch_[k] - patches_];
    work_friction_[k] += advance_rolling(law, patch, rolling, eigen(plain(spin_rows_[k])), dt);
    add(plain(rolling), moment_a_[k]);
    add(-1.0 * plain(rolling), moment_b_[k]);
  }
  if (law.adhesion_force > 0 || law.adhesion_fraction > 0) {
    const Approach way{tilt_.w[k], tilt_.vec(k), {}, 0};
    const NormalLoad pull = adhesion_of(law, patch, points_[k], way);
    work_normal_[k] += pull.work;
    const Vec normal = plain(patch.normal), force = pull.force * normal;
    const Vec moment = cross(plain(patch.arm), force) - cross(normal, pull.offset_force);
    add(force, force_[k]);
    add(moment, moment_a_[k]);
    add(-1.0 * (moment + cross(plain(apart_rows_[k]), force)), moment_b_[k]);
  }
}

}  // namespace firn
