// One rigid body that tips, rocks or rolls over its edges.
#include <algorithm>
#include <cmath>

#include "validation/verification/fixtures/closed_forms.h"

namespace firn::verification {

std::vector<VerificationCase> rolling_cases();

namespace {

using scenes::kGravity;

// A regular prism of 1 kg about the y axis, standing on a face; R to its long edges.
Shape prism(int sides, double radius, double stiffness, double rounding) {
  std::vector<Vec3> corners;
  for (int i = 0; i < sides; ++i) {
    const double angle = (2 * i + 1) * std::numbers::pi / sides - 0.5 * std::numbers::pi;
    for (const double y : {-radius, radius})
      corners.push_back({radius * std::cos(angle), y, radius * std::sin(angle)});
  }
  return make_convex(corners, scenes::ice_options(1, stiffness, rounding));
}

// A body whose center stands `height` above a base of half length `half`: the resultant leaves the
// support at tan(angle) = half / height. The plane creeps up to the angle so that the load does not
// set the body rocking.
bool tips(const Shape& shape, double half, double height, double off) {
  const double limit = std::atan2(half, height) / kDegToRad;
  const double start = limit - 1.5, rate = 1;  // deg, deg/s
  const double degrees = limit + off;
  Model model = scenes::empty(scenes::law(2.5, 0.5), scenes::law(2.5, 0.5));
  scenes::add_particles(model, scenes::add_shape(model, shape));
  const Vec3 normal(std::sin(start * kDegToRad), 0, std::cos(start * kDegToRad));
  const int plane = scenes::add_plane(model, Vec3::Zero(), normal);
  Motion tilt;
  tilt.kind = Motion::Kind::rotation;
  tilt.axis = Vec3::UnitY();
  tilt.angular_speed = rate * kDegToRad;
  tilt.start = 0.3;
  tilt.stop = tilt.start + (degrees - start) / rate;
  model.boundaries[plane].motions = {tilt};
  model.timestep = 2e-5;
  Solver solver(model);
  const double dent = kGravity * std::cos(start * kDegToRad) / shape.stiffness;
  solver.insert(0, (height - dent) * normal, about(Vec3::UnitY(), start), Vec3::Zero(),
                Vec3::Zero());
  while (solver.time() < tilt.stop + 0.8) {
    scenes::run(solver, 0.01);
    const Vec3 up = solver.shape_orientation(0) * Vec3::UnitZ();
    if (std::acos(std::clamp(up.z(), -1.0, 1.0)) / kDegToRad > degrees + 5) return true;
  }
  return false;
}

std::vector<Check> tipping() {
  struct Body {
    std::string name;
    Shape shape;
    double half, height;
  };
  const double stiffness = 1e7, rounding = 1e-5;
  std::vector<Body> bodies;
  for (const Vec3& size : {Vec3(0.1, 0.1, 0.1), Vec3(0.06, 0.1, 0.1), Vec3(0.1, 0.08, 0.05)}) {
    bodies.push_back({fmt::format("box of base {} and height {} m", size.x(), size.z()),
                      make_box(size, scenes::ice_options(1, stiffness, rounding)), size.x() / 2,
                      size.z() / 2});
  }
  for (const int sides : {5, 6, 8, 12}) {
    const double part = std::numbers::pi / sides;
    bodies.push_back({fmt::format("prism of {} sides", sides),
                      prism(sides, 0.05, stiffness, rounding), 0.05 * std::sin(part),
                      0.05 * std::cos(part)});
  }
  std::vector<Check> checks;
  for (const Body& b : bodies) {
    const double limit = std::atan2(b.half, b.height) / kDegToRad;
    for (const double off : {-0.15, 0.15}) {
      checks.push_back({fmt::format("{}, {:.2f} deg (limit {:.2f}): goes over (1) or stays (0)",
                                    b.name, limit + off, limit),
                        tips(b.shape, b.half, b.height, off) ? 1.0 : 0.0, off > 0 ? 1.0 : 0.0, 0,
                        Bound::absolute, "1"});
    }
  }
  return checks;
}

// Housner's block, 0.1 x 0.4 m, released from a lean; p = sqrt(3 g / 4 R).
struct Rocking {
  double quarter = 0;                 // s, until upright
  double angular_velocity_ratio = 0;  // over the impact
};

Rocking rock(double lean_share) {
  const double stiffness = 1e8, rounding = 1e-5;
  const Shape block = make_box({0.1, 0.1, 0.4}, scenes::ice_options(1, stiffness, rounding));
  Model model = scenes::body_on_plane(block, scenes::law(1, 0.1));
  model.timestep = 1e-6;
  Solver solver(model);
  const double slenderness = std::atan2(0.05, 0.2), lean = lean_share * slenderness;
  const Quat turn = about(Vec3::UnitY(), lean / kDegToRad);
  const Vec3 corner = turn * Vec3(0.05 - rounding, 0, -0.2 + rounding);
  solver.insert(0, {0, 0, rounding - corner.z() - kGravity / stiffness}, turn, Vec3::Zero(),
                Vec3::Zero());
  const auto angle = [&] {
    const Vec3 up = solver.shape_orientation(0) * Vec3::UnitZ();
    return std::atan2(up.x(), up.z());
  };
  double angular_velocity_before = 0;
  while (angle() > 0 && solver.time() < 1) {
    angular_velocity_before = solver.particles().angular_velocity[0].y();
    solver.step();
  }
  Rocking out;
  out.quarter = solver.time();
  scenes::run(solver, 0.01);
  // Gravity slows the rise meanwhile: theta'' = -p^2 (sin(alpha - theta)) about.
  const double p2 = 0.75 * kGravity / std::hypot(0.05, 0.2);
  const double after = solver.particles().angular_velocity[0].y() - p2 * slenderness * 0.01;
  out.angular_velocity_ratio = after / angular_velocity_before;
  return out;
}

// Quarter period of theta'' = -p^2 sin(alpha - theta), from rest at theta0: integral of
// dtheta / theta' by the midpoint rule in u, theta = theta0 - u^2, which takes the root away.
double exact_quarter(double theta0, double alpha) {
  const double p2 = 0.75 * kGravity / std::hypot(0.05, 0.2);
  const int n = 100000;
  const double top = std::sqrt(theta0);
  double time = 0;
  for (int i = 0; i < n; ++i) {
    const double u = (i + 0.5) / n * top, theta = theta0 - u * u;
    const double speed2 = 2 * p2 * (std::cos(alpha - theta0) - std::cos(alpha - theta));
    time += 2 * u * (top / n) / std::sqrt(speed2);
  }
  return time;
}

std::vector<Check> rocking() {
  std::vector<Check> checks;
  const double alpha = std::atan2(0.05, 0.2);
  checks.push_back({"quadrature of the quarter period from half the slenderness",
                    exact_quarter(0.5 * alpha, alpha), 0.220836, 2e-6, Bound::absolute, "s"});
  for (const double share : {0.3, 0.5, 0.8}) {
    const Rocking got = rock(share);
    const std::string scene = fmt::format("from {} of the slenderness: ", share);
    checks.push_back({scene + "quarter period", got.quarter, exact_quarter(share * alpha, alpha),
                      5e-3, Bound::relative, "s"});
    checks.push_back({scene + "spin after the impact over that before", got.angular_velocity_ratio,
                      1 - 1.5 * std::pow(std::sin(alpha), 2), 0.05, Bound::absolute, "1"});
  }
  return checks;
}

// A prism rolls on the level from one face to the next. It starts on a face, turning about the
// front edge, and must come over it. Returns its spin after the next edge has landed over that
// before.
double rolling_ratio(int sides) {
  const double radius = 0.05, stiffness = 1e7, rounding = 1e-5;
  const double part = std::numbers::pi / sides;
  const double about_edge =  // moment of inertia of 1 kg
      ((2 + std::cos(2 * part)) / 6 + 1) * radius * radius;
  const double angular_velocity =
      1.5 * std::sqrt(2 * kGravity * radius * (1 - std::cos(part)) / about_edge);
  Interaction law = scenes::law(2, 0.05);
  law.minimum_unloading_ratio = 1e-4;  // or it would give back 3 % of the speed by itself
  Model model = scenes::body_on_plane(prism(sides, radius, stiffness, rounding), law);
  model.timestep = 2e-6;
  Solver solver(model);
  const Vec3 arm(-radius * std::sin(part), 0, radius * std::cos(part));  // from the front edge
  const Vec3 turn(0, angular_velocity, 0);
  solver.insert(0, {0, 0, arm.z() - kGravity / stiffness}, Quat::Identity(), turn.cross(arm), turn);
  // Spin at an angle (rad, from where the edge began to bear) as it would be at another one:
  // I w^2 / 2 + m g R cos(part - angle) is kept about the edge.
  const auto angular_velocity_at = [&](double other, double angle) {
    const double now = solver.particles().angular_velocity[0].y();
    const double rise = radius * (std::cos(part - angle) - std::cos(part - other));
    return std::sqrt(now * now + 2 * kGravity * rise / about_edge);
  };
  const auto roll_to = [&](double angle) {
    double turned = 0;
    while (turned < angle) {
      if (solver.time() > 2) throw RunError(fmt::format("the prism never turned by {} rad", angle));
      solver.step();
      const Vec3 x = solver.shape_orientation(0) * Vec3::UnitX();
      turned = std::atan2(-x.z(), x.x());
    }
    return turned;
  };
  const double down = roll_to(2 * part - 0.02);
  const double before = angular_velocity_at(2 * part, down);
  // The edge that lands bounces a little; its forces have no moment about itself.
  const double up = roll_to(2 * part + 0.15);
  return angular_velocity_at(0, up - 2 * part) / before;
}

std::vector<Check> rolling() {
  std::vector<Check> checks;
  for (const int sides : {6, 7, 8, 10, 12}) {
    const double part = std::numbers::pi / sides;
    const double polar = (2 + std::cos(2 * part)) / 6;
    const double expected = (polar + std::cos(2 * part)) / (polar + 1);
    if (sides == 6)
      checks.push_back(
          {"closed form for six sides", expected, 11.0 / 17, 1e-12, Bound::absolute, "1"});
    checks.push_back({fmt::format("{} sides: spin after a face has landed over that before", sides),
                      rolling_ratio(sides), expected, 0.02, Bound::absolute, "1"});
  }
  return checks;
}

}  // namespace

std::vector<VerificationCase> rolling_cases() {
  return {
      {"body.tipping", "Boxes and prisms on an incline go over their edge",
       "tan(angle) = half the base / height of the center; 180/n degrees for a regular prism",
       "0.15 degrees below it stands, 0.15 above it goes over. Edges rounded by 10 um narrow the "
       "base by 0.01 degrees. The stiffness is 1e7 N/m: "
       "springs that ring after the set-down must not carry the body over the edge.",
       Tier::quick, tipping},
      {"body.rocking", "A slender block rocks",
       "Housner (1963): quarter period by quadrature of theta'' = -p^2 sin(alpha - theta); spin "
       "ratio 1 - 1.5 sin^2 alpha",
       "Block 0.1 x 0.4 m, p = 5.974 1/s, slenderness 14.036 degrees. The ratio holds for an "
       "inelastic impact without slip; here e = 0.1 and K = 1e8 N/m: within 5 %.",
       Tier::quick, rocking},
      {"body.rolling", "Prisms of 6 to 12 sides roll from face to face",
       "angular momentum about the edge that lands: (I + m R^2 cos(2 pi/n)) / (I + m R^2)",
       "Forces at the edge that lands have no moment about it; the one behind lifts off by itself. "
       "The bounce (e = 0.05) has died when the spin is read, 0.15 rad on. Prisms of fewer sides "
       "land so steeply that the elastic tangential spring throws the edge back and it slides: the "
       "closed form, which has no such rebound, does not apply.",
       Tier::quick, rolling}};
}

}  // namespace firn::verification
