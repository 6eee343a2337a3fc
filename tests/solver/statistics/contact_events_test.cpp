// Statistics of contacts against closed forms, and that they depend on nothing but the motion.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "solver/geometry/nearest_triangle.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

using std::numbers::pi;

// A sphere of 1 g over the plane z = 0, without gravity.
constexpr double kRadius = 0.01, kMass = 1e-3, kStiffness = 1e4;  // m, kg, N/m

Model sphere_over_plane(double friction, double restitution) {
  const Shape ball = make_sphere(kRadius, scenes::ice_options(kMass, kStiffness, kRadius));
  Interaction law = scenes::law(friction, restitution);
  law.minimum_unloading_ratio = 1e-6;
  Model model = scenes::body_on_plane(ball, law);
  model.gravity = Vec3::Zero();
  model.timestep = 1e-3 * std::sqrt(kMass / kStiffness);
  model.statistics.events = true;
  return model;
}

void run_for(Solver& solver, double duration) {
  const double end = solver.time() + duration;
  while (solver.time() < end) solver.step();
}

// The hysteretic spring loads for a quarter period of K and unloads for one of K / e^2: the peak is
// v sqrt(m K), and the impulse (1 + e) m v. What is left of the overlap then, 1 - e^2 of the
// largest, goes back at the speed e v under the floor of the law. The loss is (1 - e^2) m v^2 / 2.
TEST(Events, ImpactOfASphereHasTheClosedForms) {
  for (const double e : {0.3, 0.7, 1.0}) {
    const double v = 0.5;
    const Model model = sphere_over_plane(0, e);
    Solver solver(model);
    const Quat turned(Eigen::AngleAxisd(1.0, Vec3(1, 2, 3).normalized()));
    solver.insert(0, {0.3, 0.2, kRadius + 1e-5}, turned, {0, 0, -v}, Vec3::Zero());
    run_for(solver, 7 * std::sqrt(kMass / kStiffness));
    const std::vector<ContactEvent> events = solver.take_events();
    ASSERT_EQ(events.size(), 1u) << e;
    EXPECT_TRUE(solver.take_events().empty());
    EXPECT_TRUE(solver.open_events().empty());
    const ContactEvent& event = events[0];
    const double period = std::sqrt(kMass / kStiffness);
    EXPECT_EQ(event.a, 0);
    EXPECT_EQ(event.b, 1);
    EXPECT_NEAR(event.start, 1e-5 / v, 2 * model.timestep);
    EXPECT_NEAR(event.duration, ((1 + e) * pi / 2 + 1 / e - e) * period, 0.005 * period);
    EXPECT_NEAR(event.peak_time - event.start, pi / 2 * period, 0.005 * period);
    EXPECT_NEAR(event.peak_normal_force, v * std::sqrt(kMass * kStiffness),
                2e-3 * v * std::sqrt(kMass * kStiffness));
    EXPECT_EQ(event.peak_normal_force, solver.particles().peak_normal_force[0]);
    EXPECT_NEAR(event.normal_impulse, (1 + e) * kMass * v, 2e-3 * kMass * v);
    EXPECT_NEAR(event.impulse.z(), event.normal_impulse, 1e-12 * kMass);
    EXPECT_EQ(event.tangential_impulse, 0);
    EXPECT_NEAR(event.impact_velocity_normal, v, 1e-12);
    EXPECT_NEAR(event.impact_velocity_tangential, 0, 1e-12);
    EXPECT_NEAR(event.dissipated, 0.5 * kMass * v * v * (1 - e * e), 2e-3 * 0.5 * kMass * v * v);
    EXPECT_LT((event.normal + Vec3::UnitZ()).norm(), 1e-12);
    // The lowest point of the ball, wherever it is in its own axes.
    EXPECT_LT((event.position - Vec3(0.3, 0.2, 0)).norm(), 2e-4);
    EXPECT_LT((turned * event.position_on_a - Vec3(0, 0, -kRadius)).norm(), 2e-4);
    EXPECT_LT((event.position_on_b - event.position).norm(), 1e-12);
  }
}

