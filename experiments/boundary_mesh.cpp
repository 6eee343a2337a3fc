#include "experiments/boundary_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace firn {
namespace {

using Edge = std::pair<int, int>;  // vertices, in the direction of the triangle that owns it

// A sharper fold than this has no bisector worth the name: about 168 degrees between the normals.
constexpr double kSharpestFold = -0.98;

Vec3 face_normal(const TriangleMesh& mesh, const std::array<int, 3>& t) {
  const Vec3& a = mesh.vertices[t[0]];
  return (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).normalized();
}

double size_of(const TriangleMesh& mesh) {
  const auto [lower, upper] = bounding_box(mesh);
  return (upper - lower).norm();
}

bool is_convex(const TriangleMesh& mesh) {
  const double tolerance = 1e-7 * size_of(mesh);
  return std::ranges::all_of(mesh.triangles, [&](const std::array<int, 3>& t) {
    const Vec3 n = face_normal(mesh, t);
    const double offset = n.dot(mesh.vertices[t[0]]) + tolerance;
    return std::ranges::all_of(mesh.vertices, [&](const Vec3& v) { return n.dot(v) <= offset; });
  });
}

void check(const MeshDefects& found) {
  MeshDefects fatal;
  fatal.flipped_edges = found.flipped_edges;
  fatal.degenerate = found.degenerate;
  fatal.duplicated = found.duplicated;
  fatal.non_finite = found.non_finite;
  if (!fatal.sound()) {
    throw InputError(fmt::format("the surface has {}; expected triangles that face the same way",
                                 fatal.sentence()));
  }
}

// The one triangle on the other side of each edge.
std::map<Edge, int> owners(const TriangleMesh& mesh) {
  std::map<Edge, int> count, owner;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      ++count[{low, high}];
      owner[{t[k], t[(k + 1) % 3]}] = static_cast<int>(i);
    }
  }
  std::erase_if(owner, [&](const auto& entry) {
    const auto [low, high] = std::minmax(entry.first.first, entry.first.second);
    return count[{low, high}] != 2;
  });
  return owner;
}

ConvexPart prism(const TriangleMesh& mesh, const std::vector<Vec3>& normals,
                 const std::map<Edge, int>& owner, std::size_t index, double thickness) {
  const auto& t = mesh.triangles[index];
  const Vec3& n = normals[index];
  const double offset = n.dot(mesh.vertices[t[0]]);
  std::vector<HalfSpace> sides = {{n, offset, false}, {-n, thickness - offset, false}};
  for (int k = 0; k < 3; ++k) {
    const int a = t[k], b = t[(k + 1) % 3];
    const Vec3 along = (mesh.vertices[b] - mesh.vertices[a]).normalized();
    HalfSpace side{along.cross(n), 0, false};
    const auto other = owner.find({b, a});
    if (other != owner.end() && n.dot(normals[other->second]) > kSharpestFold) {
      side.normal = along.cross(n + normals[other->second]).normalized();
      side.internal = true;
    }
    side.offset = side.normal.dot(mesh.vertices[a]);
    sides.push_back(side);
  }
  return convex_part(sides, 0);
}

}  // namespace

std::vector<ConvexPart> boundary_parts(const TriangleMesh& mesh, double thickness) {
  const MeshDefects defects = inspect(mesh);
  check(defects);
  if (defects.sound() && is_convex(mesh)) {
    return {convex_part(convex_hull(mesh.vertices), 0)};
  }
  std::vector<Vec3> normals;
  for (const auto& t : mesh.triangles) normals.push_back(face_normal(mesh, t));
  const auto owner = owners(mesh);
  std::vector<ConvexPart> parts;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    parts.push_back(prism(mesh, normals, owner, i, thickness));
  }
  return parts;
}

std::vector<HalfSpace> box_half_spaces(const Vec3& size) {
  std::vector<HalfSpace> sides;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      sides.push_back({sign * Vec3::Unit(axis), size[axis] / 2, false});
    }
  }
  return sides;
}

TriangleMesh box_mesh(const Vec3& size) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {  // bit k of i: upper side along axis k
    mesh.vertices.push_back(
        Vec3(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5).cwiseProduct(size));
  }
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

}  // namespace firn
