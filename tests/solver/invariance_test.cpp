// What must not change a simulation: threads, interruptions, the frame of reference, the way a body
// is cut into parts; and what must never grow: its energy.
#include <gtest/gtest.h>

#include <cmath>

#include "validation/verification/scenes.h"

namespace firn {
namespace {

using scenes::kDegree;

// Crescents that fall into a closed box of planes.
Model small_box(int crescents, double restitution = 0.3) {
  Model model = scenes::empty(scenes::law(0.1, restitution), scenes::law(0.3, restitution));
  scenes::add_particles(model, scenes::add_shape(model, scenes::crescent()), crescents);
  scenes::add_box_of_planes(model, Vec3::Zero(), {0.14, 0.12, 0});
  model.timestep = 1e-5;
  return model;
}

Solver filled(const Model& model, double height, std::uint64_t seed) {
  Solver solver(model);
  const int count = static_cast<int>(model.particles.size());
  scenes::scatter(solver, 0, count, Vec3::Zero(), {0.14, 0.12, height}, seed);
  return solver;
}

TEST(Determinism, SameSeedGivesTheSameBytesAndAnotherDoesNot) {
  const Model model = small_box(20);
  std::vector<std::vector<std::byte>> states;
  for (const std::uint64_t seed : {7, 7, 8}) {
    Solver solver = filled(model, 0.25, seed);
    scenes::run(solver, 0.15);
    ASSERT_GT(solver.health().patches, 0u);
    states.push_back(solver.save());
  }
  EXPECT_TRUE(states[0] == states[1]);
  EXPECT_FALSE(states[0] == states[2]);
}

// 16 layers of 12 x 12 cubes land on each other: enough bodies, pairs and contacts that every phase
// of the step is shared out between threads.
std::vector<std::byte> falling_cubes(int threads) {
  constexpr int kSide = 12, kLayers = 16;
  constexpr double kEdge = 0.02, kPitch = 0.0201;
  Model model = scenes::empty(scenes::law(0.2, 0.3), scenes::law(0.2, 0.3));
  const Shape cube = make_box(Vec3::Constant(kEdge), scenes::ice_options(0.007, 2e5, 1e-3));
  scenes::add_particles(model, scenes::add_shape(model, cube), kSide * kSide * kLayers);
  scenes::add_plane(model, Vec3::Zero(), Vec3::UnitZ());
  model.timestep = 1e-5;
  model.numerics.threads = threads;
  Solver solver(model);
  scenes::Random random(3);
  for (int i = 0; i < kSide * kSide * kLayers; ++i) {
    const Vec3 cell(i % kSide, i / kSide % kSide, i / (kSide * kSide));
    const Vec3 speed(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-1, 0));
    solver.insert(i, kPitch * (cell + Vec3::Constant(0.5)), Quat::Identity(), speed, Vec3::Zero());
  }
  scenes::run(solver, 1e-3);
  EXPECT_GT(solver.health().patches, 1000u);
  return solver.save();
}

TEST(Determinism, AnyNumberOfThreadsGivesTheSameBytes) {
  const std::vector<std::byte> one = falling_cubes(1);
  for (const int threads : {2, 3, 4})
    EXPECT_TRUE(falling_cubes(threads) == one) << threads << " threads";
}

TEST(Checkpoint, RestoredSolverGoesOnBitForBit) {
  const Model model = small_box(20);
  Solver solver = filled(model, 0.25, 3);
  scenes::run(solver, 0.12);
  const std::vector<std::byte> saved = solver.save();
  scenes::run(solver, 0.05);

  Solver restored(model);
  restored.restore(saved);
  EXPECT_TRUE(restored.save() == saved);
  scenes::run(restored, 0.05);
  EXPECT_TRUE(restored.save() == solver.save());
  EXPECT_EQ(restored.hash(), solver.hash());
  EXPECT_EQ(restored.time(), solver.time());
  EXPECT_EQ(restored.energy().dissipated_friction, solver.energy().dissipated_friction);
}

TEST(Checkpoint, StateOfAnotherModelOrDamagedBytesAreRefused) {
  Solver solver = filled(small_box(3), 0.25, 3);
  scenes::run(solver, 0.01);
  std::vector<std::byte> saved = solver.save();
  Solver other(small_box(4));
  EXPECT_THROW(other.restore(saved), RunError);
  Model stiffer = small_box(3);
  stiffer.shapes[0].stiffness *= 2;
  Solver second(stiffer);
  EXPECT_THROW(second.restore(saved), RunError);
  saved.resize(saved.size() / 2);
  Solver same(small_box(3));
  EXPECT_THROW(same.restore(saved), RunError);
  EXPECT_THROW(same.restore({}), RunError);
}

// Seen in other axes, the same fall: positions after it, back in the first axes.
std::vector<Vec3> fall(const Mat3& axes, const Vec3& origin, int bodies, bool walls) {
  const bool mirrored = axes.determinant() < 0;
  // The mirror image of a body is a body of the same shape (a crescent is symmetric in x), turned.
  const Mat3 flip = mirrored ? Mat3(Vec3(-1, 1, 1).asDiagonal()) : Mat3(Mat3::Identity());
  Model model = scenes::empty(scenes::law(0.2, 0.3), scenes::law(0.3, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, scenes::crescent()), bodies);
  const double sides[4][3] = {{-1, 0, -0.2}, {1, 0.1, -0.3}, {0.1, 1, -0.4}, {0.05, -1, -0.3}};
  scenes::add_plane(model, origin, axes * Vec3::UnitZ());
  for (const auto& side : sides) {
    if (!walls) break;
    const Vec3 normal = -Vec3(side[0], side[1], side[2]).normalized();
    scenes::add_plane(model, axes * Vec3(-0.07 * normal) + origin, axes * normal);
  }
  model.gravity = axes * model.gravity;
  model.timestep = 1e-5;
  // The plain path: when a contact is found anew is itself decided to rounding.
  model.numerics.refresh_fraction = 0;
  Solver solver(model);
  scenes::Random random(11);
  for (int i = 0; i < bodies; ++i) {
    const Mat3 turn = axes * random.orientation().toRotationMatrix() * flip;
    const Vec3 at(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), 0.04 + 0.066 * i);
    const Vec3 spin(3, -2, 1 + i);
    solver.insert(i, axes * at + origin, Quat(turn), axes * Vec3(0.1, 0.2, -0.5),
                  axes.determinant() * (axes * spin));
  }
  scenes::run(solver, 0.2);
  EXPECT_GT(solver.health().patches, 0u);
  std::vector<Vec3> out;
  for (const Vec3& p : solver.particles().position) out.push_back(axes.transpose() * (p - origin));
  return out;
}