// Friction that slides all the while takes mu times the normal impulse, across the approach.
TEST(Events, ObliqueImpactHasItsFriction) {
  constexpr double kMu = 0.1, kDown = 0.5, kAlong = 2;
  const Model model = sphere_over_plane(kMu, 0.5);
  Solver solver(model);
  solver.insert(0, {0, 0, kRadius + 1e-5}, Quat::Identity(), {kAlong, 0, -kDown}, Vec3::Zero());
  run_for(solver, 7 * std::sqrt(kMass / kStiffness));
  const std::vector<ContactEvent> events = solver.take_events();
  ASSERT_EQ(events.size(), 1u);
  const ContactEvent& event = events[0];
  EXPECT_NEAR(event.impact_velocity_normal, kDown, 1e-12);
  EXPECT_NEAR(event.impact_velocity_tangential, kAlong, 1e-12);
  EXPECT_NEAR(event.tangential_impulse, kMu * event.normal_impulse, 0.01 * event.normal_impulse);
  EXPECT_NEAR(event.impulse.x(), -event.tangential_impulse, 1e-12);
  EXPECT_NEAR(event.peak_friction, kMu * event.peak_normal_force, 1e-9 * event.peak_normal_force);
  const Energy energy = solver.energy();
  EXPECT_NEAR(event.dissipated, energy.dissipated_normal + energy.dissipated_friction,
              1e-12 * energy.kinetic);
}

// A ball that bounces is in one contact for the merge time, and in as many as it bounces without.
TEST(Events, ShortGapsAreMerged) {
  for (const double merge : {0.0, 0.5}) {
    Model model = sphere_over_plane(0, 0.8);
    model.gravity = {0, 0, -9.81};
    model.timestep *= 20;
    model.statistics.merge_gap = merge;
    Solver solver(model);
    solver.insert(0, {0, 0, kRadius + 1e-3}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
    run_for(solver, 0.1);
    std::vector<ContactEvent> events = solver.take_events();
    for (const ContactEvent& event : solver.open_events()) events.push_back(event);
    double impulse = 0;
    for (const ContactEvent& event : events) impulse += event.normal_impulse;
    if (merge > 0) {
      EXPECT_EQ(events.size(), 1u);
    } else {
      // It flies for 2 v / g between two bounces, v falling by 0.8 each time.
      EXPECT_GE(events.size(), 4u);
      EXPECT_NEAR(events[0].impact_velocity_normal, std::sqrt(2 * 9.81 * 1e-3), 1e-3);
      for (std::size_t k = 1; k < 4; ++k)
        EXPECT_NEAR(events[k].impact_velocity_normal / events[k - 1].impact_velocity_normal, 0.8,
                    0.05);
    }
    const double fallen = kMass * (9.81 * 0.1 + solver.particles().velocity[0].z());
    EXPECT_NEAR(impulse, fallen, 0.01 * fallen);
  }
}

// Crescents that fall into a box of planes.
Model small_box(int crescents, const Vec3& size = {0.14, 0.12, 0}) {
  Model model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.3, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, scenes::crescent()), crescents);
  scenes::add_box_of_planes(model, Vec3::Zero(), size);
  model.timestep = 1e-5;
  return model;
}

Solver filled(const Model& model, const Vec3& upper = {0.14, 0.12, 0.3}) {
  Solver solver(model);
  scenes::scatter(solver, 0, static_cast<int>(model.particles.size()), Vec3::Zero(), upper, 3);
  return solver;
}

bool same(const std::vector<ContactEvent>& a, const std::vector<ContactEvent>& b) {
  static_assert(sizeof(ContactEvent) == 8 + 9 * 8 + 5 * 24 + 8 + 8);  // no padding to compare
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), a.size() * sizeof(ContactEvent)) == 0;
}

bool same(const std::vector<LoadInterval>& a, const std::vector<LoadInterval>& b) {
  static_assert(sizeof(TriangleSums) == 9 * 8);
  return std::ranges::equal(a, b, [](const LoadInterval& x, const LoadInterval& y) {
    return x.start == y.start && x.end == y.end && x.triangles.size() == y.triangles.size() &&
           std::memcmp(x.triangles.data(), y.triangles.data(),
                       x.triangles.size() * sizeof(TriangleSums)) == 0;
  });
}

