#include "solver/shapes/merge_pieces.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace firn {
namespace {

constexpr double kSamePlane = 1e-6;   // of the size
constexpr double kSameVolume = 1e-6;  // relative

struct Solid {
  Piece faces;
  std::vector<Vec3> corners;
  double volume = 0;
  Vec3 center = Vec3::Zero();
  double radius = 0;  // m, of a ball about the center
};

Solid solid_of(Piece faces) {
  const ConvexPart part = convex_part(faces, 0);
  Solid s;
  // Planes that only touch the solid are left out.
  for (const ConvexPart::Face& f : part.faces) s.faces.push_back({f.normal, f.offset, f.internal});
  for (int i = 0; i < part.vertex_count; ++i) s.corners.push_back(part.vertex(i));
  s.volume = mass_properties(surface_mesh(part)).volume;
  s.center = part.center;
  s.radius = part.bounding_radius;
  return s;
}

double highest(const Solid& s, const HalfSpace& h) {
  double most = -std::numeric_limits<double>::infinity();
  for (const Vec3& x : s.corners) most = std::max(most, h.normal.dot(x) - h.offset);
  return most;
}

// True if a corner of a face of `s` in this plane is on it: the plane carries a face of s.
const HalfSpace* same_face(const Solid& s, const HalfSpace& h, double tolerance) {
  for (const HalfSpace& f : s.faces) {
    if (f.normal.dot(h.normal) < 0.9) continue;
    const bool coincides = std::ranges::count_if(s.corners, [&](const Vec3& x) {
                             return std::abs(h.normal.dot(x) - h.offset) <= tolerance &&
                                    std::abs(f.normal.dot(x) - f.offset) <= tolerance;
                           }) >= 3;
    if (coincides) return &f;
  }
  return nullptr;
}

// Two convex solids have a convex union if they lie on both sides of one plane, which carries a
// face of each, and every other face of either one has the other one below it: what is below all
// of these other faces belongs to one of the two, depending on its side of the plane.
std::optional<Piece> convex_union(const Solid& a, const Solid& b) {
  const double tolerance = kSamePlane * std::min(a.radius, b.radius);
  if ((a.center - b.center).norm() > a.radius + b.radius + tolerance) return std::nullopt;
  Piece all;
  int shared = 0;
  const auto collect = [&](const Solid& s, const Solid& other, bool first) {
    for (const HalfSpace& f : s.faces) {
      if (highest(other, f) > tolerance) {
        const HalfSpace opposite{-f.normal, -f.offset, f.internal};
        if (highest(other, opposite) > tolerance || !same_face(other, opposite, tolerance))
          return false;
        ++shared;
        continue;
      }
      const HalfSpace* twin = same_face(other, f, tolerance);
      if (twin && twin->internal != f.internal) return false;
      if (first || !twin) all.push_back(f);
    }
    return true;
  };
  if (!collect(a, b, true) || !collect(b, a, false) || shared != 2) return std::nullopt;
  return all;
}

// The hull of all pieces, if it has no more volume than they have.
std::optional<Piece> convex_union(const std::vector<Solid>& solids) {
  std::vector<Vec3> corners;
  double volume = 0, size = 0;
  for (const Solid& s : solids) {
    corners.insert(corners.end(), s.corners.begin(), s.corners.end());
    volume += s.volume;
    size = std::max(size, (s.center - solids[0].center).norm() + s.radius);
  }
  const Solid hull = solid_of(convex_hull(corners));
  if (!(std::abs(hull.volume - volume) <= kSameVolume * volume)) return std::nullopt;
  for (const HalfSpace& h : hull.faces) {
    for (const Solid& s : solids) {
      const HalfSpace* face = same_face(s, h, kSamePlane * size);
      if (face && face->internal) return std::nullopt;
    }
  }
  return hull.faces;
}

// Groups of solids that are connected by coinciding planes of opposite faces.
std::vector<std::vector<Solid>> components(const std::vector<Solid>& solids) {
  const auto may_touch = [](const Solid& a, const Solid& b) {
    const double tolerance = kSamePlane * std::min(a.radius, b.radius);
    if ((a.center - b.center).norm() > a.radius + b.radius + tolerance) return false;
    return std::ranges::any_of(a.faces, [&](const HalfSpace& f) {
      return same_face(b, {-f.normal, -f.offset, false}, tolerance) != nullptr;
    });
  };
  std::vector<char> taken(solids.size(), 0);
  std::vector<std::vector<Solid>> groups;
  for (std::size_t seed = 0; seed < solids.size(); ++seed) {
    if (taken[seed]) continue;
    taken[seed] = 1;
    std::vector<std::size_t> open = {seed};
    std::vector<Solid>& group = groups.emplace_back();
    for (std::size_t i = 0; i < open.size(); ++i) {
      for (std::size_t k = 0; k < solids.size(); ++k) {
        if (taken[k] || !may_touch(solids[open[i]], solids[k])) continue;
        taken[k] = 1;
        open.push_back(k);
      }
    }
    std::ranges::sort(open);
    for (const std::size_t i : open) group.push_back(solids[i]);
  }
  return groups;
}

// Of one component.
void merge(std::vector<Solid>& solids) {
  if (std::optional<Piece> whole = convex_union(solids)) {
    solids = {solid_of(std::move(*whole))};
    return;
  }
  for (std::size_t i = 0; i < solids.size(); ++i) {
    for (std::size_t k = i + 1; k < solids.size();) {
      if (const std::optional<Piece> both = convex_union(solids[i], solids[k])) {
        solids[i] = solid_of(*both);
        solids.erase(solids.begin() + static_cast<std::ptrdiff_t>(k));
        k = i + 1;  // the union may fit to pieces that its halves did not fit to
      } else {
        ++k;
      }
    }
  }
}

double area_of(const std::vector<Vec3>& polygon) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
    sum += (polygon[k] - polygon[0]).cross(polygon[k + 1] - polygon[0]);
  }
  return 0.5 * sum.norm();
}

