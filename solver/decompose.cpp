// Concave meshes cut into convex pieces. A piece is the part of the surface between cutting planes;
// its convex hull stands for it in contacts. The most concave piece is cut again and again, by the
// plane through its deepest notch that leaves the least concavity.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "solver/mesh_conflicts.h"
#include "solver/shape_makers.h"

namespace firn {
namespace {

constexpr std::size_t kMaxCuts = 32;          // of one part
constexpr std::size_t kMaxTriangles = 20000;  // of a mesh with contact parts
// Pieces this convex (relative to the diagonal of the box) are not cut.
constexpr double kConvexEnough = 2e-3;

struct Facet {
  std::array<Vec3, 3> corners;
  Vec3 normal;
};

// A place of the surface and how far the hull of its piece lies above it, along the normal.
struct Notch {
  double depth = 0;  // m
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ();
};

struct Piece {
  std::vector<Facet> surface;
  std::vector<HalfSpace> cuts;
  std::vector<HalfSpace> hull;
  std::vector<Notch> notches;  // one a facet, deepest first

  double concavity() const { return notches[0].depth; }
};

double distance_to_hull(const std::vector<HalfSpace>& hull, const Vec3& p, const Vec3& direction) {
  double distance = std::numeric_limits<double>::infinity();
  for (const auto& h : hull) {
    const double speed = h.normal.dot(direction);
    if (speed > 0) distance = std::min(distance, (h.offset - h.normal.dot(p)) / speed);
  }
  return std::max(distance, 0.0);
}

// Gives the piece its hull and notches. Throws InputError when the surface is flat or empty.
void measure(Piece& piece, double size) {
  std::vector<Vec3> points;
  for (const auto& f : piece.surface) {
    points.insert(points.end(), f.corners.begin(), f.corners.end());
  }
  piece.hull = convex_hull(points);
  for (auto& h : piece.hull) {
    // The pieces on both sides of a cut get exactly opposite planes.
    for (const auto& cut : piece.cuts) {
      const bool same =
          (h.normal - cut.normal).norm() < 1e-6 && std::abs(h.offset - cut.offset) < 1e-6 * size;
      if (same) h = cut;
    }
  }
  piece.notches.clear();
  for (const auto& f : piece.surface) {
    Notch deepest;
    const Vec3 middle = (f.corners[0] + f.corners[1] + f.corners[2]) / 3;
    for (const Vec3& p : {middle, f.corners[0], f.corners[1], f.corners[2]}) {
      const double depth = distance_to_hull(piece.hull, p, f.normal);
      if (depth >= deepest.depth) deepest = {depth, p, f.normal};
    }
    piece.notches.push_back(deepest);
  }
  std::stable_sort(piece.notches.begin(), piece.notches.end(),
                   [](const Notch& a, const Notch& b) { return a.depth > b.depth; });
}

// The part of a facet where n . x <= offset.
void clip(const Facet& facet, const Vec3& n, double offset, double tolerance,
          std::vector<Facet>& out) {
  std::array<double, 3> height;
  for (int k = 0; k < 3; ++k) height[k] = n.dot(facet.corners[k]) - offset;
  const auto [low, high] = std::minmax_element(height.begin(), height.end());
  // A facet in the plane belongs to the body below it.
  if (*high <= tolerance && *low >= -tolerance && n.dot(facet.normal) < 0) return;
  std::vector<Vec3> polygon;
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    if (height[k] <= tolerance) polygon.push_back(facet.corners[k]);
    if (std::min(height[k], height[next]) < -tolerance &&
        std::max(height[k], height[next]) > tolerance) {
      const double s = height[k] / (height[k] - height[next]);
      polygon.push_back(facet.corners[k] + s * (facet.corners[next] - facet.corners[k]));
    }
  }
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
    out.push_back({{polygon[0], polygon[k], polygon[k + 1]}, facet.normal});
  }
}