// All work of all contacts is in one of them, whatever the patches did meanwhile.
TEST(Events, HaveAllTheWorkOfContacts) {
  Model model = small_box(30);
  model.statistics.events = true;
  Solver solver = filled(model);
  scenes::run(solver, 0.4);
  const std::vector<ContactEvent> ended = solver.take_events(), open = solver.open_events();
  ASSERT_GT(ended.size(), 100u);
  ASSERT_GT(open.size(), 20u);
  double work = 0;
  Vec3 impulse = Vec3::Zero();
  for (const auto* events : {&ended, &open}) {
    for (const ContactEvent& e : *events) {
      work += e.dissipated;
      if (e.b >= 30) impulse += e.impulse;
      EXPECT_LE(e.peak_normal_force, solver.particles().peak_normal_force[e.a] * 8);
      EXPECT_GT(e.duration, 0);
      EXPECT_GE(e.peak_time, e.start);
      EXPECT_LE(e.peak_time, e.start + e.duration);
    }
  }
  const Energy energy = solver.energy();
  const double taken = energy.elastic + energy.dissipated_normal + energy.dissipated_friction;
  EXPECT_NEAR(work, taken, 1e-9 * taken);
  Vec3 momentum = Vec3::Zero();
  double mass = 0;
  for (int i = 0; i < 30; ++i) {
    const double m = model.shapes[0].mass;
    momentum += m * solver.particles().velocity[i];
    mass += m;
  }
  momentum -= mass * model.gravity * solver.time();
  // The last half kick has been given with the forces at the end, and the first without any.
  EXPECT_LT((impulse - momentum).norm(), 1e-3 * mass * 9.81 * solver.time());
}

TEST(Events, ChangeNothingOfTheMotion) {
  Model model = small_box(20);
  Solver plain = filled(model);
  model.statistics.events = true;
  Solver counted = filled(model);
  scenes::run(plain, 0.2);
  scenes::run(counted, 0.2);
  const auto a = plain.group_hashes(), b = counted.group_hashes();
  for (std::size_t k = 0; k < a.size(); ++k) {
    if (std::string(a[k].group) != "statistics") {
      EXPECT_EQ(a[k].hash, b[k].hash) << a[k].group;
    }
  }
  EXPECT_TRUE(plain.open_events().empty());
}

TEST(Statistics, AreTheSameForEveryNumberOfThreadsAndAcrossARestore) {
  Model model = small_box(300, {0.25, 0.2, 0});
  model.statistics.events = true;
  model.statistics.compressive_loads = true;
  model.statistics.energies = {1e-9, 5, 8};
  model.statistics.surfaces = {model.shapes[0].mesh};
  const TriangleMesh floor{{{0, 0, 0}, {0.25, 0, 0}, {0.25, 0.2, 0}, {0, 0.2, 0}},
                           {{0, 1, 2}, {0, 2, 3}}};
  model.statistics.monitored = {{0, subdivided(floor, 0.02)}};
  model.statistics.interval = 0.03;
  model.statistics.merge_gap = 1e-4;
  model.timestep = 2e-5;
  Solver whole = filled(model, {0.25, 0.2, 0.6});
  scenes::run(whole, 0.2);
  model.numerics.threads = 3;
  Solver shared = filled(model, {0.25, 0.2, 0.6});
  scenes::run(shared, 0.1);
  Solver resumed(model);
  resumed.restore(shared.save());
  scenes::run(shared, 0.1);
  scenes::run(resumed, 0.1);
  ASSERT_GT(whole.diagnostics().pairs, 1024u) << "one range of pairs says nothing of threads";
  EXPECT_EQ(whole.hash(), shared.hash());
  EXPECT_EQ(whole.hash(), resumed.hash());
  const std::vector<ContactEvent> events = whole.take_events();
  EXPECT_GT(events.size(), 100u);
  EXPECT_TRUE(same(events, shared.take_events()));
  EXPECT_TRUE(same(events, resumed.take_events()));
  EXPECT_TRUE(same(whole.open_events(), resumed.open_events()));
  const std::vector<LoadInterval> intervals = whole.take_load_intervals(true);
  EXPECT_EQ(intervals.size(), 7u);
  EXPECT_TRUE(same(intervals, shared.take_load_intervals(true)));
  EXPECT_TRUE(same(intervals, resumed.take_load_intervals(true)));
}

