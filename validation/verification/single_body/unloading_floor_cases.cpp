// Rebounds with small unloading floors, among them none: a point that has unloaded to no force is
// not one that touches for the first time.
#include <array>
#include <cmath>
#include <optional>

#include "validation/verification/fixtures/closed_forms.h"
#include "validation/verification/fixtures/wall_impact.h"

namespace firn::verification {

std::vector<VerificationCase> impact_floor_cases();

namespace {

struct FloorImpact {
  Shape shape;
  Quat turn = Quat::Identity();  // shape axes -> world
  ThinWall ground;
  Vec3 target = Vec3::Zero();  // m, on the ground
  double speed = 1;            // m/s
  double e = 0.5, floor = 0;
  bool one_point = false;
};

// Speed with which the place of contact leaves the ground, over that with which it came. Nothing
// when it does not leave, or when a crescent touches with more than one point.
std::optional<double> rebound(const FloorImpact& in) {
  Interaction law = scenes::law(0, in.e);
  law.minimum_unloading_ratio = in.floor;
  Model model = scenes::empty(law, law);
  scenes::add_particles(model, scenes::add_shape(model, in.shape));
  model.boundaries.push_back(sheet(in.ground));
  model.gravity.setZero();
  model.timestep = advise_timestep(model, 60).timestep;
  Solver solver(model);
  solver.insert(0, in.target + Vec3(0, 0, 1e-7 - lowest_point(in.shape, in.turn)), in.turn,
                {0, 0, -in.speed}, Vec3::Zero());
  double peak = 0;
  Vec3 place = Vec3::Zero();
  for (int k = 0; k < 200000; ++k) {
    solver.step();
    double force = 0;
    int points = 0;
    for (const Contact& c : solver.contacts()) {
      for (const ContactPointInfo& spot : c.points) points += spot.force > 0 ? 1 : 0;
      if (!(c.normal_force > peak)) {
        force += c.normal_force;
        continue;
      }
      force = peak = c.normal_force;
      place = c.position;
    }
    if (in.one_point && points > 1) return std::nullopt;
    if (peak > 0 && force < 1e-9 * peak && (in.floor == 0 || force == 0)) {
      const ParticleState& p = solver.particles();
      const Vec3 velocity =
          p.velocity[0] + p.angular_velocity[0].cross(Vec3(place - p.position[0]));
      return velocity.z() / in.speed;
    }
  }
  return std::nullopt;
}

std::vector<Check> small_floors() {
  constexpr int kMembers = 27;  // of each body, ground, floor and restitution
  scenes::Random random(2026);
  std::vector<Check> checks;
  const auto options = [](double stiffness) { return scenes::ice_options(0.05, stiffness, 1e-4); };
  for (const char* body :
       {"sphere", "box on a face", "box on an edge", "box on a corner", "crescent"}) {
    for (const ThinWall::Kind ground : {ThinWall::Kind::plane, ThinWall::Kind::mesh}) {
      LargestError worst(fmt::format("{} on a {}: rebound / e'", body,
                                     ground == ThinWall::Kind::plane ? "plane" : "mesh"),
                         0.01);
      for (int k = 0; k < kMembers; ++k) {
        FloorImpact in;
        in.e = 0.1 * (1 + k % 9);
        in.floor = std::array{0.0, 1e-6, 1e-3}[static_cast<std::size_t>(k / 9)];
        in.speed = random.uniform(0.2, 2);
        in.ground = {ground, 5e-3, 1, 0.6};
        in.target =
            Vec3(random.uniform(0.08, 0.12), random.uniform(0.08, 0.12), 0);  // within a triangle
        const double stiffness = std::pow(10, random.uniform(7.5, 8.5));
        const Vec3 size(random.uniform(10e-3, 30e-3), random.uniform(10e-3, 30e-3),
                        random.uniform(10e-3, 30e-3));
        const std::string kind = body;
        in.shape =
            kind == "sphere" ? make_sphere(size.x(), scenes::ice_options(0.05, stiffness, size.x()))
            : kind == "crescent"
                ? make_crescent(named_crescent("mass-matched", {}).parameters, options(stiffness))
                : make_box(size, options(stiffness));
        const double yaw = random.uniform(0, 360);
        in.turn = about(Vec3::UnitZ(), yaw);
        if (kind == "box on an edge")
          in.turn = in.turn * about(Vec3::UnitY(), random.uniform(20, 70));
        if (kind == "box on a corner")
          in.turn = in.turn * about(Vec3::UnitY(), random.uniform(20, 70)) *
                    about(Vec3::UnitX(), random.uniform(20, 70));
        in.one_point = kind == "crescent";
        std::optional<double> got;
        for (int tries = 0; tries < 20 && !got; ++tries) {
          if (in.one_point) in.turn = random.orientation();
          got = rebound(in);
          if (!in.one_point) break;
        }
        worst.add(got.value_or(0), restitution_with_floor(in.e, in.floor),
                  fmt::format("e {:.1f} lambda {:g} v {:.2f}", in.e, in.floor, in.speed));
      }
      checks.push_back(worst.check());
    }
  }
  return checks;
}

}  // namespace

std::vector<VerificationCase> impact_floor_cases() {
  return {
      {"impact.small_floors",
       "Spheres, boxes and crescents at random, with small unloading floors and none",
       "e'^2 = 1 - r (1 - lambda), r = (1 - e^2) / (1 - lambda e^2), of the place of contact",
       "Restitution 0.1 to 0.9, lambda 0, 1e-6 and 1e-3; bodies, places, speeds and stiffnesses "
       "at random. A point that has unloaded to no force but overlaps stays in contact.",
       Tier::quick, small_floors}};
}

}  // namespace firn::verification