// Both sides of a cut; nothing when a side is empty, flat or thinner than `thinnest`.
std::optional<std::array<Piece, 2>> split(const Piece& piece, const Vec3& n, double offset,
                                          double thinnest, double size, std::size_t stride = 1) {
  std::array<Piece, 2> sides;
  for (int i = 0; i < 2; ++i) {
    const Vec3 normal = i == 0 ? n : Vec3(-n);
    const double at = i == 0 ? offset : -offset;
    for (std::size_t k = 0; k < piece.surface.size(); k += stride) {
      clip(piece.surface[k], normal, at, 1e-9 * size, sides[i].surface);
    }
    double lowest = 0;
    for (const auto& f : sides[i].surface) {
      for (const Vec3& p : f.corners) lowest = std::min(lowest, normal.dot(p) - at);
    }
    if (-lowest <= thinnest) return std::nullopt;
    sides[i].cuts = piece.cuts;
    sides[i].cuts.push_back({normal, at, false});
    try {
      measure(sides[i], size);
    } catch (const InputError&) {
      return std::nullopt;
    }
  }
  return sides;
}

// Planes worth trying: along the axes and along the deepest walls, through the deepest notch and
// through the middle of the piece.
std::vector<HalfSpace> candidate_cuts(const Piece& piece) {
  std::vector<HalfSpace> cuts;
  const Vec3& notch = piece.notches[0].point;
  Vec3 lower = piece.surface[0].corners[0], upper = lower;
  for (const auto& f : piece.surface) {
    for (const Vec3& p : f.corners) {
      lower = lower.cwiseMin(p);
      upper = upper.cwiseMax(p);
    }
  }
  for (int k = 0; k < 3; ++k) {
    cuts.push_back({Vec3::Unit(k), notch(k), false});
    cuts.push_back({Vec3::Unit(k), (lower(k) + upper(k)) / 2, false});
  }
  constexpr std::size_t kWalls = 6;
  const std::size_t axes = cuts.size();
  for (const auto& wall : piece.notches) {
    if (wall.depth < piece.concavity() / 4 || cuts.size() == axes + kWalls) break;
    const bool tried = std::any_of(cuts.begin() + axes, cuts.end(), [&wall](const HalfSpace& c) {
      return c.normal.dot(wall.normal) > 0.99;
    });
    if (!tried) cuts.push_back({wall.normal, wall.normal.dot(wall.point), false});
  }
  return cuts;
}

// The two sides of the best cut, or nothing when no cut helps.
std::optional<std::array<Piece, 2>> best_split(const Piece& piece, double thinnest, double size) {
  const std::size_t stride = 1 + piece.surface.size() / 800;
  double best_score = std::numeric_limits<double>::infinity();
  std::optional<HalfSpace> best;
  for (const auto& cut : candidate_cuts(piece)) {
    const auto sides = split(piece, cut.normal, cut.offset, thinnest, size, stride);
    if (!sides) continue;
    const double a = (*sides)[0].concavity(), b = (*sides)[1].concavity();
    const double score = std::max(a, b) + 0.5 * std::min(a, b);
    if (score < best_score) {
      best_score = score;
      best = cut;
    }
  }
  if (!best) return std::nullopt;
  return split(piece, best->normal, best->offset, thinnest, size);
}

std::vector<Piece> decompose(const TriangleMesh& mesh, double rounding, double size,
                             std::size_t max_parts) {
  std::vector<Piece> pieces(1);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 &p = mesh.vertices[a], &q = mesh.vertices[b], &r = mesh.vertices[c];
    pieces[0].surface.push_back({{p, q, r}, (q - p).cross(r - p).normalized()});
  }
  measure(pieces[0], size);
  std::vector<Piece> done;
  while (!pieces.empty()) {
    const auto worst = std::max_element(
        pieces.begin(), pieces.end(),
        [](const auto& a, const auto& b) { return a.concavity() < b.concavity(); });
    Piece piece = std::move(*worst);
    pieces.erase(worst);
    std::optional<std::array<Piece, 2>> sides;
    if (piece.concavity() > kConvexEnough * size && pieces.size() + done.size() + 2 <= max_parts) {
      sides = best_split(piece, 4 * rounding, size);
    }
    if (!sides) {
      done.push_back(std::move(piece));
    } else {
      for (auto& side : *sides) pieces.push_back(std::move(side));
    }
  }
  return done;
}

