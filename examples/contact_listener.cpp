// Listens to the contacts of two cubes that are stacked: prints each new touch, and in the end who
// bears whom.
#include <firn/solver.h>

#include <cstdio>
#include <map>
#include <set>
#include <utility>

using namespace firn;

int main() {
  Model model;  // SI units throughout
  model.materials = {{"ice", 916.7, 1e7, 0.33}};
  Interaction law;
  law.static_friction = law.dynamic_friction = 0.2;
  law.restitution = 0.3;
  model.interactions = {law};
  ShapeOptions ice;
  ice.name = "cube";
  ice.density = 916.7;
  ice.young_modulus = 1e7;
  model.shapes = {make_box(Vec3(0.03, 0.03, 0.02), ice)};
  model.particles = {Particle{}, Particle{}};
  Boundary floor;
  floor.name = "floor";
  model.boundaries = {floor};
  model.timestep = advise_timestep(model, 10).timestep;

  Solver solver(model);
  solver.insert(0, Vec3(0, 0, 0.012), Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  solver.insert(1, Vec3(0.005, 0, 0.036), Quat::Identity(), Vec3::Zero(), Vec3::Zero());

  const auto name = [&](int body) {  // bodies above the particles are boundaries
    const int particles = static_cast<int>(model.particles.size());
    return body < particles ? "cube " + std::to_string(body)
                            : model.boundaries[static_cast<std::size_t>(body - particles)].name;
  };
  std::set<std::pair<int, int>> touching;
  std::map<std::pair<int, int>, double> impulse;  // N s, over the last half second
  const double begin = 0.5, end = 1;              // s
  while (solver.time() < end) {
    solver.step();
    std::set<std::pair<int, int>> now;
    for (const Contact& c : solver.contacts()) {
      if (c.normal_force <= 0) continue;
      if (now.insert({c.a, c.b}).second && !touching.contains({c.a, c.b}))
        std::printf("t = %.4f s  %s touches %s: %.3f N\n", solver.time(), name(c.a).c_str(),
                    name(c.b).c_str(), c.normal_force);
      if (solver.time() > begin) impulse[{c.a, c.b}] += c.normal_force * model.timestep;
    }
    touching = std::move(now);
  }
  for (const auto& [pair, sum] : impulse)
    std::printf("%s on %s: mean %.4f N\n", name(pair.first).c_str(), name(pair.second).c_str(),
                sum / (end - begin));
  std::printf("weight of a cube: %.4f N\n", 9.81 * model.shapes[0].mass);
}
