#include "firn/shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "solver/shapes/shape_builder.h"

namespace firn {

PrincipalInertia principal_inertia(const Mat3& inertia) {
  const Vec3 products(inertia(0, 1), inertia(1, 2), inertia(2, 0));
  if (products.cwiseAbs().maxCoeff() <= 1e-7 * inertia.trace()) {
    return {Quat::Identity(), inertia.diagonal()};
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(inertia);
  // Each principal axis gets the place and sense of the given axis it is nearest to.
  std::array<int, 3> order = {0, 1, 2}, best = order;
  const auto closeness = [&eigen](const std::array<int, 3>& o) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += std::abs(eigen.eigenvectors()(k, o[k]));
    return sum;
  };
  while (std::next_permutation(order.begin(), order.end())) {
    if (closeness(order) > closeness(best) + 1e-9) best = order;
  }
  PrincipalInertia result;
  Mat3 axes;
  for (int k = 0; k < 3; ++k) {
    const Vec3 axis = eigen.eigenvectors().col(best[k]);
    axes.col(k) = axis(k) < 0 ? Vec3(-axis) : axis;
    result.moments(k) = eigen.eigenvalues()(best[k]);
  }
  if (axes.determinant() < 0) {
    int least = 0;
    for (int k = 1; k < 3; ++k) {
      if (axes(k, k) < axes(least, least)) least = k;
    }
    axes.col(least) *= -1;
  }
  result.axes = Quat(axes).normalized();
  return result;
}

namespace {

// Rejects shapes thinner than the tolerances of a convex part.
void reject_degenerate_shape(const Vec3& moments) {
  constexpr double kThinnest = 1e-5;
  // Second moments along the axes: the square of the thickness over 12 for a plate.
  const Vec3 along = Vec3::Constant(0.5 * moments.sum()) - moments;
  if (along.minCoeff() > kThinnest * kThinnest * along.maxCoeff()) return;
  throw InputError(
      "the shape is thinner than a hundred-thousandth of its length; expected a thicker one");
}

}  // namespace

Shape begin_shape(TriangleMesh mesh, const MassProperties& integrals, const ShapeOptions& options) {
  if (!(integrals.volume > 0)) throw InputError("the shape has no volume; expected a closed solid");
  if (!(options.density > 0) && !(options.mass > 0)) {
    throw InputError("the shape has neither a density nor a mass; expected one above zero");
  }
  Shape shape;
  shape.name = options.name;
  shape.material = options.material;
  shape.volume = integrals.volume;
  shape.mass = options.mass > 0 ? options.mass : options.density * integrals.volume;
  const PrincipalInertia principal = principal_inertia(integrals.inertia);
  shape.centroid = integrals.centroid;
  shape.shape_from_body = principal.axes;
  shape.inertia = shape.mass / shape.volume * principal.moments;
  reject_degenerate_shape(principal.moments);
  const auto [lower, upper] = bounding_box(mesh);
  shape.box = upper - lower;
  shape.mesh = std::move(mesh);
  std::array<double, 3> edges = {shape.box.x(), shape.box.y(), shape.box.z()};
  std::sort(edges.begin(), edges.end());
  shape.rounding = std::max(options.rounding, 0.0);  // the default needs the pieces
  shape.stiffness_length = options.stiffness_length > 0 ? options.stiffness_length : edges[1];
  shape.stiffness =
      options.stiffness > 0 ? options.stiffness : options.young_modulus * shape.stiffness_length;
  return shape;
}

void add_part(Shape& shape, std::vector<HalfSpace> half_spaces) {
  const Mat3 body_from_shape = shape.shape_from_body.conjugate().toRotationMatrix();
  for (auto& h : half_spaces) {
    h.offset -= h.normal.dot(shape.centroid);
    h.normal = body_from_shape * h.normal;
  }
  shape.parts.push_back(convex_part(half_spaces, shape.rounding));
}

void compute_bounding_radius(Shape& shape) {
  if (shape.parts.size() > 64) {
    throw InputError("the shape has " + std::to_string(shape.parts.size()) +
                     " convex parts; expected at most 64");
  }
  double reach = 0;
  for (const Vec3& v : shape.mesh.vertices) reach = std::max(reach, (v - shape.centroid).norm());
  for (const auto& part : shape.parts) {
    for (int i = 0; i < part.vertex_count; ++i) {
      reach = std::max(reach, part.vertex(i).norm() + part.radius);
    }
  }
  shape.bounding_radius = reach;
}

namespace {

// Splits every triangle in four and moves the new corners onto the unit sphere.
TriangleMesh refine_unit_sphere(const TriangleMesh& coarse) {
  TriangleMesh fine;
  fine.vertices = coarse.vertices;
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [entry, fresh] =
        middles.try_emplace(std::minmax(a, b), static_cast<int>(fine.vertices.size()));
    if (fresh) fine.vertices.push_back((fine.vertices[a] + fine.vertices[b]).normalized());
    return entry->second;
  };
  for (const auto& [a, b, c] : coarse.triangles) {
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    fine.triangles.push_back({a, ab, ca});
    fine.triangles.push_back({ab, b, bc});
    fine.triangles.push_back({ca, bc, c});
    fine.triangles.push_back({ab, bc, ca});
  }
  return fine;
}

// An octahedron refined four times: 2048 triangles, mirror symmetric in the coordinate planes.
TriangleMesh sphere_mesh(double radius) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3::UnitX(),  -Vec3::UnitX(), Vec3::UnitY(),
                   -Vec3::UnitY(), Vec3::UnitZ(),  -Vec3::UnitZ()};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int i = 0; i < 4; ++i) mesh = refine_unit_sphere(mesh);
  for (Vec3& v : mesh.vertices) v *= radius;
  return mesh;
}

