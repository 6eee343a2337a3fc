#include "firn/shape.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "solver/shapes/shape_builder.h"
#include "tests/support/dice.h"
#include "tests/support/error_of.h"

namespace firn {
namespace {

constexpr double kInch = 0.0254;

ShapeOptions ice(double rounding = -1) {
  ShapeOptions options;
  options.name = "ice";
  options.density = 916.7;
  options.young_modulus = 1e7;
  options.rounding = rounding;
  return options;
}

Shape named(const std::string& name, int facets) {
  CrescentParameters base;
  base.facets = facets;
  const NamedCrescent crescent = named_crescent(name, base);
  ShapeOptions options = ice();
  options.mass = crescent.mass;
  return make_crescent(crescent.parameters, options);
}

double core_volume(const Shape& shape) {
  double volume = 0;
  for (const auto& part : shape.parts) volume += mass_properties(surface_mesh(part)).volume;
  return volume;
}

TEST(Sphere, HasItsClosedForms) {
  const double r = 0.02;
  const Shape s = make_sphere(r, ice());
  EXPECT_DOUBLE_EQ(s.volume, 4.0 / 3 * std::numbers::pi * r * r * r);
  EXPECT_DOUBLE_EQ(s.mass, 916.7 * s.volume);
  EXPECT_LT((s.inertia - Vec3::Constant(0.4 * s.mass * r * r)).norm(), 1e-20);
  EXPECT_EQ(s.rounding, r);
  EXPECT_EQ(s.box, Vec3::Constant(2 * r));
  EXPECT_NEAR(s.bounding_radius, r, 1e-17);
  EXPECT_DOUBLE_EQ(s.stiffness_length, 2 * r);
  EXPECT_DOUBLE_EQ(s.stiffness, 1e7 * 2 * r);
  EXPECT_TRUE(inspect(s.mesh).is_valid());
  // Triangles of a drawn sphere lie inside it by their sagitta, and nowhere outside.
  EXPECT_GT(s.surface_deviation, 1e-3 * r);
  EXPECT_LT(s.surface_deviation, 5e-3 * r);
}

TEST(Box, HasItsClosedForms) {
  const Vec3 size(0.03, 0.02, 0.01);
  const Shape s = make_box(size, ice());
  EXPECT_DOUBLE_EQ(s.mass, 916.7 * 6e-6);
  const Vec3 squares = size.cwiseProduct(size);
  const Vec3 expected = s.mass / 12 * (Vec3::Constant(squares.sum()) - squares);
  EXPECT_LT((s.inertia - expected).norm(), 1e-14 * expected.norm());
  EXPECT_TRUE(s.shape_from_body.coeffs() == Quat::Identity().coeffs());
  EXPECT_DOUBLE_EQ(s.rounding, 2e-4);  // 2 % of the smallest edge
  EXPECT_DOUBLE_EQ(s.stiffness_length, 0.02);
  EXPECT_NEAR(s.bounding_radius, size.norm() / 2, 1e-16);
  EXPECT_THAT(s.part_neighbors, testing::ElementsAre(1u));
}

TEST(Box, DeviationIsThatOfARoundedCorner) {
  // The sphere of radius r in a corner stays sqrt(3) r - r away from it.
  const double rounding = 1e-3;
  const Shape s = make_box({0.03, 0.02, 0.01}, ice(rounding));
  EXPECT_NEAR(s.surface_deviation, (std::sqrt(3.0) - 1) * rounding, 1e-15);
}

TEST(Box, OptionsOverrideMassSizeAndStiffness) {
  ShapeOptions options = ice();
  options.mass = 2;
  options.stiffness_length = 0.5;
  EXPECT_DOUBLE_EQ(make_box({1, 1, 1}, options).stiffness, 1e7 * 0.5);
  options.stiffness = 123;
  const Shape s = make_box({1, 1, 1}, options);
  EXPECT_EQ(s.stiffness, 123);
  EXPECT_EQ(s.mass, 2);
  EXPECT_NEAR(s.inertia.x(), 2 / 6.0, 1e-15);
}

TEST(Box, ImpossibleOnesAreRefused) {
  EXPECT_THROW(make_box({1, 0, 1}, ice()), InputError);
  EXPECT_THROW(make_box({1, 1, 1}, ice(0.5)), InputError);
  EXPECT_THROW(make_box({1, 1, 1}, ShapeOptions{}), InputError);  // no mass
  EXPECT_THROW(make_sphere(-1, ice()), InputError);
}

TEST(PrincipalInertia, GivesBackTheTensorInARightHandedFrame) {
  const Mat3 turn = Quat(0.9, 0.1, -0.3, 0.2).normalized().toRotationMatrix();
  const Mat3 inertia = turn * Vec3(3, 1, 2).asDiagonal() * turn.transpose();
  const PrincipalInertia p = principal_inertia(inertia);
  const Mat3 axes = p.axes.toRotationMatrix();
  EXPECT_NEAR(axes.determinant(), 1, 1e-14);
  EXPECT_LT((axes * p.moments.asDiagonal() * axes.transpose() - inertia).norm(), 1e-14);
  // The frame is the one nearest to the given axes: a small turn stays a small turn.
  EXPECT_LT((axes - turn).norm(), 1e-13);
  EXPECT_LT((p.moments - Vec3(3, 1, 2)).norm(), 1e-14);
}

TEST(PrincipalInertia, NearlyIsotropicKeepsTheAxes) {
  Mat3 inertia = Mat3::Identity();
  inertia(0, 1) = inertia(1, 0) = 1e-9;
  EXPECT_TRUE(principal_inertia(inertia).axes.coeffs() == Quat::Identity().coeffs());
}

TEST(Convex, TurnedBoxHasTheInertiaAndPartOfTheBox) {
  const Vec3 size(0.03, 0.02, 0.01), place(1, 2, 3);
  const Quat turn = Quat(0.95, 0.1, -0.2, 0.15).normalized();
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i) {
    const Vec3 half(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5);
    corners.push_back(place + turn * half.cwiseProduct(size));
  }
  const Shape straight = make_box(size, ice(1e-3)), turned = make_convex(corners, ice(1e-3));
  EXPECT_NEAR(turned.mass, straight.mass, 1e-12 * straight.mass);
  EXPECT_LT((turned.inertia - straight.inertia).norm(), 1e-11 * straight.inertia.norm());
  EXPECT_LT((turned.centroid - place).norm(), 1e-14);
  EXPECT_LT(turned.shape_from_body.angularDistance(turn), 1e-11);
  ASSERT_EQ(turned.parts[0].vertex_count, 8);
  for (int i = 0; i < 8; ++i) {
    const Vec3 expected = size / 2 - Vec3::Constant(1e-3);
    EXPECT_LT((turned.parts[0].vertex(i).cwiseAbs() - expected).norm(), 1e-12);
  }
}

TEST(CrescentMesh, HasTheWantedFacets) {
  for (const auto& [wanted, made] :
       {std::pair{1272, 1272}, {68, 68}, {20, 20}, {300, 296}, {100000, 100012}}) {
    CrescentParameters p;
    p.facets = wanted;
    const TriangleMesh mesh = crescent_mesh(p);
    EXPECT_EQ(static_cast<int>(mesh.triangles.size()), made);
    EXPECT_TRUE(inspect(mesh).is_valid());
    const auto [lower, upper] = bounding_box(mesh);
    EXPECT_LT((upper - Vec3(p.chord / 2, p.width / 2, 0)).norm(), 1e-16);
    EXPECT_LT((lower - Vec3(-p.chord / 2, -p.width / 2, -p.depth)).norm(), 1e-16);
  }
}

TEST(CrescentMesh, PlainSegmentTendsToItsClosedForm) {
  // No dish, no draft: circular segment of chord c and sagitta h on a rectangle of height t.
  CrescentParameters p;
  p.top_concavity_depth = p.draft = 0;
  p.facets = 100000;
  const double h = p.depth - p.tip_height, r = (p.chord * p.chord / 4 + h * h) / (2 * h);
  const double angle = 2 * std::asin(p.chord / 2 / r);
  const double area = r * r / 2 * (angle - std::sin(angle)) + p.chord * p.tip_height;
  EXPECT_NEAR(mass_properties(crescent_mesh(p)).volume, area * p.width, 2e-5 * area * p.width);
}

TEST(NamedCrescent, Table1FillsItsBox) {
  const Shape s = named("table1", 1272);
  EXPECT_LT((s.box - kInch * Vec3(2.4, 0.81, 0.54)).norm(), 1e-16);
  EXPECT_NEAR(s.volume, 11.382e-6, 0.0005e-6);
  EXPECT_NEAR(s.mass, 10.43e-3, 0.005e-3);
  EXPECT_NEAR(s.inertia.x(), 4.68e-7, 0.005e-7);
  EXPECT_NEAR(s.inertia.y(), 2.41e-6, 0.005e-6);
  EXPECT_NEAR(s.inertia.z(), 2.64e-6, 0.005e-6);
  EXPECT_TRUE(s.shape_from_body.coeffs() == Quat::Identity().coeffs());
}

TEST(NamedCrescent, MassMatchedWeighsItsMassAtEveryFacetCount) {
  for (const auto& [facets, depth] : {std::pair{1272, 0.7010}, {68, 0.7106}}) {
    const Shape s = named("mass-matched", facets);
    EXPECT_NEAR(s.mass, 13.7e-3, 1e-12);
    EXPECT_NEAR(s.box.z(), depth * kInch, 0.00005 * kInch);
    EXPECT_NEAR(s.box.x(), 2.4 * kInch, 1e-16);
  }
  const Shape s = named("mass-matched", 1272);
  EXPECT_NEAR(s.inertia.x(), 7.23e-7, 0.005e-7);
  EXPECT_NEAR(s.inertia.y(), 3.27e-6, 0.005e-6);
  EXPECT_NEAR(s.inertia.z(), 3.44e-6, 0.005e-6);
}

TEST(NamedCrescent, HeavyOneHasTheBoxAndTheMass) {
  const Shape s = named("table1-mass-override", 1272);
  EXPECT_EQ(s.mass, 13.7e-3);
  EXPECT_NEAR(s.mass / s.volume, 1203.6, 0.05);
  EXPECT_THROW(named_crescent("table2", {}), InputError);
}

// Corners of the internal face of `part` whose normal is nearest to n.
std::vector<Vec3> seam(const ConvexPart& part, const Vec3& n) {
  const ConvexPart::Face* best = nullptr;
  for (const auto& face : part.faces) {
    if (face.internal && (!best || face.normal.dot(n) > best->normal.dot(n))) best = &face;
  }
  std::vector<Vec3> corners;
  for (int k = 0; best && k < best->count; ++k) {
    corners.push_back(part.vertex(part.face_vertices[best->first + k]));
  }
  return corners;
}

class CrescentParts : public testing::TestWithParam<std::tuple<int, double>> {
 protected:
  void SetUp() override {
    parameters.parts = std::get<0>(GetParam());
    rounding = std::get<1>(GetParam());
    shape = make_crescent(parameters, ice(rounding));
  }
  CrescentParameters parameters;
  double rounding = 0;
  Shape shape;
};

TEST_P(CrescentParts, NeighborsShareTheirSeamExactly) {
  ASSERT_EQ(static_cast<int>(shape.parts.size()), parameters.parts);
  for (int i = 0; i + 1 < parameters.parts; ++i) {
    const ConvexPart &left = shape.parts[i], &right = shape.parts[i + 1];
    const auto a = seam(left, Vec3::UnitX()), b = seam(right, -Vec3::UnitX());
    ASSERT_EQ(a.size(), b.size());
    ASSERT_GE(a.size(), 4u);
    for (const Vec3& p : a) {
      double nearest = 1;
      for (const Vec3& q : b) nearest = std::min(nearest, (p - q).norm());
      EXPECT_LT(nearest, 1e-15);
    }
    EXPECT_EQ(left.internal_normals.back(), -right.internal_normals.front());
  }
}

TEST_P(CrescentParts, NeighborsAreThoseNextToEachOther) {
  const std::uint64_t all = (std::uint64_t{1} << parameters.parts) - 1;
  for (int i = 0; i < parameters.parts; ++i) {
    const std::uint64_t three = i == 0 ? 3 : std::uint64_t{7} << (i - 1);
    EXPECT_EQ(shape.part_neighbors[i], three & all);
  }
  const auto given = shape.part_neighbors;
  find_neighboring_parts(shape);
  EXPECT_EQ(shape.part_neighbors, given);
}

TEST_P(CrescentParts, StayNearTheMesh) {
  // Flat pieces of dish and arc leave a distance; the sweep adds that of its rounded
  // corners: where three faces meet at right angles, sqrt(3) - 1 of its radius.
  const double flat = parameters.parts == 1 ? 0.7e-3 : parameters.parts < 4 ? 0.35e-3 : 0.09e-3;
  EXPECT_LT(shape.surface_deviation, flat + 0.8 * rounding);
}

INSTANTIATE_TEST_SUITE_P(OneToTwelve, CrescentParts,
                         testing::Combine(testing::Range(1, 13), testing::Values(1e-5, 1e-3)));

TEST(CrescentParts, FillTheMeshWhateverTheirNumber) {
  for (int parts = 1; parts <= 12; ++parts) {
    CrescentParameters p;
    p.parts = parts;
    const Shape s = make_crescent(p, ice(0));
    EXPECT_NEAR(core_volume(s), s.volume, 1e-4 * s.volume) << parts << " parts";
  }
}

TEST(CrescentParts, FlatTopIsCutUpright) {
  CrescentParameters p;
  p.top_concavity_depth = 0;
  p.parts = 3;
  const Shape s = make_crescent(p, ice(1e-3));
  for (const Vec3& n : s.parts[1].internal_normals) EXPECT_EQ(std::abs(n.x()), 1);
  EXPECT_NEAR(core_volume(make_crescent(p, ice(0))), s.volume, 1e-3 * s.volume);
}

TEST(CrescentHalf, BothMakeUpTheWhole) {
  using Half = CrescentParameters::Half;
  Dice dice(11);
  const auto whole_number = [&](int low, int high) {
    return static_cast<int>(dice(low, high + 0.999));
  };
  for (int trial = 0; trial < 12; ++trial) {
    CrescentParameters p;
    p.chord = dice(30e-3, 80e-3);
    p.width = dice(12e-3, 30e-3);
    p.depth = dice(8e-3, 14e-3);
    p.top_concavity_depth = std::max(0.0, dice(-1e-3, 2e-3));
    p.draft = dice(0, 0.1);
    p.facets = whole_number(20, 1500);
    p.parts = whole_number(1, 12);
    p.arc_segments = whole_number(2, 20);
    SCOPED_TRACE(testing::Message() << "trial " << trial << ", " << p.parts << " parts");
    const Shape whole = make_crescent(p, ice(2e-4));
    std::vector<Component> halves;
    double of_parts = 0;
    for (const Half half : {Half::left, Half::right}) {
      p.half = half;
      const Shape s = make_crescent(p, ice(2e-4));
      EXPECT_TRUE(inspect(s.mesh).is_valid()) << inspect(s.mesh).to_message();
      EXPECT_NEAR(s.mass, whole.mass / 2, 1e-12 * whole.mass);
      EXPECT_EQ(s.centroid.x() < 0, half == Half::left);
      EXPECT_EQ(static_cast<int>(s.parts.size()), (p.parts + 1) / 2);
      EXPECT_LT(s.surface_deviation, whole.surface_deviation + 1e-4);
      of_parts += core_volume(make_crescent(p, ice(0)));
      halves.push_back({s, {Mat3::Identity(), Vec3::Zero()}});
    }
    const Shape both = make_compound(halves, ice());
    EXPECT_LT((both.centroid - whole.centroid).norm(), 1e-15);
    EXPECT_LT((both.inertia - whole.inertia).norm(), 1e-12 * whole.inertia.norm());
    p.half = Half::none;
    const double volume = core_volume(make_crescent(p, ice(0)));
    EXPECT_NEAR(of_parts, volume, 1e-9 * volume);
  }
}

TEST(Crescent, ImpossibleOnesAreRefused) {
  const auto refused = [](auto change) {
    CrescentParameters p;
    change(p);
    EXPECT_THROW(make_crescent(p, ice()), InputError);
  };
  refused([](auto& p) { p.chord = 0; });
  refused([](auto& p) { p.tip_height = p.depth; });
  refused([](auto& p) { p.tip_height = 0; });
  refused([](auto& p) { p.depth = p.chord; });
  refused([](auto& p) { p.top_concavity_depth = p.depth; });
  refused([](auto& p) { p.draft = 1; });
  refused([](auto& p) { p.facets = 12; });
  refused([](auto& p) { p.parts = 65; });
  refused([](auto& p) { p.arc_segments = 0; });
}

TEST(Compound, TwoHalvesWeighAsTheWhole) {
  const Shape half = make_box({0.01, 0.024, 0.03}, ice(1e-4));
  const Quat turn = Quat(0.9, 0.2, -0.1, 0.3).normalized();
  const Mat3 axes = turn.toRotationMatrix();
  const Shape whole = make_compound(
      {{half, {axes, axes * Vec3(-0.005, 0, 0)}}, {half, {axes, axes * Vec3(0.005, 0, 0)}}}, ice());
  const Shape box = make_box({0.02, 0.024, 0.03}, ice(1e-4));
  EXPECT_NEAR(whole.mass, box.mass, 1e-15);
  EXPECT_NEAR(whole.volume, box.volume, 1e-18);
  EXPECT_LT((whole.inertia - box.inertia).norm(), 1e-10 * box.inertia.norm());
  EXPECT_LT(whole.centroid.norm(), 1e-16);
  EXPECT_NEAR(whole.bounding_radius, box.bounding_radius, 1e-15);
  // The union is convex, and so one part, in the compound's own principal axes.
  ASSERT_EQ(whole.parts.size(), 1u);
  EXPECT_THAT(whole.part_neighbors, testing::ElementsAre(1u));
  EXPECT_EQ(whole.parts[0].vertex_count, 8);
  EXPECT_LT(whole.parts[0].center.norm(), 1e-12);
  EXPECT_NEAR(whole.parts[0].thickness, 0.02, 1e-12);
}

TEST(Compound, UnequalSpheresFollowTheParallelAxesRule) {
  ShapeOptions light = ice(), heavy = ice();
  light.mass = 1;
  heavy.mass = 3;
  const double r = 0.1, d = 0.4;
  const Shape s = make_compound({{make_sphere(r, light), {Mat3::Identity(), {0, 0, 0}}},
                                 {make_sphere(r, heavy), {Mat3::Identity(), {d, 0, 0}}}},
                                ice());
  EXPECT_NEAR(s.centroid.x(), 0.75 * d, 1e-16);
  const double own = 0.4 * 4 * r * r, reduced = 1.0 * 3.0 / 4.0;
  EXPECT_LT((s.inertia - Vec3(own, own + reduced * d * d, own + reduced * d * d)).norm(), 1e-15);
  EXPECT_THAT(s.part_neighbors, testing::ElementsAre(1u, 2u));  // apart
  EXPECT_THROW(make_compound({}, ice()), InputError);
}

// Steps: an L (or a stair of more steps) of unit cells, extruded by one.
TriangleMesh stair(int steps) {
  TriangleMesh mesh;
  std::vector<std::pair<double, double>> outline = {{0, 0}};
  for (int i = 0; i < steps; ++i) {
    outline.emplace_back(steps - i, i);
    outline.emplace_back(steps - i, i + 1);
  }
  outline.emplace_back(0, steps);
  const int n = static_cast<int>(outline.size());
  for (const double z : {0.0, 1.0}) {
    for (const auto& [x, y] : outline) mesh.vertices.emplace_back(x, y, z);
  }
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.triangles.push_back({i, j, n + j});
    mesh.triangles.push_back({i, n + j, n + i});
    if (i > 0 && j > 0) {  // the outline is star-shaped about its first corner
      mesh.triangles.push_back({0, j, i});
      mesh.triangles.push_back({n, n + i, n + j});
    }
  }
  return mesh;
}

