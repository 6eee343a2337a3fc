// Curved walls of plane facets that are refined: forces and rebounds approach those of the true
// wall. Random members with fixed seeds.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <numbers>
#include <tuple>

#include "experiments/meshes/wall_solids.h"
#include "validation/verification/fixtures/closed_forms.h"
#include "validation/verification/fixtures/wall_impact.h"
#include "validation/verification/robustness/cases.h"

namespace firn::verification {

namespace {

using scenes::Random;

// Inside of a cylinder about y, or of a sphere, both about the origin.
enum class Curved { trough, bowl };
constexpr double kWallRadius = 30e-3, kBallMass = 4e-3, kBallStiffness = 1e5;  // m, kg, N/m
// rad, of places of contact from -z: an edge and two half facets of the coarsest wall.
constexpr double kReach = std::numbers::pi / 32;

// The part of the wall near -z, with its corners on the true surface and `around` facets in a full
// circle.
TriangleMesh curved_mesh(Curved kind, int around) {
  const double cell = 2 * std::numbers::pi / around;
  const int half = static_cast<int>(std::ceil((kReach + 0.08) / cell));
  const int columns = 2 * half, rows = kind == Curved::bowl ? columns : 1;
  TriangleMesh mesh;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      const double a = (i - half) * cell, b = (j - half) * cell;
      if (kind == Curved::bowl) {
        mesh.vertices.emplace_back(kWallRadius * Vec3(std::tan(a), std::tan(b), -1).normalized());
      } else {
        mesh.vertices.emplace_back(kWallRadius * std::sin(a), (j - 0.5) * kWallRadius,
                                   -kWallRadius * std::cos(a));
      }
    }
  }
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int a = j * (columns + 1) + i, b = a + 1, c = a + columns + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
  return mesh;
}

// Largest distance of the facets from the true wall, m: in the bowl, at the diagonal of a cell.
double curved_sagitta(Curved kind, int around) {
  const double half = std::numbers::pi / around;
  return kWallRadius * (1 - std::cos(kind == Curved::bowl ? std::numbers::sqrt2 * half : half));
}

struct Scene {
  Curved kind = Curved::trough;
  int around = 64;  // facets in a full circle
  double friction = 0, restitution = 0.5;
  double ball_radius = 10e-3;  // m

  double facet_angle() const { return 2 * std::numbers::pi / around; }  // rad
};

std::shared_ptr<const Model> ball_in_wall(const Scene& scene) {
  Model model = scenes::body_on_plane(sphere(scene.ball_radius, kBallMass, kBallStiffness),
                                      scenes::law(scene.friction, scene.restitution));
  Boundary wall = sheet({.kind = ThinWall::Kind::plane});
  wall.kind = Boundary::Kind::solid;
  wall.parts = wall_solids(curved_mesh(scene.kind, scene.around), 2e-3);
  model.boundaries = {wall};
  model.gravity.setZero();
  model.timestep = advise_timestep(model, 10).timestep;
  validate(model);
  return std::make_shared<const Model>(std::move(model));
}

// A random outward normal of the true wall, and a place along the axis of the trough.
struct WallPlace {
  Vec3 normal = Vec3::Zero();
  double along = 0;  // m

  WallPlace(Curved kind, Random& random) {
    const double a = random.uniform(-kReach, kReach), b = random.uniform(-kReach, kReach);
    if (kind == Curved::bowl) {
      normal = Vec3(std::tan(a), std::tan(b), -1).normalized();
    } else {
      normal = Vec3(std::sin(a), 0, -std::cos(a));
      along = 0.1 * kWallRadius * b / kReach;
    }
  }
  // Center of the ball at this overlap (m) with the true wall.
  Vec3 center(const Scene& scene, double overlap) const {
    return (kWallRadius - scene.ball_radius + overlap) * normal + along * Vec3::UnitY();
  }
};

// Order p of errors c n^-p at n = first, 2 first, 4 first ..., by least squares of the logarithms.
double fitted_order(const std::vector<double>& errors) {
  const double middle = 0.5 * (static_cast<double>(errors.size()) - 1);
  double product = 0, square = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double x = static_cast<double>(i) - middle;
    product += x * std::log2(errors[i]);
    square += x * x;
  }
  return -product / square;
}

// Root mean square and largest value of many.
struct Deviation {
  double squares = 0, largest = 0;
  int count = 0, member = 0;  // of the largest

  void add(double value) {
    if (value > largest) member = count;
    largest = std::max(largest, value);
    squares += value * value;
    ++count;
  }
  double rms() const { return std::sqrt(squares / count); }
};

// --- Forces. -------------------------------------------------------------------------------------

