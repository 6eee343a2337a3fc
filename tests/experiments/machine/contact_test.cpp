// What bodies feel of machine parts: nothing of seams, and thin walls that hold under load.
#include <gtest/gtest.h>

#include "experiments/machine/parts.h"
#include "experiments/meshes/wall_solids.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

Boundary boundary_of(Solid part) {
  Boundary b;
  b.name = "part";
  b.material = scenes::kPlastic;
  b.rigid = true;
  b.kind = Boundary::Kind::solid;
  b.mesh = std::move(part.mesh);
  b.parts = std::move(part.parts);
  return b;
}

// One cube of 20 mm, its edges rounded by 1 mm, and a part.
Model cube_and(Solid part, double friction, double gravity = scenes::kGravity) {
  Model model = scenes::empty(scenes::law(friction, 0.3), scenes::law(friction, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, make_box(Vec3::Constant(20e-3),
                                                                 scenes::ice_options(0, 0, 1e-3))));
  model.boundaries.push_back(boundary_of(std::move(part)));
  model.gravity = {0, 0, -gravity};
  model.timestep = 1e-5;
  return model;
}

double settled(const Model& model) {  // m, overlap on a level floor
  return model.shapes[0].mass * -model.gravity.z() / model.shapes[0].stiffness;
}

// Slides the cube, square to the axes, from `from` with this velocity and returns where it is.
ParticleState slide(const Model& model, const Vec3& from, const Vec3& velocity, double duration) {
  Solver solver(model);
  const double sunk = std::min(settled(model), 0.8e-3);
  solver.insert(0, from + Vec3(0, 0, 10e-3 - sunk), Quat::Identity(), velocity, Vec3::Zero());
  scenes::run(solver, duration);
  return solver.particles();
}

struct Ride {
  const char* name;
  Solid part;
  Vec3 from, velocity;  // the floor is at z = 0
};

// Floors that are cut into several parts, each crossed at speed.
std::vector<Ride> rides() {
  Bucket split;  // into three strips, by its outlet
  split.outlet = Bucket::Outlet::floor;
  split.outlet_width = 60e-3;
  split.outlet_length = 60e-3;
  Container cup;  // into two halves
  cup.diameter = 120e-3;
  return {{"bucket", make_bucket(split), {0, -50e-3, 0}, {0, 0.5, 0}},
          {"bucket, aslant", make_bucket(split), {-50e-3, -50e-3, 0}, {0.2, 0.5, 0}},
          {"cup", make_container(cup), {0, -45e-3, 0}, {0.1, 0.4, 0}}};
}

TEST(MachineContact, SeamsOfAFloorAreNotFelt) {
  constexpr double kTime = 0.2;
  for (const Ride& ride : rides()) {
    const Model model = cube_and(ride.part, 0);
    const ParticleState end = slide(model, ride.from, ride.velocity, kTime);
    const Vec3 way = kTime * ride.velocity;
    EXPECT_NEAR(end.position[0].x(), ride.from.x() + way.x(), 1e-9) << ride.name;
    EXPECT_NEAR(end.position[0].y(), ride.from.y() + way.y(), 1e-9) << ride.name;
    // It rides in its own dent: 0.35 um.
    EXPECT_NEAR(end.position[0].z(), 10e-3 - settled(model), 0.1e-6) << ride.name;
    EXPECT_LT(end.angular_velocity[0].norm(), 1e-6) << ride.name;
  }
}

// With friction, as on one plane: a cube that is braced over a seam keeps its way.
TEST(MachineContact, FrictionIsThatOfOneFloor) {
  for (const Ride& ride : rides()) {
    const Model model = cube_and(ride.part, 0.2);
    Model plane = model;
    plane.boundaries[0].parts.clear();
    plane.boundaries[0].kind = Boundary::Kind::plane;
    const Vec3 there = slide(model, ride.from, ride.velocity, 0.15).position[0];
    const Vec3 wanted = slide(plane, ride.from, ride.velocity, 0.15).position[0];
    EXPECT_LT((there - wanted).norm(), 2e-3 * (wanted - ride.from).norm()) << ride.name;
  }
}