// They start where they are asked for, and end where they are not, in a state that continues.
TEST(Events, StartInAStateThatWasKeptWithoutThem) {
  Model model = small_box(10);
  Solver plain = filled(model);
  scenes::run(plain, 0.3);
  model.statistics.events = true;
  Solver counted(model);
  counted.restore(plain.save());
  EXPECT_TRUE(counted.open_events().empty());
  counted.step();
  ASSERT_FALSE(counted.open_events().empty());
  for (const ContactEvent& e : counted.open_events()) EXPECT_EQ(e.start, counted.time());
  plain.restore(counted.save());
  plain.step();
  EXPECT_TRUE(plain.open_events().empty());
}

// Deferred ones begin as in a state that was kept without them, whatever happens at that moment.
TEST(Statistics, DeferredOnesCountFromTheirStart) {
  Model model = small_box(30);
  model.statistics.events = true;
  model.statistics.compressive_loads = true;
  model.statistics.energies = {1e-9, 5, 8};
  Solver whole = filled(model);
  scenes::run(whole, 0.3);
  Model none = model;
  none.statistics = {};
  Solver plain = filled(none);
  scenes::run(plain, 0.3);
  Solver restored(model);
  restored.restore(plain.save());

  model.statistics.deferred = true;
  Solver deferred = filled(model);
  scenes::run(deferred, 0.3);
  EXPECT_TRUE(deferred.take_events().empty());
  EXPECT_TRUE(deferred.open_events().empty());
  EXPECT_GT(deferred.particles().peak_normal_force[0], 0);
  deferred.start_statistics();
  EXPECT_EQ(deferred.particles().peak_normal_force[0], 0);
  EXPECT_THROW(deferred.start_statistics(), std::logic_error);
  EXPECT_THROW(whole.start_statistics(), std::logic_error);
  Solver resumed(model);
  resumed.restore(deferred.save());
  for (Solver* solver : {&whole, &restored, &deferred, &resumed}) {
    solver->remove_boundary(0);
    solver->remove_particle(3);
    scenes::run(*solver, 0.2);
  }
  const std::vector<ContactEvent> events = deferred.take_events();
  EXPECT_GT(events.size(), 10u);
  EXPECT_TRUE(same(events, restored.take_events()));
  EXPECT_TRUE(same(events, resumed.take_events()));
  EXPECT_TRUE(same(deferred.open_events(), restored.open_events()));
  EXPECT_EQ(deferred.hash(), resumed.hash());
  for (std::size_t i = 0; i < 30; ++i) {
    EXPECT_EQ(deferred.compressive_loads()[i].load, restored.compressive_loads()[i].load) << i;
    EXPECT_LE(deferred.particles().peak_normal_force[i], whole.particles().peak_normal_force[i]);
  }
}

// A body that is taken away ends its contacts.
TEST(Events, EndWhenABodyIsRemoved) {
  Model model = small_box(10);
  model.statistics.events = true;
  model.statistics.threshold = 1e9;
  Solver solver = filled(model);
  scenes::run(solver, 0.3);
  ASSERT_FALSE(solver.open_events().empty());
  EXPECT_TRUE(solver.take_events().empty());  // none reaches the threshold
  for (int i = 0; i < 10; ++i) solver.remove_particle(i);
  solver.step();
  EXPECT_TRUE(solver.open_events().empty());
}

