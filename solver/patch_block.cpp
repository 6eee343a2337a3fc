#include "solver/patch_block.h"

namespace firn {

void PatchBlock::advance(double dt) {
  approach_all(dt);
  press_all();
  rub_all(dt);
  store_all(dt);
}

void PatchBlock::approach_all(double dt) {
  for (int k = 0; k < count_; ++k) {
    const Vec spin = plain(spin_[k]);
    const Vec velocity = plain(velocity_[k]) + cross(spin, plain(arm_[k]));
    const Approach way = approach(plain(normal_[k]), velocity, spin, dt);
    tilt_[k] = {way.tilt.x, way.tilt.y, way.tilt.z, way.closing};
    slip_[k] = {way.slip.x, way.slip.y, way.slip.z, way.turn};
  }
}

void PatchBlock::press_all() {
  for (int k = 0; k < count_; ++k) {
    const Approach way{tilt_[k].w, plain(tilt_[k]), {}, 0};
    const NormalLoad load = advance_points(*law_[k], *patch_[k], points_[k], way);
    pressed_[k] = {load.offset_force.x, load.offset_force.y, load.offset_force.z, load.force};
    overlap_[k] = load.overlap;
    work_normal_[k] = load.work;
  }
}

void PatchBlock::rub_all(double dt) {
  for (int k = 0; k < count_; ++k) {
    const Vec normal = plain(normal_[k]);
    const double pressing = pressed_[k].w;
    const Approach way{0, {}, plain(slip_[k]), slip_[k].w};
    const FrictionStep step = advance_friction(
        {friction_[k].x, friction_[k].y, friction_[k].z, friction_[k].w},
        {plain(tangential_[k]), normal_[k].w, sliding_[k]}, pressing, arm_[k].w, way, dt);
    const Wrench on_a = wrench(normal, pressing, plain(pressed_[k]), step.state);
    const Vec moment = on_a.moment + cross(plain(arm_[k]), on_a.force);
    const Vec counter = moment + cross(plain(apart_[k]), on_a.force);  // arm_b = arm_a + apart
    const Vec t = step.state.tangential;
    tangential_[k] = {t.x, t.y, t.z, pressing};
    torsion_[k] = step.state.torsion;
    sliding_[k] = step.state.sliding;
    work_friction_[k] = step.work;
    force_[k] = {on_a.force.x, on_a.force.y, on_a.force.z, 0};
    moment_a_[k] = {moment.x, moment.y, moment.z, 0};
    moment_b_[k] = {-counter.x, -counter.y, -counter.z, 0};
  }
}

void PatchBlock::store_all(double dt) {
  for (int k = 0; k < count_; ++k) {
    Patch& patch = *patch_[k];
    copy_four(&tangential_[k], &patch.tangential);
    patch.torsion = torsion_[k];
    patch.sliding = sliding_[k] > 0;
    patch.fresh = 0;
    if (law_[k]->rolling_limit > 0) {
      work_friction_[k] += advance_rolling(*law_[k], patch, eigen(plain(spin_[k])), dt);
      const Vec m = plain(patch.rolling);
      moment_a_[k] = {moment_a_[k].x + m.x, moment_a_[k].y + m.y, moment_a_[k].z + m.z, 0};
      moment_b_[k] = {moment_b_[k].x - m.x, moment_b_[k].y - m.y, moment_b_[k].z - m.z, 0};
    }
  }
}

}  // namespace firn