// The part of a convex polygon within a piece.
std::vector<Vec3> clipped(std::vector<Vec3> polygon, const Piece& piece) {
  for (const auto& h : piece) {
    std::vector<Vec3> rest;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const Vec3 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
      const double from = h.normal.dot(a) - h.offset, to = h.normal.dot(b) - h.offset;
      if (from <= 0) rest.push_back(a);
      if ((from < 0 && to > 0) || (from > 0 && to < 0)) {
        rest.push_back(a + from / (from - to) * (b - a));
      }
    }
    polygon = std::move(rest);
    if (polygon.size() < 3) return {};
  }
  return polygon;
}

}  // namespace

std::vector<Piece> merge_convex_pieces(std::vector<Piece> pieces) {
  if (pieces.size() < 2) return pieces;
  std::vector<Solid> solids;
  for (const Piece& p : pieces) solids.push_back(solid_of(p));
  pieces.clear();
  for (std::vector<Solid>& group : components(solids)) {
    merge(group);
    for (Solid& s : group) pieces.push_back(std::move(s.faces));
  }
  return pieces;
}

// Marks faces that other pieces cover. Each face is moved outwards a little, and the areas of its
// intersections with the other pieces are added up. Pieces do not overlap, so a face is internal if
// the sum is its whole area.
void mark_internal_faces(std::vector<Piece>& pieces, double size) {
  constexpr double kLift = 1e-5;      // over the size
  constexpr double kRelative = 1e-3;  // of the area; and a rim as wide as three lifts
  std::vector<ConvexPart> parts;
  for (const auto& piece : pieces) parts.push_back(convex_part(piece, 0));
  const auto original = pieces;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    std::size_t cuts = 0;
    for (const auto& face : parts[i].faces) {
      if (cuts == kMaxInternalFaces) break;
      std::vector<Vec3> polygon;
      for (int k = 0; k < face.count; ++k) {
        polygon.push_back(parts[i].vertex(parts[i].face_vertices[face.first + k]) +
                          kLift * size * face.normal);
      }
      double rim = 0;
      for (std::size_t k = 0; k < polygon.size(); ++k) {
        rim += (polygon[(k + 1) % polygon.size()] - polygon[k]).norm();
      }
      double open = area_of(polygon);
      const double allowed = kRelative * open + 3 * kLift * size * rim;
      for (std::size_t j = 0; j < pieces.size() && open > allowed; ++j) {
        const double reach = parts[i].bounding_radius + parts[j].bounding_radius;
        if (j == i || (parts[i].center - parts[j].center).norm() > reach) continue;
        open -= area_of(clipped(polygon, original[j]));
      }
      if (open > allowed) continue;
      for (auto& h : pieces[i]) {
        h.internal |= h.normal == face.normal && std::abs(h.offset - face.offset) < 1e-9 * size;
      }
      ++cuts;
    }
  }
}

}  // namespace firn
