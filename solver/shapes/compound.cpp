#include <algorithm>
#include <map>
#include <vector>

#include "solver/collision/narrowphase.h"
#include "solver/shapes/merge_pieces.h"
#include "solver/shapes/shape_builder.h"

namespace firn {

void find_neighboring_parts(Shape& shape) {
  shape.part_neighbors.assign(shape.parts.size(), 0);
  const double tolerance = 1e-6 * shape.box.norm();
  for (std::size_t i = 0; i < shape.parts.size(); ++i) {
    for (std::size_t j = 0; j < shape.parts.size(); ++j) {
      const ConvexPart &a = shape.parts[i], &b = shape.parts[j];
      GjkCache cold;
      const double gap = i == j ? 0 : core_distance(a, b, Pose{}, cold) - a.radius - b.radius;
      if (gap <= tolerance) shape.part_neighbors[i] |= std::uint64_t{1} << j;
    }
  }
}

namespace {

// Appends a mesh, moved.
void append(TriangleMesh& whole, const TriangleMesh& part, const Pose& pose) {
  const int first = static_cast<int>(whole.vertices.size());
  for (const Vec3& v : part.vertices) whole.vertices.push_back(pose * v);
  for (const auto& [a, b, c] : part.triangles) {
    whole.triangles.push_back({first + a, first + b, first + c});
  }
}

// Volume, centroid and inertia of the bodies together; each weighs as much as its mass, and the
// result is that of a solid of unit density whose volume is the sum of the volumes.
MassProperties combine(const std::vector<Component>& components) {
  MassProperties whole;
  double mass = 0;
  for (const auto& c : components) {
    whole.volume += c.shape.volume;
    mass += c.shape.mass;
    whole.centroid += c.shape.mass * (c.pose * c.shape.centroid);
  }
  whole.centroid /= mass;
  for (const auto& c : components) {
    const Mat3 axes = c.pose.rotation * c.shape.shape_from_body.toRotationMatrix();
    const Vec3 arm = c.pose * c.shape.centroid - whole.centroid;
    whole.inertia += axes * c.shape.inertia.asDiagonal() * axes.transpose();
    whole.inertia += c.shape.mass * (arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose());
  }
  whole.inertia *= whole.volume / mass;
  return whole;
}

// Pieces of equal rounding (m) can be merged.
using PiecesByRounding = std::map<double, std::vector<Piece>>;

// The faces of a part before it was eroded, moved.
Piece drawn_piece(const ConvexPart& part, const Pose& pose) {
  Piece piece;
  for (const ConvexPart::Face& face : part.faces) {
    const Vec3 normal = pose.rotation * face.normal;
    const double eroded = face.internal ? 0 : part.radius;
    piece.push_back({normal, face.offset + eroded + normal.dot(pose.translation), face.internal});
  }
  return piece;
}

// Adds the union of the pieces (body axes): a component is no feature of the compound.
void add_pieces(const PiecesByRounding& pieces, Shape& shape) {
  std::vector<Piece> all;
  std::vector<double> roundings;
  for (const auto& [rounding, alike] : pieces) {
    const std::vector<Piece> merged = merge_convex_pieces(alike);
    all.insert(all.end(), merged.begin(), merged.end());
    roundings.resize(all.size(), rounding);
  }
  mark_internal_faces(all, shape.box.norm());
  for (std::size_t i = 0; i < all.size(); ++i)
    shape.parts.push_back(convex_part(all[i], roundings[i]));
}

}  // namespace

Shape make_compound(const std::vector<Component>& components, const ShapeOptions& options) {
  if (components.empty()) throw InputError("the compound has no components; expected one or more");
  TriangleMesh mesh;
  ShapeOptions whole = options;
  double mass = 0;
  for (const auto& c : components) {
    append(mesh, c.shape.mesh, c.pose);
    mass += c.shape.mass;
  }
  if (!(whole.mass > 0)) whole.mass = mass;
  Shape shape = begin_shape(std::move(mesh), combine(components), whole);
  const Mat3 body_from_shape = shape.shape_from_body.conjugate().toRotationMatrix();
  shape.rounding = components[0].shape.rounding;
  PiecesByRounding pieces;
  for (const auto& c : components) {
    const Pose body_pose = {
        body_from_shape * c.pose.rotation * c.shape.shape_from_body.toRotationMatrix(),
        body_from_shape * (c.pose * c.shape.centroid - shape.centroid)};
    for (const ConvexPart& part : c.shape.parts) {
      if (part.faces.empty()) {
        shape.parts.push_back(moved(part, body_pose));
      } else {
        pieces[part.radius].push_back(drawn_piece(part, body_pose));
      }
    }
    shape.rounding = std::min(shape.rounding, c.shape.rounding);
    if (c.shape.surface_deviation > shape.surface_deviation || shape.deviation_reason.empty()) {
      shape.surface_deviation = c.shape.surface_deviation;
      shape.deviation_reason = "component " + c.shape.name + ": " + c.shape.deviation_reason;
    }
  }
  add_pieces(pieces, shape);
  compute_bounding_radius(shape);
  find_neighboring_parts(shape);
  return shape;
}

}  // namespace firn