// A floor of 3 mm under a load that sinks the cube in by 1.2 mm, and more on the way: it rides over
// the seams and is not pushed through.
TEST(MachineContact, ThinFloorHoldsUnderLoad) {
  for (const Ride& ride : rides()) {
    Model model = cube_and(ride.part, 0);
    model.gravity *= 1.2e-3 / settled(model);
    const ParticleState end = slide(model, ride.from, ride.velocity, 0.2);
    const Vec3 way = 0.2 * ride.velocity;
    EXPECT_NEAR(end.position[0].x(), ride.from.x() + way.x(), 1e-6) << ride.name;
    EXPECT_NEAR(end.position[0].y(), ride.from.y() + way.y(), 1e-6) << ride.name;
    EXPECT_NEAR(end.position[0].z(), 10e-3 - settled(model), 0.6e-3) << ride.name;
  }
}

// A crescent let go in a cavity of the mold lies still on its arc, whatever strips it is made of.
TEST(MachineContact, CrescentRestsInItsCavity) {
  Mold mold;
  mold.cavities = 1;
  Model model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.2, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, scenes::crescent()));
  model.boundaries.push_back(boundary_of(make_mold(mold)));
  model.timestep = 1e-5;
  Solver solver(model);
  const Quat across(Eigen::AngleAxisd(90 * kDegToRad, Vec3::UnitZ()));
  const Vec3 frozen = across * model.shapes[0].centroid + Vec3(0, 0, water_line(mold.cube));
  solver.insert(0, frozen, across, Vec3::Zero(), Vec3::Zero());
  scenes::run(solver, 0.3);
  const ParticleState& state = solver.particles();
  EXPECT_LT(state.velocity[0].norm(), 0.02);
  // It has sunk by the clearance of 1 mm, and no farther.
  EXPECT_NEAR(state.position[0].z(), frozen.z() - mold.clearance, 0.3e-3);
  EXPECT_LT((state.position[0] - frozen).head<2>().norm(), 1.5e-3);
}

// Cubes thrown against blade and shaft from all sides stay outside.
TEST(MachineContact, AugerLetsNothingThrough) {
  Auger auger;
  auger.turns = 2;
  Model model = cube_and(make_auger(auger), 0.2, 0);
  const double sides = 24;
  for (int i = 1; i < sides; ++i) scenes::add_particles(model, 0);
  Solver solver(model);
  for (int i = 0; i < sides; ++i) {
    const Quat turn(Eigen::AngleAxisd(2 * EIGEN_PI * i / sides, Vec3::UnitX()));
    const double x = 0.11 * i / sides;
    solver.insert(i, turn * Vec3(x, 0.1, 0), turn, turn * Vec3(0.2, -2, 0.3), Vec3(3, 5, 2));
  }
  EXPECT_NO_THROW(scenes::run(solver, 0.15));
}

// The masks of patches repeat after 64 parts: a cube that leans on the 65th part of a boundary when
// it comes to lie on the first one does not take the side of the one for that of the other.
TEST(MachineContact, PartsBeyondTheSixtyFourthAreNotMistakenForEarlierOnes) {
  const auto block = [](const Vec3& lower, const Vec3& upper) {
    std::vector<HalfSpace> faces = box_half_spaces(upper - lower);
    for (HalfSpace& face : faces) face.offset += face.normal.dot(0.5 * (lower + upper));
    return convex_part(faces, 0);
  };
  Solid solid;
  solid.parts.push_back(block({-0.15, -0.05, -0.02}, {0.15, 0.05, 0}));  // a long floor
  for (int i = 1; i < 64; ++i) {
    solid.parts.push_back(block({0.01 * i, 1, 0}, {0.01 * i + 0.005, 1.01, 0.01}));
  }
  solid.parts.push_back(block({0.01, -0.05, 0}, {0.03, 0.05, 0.1}));  // and a wall on it
  Model model = cube_and(std::move(solid), 0);
  model.gravity = {3, 0, -scenes::kGravity};  // leans on the wall
  Solver solver(model);
  solver.insert(0, {0, 0, 10.2e-3}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  scenes::run(solver, 0.1);
  const Vec3 place = solver.particles().position[0];
  EXPECT_NEAR(place.x(), 0, 0.05e-3);
  EXPECT_NEAR(place.z(), 10e-3, 0.05e-3);
  EXPECT_LT(solver.diagnostics().largest_overlap, 0.2e-3);
}

}  // namespace
}  // namespace firn
