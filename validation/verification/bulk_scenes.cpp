#include "validation/verification/bulk_scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace firn::scenes {

std::vector<Vec3> platonic_solid(int faces, double diameter) {
  const double g = std::numbers::phi, i = 1 / g;
  std::vector<Vec3> p;
  const auto cyclic = [&](double a, double b, double c) {
    p.insert(p.end(), {{a, b, c}, {c, a, b}, {b, c, a}});
  };
  const double signs[] = {-1, 1};
  if (faces == 4) p = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  if (faces == 6 || faces == 12) {
    for (const double x : signs) {
      for (const double y : signs) p.insert(p.end(), {{x, y, -1}, {x, y, 1}});
    }
  }
  for (const double s : signs) {
    if (faces == 8) cyclic(s, 0, 0);
    for (const double t : signs) {
      if (faces == 12) cyclic(0, s * i, t * g);
      if (faces == 20) cyclic(0, s, t * g);
    }
  }
  ShapeOptions plain;
  plain.density = plain.young_modulus = 1;
  plain.rounding = 1e-3;
  const double volume = make_convex(p, plain).volume;
  const double scale = diameter * std::cbrt(std::numbers::pi / 6 / volume);
  for (Vec3& corner : p) corner *= scale;
  return p;
}

bool inside(const std::vector<HalfSpace>& sides, const Vec3& point) {
  return std::all_of(sides.begin(), sides.end(),
                     [&](const HalfSpace& h) { return h.normal.dot(point) <= h.offset; });
}

double die_mass(const Dice& dice) {
  return dice.density * std::numbers::pi / 6 * kDie * kDie * kDie;
}

Model dice_model(const Dice& dice) {
  Interaction between = law(dice.friction, dice.restitution);
  between.rolling_resistance = dice.rolling_resistance;
  Model model = empty(between, law(dice.wall_friction, dice.restitution));
  const double mass = die_mass(dice);
  const double stiffness = dice.hardness * mass * kGravity / kDie;
  const ShapeOptions options = ice_options(mass, stiffness, 0.015 * kDie);
  add_shape(model, dice.faces == 0 ? make_sphere(kDie / 2, options)
                                   : make_convex(platonic_solid(dice.faces, kDie), options));
  return model;
}

void rain(Solver& solver, int first, int last, const Rain& how) {
  Random random(how.seed);
  for (int particle = first; particle < last; ++particle) {
    const int shape = solver.model().particles[particle].shape;
    for (int tries = 0;; ++tries) {
      if (tries == 1000) throw RunError(fmt::format("no room for particle {}", particle));
      Vec3 at(random.uniform(how.lower.x(), how.upper.x()),
              random.uniform(how.lower.y(), how.upper.y()), how.upper.z());
      const Quat turn = random.orientation();
      if (solver.overlaps(shape, at, turn, 0)) continue;
      while (at.z() > how.lower.z() &&
             !solver.overlaps(shape, at - how.step * Vec3::UnitZ(), turn, 0)) {
        at.z() -= how.step;
      }
      solver.insert(particle, at, turn, Vec3::Zero(), Vec3::Zero());
      break;
    }
    if ((particle - first + 1) % how.batch == 0) run(solver, how.interval);
  }
}

void tap(Solver& solver, double speed, double rise, double period) {
  const int boundaries = static_cast<int>(solver.model().boundaries.size());
  const double now = solver.time();
  for (int b = 0; b < boundaries; ++b) {
    Motion up;
    up.start = now;
    up.stop = now + rise;
    up.velocity = Vec3(0, 0, speed);
    Motion down = up;
    down.start = up.stop;
    down.stop = up.stop + rise;
    down.velocity = Vec3(0, 0, -speed);
    solver.add_motion(b, up);
    solver.add_motion(b, down);
  }
  run(solver, period);
}

double packing_fraction(const Solver& solver, const Vec3& lower, const Vec3& upper,
                        double spacing) {
  const Model& model = solver.model();
  std::vector<std::vector<HalfSpace>> sides;
  for (const Shape& s : model.shapes) sides.push_back(convex_hull(s.mesh.vertices));
  Eigen::Vector3i count;
  Vec3 step;
  for (int axis = 0; axis < 3; ++axis) {
    count[axis] = std::max(1, static_cast<int>(std::lround((upper - lower)[axis] / spacing)));
    step[axis] = (upper - lower)[axis] / count[axis];
  }
  // Bodies overlap by next to nothing, so that points in two of them need no care.
  const ParticleState& now = solver.particles();
  std::int64_t filled = 0;
  for (int p = 0; p < static_cast<int>(now.position.size()); ++p) {
    if (now.presence[p] != Presence::present) continue;
    const Shape& shape = model.shapes[model.particles[p].shape];
    const Mat3 to_shape = solver.shape_orientation(p).toRotationMatrix().transpose();
    Eigen::Vector3i from, to;
    for (int axis = 0; axis < 3; ++axis) {
      const double at = now.position[p][axis] - lower[axis], reach = shape.bounding_radius;
      from[axis] = std::max(0, static_cast<int>(std::floor((at - reach) / step[axis])));
      to[axis] = std::min(count[axis], static_cast<int>(std::ceil((at + reach) / step[axis])));
    }
    for (int i = from.x(); i < to.x(); ++i) {
      for (int j = from.y(); j < to.y(); ++j) {
        for (int k = from.z(); k < to.z(); ++k) {
          const Vec3 point = lower + step.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5));
          const Vec3 from_center = point - now.position[p];
          filled += shape.rounding == shape.bounding_radius
                        ? from_center.norm() <= shape.rounding  // a sphere
                        : inside(sides[model.particles[p].shape],
                                 shape.centroid + to_shape * from_center);
        }
      }
    }
  }
  return static_cast<double>(filled) / (static_cast<double>(count.x()) * count.y() * count.z());
}

double height_below(const Solver& solver, double fraction) {
  const ParticleState& now = solver.particles();
  std::vector<double> heights;
  for (std::size_t p = 0; p < now.position.size(); ++p) {
    if (now.presence[p] == Presence::present) heights.push_back(now.position[p].z());
  }
  if (heights.empty()) return 0;
  const auto at = std::min(
      heights.size() - 1, static_cast<std::size_t>(fraction * static_cast<double>(heights.size())));
  std::nth_element(heights.begin(), heights.begin() + static_cast<std::ptrdiff_t>(at),
                   heights.end());
  return heights[at];
}

Sample sample(const std::vector<double>& values) {
  Sample s;
  s.count = static_cast<int>(values.size());
  for (const double v : values) s.mean += v / s.count;
  double sum = 0;
  for (const double v : values) sum += (v - s.mean) * (v - s.mean);
  s.deviation = std::sqrt(sum / (s.count - 1));
  s.error = s.deviation / std::sqrt(s.count);
  return s;
}

double energy_gap(const Energy& e) {
  return mechanical(e) + e.dissipated_normal + e.dissipated_friction - e.boundary_work + e.removed;
}

bool settle(Solver& solver, double still, double patience) {
  const double give_up = solver.time() + patience;
  double calm_since = solver.time();
  while (solver.time() < give_up) {
    run(solver, 1e-3);
    const auto& presence = solver.particles().presence;
    const auto present = std::count(presence.begin(), presence.end(), Presence::present);
    if (solver.energy().kinetic > still * static_cast<double>(present)) calm_since = solver.time();
    if (solver.time() - calm_since >= 20e-3) return true;
  }
  return false;
}

}  // namespace firn::scenes