bool contains(const std::vector<HalfSpace>& piece, const Vec3& p) {
  return std::all_of(piece.begin(), piece.end(),
                     [&p](const HalfSpace& h) { return h.normal.dot(p) <= h.offset; });
}

// Points spread over a face, at `lift` above it.
std::vector<Vec3> points_above(const ConvexPart& part, const ConvexPart::Face& face, double lift) {
  Vec3 middle = Vec3::Zero();
  for (int k = 0; k < face.count; ++k) middle += part.vertex(part.loops[face.first + k]);
  middle /= face.count;
  std::vector<Vec3> points = {middle};
  for (int k = 0; k < face.count; ++k) {
    const Vec3 corner = part.vertex(part.loops[face.first + k]);
    const Vec3 next = part.vertex(part.loops[face.first + (k + 1) % face.count]);
    for (const Vec3& p : {corner, Vec3((corner + next) / 2)}) {
      for (const double s : {0.01, 0.5}) points.push_back(p + s * (middle - p));
    }
  }
  for (Vec3& p : points) p += lift * face.normal;
  return points;
}

// Marks the faces that lie wholly inside or against other pieces: they are cuts, not surface.
void mark_cuts(std::vector<std::vector<HalfSpace>>& pieces, double size) {
  std::vector<ConvexPart> parts;
  for (const auto& piece : pieces) parts.push_back(convex_part(piece, 0));
  const auto original = pieces;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const auto in_another = [&](const Vec3& p) {
      for (std::size_t j = 0; j < pieces.size(); ++j) {
        if (j != i && contains(original[j], p)) return true;
      }
      return false;
    };
    std::size_t cuts = 0;
    for (const auto& face : parts[i].faces) {
      const auto points = points_above(parts[i], face, 1e-5 * size);
      if (cuts == kMaxCuts || !std::all_of(points.begin(), points.end(), in_another)) continue;
      for (auto& h : pieces[i]) {
        h.internal |= h.normal == face.normal && std::abs(h.offset - face.offset) < 1e-9 * size;
      }
      ++cuts;
    }
  }
}

}  // namespace

Shape make_mesh(const TriangleMesh& mesh, const ShapeOptions& options) {
  const std::string defects = inspect(mesh).sentence();
  if (!defects.empty()) {
    throw InputError("the mesh is no solid (" + defects +
                     "); expected a closed surface facing outwards");
  }
  if (mesh.triangles.size() > kMaxTriangles) {
    throw InputError("the mesh has " + std::to_string(mesh.triangles.size()) +
                     " triangles; expected at most " + std::to_string(kMaxTriangles));
  }
  const std::string conflicts = find_conflicts(mesh).sentence();
  if (!conflicts.empty()) {
    throw InputError("the mesh bounds no solid: " + conflicts +
                     "; expected surfaces that do not cross and no solid inside another one");
  }
  Shape shape = begin_shape(mesh, mass_properties(mesh), options);
  std::vector<std::vector<HalfSpace>> hulls;
  for (auto& piece : decompose(mesh, shape.rounding, shape.box.norm(), options.max_parts)) {
    hulls.push_back(std::move(piece.hull));
  }
  mark_cuts(hulls, shape.box.norm());
  for (auto& hull : hulls) add_part(shape, std::move(hull));
  set_reach(shape);
  find_neighbours(shape);
  shape.contact_deviation = measure_deviation(shape);
  return shape;
}

}  // namespace firn