// The default: 2 % of the smallest edge, less where a sharp corner would deviate by more.
TEST(Rounding, DefaultKeepsEveryCornerNear) {
  EXPECT_DOUBLE_EQ(make_box({0.05, 0.02, 0.03}, ice()).rounding, 4e-4);
  for (const double height : {0.5, 1.0, 2.0, 8.0, 40.0}) {
    // A needle of a pyramid: the sharper its tip, the smaller the rounding.
    const Shape s = make_convex({{0.01, 0.01, 0},
                                 {-0.01, 0.01, 0},
                                 {-0.01, -0.01, 0},
                                 {0.01, -0.01, 0},
                                 {0, 0, 0.01 * height}},
                                ice());
    const double edge = s.box.minCoeff();
    EXPECT_LE(s.surface_deviation, 0.0181 * edge) << height;
    EXPECT_GT(s.rounding, 0) << height;
    EXPECT_LE(s.rounding, 0.02 * edge) << height;
  }
}

TEST(Rounding, DefaultOfCrescentsKeepsThemNear) {
  for (const char* name : {"table1", "mass-matched", "table1-mass-override"}) {
    const Shape s = named(name, 1272);
    EXPECT_LE(s.surface_deviation, 0.02 * s.box.minCoeff()) << name;
    EXPECT_GE(s.rounding, 0.01 * s.box.minCoeff()) << name;
  }
}