void expect_same(const std::vector<Vec3>& a, const std::vector<Vec3>& b, double tolerance) {
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_LT((a[i] - b[i]).norm(), tolerance) << "body " << i;
}

TEST(FrameOfReference, TranslatedSceneMovesAlike) {
  const Mat3 axes = Mat3::Identity();
  expect_same(fall(axes, {1.25, -3.5, 0.75}, 4, true), fall(axes, Vec3::Zero(), 4, true), 1e-6);
}

TEST(FrameOfReference, RotatedSceneMovesAlike) {
  const Mat3 turn(Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.5).normalized()));
  expect_same(fall(turn, Vec3::Zero(), 4, true), fall(Mat3::Identity(), Vec3::Zero(), 4, true),
              1e-6);
}

// The mirror image numbers vertices and parts the other way round, which decides between equally
// near features: two bodies that fall on a floor and on each other agree to 0.2 mm after 0.2 s. A
// friction or a spin of the wrong hand moves them by centimetres.
TEST(FrameOfReference, MirroredSceneMovesAlike) {
  const Mat3 mirror = Vec3(-1, 1, 1).asDiagonal();
  expect_same(fall(mirror, Vec3::Zero(), 2, false), fall(Mat3::Identity(), Vec3::Zero(), 2, false),
              2e-4);
}

// Nothing but gravity works on crescents in a box at rest: kinetic, potential and elastic energy
// together can only fall. Where a contact's touching set changes its springs are shared out anew,
// which may store a little: a thousandth of what is lost.
TEST(Energy, NeverGrowsInAClosedBox) {
  Solver solver = filled(small_box(30), 0.35, 5);
  double lowest = scenes::mechanical(solver.energy());
  const double start = lowest;
  double rises = 0;
  for (int i = 0; i < 4000; ++i) {
    scenes::run(solver, 1e-4);
    const double now = scenes::mechanical(solver.energy());
    if (now > lowest) rises += now - lowest;
    lowest = std::min(lowest, now);
  }
  const double lost = start - lowest;
  EXPECT_GT(lost, 0.1);
  EXPECT_LT(rises, 1e-3 * lost);
  // The books balance: what is gone is in the accounts of dissipation.
  const Energy e = solver.energy();
  EXPECT_NEAR(e.dissipated_normal + e.dissipated_friction, lost, 0.02 * lost);
  EXPECT_LT(solver.health().largest_overlap, 1e-3);
}

