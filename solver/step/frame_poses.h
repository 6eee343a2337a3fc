// Poses of motion frames.
#pragma once

#include <cstddef>

#include "firn/model.h"
#include "solver/state/state.h"

namespace firn {

// View of FrameMotion::rotation as a matrix.
using RotationMap = Eigen::Map<const Mat3>;

// m, origin of a frame as drawn; -1: the world.
inline Vec3 origin_of(const Model& model, int frame) {
  return frame < 0 ? Vec3(Vec3::Zero()) : model.frames[static_cast<std::size_t>(frame)].origin;
}

// m, position of a free body in the axes of its parent; `rest`: at coordinates of zero.
inline Vec3 position_of(const FreeBody& body, const Vec3& rest, const FrameMotion& motion) {
  Vec3 position = rest;
  for (std::size_t k = 0; k < body.joints.size(); ++k) {
    if (body.joints[k].kind == Joint::Kind::translation)
      position += body.joints[k].direction * motion.coordinate[k];
  }
  return position;
}

}  // namespace firn