std::vector<Check> held_in_curved_walls(Curved kind, const std::string& name, int count) {
  constexpr double overlap = 100e-6;
  std::vector<double> force_errors, direction_errors;
  Deviation force, direction, moment;
  constexpr int finest = 512;
  double sagitta = 0;  // m
  for (int around = 32; around <= finest; around *= 2) {
    sagitta = curved_sagitta(kind, around);
    const Scene scene{.kind = kind, .around = around};
    const auto model = ball_in_wall(scene);
    Solver solver(model, 1);
    const std::vector<std::byte> empty = solver.save();
    force = direction = {};
    Random random(611);
    for (int i = 0; i < count; ++i) {
      const WallPlace place(kind, random);
      solver.restore(empty);
      solver.insert(0, place.center(scene, overlap), Quat::Identity(), Vec3::Zero(), Vec3::Zero());
      solver.step();
      const ParticleState& p = solver.particles();
      // The first force acts for half a step: velocity Verlet.
      const double time = 0.5 * model->timestep;
      const Vec3 push = kBallMass * p.velocity[0] / time;
      const Vec3 turn = model->shapes[0].inertia.x() * p.angular_velocity[0] / time;
      const double inward = -push.dot(place.normal);
      force.add(std::abs(inward / (kBallStiffness * overlap) - 1));
      direction.add(std::atan2(push.cross(place.normal).norm(), inward));
      moment.add(turn.norm() / (push.norm() * scene.ball_radius));
    }
    force_errors.push_back(force.rms());
    direction_errors.push_back(direction.rms());
  }
  const std::string many = fmt::format("{}, {} places, ", name, count),
                    last = fmt::format("{}{} facets around: ", many, finest);
  return {
      {many + "order of the force", fitted_order(force_errors), 2, 0.1, Bound::absolute},
      {many + "order of its direction", fitted_order(direction_errors), 1, 0.15, Bound::absolute},
      {many + "largest moment about the center, of force times radius", moment.largest, 1e-12, 0,
       Bound::at_most},
      {last + "largest error of the force, of sagitta over overlap",
       force.largest * overlap / sagitta, 1.01, 0, Bound::at_most},
      {last + "largest error of its direction, of the angle between facets",
       direction.largest * finest / (2 * std::numbers::pi), 0.35, 0, Bound::at_most}};
}

// --- Rebounds. -----------------------------------------------------------------------------------

struct BallMotion {
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();  // SI
};

// The same law on the true wall, with 20 times shorter steps. `duration` in s.
BallMotion on_true_wall(const Scene& scene, const Model& model, BallMotion now, double duration) {
  const Interaction& law = model.interaction(scenes::kIce, scenes::kPlastic);
  const double inertia = model.shapes[0].inertia.x(), k = kBallStiffness;
  const double unloading = k / (law.restitution * law.restitution);
  const auto steps = std::llround(duration / model.timestep) * 20;
  const double dt = duration / static_cast<double>(steps);
  double overlap = 0, force = 0;
  Vec3 friction = Vec3::Zero(), push = Vec3::Zero(), moment = Vec3::Zero();
  const auto kick = [&] {
    now.velocity += 0.5 * dt / kBallMass * push;
    now.angular_velocity += 0.5 * dt / inertia * moment;
  };
  for (long long i = 0; i < steps; ++i) {
    kick();
    now.position += dt * now.velocity;
    Vec3 normal = now.position;
    if (scene.kind == Curved::trough) normal.y() = 0;
    const double before = overlap;
    overlap = std::max(0.0, normal.norm() + scene.ball_radius - kWallRadius);
    normal.normalize();
    force = std::min(k * overlap, std::max(force + unloading * (overlap - before),
                                           law.minimum_unloading_ratio * k * overlap));
    const Vec3 arm = (scene.ball_radius - 0.5 * overlap) * normal;
    const Vec3 slip = now.velocity + now.angular_velocity.cross(arm);
    friction -= k * dt * slip;
    friction -= friction.dot(normal) * normal;
    const double limit = law.dynamic_friction * force, size = friction.norm();
    if (size > limit) friction *= limit / size;
    push = friction - force * normal;
    moment = arm.cross(friction);
    kick();
  }
  return now;
}

// Off the rebound from the true wall, m/s; spin times radius.
struct ReboundErrors {
  Deviation velocity, across, spin;
};

// Impacts at 1 m/s. Without friction, along the normal of the true wall and without spin; else
// within 45 degrees of it, with a spin of up to 50 rad/s about each axis.
ReboundErrors rebounds(const Scene& scene, int count, Random& random) {
  constexpr double duration = 1.4e-3, gap = 5e-6;
  const auto model = ball_in_wall(scene);
  Solver solver(model, 1);
  const std::vector<std::byte> empty = solver.save();
  ReboundErrors errors;
  for (int i = 0; i < count; ++i) {
    const WallPlace place(scene.kind, random);
    BallMotion start;
    start.position = place.center(scene, -gap - 1.1 * curved_sagitta(scene.kind, scene.around));
    start.velocity = place.normal;
    if (scene.friction > 0) {
      const double angle = random.uniform(0, 45) * kDegToRad;
      const Vec3 across = place.normal.cross(random.orientation() * Vec3::UnitX()).normalized();
      start.velocity = std::cos(angle) * place.normal + std::sin(angle) * across;
      for (int axis = 0; axis < 3; ++axis) start.angular_velocity[axis] = random.uniform(-50, 50);
    }
    solver.restore(empty);
    solver.insert(0, start.position, Quat::Identity(), start.velocity, start.angular_velocity);
    const auto steps = std::llround(duration / model->timestep);
    scenes::run(solver, duration);
    const BallMotion wanted =
        on_true_wall(scene, *model, start, static_cast<double>(steps) * model->timestep);
    const Vec3 off = solver.particles().velocity[0] - wanted.velocity;
    const double normal = off.dot(place.normal);
    errors.velocity.add(off.norm());
    errors.across.add((off - normal * place.normal).norm());
    errors.spin.add(scene.ball_radius *
                    (solver.particles().angular_velocity[0] - wanted.angular_velocity).norm());
  }
  return errors;
}

