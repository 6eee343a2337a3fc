// An ice cube falls onto a plastic floor: prints its height until it lies still.
#include <firn/solver.h>

#include <cstdio>

using namespace firn;

int main() {
  Model model;  // SI units throughout
  model.materials = {{"ice", 916.7, 1e7, 0.33}, {"plastic", 0, 2e9, 0.35}};
  Interaction law;
  law.static_friction = law.dynamic_friction = 0.1;
  law.restitution = 0.3;
  model.interactions.assign(4, law);

  ShapeOptions ice;
  ice.name = "cube";
  ice.density = model.materials[0].density;
  ice.young_modulus = model.materials[0].young_modulus;
  model.shapes = {make_box(Vec3(0.03, 0.02, 0.02), ice)};
  model.particles = {Particle{}};

  Boundary floor;  // the half-space z <= 0
  floor.name = "floor";
  floor.material = 1;
  model.boundaries = {floor};
  model.timestep = advise_timestep(model, 10).timestep;

  Solver solver(model);
  const Quat tilted(Eigen::AngleAxisd(0.4, Vec3::UnitY()));
  solver.insert(0, Vec3(0, 0, 0.1), tilted, Vec3::Zero(), Vec3::Zero());

  const double every = 0.1, end = 1;  // s
  double next = 0;
  while (solver.time() < end) {
    if (solver.time() >= next) {
      std::printf("t = %.2f s  height %6.2f mm  speed %.3f m/s\n", solver.time(),
                  1e3 * solver.particles().position[0].z(), solver.particles().velocity[0].norm());
      next += every;
    }
    solver.step();
  }
  std::printf("at rest at %.2f mm\n", 1e3 * solver.particles().position[0].z());
}