// A cube between two plates of which one comes nearer bears what they bear.
TEST(OpposedLoads, SqueezedCubeBearsTheForceOfThePlates) {
  constexpr double kEdge = 0.02, kRate = 1e-3;  // m, m/s
  const Shape cube = make_box(Vec3::Constant(kEdge), scenes::ice_options(0.008, 2e4, 5e-4));
  Model model = scenes::body_on_plane(cube, scenes::law(0.3, 0.3));
  model.gravity = Vec3::Zero();
  const int lid = scenes::add_plane(model, {0, 0, kEdge}, -Vec3::UnitZ());
  Motion down;
  down.velocity = {0, 0, -kRate};
  down.stop = 0.2;
  model.boundaries[lid].motions.push_back(down);
  model.timestep = 2e-5;
  model.statistics.compressive_loads = true;
  Solver solver(model);
  solver.insert(0, {0, 0, kEdge / 2}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  scenes::run(solver, 0.2);
  // Each contact has taken half of the way.
  const double force = 0.5 * 2e4 * kRate * 0.2;
  const CompressiveLoad& squeezed = solver.compressive_loads().at(0);
  EXPECT_NEAR(squeezed.load, force, 0.01 * force);
  EXPECT_LE(squeezed.load, solver.boundaries()[lid].peak_normal_force);
  EXPECT_NEAR(squeezed.load, solver.boundaries()[lid].peak_normal_force, 0.01 * force);
  EXPECT_NEAR(squeezed.time, 0.2, 0.01);
  EXPECT_EQ(squeezed.bodies[0] + squeezed.bodies[1], 1 + 2);
}

TEST(OpposedLoads, OneImpactHasNone) {
  Model model = sphere_over_plane(0.1, 0.3);
  model.statistics.events = false;
  model.statistics.compressive_loads = true;
  Solver solver(model);
  solver.insert(0, {0, 0, kRadius + 1e-5}, Quat::Identity(), {1, 0, -1}, Vec3::Zero());
  run_for(solver, 0.01);
  EXPECT_GT(solver.particles().peak_normal_force[0], 1);
  EXPECT_EQ(solver.compressive_loads().at(0).load, 0);
}

// The definition, word for word, at every step.
TEST(OpposedLoads, AreTheLargestOfAllPairsOfPatchesAndSteps) {
  Model model = small_box(20);
  model.statistics.compressive_loads = true;
  Solver solver = filled(model, {0.14, 0.12, 0.2});
  std::vector<double> expected(20, 0);
  struct Push {
    double force;
    Vec3 out;
  };
  for (int i = 0; i < 15000; ++i) {
    solver.step();
    std::vector<std::vector<Push>> pushes(20);
    for (const Contact& c : solver.contacts()) {
      pushes[c.a].push_back({c.normal_force, c.normal});
      if (c.b < 20) pushes[c.b].push_back({c.normal_force, -c.normal});
    }
    for (std::size_t p = 0; p < 20; ++p) {
      for (std::size_t a = 0; a < pushes[p].size(); ++a) {
        for (std::size_t b = 0; b < a; ++b) {
          const double load = std::min(pushes[p][a].force, pushes[p][b].force) *
                              -pushes[p][a].out.dot(pushes[p][b].out);
          expected[p] = std::max(expected[p], load);
        }
      }
    }
  }
  int loaded = 0;
  for (std::size_t p = 0; p < 20; ++p) {
    EXPECT_NEAR(solver.compressive_loads()[p].load, expected[p], 1e-12 * expected[p]) << p;
    loaded += expected[p] > 0;
  }
  EXPECT_GT(loaded, 10);
}

// A box about the origin.
TriangleMesh box_mesh(const Vec3& size) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back(
        Vec3(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5).cwiseProduct(size));
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

TEST(NearestTriangle, FindsTheNearestTriangleOfMany) {
  const TriangleMesh mesh = subdivided(box_mesh({0.1, 0.08, 0.02}), 0.013);
  double area = 0;
  Vec3 closed = Vec3::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    area += 0.5 * area_normal(mesh, t).norm();
    closed += area_normal(mesh, t);
    for (int k = 0; k < 3; ++k) {
      const auto& corners = mesh.triangles[t];
      EXPECT_LE((mesh.vertices[corners[k]] - mesh.vertices[corners[(k + 1) % 3]]).norm(), 0.013);
    }
  }
  EXPECT_NEAR(area, 2 * (0.1 * 0.08 + 0.1 * 0.02 + 0.08 * 0.02), 1e-12);
  EXPECT_LT(closed.norm(), 1e-12);
  const NearestTriangle index(mesh);
  scenes::Random random(5);
  for (int i = 0; i < 300; ++i) {
    const auto t = static_cast<std::size_t>(
        random.uniform(0, static_cast<double>(mesh.triangles.size()) - 1e-9));
    double a = random.uniform(0.01, 1), b = random.uniform(0.01, 1), c = random.uniform(0.01, 1);
    const auto& corners = mesh.triangles[t];
    const Vec3 normal = area_normal(mesh, t).normalized();
    const Vec3 place = (a * mesh.vertices[corners[0]] + b * mesh.vertices[corners[1]] +
                        c * mesh.vertices[corners[2]]) /
                       (a + b + c);
    EXPECT_EQ(index.nearest(place - 1e-6 * normal), static_cast<int>(t));
    // Deeper than the sheet's middle: the other side is nearer, but faces away.
    if (std::abs(normal.z()) > 0.5 && std::abs(place.x()) < 0.037 && std::abs(place.y()) < 0.027) {
      EXPECT_EQ(index.nearest(place - 0.012 * normal, normal), static_cast<int>(t));
    }
  }
}