// A crescent dropped without spin or gravity, `down` (shape axes) first; its speed after 1 m/s.
double rebound(const Vec3& down, double restitution) {
  const Shape shape = scenes::crescent();
  Model model = scenes::body_on_plane(shape, scenes::law(0, restitution));
  model.gravity.setZero();
  model.timestep = 5e-6;
  Solver solver(model);
  const Quat turn = Quat::FromTwoVectors(down, -Vec3::UnitZ());
  double lowest = 0;
  for (const Vec3& vertex : shape.mesh.vertices)
    lowest = std::min(lowest, (turn * (vertex - shape.centroid)).z());
  solver.insert(0, {0, 0, shape.contact_deviation + 1e-5 - lowest}, turn, {0, 0, -1}, Vec3::Zero());
  scenes::run(solver, 0.01);
  return solver.particles().velocity[0].z();
}

// On its bottom and on its rim the contact is symmetric about the centre of mass, so the rebound is
// the restitution, floor included (0.3 -> 0.3014, 0.5 -> 0.5006).
TEST(Crescent, DroppedOnBottomOrRimReboundsWithTheRestitution) {
  for (const Vec3& down : {Vec3(0, 0, -1), Vec3(0, 0, 1)}) {
    SCOPED_TRACE(::testing::Message() << "down " << down.transpose());
    EXPECT_NEAR(rebound(down, 0.3), 0.3014, 3e-3);
    EXPECT_NEAR(rebound(down, 0.5), 0.5006, 3e-3);
  }
}

// On its leaning side the centre of the face is not below the centre of mass: the body turns a
// little and keeps somewhat less speed.
TEST(Crescent, DroppedFlatOnItsSideReboundsWithTheRestitution) {
  const double draft = CrescentParameters{}.draft;
  const Vec3 side(0, std::cos(draft), -std::sin(draft));
  EXPECT_NEAR(rebound(side, 0.3), 0.3014, 0.02);
}

// Two crescents, side face on side face with 10 um of overlap, after one step from rest: the
// impulse and its moment on the first, about its centre of mass.
struct Push {
  Vec3 impulse, moment;
};

Push side_on_side(int parts) {
  CrescentParameters p = named_crescent("mass-matched", {}).parameters;
  p.parts = parts;
  const Shape shape = scenes::crescent(p);
  Model model = scenes::empty(scenes::law(0, 0.3), scenes::law(0, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, shape), 2);
  model.gravity.setZero();
  model.timestep = 1e-6;
  Solver solver(model);
  // The second one lies upside down beside the first, so that the leaning sides are parallel.
  const Vec3 normal(0, std::cos(p.draft), -std::sin(p.draft));
  const Vec3 along = normal.cross(Vec3::UnitX());
  Pose second;
  second.rotation = Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX()).toRotationMatrix();
  second.translation =
      (p.width * std::cos(p.draft) - 10e-6) * normal + 12e-3 * Vec3::UnitX() + 3e-3 * along;
  const Pose first;
  solver.insert(0, scenes::center_of_mass(shape, first), Quat(first.rotation), Vec3::Zero(),
                Vec3::Zero());
  solver.insert(1, scenes::center_of_mass(shape, second), Quat(second.rotation), Vec3::Zero(),
                Vec3::Zero());
  solver.step();
  const Mat3 axes = shape.shape_from_body.toRotationMatrix();
  const Mat3 inertia = axes * shape.inertia.asDiagonal() * axes.transpose();
  return {shape.mass * solver.particles().velocity[0],
          inertia * solver.particles().angular_velocity[0]};
}

// Force within 0.5 % and torque within 1.5 % of the uncut body's, however many parts.
TEST(Crescent, ForceDoesNotDependOnTheNumberOfParts) {
  const Push reference = side_on_side(2);
  ASSERT_GT(reference.impulse.norm(), 0);
  for (const int parts : {3, 4, 6, 12}) {
    SCOPED_TRACE(parts);
    const Push push = side_on_side(parts);
    EXPECT_LT((push.impulse - reference.impulse).norm(), 5e-3 * reference.impulse.norm());
    EXPECT_LT((push.moment - reference.moment).norm(), 1.5e-2 * reference.moment.norm());
  }
}

}  // namespace
}  // namespace firn
