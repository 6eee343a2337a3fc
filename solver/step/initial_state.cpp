#include "solver/step/initial_state.h"

#include <algorithm>

#include "solver/state/state.h"
#include "solver/step/frame_poses.h"
#include "solver/step/joint_reactions.h"

namespace firn {

void place_boundaries(const Model& model, State& s) {
  const std::size_t n = model.particles.size();
  s.frames.resize(model.frames.size());
  s.joint_reactions.resize(model.frames.size());
  s.couplings.resize(model.couplings.size());
  for (std::size_t c = 0; c < model.couplings.size(); ++c)
    s.couplings[c].position = model.couplings[c].position;
  s.frame_position.resize(model.frames.size());
  s.frame_orientation.resize(model.frames.size(), Quat::Identity());
  for (std::size_t f = 0; f < model.frames.size(); ++f) {
    const MotionFrame& frame = model.frames[f];
    s.frames[f].position = frame.origin;
    s.frame_position[f] = frame.origin - origin_of(model, frame.parent);
  }
  estimate_reactions(model, s);
  s.boundary_position.resize(model.boundaries.size());
  s.boundary_orientation.resize(model.boundaries.size());
  for (std::size_t b = 0; b < model.boundaries.size(); ++b) {
    const Boundary& boundary = model.boundaries[b];
    s.motion[n + b].position = boundary.origin;
    s.orientation[n + b] = boundary.orientation;
    s.boundary_position[b] = boundary.origin - origin_of(model, boundary.frame);
    s.boundary_orientation[b] = boundary.orientation;
  }
}

void initialize(const Model& model, State& s) {
  const std::size_t n = model.particles.size(), b = model.boundaries.size();
  s.motion.resize(n + b);
  s.orientation.resize(n + b, Quat::Identity());
  s.angular_momentum.resize(n, Vec3::Zero());
  s.load.resize(n);
  s.translation_bound.resize(n + b, 0);
  s.rotation_bound.resize(n + b, 0);
  s.skin.resize(n + b, 0);
  s.rebuild_distance.resize(n + b, 0);
  s.presence.resize(n, Presence::pending);
  s.peak_normal_force.resize(n, 0);
  s.boundary_present.resize(b, 1);
  s.boundary_impulse.resize(b, Vec3::Zero());
  s.boundary_angular_impulse.resize(b, Vec3::Zero());
  s.boundary_peak.resize(b, 0);
  s.boundary_load.resize(b);
  s.bonds.resize(model.bonds.size());
  s.bond_loads.resize(model.bonds.size());
  place_boundaries(model, s);
  s.boundary_contacts.resize(model.boundary_contacts.size());
  s.statistics = empty_statistics(model);
}

void start_frame(const Model& model, const FrameStart& start, State& s) {
  const auto f = static_cast<std::size_t>(start.frame);
  const MotionFrame& frame = model.frames[f];
  FrameMotion& motion = s.frames[f];
  const FrameMotion world;
  const FrameMotion& parent =
      frame.parent < 0 ? world : s.frames[static_cast<std::size_t>(frame.parent)];
  const Mat3 axes = RotationMap(parent.rotation);
  Vec3 position = axes.transpose() * (start.position - parent.position);
  Quat orientation = (Quat(axes).conjugate() * start.orientation).normalized();
  if (frame.free) {
    std::ranges::copy(start.coordinates, motion.coordinate);
    std::ranges::copy(start.rates, motion.rate);
    if (frame.free->free_rotation)
      Eigen::Map<Vec3>(motion.rate + frame.free->joints.size()) =
          axes.transpose() * start.relative_angular_velocity;
    position = position_of(*frame.free, frame.origin - origin_of(model, frame.parent), motion);
    if (!frame.free->free_rotation) orientation = Quat::Identity();
    for (std::size_t k = 0; k < frame.free->joints.size(); ++k) {
      const Joint& axis = frame.free->joints[k];
      if (axis.kind == Joint::Kind::rotation)
        orientation = Quat(Eigen::AngleAxisd(motion.coordinate[k], axis.direction));
    }
  }
  s.frame_position[f] = position;
  s.frame_orientation[f] = orientation;
  for (std::size_t k = f; k < model.frames.size(); ++k) {
    const int above = model.frames[k].parent;
    if (!descends_from(model.frames, static_cast<int>(k), start.frame)) continue;
    const FrameMotion& carrier = above < 0 ? world : s.frames[static_cast<std::size_t>(above)];
    const Mat3 turn = RotationMap(carrier.rotation);
    s.frames[k].position = carrier.position + turn * s.frame_position[k];
    Eigen::Map<Mat3>(s.frames[k].rotation) = turn * s.frame_orientation[k].toRotationMatrix();
  }
  for (std::size_t b = 0; b < model.boundaries.size(); ++b) {
    const int carrier = model.boundaries[b].frame;
    if (!descends_from(model.frames, carrier, start.frame)) continue;
    const FrameMotion& at = s.frames[static_cast<std::size_t>(carrier)];
    const std::size_t body = model.particles.size() + b;
    const Mat3 turn = RotationMap(at.rotation);
    s.motion[body].position = at.position + turn * s.boundary_position[b];
    s.orientation[body] = (Quat(turn) * s.boundary_orientation[b]).normalized();
  }
}

}  // namespace firn