// Of the box diagonal: decompose() rounds corners to 2^-32 of it.
constexpr double kMeshRounding = 1e-9;

TEST(Mesh, ConvexOneIsASinglePart) {
  const Shape box = make_box({0.03, 0.02, 0.01}, ice(1e-3));
  const Shape s = make_mesh(box.mesh, ice(1e-3));
  ASSERT_EQ(s.parts.size(), 1u);
  EXPECT_EQ(s.parts[0].vertex_count, 8);
  EXPECT_NEAR(s.surface_deviation, box.surface_deviation, kMeshRounding * box.box.norm());
}

int cuts(const Shape& shape) {
  int count = 0;
  for (const auto& part : shape.parts) count += static_cast<int>(part.internal_normals.size());
  return count;
}

TEST(Mesh, StairsAreCutIntoTheirSteps) {
  for (int steps = 2; steps <= 5; ++steps) {
    const Shape s = make_mesh(stair(steps), ice(0));
    EXPECT_EQ(static_cast<int>(s.parts.size()), steps);
    EXPECT_NEAR(s.volume, steps * (steps + 1) / 2, 1e-14 * s.volume);
    EXPECT_NEAR(core_volume(s), s.volume, 4 * kMeshRounding * s.volume);
    EXPECT_LT(s.surface_deviation, kMeshRounding * s.box.norm());
  }
}

