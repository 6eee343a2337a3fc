#include "solver/patch_block.h"

namespace firn {

void PatchBlock::add(std::int32_t a, std::int32_t b, std::int32_t law_index, const PairLaw& law,
                     Patch& patch, ContactPoint* points, const PairMotion& motion) {
  const int k = count_++;
  a_[k] = a;
  b_[k] = b;
  law_index_[k] = law_index;
  law_[k] = &law;
  patch_[k] = &patch;
  points_[k] = points;
  normal_x[k] = patch.normal.x();
  normal_y[k] = patch.normal.y();
  normal_z[k] = patch.normal.z();
  arm_x[k] = patch.arm.x();
  arm_y[k] = patch.arm.y();
  arm_z[k] = patch.arm.z();
  apart_x[k] = motion.apart.x;
  apart_y[k] = motion.apart.y;
  apart_z[k] = motion.apart.z;
  velocity_x[k] = motion.velocity.x;
  velocity_y[k] = motion.velocity.y;
  velocity_z[k] = motion.velocity.z;
  spin_x[k] = motion.spin.x;
  spin_y[k] = motion.spin.y;
  spin_z[k] = motion.spin.z;
  tangential_x[k] = patch.tangential.x();
  tangential_y[k] = patch.tangential.y();
  tangential_z[k] = patch.tangential.z();
  torsion_[k] = patch.torsion;
  torsion_radius[k] = patch.torsion_radius;
  sliding_[k] = patch.sliding ? 1 : 0;
  stiffness_[k] = law.tangential_stiffness;
  static_[k] = law.static_friction;
  dynamic_[k] = law.dynamic_friction;
  speed_[k] = law.sliding_speed;
}

void PatchBlock::advance(double dt) {
  approach_all(dt);
  press_all();
  rub_all(dt);
  store_all(dt);
}

void PatchBlock::approach_all(double dt) {
  for (int k = 0; k < count_; ++k) {
    const Vec spin{spin_x[k], spin_y[k], spin_z[k]};
    const Vec velocity = Vec{velocity_x[k], velocity_y[k], velocity_z[k]} +
                         cross(spin, Vec{arm_x[k], arm_y[k], arm_z[k]});
    const Approach a = approach({normal_x[k], normal_y[k], normal_z[k]}, velocity, spin, dt);
    closing[k] = a.closing;
    tilt_x[k] = a.tilt.x;
    tilt_y[k] = a.tilt.y;
    tilt_z[k] = a.tilt.z;
    slip_x[k] = a.slip.x;
    slip_y[k] = a.slip.y;
    slip_z[k] = a.slip.z;
    turn[k] = a.turn;
  }
}

void PatchBlock::press_all() {
  for (int k = 0; k < count_; ++k) {
    const Approach way{closing[k], {tilt_x[k], tilt_y[k], tilt_z[k]}, {}, 0};
    const NormalLoad load = advance_points(*law_[k], *patch_[k], points_[k], way);
    normal_force_[k] = load.force;
    offset_x[k] = load.offset_force.x;
    offset_y[k] = load.offset_force.y;
    offset_z[k] = load.offset_force.z;
    overlap_[k] = load.overlap;
    work_normal_[k] = load.work;
  }
}

void PatchBlock::rub_all(double dt) {
  for (int k = 0; k < count_; ++k) {
    const Vec normal{normal_x[k], normal_y[k], normal_z[k]};
    const Approach way{closing[k], {}, {slip_x[k], slip_y[k], slip_z[k]}, turn[k]};
    const FrictionStep step = advance_friction(
        {stiffness_[k], static_[k], dynamic_[k], speed_[k]},
        {{tangential_x[k], tangential_y[k], tangential_z[k]}, torsion_[k], sliding_[k]},
        normal_force_[k], torsion_radius[k], way, dt);
    const Wrench on_a =
        wrench(normal, normal_force_[k], {offset_x[k], offset_y[k], offset_z[k]}, step.state);
    const Vec moment = on_a.moment + cross(Vec{arm_x[k], arm_y[k], arm_z[k]}, on_a.force);
    tangential_x[k] = step.state.tangential.x;
    tangential_y[k] = step.state.tangential.y;
    tangential_z[k] = step.state.tangential.z;
    torsion_[k] = step.state.torsion;
    sliding_[k] = step.state.sliding;
    work_friction_[k] = step.work;
    force_x[k] = on_a.force.x;
    force_y[k] = on_a.force.y;
    force_z[k] = on_a.force.z;
    moment_x[k] = moment.x;
    moment_y[k] = moment.y;
    moment_z[k] = moment.z;
    // arm_b = arm_a + apart
    const Vec on_b = moment + cross(Vec{apart_x[k], apart_y[k], apart_z[k]}, on_a.force);
    counter_x[k] = -on_b.x;
    counter_y[k] = -on_b.y;
    counter_z[k] = -on_b.z;
  }
}

void PatchBlock::store_all(double dt) {
  for (int k = 0; k < count_; ++k) {
    Patch& patch = *patch_[k];
    patch.tangential = {tangential_x[k], tangential_y[k], tangential_z[k]};
    patch.torsion = torsion_[k];
    patch.normal_force = normal_force_[k];
    patch.sliding = sliding_[k] > 0;
    patch.fresh = 0;
    if (law_[k]->rolling_limit > 0) {
      work_friction_[k] += advance_rolling(*law_[k], patch, {spin_x[k], spin_y[k], spin_z[k]}, dt);
      moment_x[k] += patch.rolling.x();
      moment_y[k] += patch.rolling.y();
      moment_z[k] += patch.rolling.z();
      counter_x[k] -= patch.rolling.x();
      counter_y[k] -= patch.rolling.y();
      counter_z[k] -= patch.rolling.z();
    }
  }
}

}  // namespace firn