// Corners and middles of edges have several nearest triangles, to the last bit or nearly.
TEST(NearestTriangle, AnswersTheSameWhateverTheGuess) {
  const TriangleMesh mesh = subdivided(box_mesh({0.1, 0.08, 0.02}), 0.013);
  const NearestTriangle index(mesh);
  const int count = static_cast<int>(mesh.triangles.size());
  scenes::Random random(6);
  for (int i = 0; i < 300; ++i) {
    const auto& corners = mesh.triangles[static_cast<std::size_t>(random.uniform(0, count - 1e-9))];
    Vec3 place = mesh.vertices[corners[0]];
    if (i % 3 == 1) place = 0.5 * (place + mesh.vertices[corners[1]]);
    if (i % 3 == 2) place += Vec3(random.uniform(-1, 1), random.uniform(-1, 1), 0) * 0.02;
    const Vec3 out(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const int expected = index.nearest(place, out);
    EXPECT_GE(area_normal(mesh, static_cast<std::size_t>(expected)).dot(out), 0);
    for (const int guess : {-7, 0, expected, count - 1, count, static_cast<int>(1e9)})
      EXPECT_EQ(index.nearest(place, out, guess), expected);
    for (int k = 0; k < 20; ++k)
      EXPECT_EQ(index.nearest(place, out, static_cast<int>(random.uniform(0, count))), expected);
  }
}

// A plate whose top is z = 0, turned about z, with the triangles of its top and sides.
Model over_plate(Model model, double edge) {
  const Vec3 size(0.3, 0.3, 0.02);
  const int plate = scenes::add_panel(model, "plate", Vec3(-0.15, -0.15, -0.02), {0.15, 0.15, 0});
  model.boundaries[plate].orientation = Quat(Eigen::AngleAxisd(0.3, Vec3::UnitZ()));
  model.statistics.monitored = {{plate, subdivided(box_mesh(size), edge)}};
  return model;
}

TriangleSums sum_of(const LoadInterval& interval) {
  TriangleSums all;
  for (const TriangleSums& t : interval.triangles) {
    all.normal_impulse += t.normal_impulse;
    all.tangential_impulse += t.tangential_impulse;
    all.impulse += t.impulse;
    all.peak = std::max(all.peak, t.peak);
    all.sliding_distance += t.sliding_distance;
    all.sliding_work += t.sliding_work;
    all.friction_work += t.friction_work;
  }
  return all;
}

// Together the triangles bear what the boundary bears, interval by interval.
TEST(TriangleLoads, AddUpToTheForceOnTheBoundary) {
  Model model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.3, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, scenes::crescent()), 25);
  model = over_plate(model, 0.02);
  model.timestep = 2e-5;
  model.statistics.interval = 0.05;
  Solver solver(model);
  scenes::scatter(solver, 0, 25, {-0.07, -0.07, 0}, {0.07, 0.07, 0.15}, 2);
  std::vector<LoadInterval> intervals;
  for (int k = 0; k < 5; ++k) {
    scenes::run(solver, 0.05);
    const std::vector<LoadInterval> ended = solver.take_load_intervals();
    ASSERT_EQ(ended.size(), 1u);
    const BoundaryState& plate = solver.boundaries()[0];
    EXPECT_NEAR(ended[0].start, 0.05 * k, 1e-12);
    EXPECT_NEAR(ended[0].end, 0.05 * (k + 1), 1e-12);
    const TriangleSums sum = sum_of(ended[0]);
    EXPECT_LT((plate.orientation * sum.impulse - plate.impulse).norm(),
              1e-12 * (1 + plate.impulse.norm()));
    // The plate is level: normal forces on its top are vertical.
    if (k > 0) {
      EXPECT_NEAR(sum.normal_impulse, -plate.impulse.z(), 0.05 * sum.normal_impulse);
      EXPECT_GT(sum.peak, 0);
      EXPECT_LE(sum.peak, 25 * plate.peak_normal_force);
    }
    solver.clear_boundary_loads();
  }
  EXPECT_TRUE(solver.take_load_intervals(true).empty());  // no step since
  solver.step();
  EXPECT_EQ(solver.take_load_intervals(true).size(), 1u);
}