TEST(Mesh, SeamOfAnLIsACutOnOneSideOnly) {
  // The other side of the seam belongs to a face that is half surface.
  const double rounding = 0.01;
  const Shape s = make_mesh(stair(2), ice(rounding));
  EXPECT_EQ(cuts(s), 1);
  EXPECT_THAT(s.part_neighbors, testing::ElementsAre(3u, 3u));
  EXPECT_NEAR(s.surface_deviation, (std::sqrt(3.0) - 1) * rounding, 1e-6);
}

TEST(Mesh, CrescentAsAnyMeshIsCutAsWell) {
  const Shape s = make_mesh(crescent_mesh({}), ice(0));
  const Shape made = make_crescent({}, ice());
  EXPECT_LE(s.parts.size(), 4u);
  EXPECT_LT(s.surface_deviation, 0.02 * s.box.minCoeff());
  EXPECT_EQ(s.mass, made.mass);
  EXPECT_NEAR(core_volume(s), s.volume, 2e-2 * s.volume);
}

TEST(Mesh, OnePartIsTheHull) {
  ShapeOptions options = ice();
  options.max_parts = 1;
  const CrescentParameters p;
  const Shape s = make_mesh(crescent_mesh(p), options);
  ASSERT_EQ(s.parts.size(), 1u);
  // Deepest in the dish: the hull's flat top spans it. Samples lie within half a strip of there.
  EXPECT_NEAR(s.surface_deviation, p.top_concavity_depth, 0.01 * p.top_concavity_depth);
}

TEST(Mesh, TooManyTrianglesAreRefused) {
  CrescentParameters p;
  p.facets = 25000;
  EXPECT_THROW(make_mesh(crescent_mesh(p), ice()), InputError);
}

TEST(Mesh, UnsoundOneIsRefusedByItsDefects) {
  TriangleMesh mesh = stair(2);
  mesh.triangles.pop_back();
  EXPECT_THAT(test::error_of([&] { make_mesh(mesh, ice()); }), testing::HasSubstr("3 open edges"));
  EXPECT_THROW(make_mesh(TriangleMesh{}, ice()), InputError);
}

}  // namespace
}  // namespace firn