Shape finish_single(Shape shape, const char* reason) {
  compute_bounding_radius(shape);
  shape.part_neighbors = {1};
  shape.surface_deviation = measure_deviation(shape).largest();
  shape.deviation_reason = reason;
  return shape;
}

// One part of the given faces, rounded as the options say.
Shape finish_convex(Shape shape, const std::vector<HalfSpace>& faces, const ShapeOptions& options) {
  if (!(options.rounding >= 0)) {
    shape.rounding = default_rounding({faces}, shape.mesh, shape.box.minCoeff());
  }
  add_part(shape, faces);
  return finish_single(std::move(shape), "edges rounded");
}

void expect_positive(double value, const char* what) {
  if (!(value > 0) || !std::isfinite(value)) {
    throw InputError(std::string(what) + " is " + std::to_string(value) +
                     " m; expected a length above zero");
  }
}

}  // namespace

Shape make_sphere(double radius, const ShapeOptions& options) {
  expect_positive(radius, "the radius");
  MassProperties integrals;
  integrals.volume = 4 * std::numbers::pi / 3 * radius * radius * radius;
  integrals.inertia = 0.4 * integrals.volume * radius * radius * Mat3::Identity();
  Shape shape = begin_shape(sphere_mesh(radius), integrals, options);
  shape.rounding = radius;
  shape.parts.push_back(sphere_part(Vec3::Zero(), radius));
  return finish_single(std::move(shape), "triangles of the drawing");
}

Shape make_box(const Vec3& size, const ShapeOptions& options) {
  for (int k = 0; k < 3; ++k) expect_positive(size(k), "an edge of the box");
  TriangleMesh mesh = box_mesh(size);
  const MassProperties integrals = mass_properties(mesh);
  Shape shape = begin_shape(std::move(mesh), integrals, options);
  std::vector<HalfSpace> faces;
  for (int k = 0; k < 3; ++k) {
    faces.push_back({Vec3::Unit(k), size(k) / 2, false});
    faces.push_back({-Vec3::Unit(k), size(k) / 2, false});
  }
  return finish_convex(std::move(shape), faces, options);
}

Shape make_convex(const std::vector<Vec3>& points, const ShapeOptions& options) {
  const auto faces = convex_hull(points);
  TriangleMesh mesh = surface_mesh(convex_part(faces, 0));
  const MassProperties integrals = mass_properties(mesh);
  Shape shape = begin_shape(std::move(mesh), integrals, options);
  return finish_convex(std::move(shape), faces, options);
}

}  // namespace firn