// A block that slides to rest: Archard's F s is its weight times its way, and the work of friction
// its kinetic energy. The triangles under its way have it, and no others.
TEST(TriangleLoads, SlidingBlockWearsByItsWeightTimesItsWay) {
  constexpr double kEdge = 0.02, kMass = 0.008, kStiffness = 2e4, kMu = 0.3, kSpeed = 0.5;
  const Shape cube = make_box(Vec3::Constant(kEdge), scenes::ice_options(kMass, kStiffness, 5e-4));
  Model model = scenes::empty(scenes::law(kMu, 0.3), scenes::law(kMu, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, cube));
  model = over_plate(model, 0.01);
  model.boundaries[0].rigid = true;
  model.timestep = 1e-5;
  Solver solver(model);
  solver.insert(0, {-0.1, 0, 0.5 * kEdge - kMass * scenes::kGravity / kStiffness}, Quat::Identity(),
                {kSpeed, 0, 0.5 * scenes::kGravity * model.timestep}, Vec3::Zero());
  scenes::run(solver, 0.25);
  const double way = kSpeed * kSpeed / (2 * kMu * scenes::kGravity);
  EXPECT_NEAR(solver.particles().position[0].x(), -0.1 + way, 0.01 * way);
  const std::vector<LoadInterval> intervals = solver.take_load_intervals(true);
  ASSERT_EQ(intervals.size(), 1u);
  EXPECT_NEAR(intervals[0].end, 0.25, 1e-9);
  const TriangleSums sum = sum_of(intervals[0]);
  EXPECT_NEAR(sum.sliding_distance, way, 0.01 * way);
  EXPECT_NEAR(sum.sliding_work, kMass * scenes::kGravity * way,
              0.01 * kMass * scenes::kGravity * way);
  EXPECT_NEAR(sum.friction_work, 0.5 * kMass * kSpeed * kSpeed,
              0.01 * 0.5 * kMass * kSpeed * kSpeed);
  const TriangleMesh& mesh = model.statistics.monitored[0].mesh;
  const Mat3 turned = model.boundaries[0].orientation.toRotationMatrix();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (intervals[0].triangles[t].normal_impulse == 0) continue;
    EXPECT_GT(area_normal(mesh, t).normalized().z(), 0.99);
    Vec3 middle = Vec3::Zero();
    for (const int v : mesh.triangles[t]) middle += turned * mesh.vertices[v] / 3;
    EXPECT_LT(std::abs(middle.y()), kEdge / 2 + 0.01);
    EXPECT_GT(middle.x(), -0.1 - kEdge / 2 - 0.01);
    EXPECT_LT(middle.x(), -0.1 + way + kEdge / 2 + 0.01);
  }
}

