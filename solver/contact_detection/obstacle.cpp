#include "solver/contact_detection/obstacle.h"

#include "solver/collision/gjk.h"
#include "solver/state/workspace.h"

namespace firn {

std::optional<int> find_obstacle(const Model& model, const State& s, int shape,
                                 const Vec3& center_of_mass, const Quat& orientation,
                                 double clearance) {
  const Shape& mine = model.shapes[shape];
  const Mat3 rotation = (orientation * mine.shape_from_body).toRotationMatrix();
  const auto near = [&](const std::vector<ConvexPart>& parts, const Mat3& other,
                        const Vec3& place) {
    const Pose pose{rotation.transpose() * other, rotation.transpose() * (place - center_of_mass)};
    for (const ConvexPart& a : mine.parts) {
      for (const ConvexPart& b : parts) {
        const double touch = a.radius + b.radius + clearance;
        const double apart = (a.center - pose * b.center).norm();
        if (apart > a.bounding_radius + b.bounding_radius + clearance) continue;
        GjkCache cold;
        double distance = core_distance(a, b, pose, cold);
        // A tolerated overlap deeper than the rounding reaches into the cores.
        if (distance <= 0 && touch <= 0) distance = penetration(a, b, pose).distance;
        if (distance < touch) return true;
      }
    }
    return false;
  };
  for (std::size_t i = 0; i < model.particles.size(); ++i) {
    if (s.presence[i] != Presence::present) continue;
    const Shape& other = model.shapes[model.particles[i].shape];
    const double reach = mine.bounding_radius + other.bounding_radius + clearance;
    if ((s.motion[i].position - center_of_mass).squaredNorm() > reach * reach) continue;
    if (near(other.parts, rotation_of(s, static_cast<int>(i)), s.motion[i].position))
      return static_cast<int>(i);
  }
  const std::size_t n = model.particles.size();
  for (std::size_t b = 0; b < model.boundaries.size(); ++b) {
    if (!s.boundary_present[b]) continue;
    const Mat3 axes = rotation_of(s, static_cast<int>(n + b));
    if (model.boundaries[b].kind == Boundary::Kind::solid) {
      if (near(model.boundaries[b].parts, axes, s.motion[n + b].position))
        return static_cast<int>(n + b);
      continue;
    }
    const Vec3 normal = axes.col(2);
    for (const ConvexPart& part : mine.parts) {
      for (int k = 0; k < part.vertex_count; ++k) {
        const Vec3 p = center_of_mass + rotation * part.vertex(k);
        if (normal.dot(p - s.motion[n + b].position) - part.radius < clearance)
          return static_cast<int>(n + b);
      }
    }
  }
  return std::nullopt;
}

}  // namespace firn
