// Stacks and arches.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "validation/verification/assemblies/cases.h"
#include "validation/verification/assemblies/structure_cases.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn::verification {

Check stands(std::string what, double fall, double limit) {
  return {.what = std::move(what),
          .measured = fall,
          .expected = limit,
          .bound = Bound::at_most,
          .unit = "m"};
}

Check falls(std::string what, double fall, double limit) {
  return {.what = std::move(what),
          .measured = fall,
          .expected = limit,
          .bound = Bound::at_least,
          .unit = "m"};
}

namespace {

using namespace scenes;

// Ten cubes of 1 kg and 0.1 m on a rigid floor.
constexpr int kCubes = 10;
constexpr double kCubeEdge = 0.1, kCubeStiffness = 1e7;

Model cubes_model(double restitution) {
  Model model = empty(law(0.5, restitution), law(0.5, restitution));
  const Shape cube =
      make_box(Vec3::Constant(kCubeEdge), ice_options(1, kCubeStiffness, kCubeEdge / 50));
  add_particles(model, add_shape(model, cube), kCubes);
  add_plane(model, Vec3::Zero(), Vec3::UnitZ());
  return model;
}

// Weight above interface k, N: 0 is the floor.
double interface_load(int k) { return (kCubes - k) * kGravity; }

// Elastic cubes set down with exactly the overlaps that bear them: the largest force on a cube
// is that on its lower face. A body is placed before its contacts are known, so that only gravity
// acts in its first half step: v = g dt / 2, which rings with v sqrt(k m) in every
// spring.
std::vector<Check> loaded_stack() {
  Model model = cubes_model(1);
  model.timestep = 1e-6;
  Solver solver(model);
  double z = -0.5 * kCubeEdge;
  for (int k = 0; k < kCubes; ++k) {
    const double stiffness = k == 0 ? kCubeStiffness : kCubeStiffness / 2;  // in series
    z += kCubeEdge - interface_load(k) / stiffness;
    solver.insert(k, {0, 0, z}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  }
  constexpr double kTime = 0.05;
  run(solver, kTime);
  const double ring = 2 * 0.5 * kGravity * model.timestep * std::sqrt(kCubeStiffness);
  std::vector<Check> checks;
  for (int k = 0; k < kCubes; ++k) {
    checks.push_back({.what = fmt::format("largest force on cube {}, at its lower face", k + 1),
                      .measured = solver.particles().peak_normal_force[k],
                      .expected = interface_load(k),
                      .tolerance = ring,
                      .bound = Bound::absolute,
                      .unit = "N"});
  }
  checks.push_back({.what = "impulse on the floor / time",
                    .measured = -solver.boundaries()[0].impulse.z() / kTime,
                    .expected = interface_load(0),
                    .tolerance = ring,
                    .bound = Bound::absolute,
                    .unit = "N"});
  return checks;
}

// Inelastic cubes dropped on each other by 20 micrometers: forces at the interfaces, averaged over
// one second; that of the lowest interface also from the floor's impulse and the momentum.
std::vector<Check> dropped_stack() {
  Model model = cubes_model(0.3);
  model.timestep = 1e-5;
  Solver solver(model);
  for (int k = 0; k < kCubes; ++k) {
    solver.insert(k, {0, 0, (k + 0.5) * kCubeEdge + (k + 1) * 20e-6}, Quat::Identity(),
                  Vec3::Zero(), Vec3::Zero());
  }
  run(solver, 0.5);
  const auto momentum = [&] {
    double sum = 0;  // of 1 kg each
    for (const Vec3& v : solver.particles().velocity) sum += v.z();
    return sum;
  };
  const double before = momentum();
  solver.clear_boundary_loads();
  constexpr double kTime = 1;
  constexpr int kSamples = 5000;
  std::vector<double> force(kCubes, 0);
  for (int i = 0; i < kSamples; ++i) {
    run(solver, kTime / kSamples);
    for (const Contact& c : solver.contacts()) {
      // With the floor, whose number follows those of the cubes, or with the next cube up.
      force[c.b == kCubes ? 0 : c.b] += c.normal_force / kSamples;
    }
  }
  std::vector<Check> checks;
  for (int k = 0; k < kCubes; ++k) {
    checks.push_back({.what = k == 0 ? "mean force on the floor"
                                     : fmt::format("mean force between cubes {} and {}", k, k + 1),
                      .measured = force[k],
                      .expected = interface_load(k),
                      .tolerance = 2e-3 * interface_load(0),
                      .bound = Bound::absolute,
                      .unit = "N"});
  }
  checks.push_back(
      {.what = "impulse on the floor / time, compared with weight and gain of momentum",
       .measured = -solver.boundaries()[0].impulse.z() / kTime,
       .expected = interface_load(0) + (momentum() - before) / kTime,
       .tolerance = 2 * model.timestep / kTime * interface_load(0),
       .bound = Bound::absolute,
       .unit = "N"});
  const ParticleState& now = solver.particles();
  checks.push_back({.what = "kinetic energy of the ring that stays",
                    .measured = solver.energy().kinetic,
                    .expected = kCubes * kGravity * 20e-6,
                    .bound = Bound::at_most,
                    .unit = "J"});
  checks.push_back(
      {.what = "top cube off the axis",
       .measured = std::hypot(now.position[kCubes - 1].x(), now.position[kCubes - 1].y()),
       .expected = 1e-6,
       .bound = Bound::at_most,
       .unit = "m"});
  return checks;
}

// Blocks of 1 kg that overhang the edge of a table, each the next one below by `fraction` L / (2
// i), i from the top, set down with the overlaps that their weights make on the mean. Returns how
// far the top one has come down after a second.
constexpr double kBlockLength = 0.1, kBlockHeight = 0.02, kBlockRounding = 2e-5;  // m

double overhang_fall(int blocks, double fraction) {
  constexpr double kStiffness = 1e9;
  Model model = empty(law(0.6, 0.3), law(0.6, 0.3));
  const Shape block = make_box({kBlockLength, kBlockLength, kBlockHeight},
                               ice_options(1, kStiffness, kBlockRounding));
  add_particles(model, add_shape(model, block), blocks);
  // The table ends at x = 0; blocks reach beyond it towards +x.
  const int table = add_panel(model, "table", {-0.5, -0.2, -0.1}, {0, 0.2, 0}, kBlockRounding);
  model.boundaries[table].rigid = true;
  model.timestep = advise_timestep(model, 8).timestep;
  Solver solver(model);
  double reach = 0, sunk = 0;  // of the right end of the block in hand, and its overlaps
  for (int level = 0; level < blocks; ++level) {
    reach += fraction * 0.5 * kBlockLength / (blocks - level);
    sunk += (blocks - level) * kGravity / (level == 0 ? kStiffness : kStiffness / 2);
    solver.insert(level, {reach - kBlockLength / 2, 0, (level + 0.5) * kBlockHeight - sunk},
                  Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  }
  const double before = solver.particles().position[blocks - 1].z();
  run(solver, 1);
  return before - solver.particles().position[blocks - 1].z();
}

std::vector<Check> overhangs(const std::vector<int>& counts, const std::vector<double>& below,
                             const std::vector<double>& above) {
  std::vector<Check> checks;
  for (const int blocks : counts) {
    for (const double f : below) {
      checks.push_back(
          stands(fmt::format("{} blocks at {} of the greatest: top sinks by", blocks, f),
                 overhang_fall(blocks, f), 1e-4));
    }
    for (const double f : above) {
      checks.push_back(
          falls(fmt::format("{} blocks at {} of the greatest: top falls by", blocks, f),
                overhang_fall(blocks, f), kBlockHeight));
    }
  }
  return checks;
}

// Ten deeply dished crescents, each lying in (or, turned over, on) the one below, off by up to 0.1
// mm. Reports how far any of them goes after the pile has sat down.
std::vector<Check> nested_pile() {
  constexpr int kCount = 10;
  std::vector<Check> checks;
  for (const bool turned_over : {false, true}) {
    CrescentParameters p;
    p.top_concavity_depth = 10e-3;
    p.draft = 0;
    Model model = empty(law(0.1, 0.3), law(0.1, 0.3));
    const int shape = add_shape(model, crescent(p));
    add_particles(model, shape, kCount);
    add_plane(model, Vec3::Zero(), Vec3::UnitZ(), false);
    model.timestep = advise_timestep(model, 8).timestep;
    Solver solver(model);
    const Quat turn(Eigen::AngleAxisd(turned_over ? std::numbers::pi : 0, Vec3::UnitX()));
    Random random(3);
    constexpr double kStep = 1e-5;  // m
    for (int i = 0; i < kCount; ++i) {
      Vec3 at(random.uniform(-1e-4, 1e-4), random.uniform(-1e-4, 1e-4), 0.02 * (i + 1));
      while (!solver.overlaps(shape, at - kStep * Vec3::UnitZ(), turn, 0)) at.z() -= kStep;
      solver.insert(i, at, turn, Vec3::Zero(), Vec3::Zero());
    }
    run(solver, 0.5);
    const std::vector<Vec3> before = solver.particles().position;
    run(solver, 0.5);
    double moved = 0;
    for (int i = 0; i < kCount; ++i) {
      moved = std::max(moved, (solver.particles().position[i] - before[i]).norm());
    }
    const std::string what = turned_over ? "turned over: " : "upright: ";
    const double weight = kCount * model.shapes[shape].mass * kGravity;
    checks.push_back({.what = what + "largest displacement from 0.5 to 1 s",
                      .measured = moved,
                      .expected = 10e-6,
                      .bound = Bound::at_most,
                      .unit = "m"});
    checks.push_back({.what = what + "kinetic energy",
                      .measured = solver.energy().kinetic,
                      .expected = weight * 1e-6,
                      .bound = Bound::at_most,
                      .unit = "J"});
  }
  return checks;
}

}  // namespace

std::vector<VerificationCase> structure_cases() {
  std::vector<VerificationCase> cases = {
      {.name = "structure.loaded_stack",
       .title = "Ten cubes set down under load",
       .reference = "interface forces 98.10, 88.29 ... 9.81 N: the weight of 1 kg cubes above",
       .remark = "Elastic springs, set down with the overlap of their load. A body's first half "
                 "step has gravity alone, since its contacts are not known before: it leaves with "
                 "g dt / 2, which rings; the tolerance is twice the force g dt / 2 sqrt(K m) of "
                 "one spring that rings so.",
       .tier = Tier::quick,
       .run = loaded_stack},
      {.name = "structure.dropped_stack",
       .title = "Ten cubes dropped on each other",
       .reference =
           "each interface bears the weight above it in the mean, 98.10, 88.29 ... 9.81 N; "
           "the floor's impulse is weight times time and the gain of momentum",
       .remark =
           "The law reloads without loss below the largest force so far, so that a stack that "
           "nothing tilts keeps a longitudinal ring of micrometers for good (its energy is "
           "bounded by the drop's): means over a second, to 0.2 % of the "
           "weight, what a ring of 4 mm/s can carry across its ends. Floor impulse and momentum "
           "agree to two steps of the window.",
       .tier = Tier::quick,
       .run = dropped_stack},
      {.name = "structure.nested_pile",
       .title = "Pile of ten nested crescents",
       .reference = "at rest: no motion",
       .remark =
           "Concave bodies that touch along whole faces, friction 0.1. 10 micrometers in half a "
           "second allow for what a ring of the elastic springs moves; a kinetic energy of the "
           "weight times a micrometer likewise.",
       .tier = Tier::quick,
       .run = nested_pile},
      {.name = "structure.overhang",
       .title = "Overhang of four blocks",
       .reference = "(L / 2)(1 + 1/2 + 1/3 + 1/4) = 1.041667 L",
       .remark = "3 % on either side; structure.greatest_overhang is closer.",
       .tier = Tier::quick,
       .run = [] { return overhangs({4}, {0.97}, {1.03}); }},
      {.name = "structure.greatest_overhang",
       .title = "Greatest overhang of a pile of blocks",
       .reference = "(L / 2) sum 1 / i: all interfaces tip at once",
       .remark =
           "Edges are rounded by 2e-4 L, so that the rigid limit is 0.9996. Blocks of 1 kg with "
           "K = 1e9 N/m stand at 0.998 and fall from 0.9995 on (2 and 3 blocks stand at 0.999); at "
           "1e8 N/m they stand at 0.995: setting down costs a tilt of overlap / L, and an "
           "overlap that comes at once rocks by twice that.",
       .tier = Tier::full,
       .run = [] {
         return overhangs({2, 3, 4, 6}, {0.97, 0.99, 0.998}, {1.002, 1.01, 1.03});
       }}};
  for (VerificationCase& arch : arch_cases()) cases.push_back(std::move(arch));
  return cases;
}

}  // namespace firn::verification