TEST(EnergyBins, HaveEqualWidthsOnALogarithmicScale) {
  const EnergyBins classes{1e-6, 4, 3};
  EXPECT_EQ(classes.count(), 14);
  EXPECT_EQ(EnergyBins{}.count(), 0);
  EXPECT_EQ(classes.of(-1), 0);
  EXPECT_EQ(classes.of(0), 0);
  EXPECT_EQ(classes.of(0.99e-6), 0);
  EXPECT_EQ(classes.of(1e3), 13);
  EXPECT_NEAR(classes.lower_bound(13), 1e-3, 1e-12);
  for (int k = 1; k < 14; ++k) {
    EXPECT_EQ(classes.of(classes.lower_bound(k) * 1.0001), k);
    EXPECT_EQ(classes.of(classes.lower_bound(k) * 0.9999), k - 1);
  }
}

// Every ended contact is in one class of its kind, and on one triangle of each of its particles.
TEST(ContactSums, HaveEveryEndedContactOnce) {
  constexpr int kCount = 20;
  Model model = small_box(kCount);
  model.statistics.events = true;
  model.statistics.energies = {1e-9, 5, 8};
  model.statistics.surfaces = {subdivided(model.shapes[0].mesh, 0.01)};
  Solver solver = filled(model, {0.14, 0.12, 0.2});
  scenes::run(solver, 0.3);
  const std::vector<ContactEvent> events = solver.take_events();
  ASSERT_GT(events.size(), 50u);
  std::vector<EnergySums> expected(solver.energy_sums().size());
  const int classes = model.statistics.energies.count();
  double impulse = 0, peak = 0;
  std::uint64_t touches = 0;
  for (const ContactEvent& e : events) {
    const int kind = e.b < kCount ? 0 : 1 + e.b - kCount;
    EnergySums& sums = expected[kind * classes + model.statistics.energies.of(e.dissipated)];
    sums.dissipated += e.dissipated;
    ++sums.contacts;
    const int bodies = e.b < kCount ? 2 : 1;
    touches += bodies;
    impulse += bodies * e.normal_impulse;
    peak = std::max(peak, e.peak_normal_force);
  }
  std::size_t kinds_used = 0;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_EQ(solver.energy_sums()[k].contacts, expected[k].contacts);
    EXPECT_EQ(solver.energy_sums()[k].dissipated, expected[k].dissipated);
    kinds_used += expected[k].contacts > 0;
  }
  EXPECT_GT(kinds_used, 10u);
  SurfaceSums all;
  std::size_t hit = 0;
  for (const SurfaceSums& t : solver.surface_sums()) {
    all.contacts += t.contacts;
    all.normal_impulse += t.normal_impulse;
    all.peak_normal_force = std::max(all.peak_normal_force, t.peak_normal_force);
    hit += t.contacts > 0;
  }
  EXPECT_EQ(all.contacts, touches);
  EXPECT_NEAR(all.normal_impulse, impulse, 1e-12 * impulse);
  EXPECT_EQ(all.peak_normal_force, peak);
  EXPECT_GT(hit, 20u);
}

// A cube that is dropped on one of its faces is hit on the triangles of that face.
TEST(ContactSums, LieOnTheFaceThatIsHit) {
  const Shape cube = make_box(Vec3::Constant(0.02), scenes::ice_options(0.008, 2e4, 5e-4));
  Model model = scenes::body_on_plane(cube, scenes::law(0.3, 0.3));
  model.timestep = 1e-5;
  model.statistics.surfaces = {subdivided(cube.mesh, 0.005)};
  Solver solver(model);
  const Quat x_down(Eigen::AngleAxisd(pi / 2, Vec3::UnitY()));  // its +x looks down
  solver.insert(0, {0, 0, 0.0101}, x_down, {0, 0, -0.5}, Vec3::Zero());
  scenes::run(solver, 0.02);
  std::uint64_t contacts = 0;
  for (std::size_t t = 0; t < solver.surface_sums().size(); ++t) {
    if (solver.surface_sums()[t].contacts == 0) continue;
    contacts += solver.surface_sums()[t].contacts;
    EXPECT_GT(area_normal(model.statistics.surfaces[0], t).normalized().x(), 0.99);
  }
  EXPECT_EQ(contacts, 1u);
}

}  // namespace
}  // namespace firn
