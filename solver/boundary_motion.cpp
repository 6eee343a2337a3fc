// Boundaries follow their prescribed motions.
#include "solver/workspace.h"

namespace firn {

namespace {

// How long a motion is active within [t, t + dt], s.
double active_time(const Motion& m, double t, double dt) {
  return std::max(0.0, std::min(t + dt, m.stop) - std::max(t, m.start));
}

struct Displacement {
  Vec3 position;
  Quat orientation;
  Vec3 turned = Vec3::Zero();  // rad, sum of the rotation vectors
};

void apply(const Motion& m, double t, double dt, Displacement& d) {
  const double active = active_time(m, t, dt);
  if (active <= 0) return;
  if (m.kind == Motion::Kind::translation) {
    d.position += m.velocity * active;
    return;
  }
  const Quat turn(Eigen::AngleAxisd(m.angular_speed * active, m.axis));
  d.position = m.center + turn * (d.position - m.center);
  d.orientation = turn * d.orientation;
  d.turned += m.axis * (m.angular_speed * active);
}

}  // namespace

void advance_boundaries(const Model& model, State& s) {
  const std::size_t n = model.particles.size();
  const double dt = model.timestep;
  for (std::size_t b = 0; b < model.boundaries.size(); ++b) {
    const std::size_t body = n + b;
    const Boundary& boundary = model.boundaries[b];
    BodyMotion& motion = s.motion[body];
    Displacement d{motion.position, s.orientation[body]};
    for (const Motion& m : boundary.motions) apply(m, s.time, dt, d);
    for (std::size_t k = 0; k < s.extra_motions.size(); ++k) {
      if (s.extra_motion_boundary[k] == static_cast<int>(b))
        apply(s.extra_motions[k], s.time, dt, d);
    }
    motion.velocity = (d.position - motion.position) / dt;
    motion.spin = d.turned / dt;
    motion.position = d.position;
    if (!d.turned.isZero(0)) s.orientation[body] = d.orientation.normalized();
  }
}

}  // namespace firn