constexpr double kNoSpin = 1e-12;  // m/s, rounding

std::vector<Check> rebounds_from_curved_walls(Curved kind, const std::string& name, int count) {
  std::vector<Check> checks;
  for (const double friction : {0.0, 0.2}) {
    const std::string title = fmt::format("{}, {} impacts, friction {}", name, count, friction);
    std::vector<double> across;
    for (int around = 64; around <= 1024; around *= 2) {
      const Scene scene{.kind = kind, .around = around, .friction = friction};
      Random random(612);
      const ReboundErrors errors = rebounds(scene, count, random);
      across.push_back(errors.across.rms());
      const std::string facets = fmt::format("{}, {} facets around: ", title, around);
      checks.push_back({fmt::format("{}largest error of the velocity (member {})", facets,
                                    errors.velocity.member),
                        errors.velocity.largest, 0.6 * scene.facet_angle(), 0, Bound::at_most,
                        "m/s"});
      checks.push_back({fmt::format("{}largest error of spin times radius (member {})", facets,
                                    errors.spin.member),
                        errors.spin.largest, friction > 0 ? 1.5 * scene.facet_angle() : kNoSpin, 0,
                        Bound::at_most, "m/s"});
    }
    if (friction == 0) {
      checks.push_back({title + ": order of the velocity across the normal", fitted_order(across),
                        1, 0.2, Bound::absolute});
    }
  }
  return checks;
}

// Balls of any size and restitution in walls of any number of facets, without friction. The force
// is off the true normal by less than half the angle between the facets that are touched: those
// around the corner of a cell in the bowl, up to sqrt(2) times the angle of its sides.
std::vector<Check> rebounds_of_random_balls(int count) {
  Random random(613);
  Deviation velocity, spin;
  for (int i = 0; i < count; ++i) {
    Scene scene;
    scene.kind = random.uniform(0, 1) < 0.5 ? Curved::trough : Curved::bowl;
    scene.around = static_cast<int>(std::lround(48 * std::pow(20, random.uniform(0, 1))));
    scene.restitution = random.uniform(0.2, 1);
    scene.ball_radius = random.uniform(3e-3, 25e-3);
    const ReboundErrors errors = rebounds(scene, 5, random);
    const double angle =
        scene.facet_angle() * (scene.kind == Curved::bowl ? std::numbers::sqrt2 : 1);
    velocity.add(errors.velocity.largest / ((1 + scene.restitution) * 0.5 * angle));
    spin.add(errors.spin.largest);
  }
  const std::string title = fmt::format("{} random balls, walls and restitutions, ", count);
  return {{fmt::format("{}velocity off, of that by half the angle of facets (member {})", title,
                       velocity.member),
           velocity.largest, 1, 0, Bound::at_most},
          {title + "largest spin times radius", spin.largest, kNoSpin, 0, Bound::at_most, "m/s"}};
}

std::vector<Check> curved_walls() {
  std::vector<Check> checks;
  for (const auto& [kind, name, count] :
       {std::tuple(Curved::trough, "trough", 300), std::tuple(Curved::bowl, "bowl", 100)}) {
    std::ranges::move(held_in_curved_walls(kind, name, count), std::back_inserter(checks));
    std::ranges::move(rebounds_from_curved_walls(kind, name, count), std::back_inserter(checks));
  }
  std::ranges::move(rebounds_of_random_balls(100), std::back_inserter(checks));
  return checks;
}

}  // namespace

std::vector<VerificationCase> curved_wall_cases() {
  return {
      {.name = "invariance.curved_walls",
       .title = "A sphere in troughs and bowls of more and more facets",
       .reference = "K s along the radius; the same law on the true wall, integrated on its own "
                    "with 20 times shorter steps",
       .remark =
           "Inner radius 30 mm, corners of the facets on the true wall, ball of 10 mm. Held at an "
           "overlap of 0.1 mm the force is of second order and its direction of first: the "
           "sagitta of a facet, and the angle between facets. Rebounds at 1 m/s, e = 0.5, are off "
           "by at most 0.6 times the angle between facets, times the speed: within 1 % from 400 "
           "facets around. Without friction the ball gets no spin.",
       .tier = Tier::quick,
       .run = curved_walls}};
}

}  // namespace firn::verification
