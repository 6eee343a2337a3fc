// A solid is cut by planes until the hull of every piece is near its surface; then pieces whose
// common hull is near the surface, too, are joined. Pieces of a tree of cuts are separated by
// planes, so their hulls do not overlap. Cuts are chosen one by one (greedily), by several rules
// in turn; the rule that ends with the fewest pieces wins. A thorough search shuns pieces that are
// thin and not convex yet, and takes cuts back that led to pieces that no cut helps.
#include "solver/shapes/convex_decomposition.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <thread>
#include <tuple>

#include "solver/core/parallel.h"
#include "solver/geometry/point_in_mesh.h"
#include "solver/geometry/quick_hull.h"

namespace firn {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMaxCuts = 32;   // of one part
constexpr std::size_t kSamples = 700;  // facets whose depth is measured for a trial
// Of a thorough search.
constexpr double kThinWeight = 4;        // of the least thickness over a piece's, in its cost
constexpr int kTakenBack = 40;           // cuts of one tree
constexpr std::size_t kMaxRejected = 3;  // cuts of one piece that are taken back
constexpr double kNear = 1.15;           // deviation over the tolerance that is worth measuring

// Part of the boundary of a piece. The caps of cuts are cones over their outlines from a point of
// the plane: their triangles may overlap with opposite signs, but volume and area add up exactly.
struct Facet {
  std::array<Vec3, 3> corners;
  Vec3 normal;
  bool cap = false;
};

struct CutPiece {
  std::vector<Facet> boundary;
  std::vector<HalfSpace> path;    // cuts that lead from the solid to the piece; it lies below all
  std::vector<HalfSpace> cuts;    // those that the piece reaches
  std::vector<HalfSpace> planes;  // of the hull; internal: on a cut
  std::vector<Vec3> corners;      // of the hull
  std::vector<Vec3> inner;        // corners within the solid, where three cuts meet
  double volume = 0;              // m^3
  double surplus = 0;             // m^3, of the hull over the piece
  double outer_area = 0;          // m^2, of the hull's faces that lie on no cut
  double deviation = 0;           // m, deepest point of the surface below the hull's outer faces
  bool final = false;             // no cut helps
  std::shared_ptr<const CutPiece> parent;  // what it was cut from
  std::vector<HalfSpace> rejected;         // cuts of it that were taken back
};

// A facet and how deep it lies below the hull's outer faces.
struct Notch {
  double depth = 0;
  std::size_t facet = 0;
  Vec3 point = Vec3::Zero();
};

// An edge where the surface is concave.
struct ReflexEdge {
  Vec3 a, b;    // m
  Vec3 n1, n2;  // of its facets
};

struct Rule {
  enum class Cost { volume, root, both, depth } cost;
  bool halves;             // only planes through the middle of a piece
  double thin_weight = 0;  // how much more a thin piece costs that is not convex enough
  int taken_back = 0;      // cuts that may be taken back
};

double area(const Facet& f) {
  return 0.5 * (f.corners[1] - f.corners[0]).cross(f.corners[2] - f.corners[0]).norm();
}

Vec3 middle(const Facet& f) { return (f.corners[0] + f.corners[1] + f.corners[2]) / 3; }

bool before(const Vec3& a, const Vec3& b) {
  return std::tie(a.x(), a.y(), a.z()) < std::tie(b.x(), b.y(), b.z());
}

// The triangles in an order that depends on their geometry alone.
std::vector<Facet> sorted_facets(const TriangleMesh& mesh) {
  std::vector<Facet> facets;
  for (const auto& t : mesh.triangles) {
    Facet f;
    for (int k = 0; k < 3; ++k) f.corners[k] = mesh.vertices[t[k]];
    const auto first = std::min_element(f.corners.begin(), f.corners.end(), before);
    std::rotate(f.corners.begin(), first, f.corners.end());
    f.normal = (f.corners[1] - f.corners[0]).cross(f.corners[2] - f.corners[0]).normalized();
    facets.push_back(f);
  }
  std::sort(facets.begin(), facets.end(), [](const Facet& a, const Facet& b) {
    return std::lexicographical_compare(a.corners.begin(), a.corners.end(), b.corners.begin(),
                                        b.corners.end(), before);
  });
  return facets;
}

// About `most` facets of nearly the same surface, by collapsed edges. The surface stays closed, and
// its corners are corners of the mesh.
std::vector<Facet> simplified(const std::vector<Facet>& facets, std::size_t most, double size) {
  const auto less = [](const Vec3& a, const Vec3& b) { return before(a, b); };
  std::map<Vec3, unsigned, decltype(less)> known(less);
  std::vector<Vec3> corners;
  std::vector<float> scaled;  // meshoptimizer takes single precision
  std::vector<unsigned> indices;
  for (const auto& f : facets) {
    for (const Vec3& p : f.corners) {
      const auto [at, added] = known.emplace(p, static_cast<unsigned>(corners.size()));
      indices.push_back(at->second);
      if (!added) continue;
      corners.push_back(p);
      for (int k = 0; k < 3; ++k) scaled.push_back(static_cast<float>(p(k) / size));
    }
  }
  constexpr float kAnyError = 1;  // of the size
  std::vector<unsigned> kept(indices.size());
  kept.resize(meshopt_simplify(kept.data(), indices.data(), indices.size(), scaled.data(),
                               corners.size(), 3 * sizeof(float), 3 * most, kAnyError));
  std::vector<Facet> result;
  for (std::size_t i = 0; i + 2 < kept.size(); i += 3) {
    Facet f{{corners[kept[i]], corners[kept[i + 1]], corners[kept[i + 2]]}, Vec3::Zero()};
    const Vec3 n = (f.corners[1] - f.corners[0]).cross(f.corners[2] - f.corners[0]);
    if (n.norm() <= 1e-12 * size * size) continue;
    f.normal = n.normalized();
    result.push_back(f);
  }
  return result;
}

std::vector<ReflexEdge> reflex_edges(const std::vector<Facet>& facets, double size) {
  constexpr double kLeast = 0.1;  // sine of the angle between the facets
  const auto less = [](const std::array<Vec3, 2>& x, const std::array<Vec3, 2>& y) {
    return before(x[0], y[0]) || (!before(y[0], x[0]) && before(x[1], y[1]));
  };
  std::map<std::array<Vec3, 2>, Vec3, decltype(less)> sides(less);
  std::vector<ReflexEdge> result;
  for (const auto& f : facets) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 &a = f.corners[k], &b = f.corners[(k + 1) % 3];
      const auto other = sides.find({b, a});
      if (other == sides.end()) {
        sides[{a, b}] = f.normal;
        continue;
      }
      // Seen along the edge of this facet, the other facet rises when the edge is concave.
      const Vec3 along = b - a;
      const double sine = f.normal.cross(other->second).dot(along) / along.norm();
      if (sine < -kLeast && along.norm() > 1e-6 * size) {
        result.push_back({a, b, f.normal, other->second});
      }
      sides.erase(other);
    }
  }
  return result;
}

class Decomposer {
 public:
  // The solid must outlive the decomposer.
  Decomposer(const Interior& solid, const DecomposeOptions& options, double size,
             const Vec3& origin)
      : solid_(solid), options_(options), size_(size), snap_(1e-9 * size), origin_(origin) {}

  // Gives the piece its hull and what follows from it. False for a flat or empty piece.
  bool measure(CutPiece& piece) const {
    std::vector<Vec3> points = piece.inner;
    for (const auto& f : piece.boundary) {
      if (!f.cap) points.insert(points.end(), f.corners.begin(), f.corners.end());
    }
    piece.volume = volume(piece.boundary);
    return set_hull(piece, points) && set_deviation(piece);
  }

  // Both sides of a cut. Nothing when a side is empty, flat or too thin.
  std::optional<std::array<CutPiece, 2>> split(const CutPiece& piece, const HalfSpace& cut) const {
    if (piece.cuts.size() >= kMaxCuts) return std::nullopt;
    std::array<CutPiece, 2> sides;
    clip(piece.boundary, cut, sides[0].boundary, sides[1].boundary);
    for (int i = 0; i < 2; ++i) {
      const HalfSpace below = i == 0 ? HalfSpace{cut.normal, cut.offset, false}
                                     : HalfSpace{-cut.normal, -cut.offset, false};
      sides[i].path = piece.path;
      sides[i].path.push_back(below);
      sides[i].cuts = piece.cuts;
      sides[i].cuts.push_back(below);
      double lowest = 0;
      for (const auto& f : sides[i].boundary) {
        for (const Vec3& p : f.corners) {
          const double height = cut.normal.dot(p) - cut.offset;
          lowest = std::min(lowest, i == 0 ? height : -height);
        }
      }
      if (-lowest < options_.thinnest) return std::nullopt;
    }
    add_inner(piece, cut, sides[0].inner, sides[1].inner);
    // The caps of a cut that rounding errors leave open would add or lose volume.
    const double exact = 1e-7 * size_ * size_ * size_;
    for (auto& side : sides) {
      if (!measure(side) || side.volume <= 1e-12 * size_ * size_ * size_) return std::nullopt;
      if (side.surplus < -exact) return std::nullopt;
    }
    if (std::abs(sides[0].volume + sides[1].volume - piece.volume) > exact) return std::nullopt;
    return sides;
  }

  // Repeats on `piece` the tree of cuts that led to `leaves`, from `depth` cuts on. A cut that
  // would leave a side empty, flat or too thin is left out; the cuts of the larger side follow.
  void repeat_cuts(CutPiece piece, const std::vector<const CutPiece*>& leaves, std::size_t depth,
                   std::vector<CutPiece>& result) const {
    if (leaves.size() == 1) {
      result.push_back(std::move(piece));
      return;
    }
    const HalfSpace cut = leaves[0]->path[depth];
    std::array<std::vector<const CutPiece*>, 2> parts;
    std::array<double, 2> volumes{};
    for (const CutPiece* leaf : leaves) {
      const int side = leaf->path[depth].normal == cut.normal ? 0 : 1;
      parts[side].push_back(leaf);
      volumes[side] += leaf->volume;
    }
    if (auto sides = split(piece, cut)) {
      for (int i = 0; i < 2; ++i) repeat_cuts(std::move((*sides)[i]), parts[i], depth + 1, result);
    } else {
      repeat_cuts(std::move(piece), parts[volumes[1] > volumes[0]], depth + 1, result);
    }
  }

  // Corners of the hull; of very many those that keep it within a tenth of the tolerance, and all
  // on cuts, so that neighbours still share their faces.
  std::vector<Vec3> fewer_corners(const CutPiece& piece) const {
    constexpr std::size_t kMany = 1000;
    if (piece.corners.size() <= kMany) return piece.corners;
    const auto coarse = quick_hull(piece.corners, 0.1 * options_.tolerance);
    if (!coarse) return piece.corners;
    std::vector<char> kept(piece.corners.size(), 0);
    for (const int i : coarse->corners) kept[i] = 1;
    std::vector<Vec3> result;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      const bool on_cut =
          std::any_of(piece.cuts.begin(), piece.cuts.end(), [&](const HalfSpace& h) {
            return std::abs(h.normal.dot(piece.corners[i]) - h.offset) <= 1e-6 * size_;
          });
      if (kept[i] || on_cut) result.push_back(piece.corners[i]);
    }
    return result;
  }

  bool convex_enough(const CutPiece& p) const { return p.deviation <= options_.tolerance; }

  // Cuts the worst piece again and again. Where no cut helps a piece, the one that made it is taken
  // back, as often as the rule allows.
  std::vector<CutPiece> cut_down(std::vector<CutPiece> pieces, const Rule& rule,
                                 const std::vector<ReflexEdge>& reflex) const {
    int taken_back = 0;
    while (static_cast<int>(pieces.size()) < options_.max_parts) {
      CutPiece* worst = nullptr;
      for (auto& p : pieces) {
        if (!p.final && !convex_enough(p) && (!worst || p.deviation > worst->deviation)) worst = &p;
      }
      if (!worst) break;
      std::optional<std::array<CutPiece, 2>> sides;
      if (worst->rejected.size() < kMaxRejected) sides = best_split(*worst, rule, reflex);
      if (!sides) {
        if (taken_back < rule.taken_back && worst->parent) {
          ++taken_back;
          take_back(pieces, *worst);
        } else {
          worst->final = true;
        }
        continue;
      }
      if (rule.taken_back > 0) {
        const auto parent = std::make_shared<const CutPiece>(std::move(*worst));
        for (auto& side : *sides) side.parent = parent;
      }
      *worst = std::move((*sides)[0]);
      pieces.push_back(std::move((*sides)[1]));
    }
    return pieces;
  }

  // Joins pairs of pieces, best first, whose common hull is near the surface and keeps clear of all
  // other pieces.
  std::vector<CutPiece> merge(std::vector<CutPiece> pieces) const {
    struct Pair {
      std::size_t a, b;
      CutPiece whole;
    };
    std::vector<Pair> pairs;
    std::vector<char> alive(pieces.size(), 1);
    const auto consider = [&](std::size_t a, std::size_t b) {
      if (!touch(pieces[a], pieces[b])) return;
      CutPiece whole;
      if (!join(pieces[a], pieces[b], whole)) return;
      if (!convex_enough(whole)) return;
      pairs.push_back({a, b, std::move(whole)});
    };
    for (std::size_t b = 1; b < pieces.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) consider(a, b);
    }
    while (!pairs.empty()) {
      std::size_t best = pairs.size();
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (best < pairs.size() && pairs[i].whole.surplus >= pairs[best].whole.surplus) continue;
        const Pair& p = pairs[i];
        bool clear = true;
        for (std::size_t k = 0; k < pieces.size() && clear; ++k) {
          if (alive[k] && k != p.a && k != p.b) clear = apart(p.whole, pieces[k]);
        }
        if (clear) best = i;
      }
      if (best == pairs.size()) break;
      Pair chosen = std::move(pairs[best]);
      alive[chosen.a] = alive[chosen.b] = 0;
      std::erase_if(pairs, [&alive](const Pair& p) { return !alive[p.a] || !alive[p.b]; });
      pieces.push_back(std::move(chosen.whole));
      alive.push_back(1);
      const std::size_t fresh = pieces.size() - 1;
      for (std::size_t k = 0; k < fresh; ++k) {
        if (alive[k]) consider(k, fresh);
      }
    }
    std::vector<CutPiece> result;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (alive[i]) result.push_back(std::move(pieces[i]));
    }
    return result;
  }

 private:
  // Puts the piece that `stuck` was cut from in the place of all that came of it.
  static void take_back(std::vector<CutPiece>& pieces, const CutPiece& stuck) {
    const std::shared_ptr<const CutPiece> parent = stuck.parent;
    CutPiece again = *parent;
    again.rejected.push_back(stuck.path[parent->path.size()]);
    std::erase_if(pieces, [&parent](const CutPiece& p) {
      const CutPiece* ancestor = p.parent.get();
      while (ancestor && ancestor != parent.get()) ancestor = ancestor->parent.get();
      return ancestor != nullptr;
    });
    pieces.push_back(std::move(again));
  }

  double volume(const std::vector<Facet>& boundary) const {
    double sum = 0;
    for (const auto& f : boundary) {
      sum += (f.corners[0] - origin_).dot((f.corners[1] - origin_).cross(f.corners[2] - origin_));
    }
    return sum / 6;
  }

  // Corners within the solid of both sides of a cut.
  void add_inner(const CutPiece& piece, const HalfSpace& cut, std::vector<Vec3>& below,
                 std::vector<Vec3>& above) const {
    for (const Vec3& p : piece.inner) {
      const double height = cut.normal.dot(p) - cut.offset;
      if (height <= snap_) below.push_back(p);
      if (height >= -snap_) above.push_back(p);
    }
    for (std::size_t i = 0; i < piece.cuts.size(); ++i) {
      for (std::size_t j = i + 1; j < piece.cuts.size(); ++j) {
        const HalfSpace &a = piece.cuts[i], &b = piece.cuts[j];
        const Vec3 along = a.normal.cross(b.normal);
        const double volume = along.dot(cut.normal);
        if (std::abs(volume) < 1e-9) continue;
        const Vec3 p = (a.offset * b.normal.cross(cut.normal) +
                        b.offset * cut.normal.cross(a.normal) + cut.offset * along) /
                       volume;
        const bool in_cell =
            std::all_of(piece.cuts.begin(), piece.cuts.end(),
                        [&](const HalfSpace& h) { return h.normal.dot(p) - h.offset <= snap_; });
        if (!in_cell || !solid_.contains(p)) continue;
        below.push_back(p);
        above.push_back(p);
      }
    }
  }

  bool set_hull(CutPiece& piece, const std::vector<Vec3>& points) const {
    const auto hull = quick_hull(points, snap_);
    if (!hull) return false;
    piece.planes = hull->planes;
    piece.corners.clear();
    piece.outer_area = 0;
    for (const int i : hull->corners) piece.corners.push_back(points[i]);
    piece.surplus = hull->volume - piece.volume;
    // Cuts that the piece does not reach do not bound it.
    std::erase_if(piece.cuts, [&](const HalfSpace& cut) {
      return std::all_of(piece.corners.begin(), piece.corners.end(), [&](const Vec3& p) {
        return cut.normal.dot(p) < cut.offset - 1e-6 * size_;
      });
    });
    for (std::size_t i = 0; i < piece.planes.size(); ++i) {
      HalfSpace& h = piece.planes[i];
      for (const auto& cut : piece.cuts) h.internal |= same_plane(h, cut);
      const auto& [a, b, c] = hull->triangles[i];
      if (!h.internal) {
        piece.outer_area += 0.5 * (points[b] - points[a]).cross(points[c] - points[a]).norm();
      }
    }
    return true;
  }

  bool same_plane(const HalfSpace& a, const HalfSpace& b) const {
    return (a.normal - b.normal).squaredNorm() < 1e-12 &&
           std::abs(a.offset - b.offset) < 1e-6 * size_;
  }

  // A facet in the plane of a cut is surface there, and at the hull.
  bool lies_in_cut(const CutPiece& piece, const Facet& f) const {
    for (const auto& cut : piece.cuts) {
      if ((cut.normal - f.normal).squaredNorm() < 1e-12 &&
          std::abs(cut.normal.dot(f.corners[0]) - cut.offset) < 1e-6 * size_) {
        return true;
      }
    }
    return false;
  }

  bool set_deviation(CutPiece& piece) const {
    piece.deviation = 0;
    std::size_t surface = 0;
    for (const auto& f : piece.boundary) surface += !f.cap;
    if (surface == 0) return true;
    const std::size_t stride = 1 + surface / kSamples;
    std::size_t near = 0;  // plane that is nearest to the last point
    for (std::size_t i = 0; i < piece.boundary.size(); i += stride) {
      const Facet& f = piece.boundary[i];
      if (f.cap || lies_in_cut(piece, f)) continue;
      const auto& c = f.corners;
      for (const Vec3& p : {middle(f), c[0], Vec3((c[0] + c[1]) / 2), Vec3((c[1] + c[2]) / 2),
                            Vec3((c[2] + c[0]) / 2), c[1], c[2]}) {
        double depth = depth_below(piece, near, p, kInfinity);
        for (std::size_t k = 0; k < piece.planes.size() && depth > piece.deviation; ++k) {
          const double d = depth_below(piece, k, p, depth);
          if (d < depth) {
            depth = d;
            near = k;
          }
        }
        if (!std::isfinite(depth)) {  // cuts all around
          for (const auto& h : piece.planes) depth = std::min(depth, h.offset - h.normal.dot(p));
        }
        piece.deviation = std::max(piece.deviation, depth);
      }
    }
    // A void may be bounded by cuts alone: its mean depth below the hull's outer faces.
    if (piece.outer_area > 0) {
      piece.deviation = std::max(piece.deviation, 2 * piece.surplus / piece.outer_area);
    }
    return true;
  }

  static double depth_below(const CutPiece& piece, std::size_t plane, const Vec3& p, double most) {
    const HalfSpace& h = piece.planes[plane];
    return h.internal ? most : std::min(most, h.offset - h.normal.dot(p));
  }

  // All facets by depth, deepest first.
  std::vector<Notch> notches(const CutPiece& piece) const {
    std::vector<Notch> result;
    const std::size_t stride = 1 + piece.boundary.size() / 4000;
    for (std::size_t i = 0; i < piece.boundary.size(); i += stride) {
      const Facet& f = piece.boundary[i];
      if (f.cap || lies_in_cut(piece, f)) continue;
      Notch notch{-1, i, Vec3::Zero()};
      for (const Vec3& p : {middle(f), f.corners[0], f.corners[1], f.corners[2]}) {
        const double depth = depth_of(piece, p);
        if (depth > notch.depth) notch = {depth, i, p};
      }
      result.push_back(notch);
    }
    std::stable_sort(result.begin(), result.end(),
                     [](const Notch& a, const Notch& b) { return a.depth > b.depth; });
    return result;
  }

  double depth_of(const CutPiece& piece, const Vec3& p) const {
    double depth = kInfinity;
    for (const auto& h : piece.planes) {
      if (!h.internal) depth = std::min(depth, h.offset - h.normal.dot(p));
    }
    return std::isfinite(depth) ? depth : 0;
  }

  // The two sides of a boundary. The cap of a side is a cone over its outline in the plane.
  void clip(const std::vector<Facet>& boundary, const HalfSpace& cut, std::vector<Facet>& below,
            std::vector<Facet>& above) const {
    Outline low_outline, high_outline;
    for (const auto& f : boundary) {
      std::array<double, 3> h;
      for (int k = 0; k < 3; ++k) {
        h[k] = cut.normal.dot(f.corners[k]) - cut.offset;
        if (std::abs(h[k]) <= snap_) h[k] = 0;
      }
      const auto [low, high] = std::minmax({h[0], h[1], h[2]});
      if (low == 0 && high == 0) {  // a facet in the plane belongs to the body on its inner side
        const bool up = f.normal.dot(cut.normal) > 0;
        (up ? below : above).push_back(f);
        for (int k = 0; k < 3; ++k) {
          add_segment(f, f.corners[k], f.corners[(k + 1) % 3], up ? low_outline : high_outline);
        }
        continue;
      }
      if (low < 0) keep(f, h, 1, below, low_outline);
      if (high > 0) keep(f, h, -1, above, high_outline);
    }
    add_cap(cut, cut.normal, low_outline, below);
    add_cap(cut, -cut.normal, high_outline, above);
  }

  struct Segment {
    Vec3 a, b;
  };
  // Where the boundary of a side meets the plane of the cut. Segments of the cap of an earlier cut
  // lie on one line, and most of them cancel.
  struct Outline {
    std::vector<Segment> surface;
    std::vector<std::pair<Vec3, std::vector<Segment>>> caps;  // by the normal of the cap
  };

  static void add_segment(const Facet& f, const Vec3& a, const Vec3& b, Outline& outline) {
    if (!f.cap) {
      outline.surface.push_back({a, b});
      return;
    }
    for (auto& [normal, segments] : outline.caps) {
      if (normal == f.normal) {
        segments.push_back({a, b});
        return;
      }
    }
    outline.caps.push_back({f.normal, {{a, b}}});
  }

  void add_cap(const HalfSpace& cut, const Vec3& normal, const Outline& outline,
               std::vector<Facet>& out) const {
    const Vec3 apex = origin_ - (cut.normal.dot(origin_) - cut.offset) * cut.normal;
    for (const auto& s : outline.surface) out.push_back({{apex, s.b, s.a}, normal, true});
    for (const auto& [other, segments] : outline.caps) {
      const Vec3 across = other.cross(normal);
      if (across.norm() < 1e-9) {  // a cap in this very plane
        for (const auto& s : segments) out.push_back({{apex, s.b, s.a}, normal, true});
        continue;
      }
      const Vec3 along = across.normalized(), start = segments[0].a;
      std::vector<std::pair<double, int>>
          ends;  // along the line: how often it is covered from here
      for (const auto& s : segments) {
        ends.emplace_back(along.dot(s.a - start), 1);
        ends.emplace_back(along.dot(s.b - start), -1);
      }
      std::sort(ends.begin(), ends.end());
      int cover = 0;
      double from = 0;
      for (std::size_t i = 0; i < ends.size();) {
        const double at = ends[i].first;
        int change = 0;
        for (; i < ends.size() && ends[i].first - at <= snap_; ++i) change += ends[i].second;
        if (change == 0) continue;
        const Vec3 p = start + from * along, q = start + at * along;
        for (int k = 0; k < std::abs(cover); ++k) {
          if (cover > 0) out.push_back({{apex, q, p}, normal, true});
          if (cover < 0) out.push_back({{apex, p, q}, normal, true});
        }
        cover += change;
        from = at;
      }
    }
  }

  // The part of a facet below the plane (sign 1) or above it (-1), and its edge in the plane.
  static void keep(const Facet& f, const std::array<double, 3>& h, int sign,
                   std::vector<Facet>& out, Outline& outline) {
    if (sign * h[0] < 0 && sign * h[1] < 0 && sign * h[2] < 0) {
      out.push_back(f);
      return;
    }
    std::array<Vec3, 4> polygon;
    std::array<bool, 4> on;
    int n = 0;
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      if (sign * h[k] <= 0) {
        polygon[n] = f.corners[k];
        on[n++] = h[k] == 0;
      }
      if (h[k] * h[next] < 0) {
        // From the lower end, so that both facets at the edge get the same point.
        const int a = h[k] < h[next] ? k : next, b = h[k] < h[next] ? next : k;
        polygon[n] = f.corners[a] + h[a] / (h[a] - h[b]) * (f.corners[b] - f.corners[a]);
        on[n++] = true;
      }
    }
    for (int k = 1; k + 1 < n; ++k) {
      out.push_back({{polygon[0], polygon[k], polygon[k + 1]}, f.normal, f.cap});
    }
    for (int k = 0; k < n; ++k) {
      const int next = (k + 1) % n;
      if (on[k] && on[next]) add_segment(f, polygon[k], polygon[next], outline);
    }
  }

  static Mat3 principal_axes(const CutPiece& piece) {
    double total = 0;
    Vec3 mean = Vec3::Zero();
    for (const auto& f : piece.boundary) {
      if (f.cap) continue;
      const double a = area(f);
      total += a;
      mean += a * middle(f);
    }
    mean /= total;
    Mat3 second = Mat3::Zero();
    for (const auto& f : piece.boundary) {
      if (f.cap) continue;
      for (const Vec3& p : f.corners) {
        second += area(f) / 3 * (p - mean) * (p - mean).transpose();
      }
    }
    return Eigen::SelfAdjointEigenSolver<Mat3>(second).eigenvectors();
  }

  // Planes worth trying.
  std::vector<HalfSpace> candidates(const CutPiece& piece, const Rule& rule,
                                    const std::vector<ReflexEdge>& reflex) const {
    std::vector<HalfSpace> result;
    const auto add = [&](const Vec3& normal, double offset) {
      for (const auto& h : result) {
        const double cosine = h.normal.dot(normal);
        const double other = cosine < 0 ? -h.offset : h.offset;
        if (std::abs(cosine) > 0.9995 && std::abs(other - offset) < 0.005 * size_) return false;
      }
      result.push_back({normal, offset, false});
      return true;
    };
    const std::vector<Notch> deep = notches(piece);
    if (deep.empty()) return result;
    if (!rule.halves) {
      add_walls(piece, deep, add);
      add_reflex(piece, reflex, add);
    }
    std::vector<Vec3> axes;
    const Mat3 own = principal_axes(piece);
    for (int k = 0; k < 3; ++k) axes.push_back(own.col(2 - k));
    for (const Vec3& n : main_normals(piece)) {
      if (std::none_of(axes.begin(), axes.end(),
                       [&n](const Vec3& a) { return std::abs(a.dot(n)) > 0.9995; })) {
        axes.push_back(n);
      }
    }
    // Across the deepest notches.
    int across = 0;
    std::vector<Vec3> known;
    for (const auto& notch : deep) {
      if (across == 3 || notch.depth < piece.deviation / 2) break;
      const Vec3& n = piece.boundary[notch.facet].normal;
      const Vec3 point = middle(piece.boundary[notch.facet]);
      if (std::any_of(known.begin(), known.end(),
                      [&n](const Vec3& k) { return k.dot(n) > 0.97; })) {
        continue;
      }
      known.push_back(n);
      ++across;
      for (const Vec3& axis : axes) {
        const Vec3 normal = n.cross(axis);
        if (normal.norm() > 0.3) add(normal.normalized(), normal.normalized().dot(point));
      }
    }
    for (const Vec3& axis : axes) {
      double low = kInfinity, high = -low;
      for (const Vec3& p : piece.corners) {
        low = std::min(low, axis.dot(p));
        high = std::max(high, axis.dot(p));
      }
      const auto at = [&](double part) { return low + part * (high - low); };
      add(axis, at(0.5));
      if (rule.halves) continue;
      add(axis, axis.dot(deep[0].point));
      for (const double part : {0.25, 0.75, 1.0 / 3, 2.0 / 3}) add(axis, at(part));
    }
    return result;
  }

  // Along the walls of deep notches.
  template <typename Add>
  void add_walls(const CutPiece& piece, const std::vector<Notch>& deep, const Add& add) const {
    constexpr int kWalls = 14;
    int walls = 0;
    for (const auto& notch : deep) {
      if (notch.depth < std::max(piece.deviation / 5, options_.tolerance / 2) || walls == kWalls) {
        break;
      }
      const Facet& f = piece.boundary[notch.facet];
      walls += add(f.normal, f.normal.dot(middle(f)));
    }
  }

  // Through concave edges: along either facet, and between them.
  template <typename Add>
  void add_reflex(const CutPiece& piece, const std::vector<ReflexEdge>& reflex,
                  const Add& add) const {
    constexpr std::size_t kEdges = 8;
    std::vector<std::pair<double, const ReflexEdge*>> edges;
    for (const auto& e : reflex) {
      double from = 0, to = 1;
      for (const auto& cut : piece.cuts) {
        const double a = cut.normal.dot(e.a) - cut.offset, b = cut.normal.dot(e.b) - cut.offset;
        if (a > snap_ && b > snap_) to = -1;
        if (a > snap_ && b <= snap_) from = std::max(from, a / (a - b));
        if (b > snap_ && a <= snap_) to = std::min(to, a / (a - b));
      }
      if (to - from < 1e-6) continue;
      const Vec3 point = e.a + 0.5 * (from + to) * (e.b - e.a);
      const double weight =
          depth_of(piece, point) * (to - from) * (e.b - e.a).norm() * e.n1.cross(e.n2).norm();
      if (weight > 0) edges.emplace_back(weight, &e);
    }
    std::stable_sort(edges.begin(), edges.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    std::size_t taken = 0;
    for (const auto& [weight, e] : edges) {
      const Vec3 along = (e->b - e->a).normalized();
      const Vec3 between = along.cross(e->n1 + e->n2);
      bool fresh = add(e->n1, e->n1.dot(e->a));
      fresh |= add(e->n2, e->n2.dot(e->a));
      if (between.norm() > 1e-6) {
        fresh |= add(between.normalized(), between.normalized().dot(e->a));
      }
      taken += fresh;
      if (taken == kEdges) break;
    }
  }

  // Up to three directions that the largest areas of the surface face.
  static std::vector<Vec3> main_normals(const CutPiece& piece) {
    std::vector<std::pair<double, Vec3>> groups;
    for (const auto& f : piece.boundary) {
      if (f.cap) continue;
      const auto group = std::find_if(groups.begin(), groups.end(), [&f](const auto& g) {
        return std::abs(g.second.dot(f.normal)) > 0.9999;
      });
      if (group != groups.end()) {
        group->first += area(f);
      } else if (groups.size() < 200) {
        groups.emplace_back(area(f), f.normal);
      }
    }
    std::stable_sort(groups.begin(), groups.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<Vec3> result;
    for (std::size_t i = 0; i < std::min<std::size_t>(3, groups.size()); ++i) {
      result.push_back(groups[i].second);
    }
    return result;
  }

  // Of a cut with normal n: what is left to do on both sides. A side that is convex enough costs
  // nothing.
  double cost(const std::array<CutPiece, 2>& sides, const Vec3& n, const Rule& rule) const {
    const double unit = size_ * size_ * size_;
    double sum = 0, least = kInfinity;
    for (const auto& s : sides) {
      const double excess = s.deviation / options_.tolerance, surplus = s.surplus / unit;
      double c = 0;
      if (excess > 1) {
        switch (rule.cost) {
          case Rule::Cost::volume:
            c = surplus;
            break;
          case Rule::Cost::root:
            c = std::cbrt(std::max(surplus, 0.0));
            break;
          case Rule::Cost::both:
            c = excess * surplus;
            break;
          case Rule::Cost::depth:
            c = excess;
            break;
        }
      }
      if (c > 0 && rule.thin_weight > 0) {
        c *= 1 + rule.thin_weight * options_.thinnest / thickness(s);
      }
      sum += c;
      least = std::min(least, c);
    }
    if (rule.cost == Rule::Cost::depth) sum -= 0.5 * least;
    // Of equal cuts the one of less surplus and less area is taken.
    double cap = 0;
    for (const auto& f : sides[0].boundary) {
      if (f.cap && f.normal == n) {
        cap += 0.5 * (f.corners[1] - f.corners[0]).cross(f.corners[2] - f.corners[0]).dot(n);
      }
    }
    return sum + 0.01 * (sides[0].surplus + sides[1].surplus) / unit +
           0.001 * cap / (size_ * size_);
  }

  double thickness(const CutPiece& piece) const {
    double least = kInfinity;
    for (const auto& h : piece.planes) {
      double deepest = 0;
      for (const Vec3& p : piece.corners) deepest = std::max(deepest, h.offset - h.normal.dot(p));
      least = std::min(least, deepest);
    }
    return least;
  }

  static bool was_rejected(const CutPiece& piece, const HalfSpace& cut) {
    return std::any_of(piece.rejected.begin(), piece.rejected.end(), [&cut](const HalfSpace& h) {
      return (h.normal == cut.normal && h.offset == cut.offset) ||
             (h.normal == -cut.normal && h.offset == -cut.offset);
    });
  }

  std::optional<std::array<CutPiece, 2>> best_split(const CutPiece& piece, const Rule& rule,
                                                    const std::vector<ReflexEdge>& reflex) const {
    std::optional<std::array<CutPiece, 2>> best;
    double best_cost = kInfinity;
    for (const auto& cut : candidates(piece, rule, reflex)) {
      if (was_rejected(piece, cut)) continue;
      auto sides = split(piece, cut);
      if (!sides) continue;
      const double c = cost(*sides, cut.normal, rule);
      if (c >= best_cost * (1 - 1e-9)) continue;
      if (thickness((*sides)[0]) < options_.thinnest || thickness((*sides)[1]) < options_.thinnest)
        continue;
      best_cost = c;
      best = std::move(sides);
    }
    return best;
  }

  bool touch(const CutPiece& a, const CutPiece& b) const {
    Vec3 low[2], high[2];
    const CutPiece* both[2] = {&a, &b};
    for (int i = 0; i < 2; ++i) {
      low[i] = high[i] = both[i]->corners[0];
      for (const Vec3& p : both[i]->corners) {
        low[i] = low[i].cwiseMin(p);
        high[i] = high[i].cwiseMax(p);
      }
    }
    const double gap = 1e-6 * size_;
    return ((low[0].array() <= high[1].array() + gap) && (low[1].array() <= high[0].array() + gap))
        .all();
  }

  bool join(const CutPiece& a, const CutPiece& b, CutPiece& whole) const {
    const auto opposite = [this](const HalfSpace& x, const HalfSpace& y) {
      return same_plane(x, {-y.normal, -y.offset, false});
    };
    const auto take = [&](const CutPiece& from, const CutPiece& other) {
      for (const auto& cut : from.cuts) {
        const bool shared = std::any_of(other.cuts.begin(), other.cuts.end(),
                                        [&](const HalfSpace& h) { return opposite(cut, h); });
        const bool known = std::any_of(whole.cuts.begin(), whole.cuts.end(),
                                       [&](const HalfSpace& h) { return same_plane(cut, h); });
        if (!shared && !known) whole.cuts.push_back(cut);
      }
    };
    take(a, b);
    take(b, a);
    std::vector<Vec3> points = a.corners;
    points.insert(points.end(), b.corners.begin(), b.corners.end());
    whole.inner = a.inner;
    whole.inner.insert(whole.inner.end(), b.inner.begin(), b.inner.end());
    whole.volume = a.volume + b.volume;
    if (!set_hull(whole, points)) return false;
    whole.boundary = a.boundary;
    whole.boundary.insert(whole.boundary.end(), b.boundary.begin(), b.boundary.end());
    return set_deviation(whole);
  }

  // True when a plane of either hull separates the two.
  bool apart(const CutPiece& a, const CutPiece& b) const {
    const double gap = 1e-6 * size_;
    const auto separates = [gap](const CutPiece& x, const CutPiece& y) {
      return std::any_of(x.planes.begin(), x.planes.end(), [&](const HalfSpace& h) {
        return std::all_of(y.corners.begin(), y.corners.end(),
                           [&](const Vec3& p) { return h.normal.dot(p) >= h.offset - gap; });
      });
    };
    return separates(a, b) || separates(b, a);
  }

  const Interior& solid_;
  DecomposeOptions options_;
  double size_, snap_;
  Vec3 origin_;
};

constexpr std::array<Rule, 5> kRules = {{{Rule::Cost::volume, false},
                                         {Rule::Cost::root, false},
                                         {Rule::Cost::both, false},
                                         {Rule::Cost::depth, false},
                                         {Rule::Cost::volume, true}}};

// A thorough search follows every rule as a quick one does, and once more with care.
std::vector<Rule> all_rules(bool thorough) {
  std::vector<Rule> rules(kRules.begin(), kRules.end());
  for (std::size_t i = 0; thorough && i < kRules.size(); ++i) {
    rules.push_back(kRules[i]);
    rules.back().thin_weight = kThinWeight;
    rules.back().taken_back = kTakenBack;
  }
  return rules;
}

Rule last_rule(bool thorough) {
  Rule rule = kRules[0];
  if (thorough) rule.thin_weight = kThinWeight;
  return rule;
}

// A tree of cuts, and what is left of it when pieces are joined.
struct Outcome {
  std::vector<CutPiece> tree, merged;
  double score = kInfinity;
};

Outcome follow_once(const Decomposer& decomposer, const CutPiece& plan, const Rule& rule,
                    const std::vector<ReflexEdge>& reflex, const DecomposeOptions& options) {
  Outcome o;
  o.tree = decomposer.cut_down({plan}, rule, reflex);
  o.merged = decomposer.merge(o.tree);
  double worst = 0;  // of the deviations, over the tolerance
  for (const auto& p : o.merged) worst = std::max(worst, p.deviation / options.tolerance);
  // Near the tolerance the number of parts counts, beyond it the deviation.
  const double near = options.thorough ? kNear : 1;
  o.score = static_cast<double>(o.merged.size()) + worst + (worst > near ? 100 * worst : 0);
  return o;
}

// Cuts are taken back only where the tree ends with pieces that no cut helps.
Outcome follow(const Decomposer& decomposer, const CutPiece& plan, const Rule& rule,
               const std::vector<ReflexEdge>& reflex, const DecomposeOptions& options) {
  Rule straight = rule;
  straight.taken_back = 0;
  Outcome first = follow_once(decomposer, plan, straight, reflex, options);
  const bool stuck =
      std::any_of(first.tree.begin(), first.tree.end(), [](const CutPiece& p) { return p.final; });
  if (!stuck || rule.taken_back == 0) return first;
  Outcome second = follow_once(decomposer, plan, rule, reflex, options);
  return second.score < first.score ? second : first;
}

// decompose() of a mesh whose box begins at the origin and has a diagonal of about 1.
Decomposition decompose_unit(const TriangleMesh& mesh, const DecomposeOptions& options) {
  const auto [lower, upper] = bounding_box(mesh);
  const double size = (upper - lower).norm();
  CutPiece whole;
  whole.boundary = sorted_facets(mesh);
  const Interior interior(mesh);
  const Decomposer decomposer(interior, options, size, (lower + upper) / 2);
  if (!decomposer.measure(whole)) throw InputError("the mesh is flat; expected a solid");
  std::vector<CutPiece> pieces;
  if (decomposer.convex_enough(whole) || options.max_parts == 1) {
    pieces.push_back(std::move(whole));
  } else {
    CutPiece plan = whole;
    if (plan.boundary.size() > options.plan_triangles) {
      plan.boundary = simplified(whole.boundary, options.plan_triangles, size);
    }
    const bool exact = plan.boundary.size() == whole.boundary.size();
    decomposer.measure(plan);
    const auto reflex = reflex_edges(plan.boundary, size);
    const std::vector<Rule> rules = all_rules(options.thorough);
    std::vector<Outcome> outcomes(rules.size());
    const int threads = std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1,
                                   static_cast<int>(rules.size()));
    parallel_for_blocks(threads, rules.size(), 1, [&](std::size_t i, std::size_t) {
      outcomes[i] = follow(decomposer, plan, rules[i], reflex, options);
    });
    Outcome& best =
        *std::min_element(outcomes.begin(), outcomes.end(),
                          [](const Outcome& a, const Outcome& b) { return a.score < b.score; });
    if (exact) {
      pieces = std::move(best.merged);
    } else {
      std::vector<const CutPiece*> leaves;
      for (const auto& leaf : best.tree) leaves.push_back(&leaf);
      decomposer.repeat_cuts(whole, leaves, 0, pieces);
      pieces = decomposer.merge(std::move(pieces));
    }
    for (auto& p : pieces) p.final = false;
    const std::size_t before = pieces.size();
    pieces = decomposer.cut_down(std::move(pieces), last_rule(options.thorough), reflex);
    if (pieces.size() > before) pieces = decomposer.merge(std::move(pieces));
  }
  Decomposition result;
  for (const auto& piece : pieces) {
    if (!decomposer.convex_enough(piece)) {
      const bool full = static_cast<int>(pieces.size()) >= options.max_parts;
      (full ? result.at_most_parts : result.stopped_by_thickness) = true;
    }
    std::vector<HalfSpace> hull = convex_hull(decomposer.fewer_corners(piece));
    for (auto& h : hull) {
      // The pieces on both sides of a cut get exactly opposite planes.
      for (const auto& cut : piece.cuts) {
        const bool same =
            (h.normal - cut.normal).norm() < 1e-6 && std::abs(h.offset - cut.offset) < 1e-6 * size;
        if (same) h = cut;
      }
    }
    result.pieces.push_back(std::move(hull));
  }
  return result;
}

}  // namespace

// Cuts of equal cost are common, and rounding errors would choose among them. The corners are
// therefore taken relative to the box and rounded: unit and place of the mesh do not matter.
Decomposition decompose(const TriangleMesh& mesh, const DecomposeOptions& options) {
  constexpr double kSteps = 0x1p32;  // of the box diagonal
  const auto [lower, upper] = bounding_box(mesh);
  const double size = (upper - lower).norm();
  TriangleMesh unit = mesh;
  for (Vec3& v : unit.vertices) v = ((v - lower) / size * kSteps).array().round() / kSteps;
  DecomposeOptions relative = options;
  relative.tolerance /= size;
  relative.thinnest /= size;
  Decomposition result = decompose_unit(unit, relative);
  for (auto& piece : result.pieces) {
    for (HalfSpace& h : piece) h.offset = size * h.offset + h.normal.dot(lower);
  }
  return result;
}

double wall_thickness(const TriangleMesh& mesh) {
  const auto facets = sorted_facets(mesh);
  const auto [lower, upper] = bounding_box(mesh);
  const double tiny = 1e-9 * (upper - lower).norm();
  const std::size_t stride = 1 + facets.size() / 300;
  std::vector<std::pair<double, double>> walls;  // thickness, area
  double total = 0;
  for (std::size_t i = 0; i < facets.size(); i += stride) {
    const Vec3 from = middle(facets[i]), way = -facets[i].normal;
    double nearest = kInfinity;
    for (const auto& f : facets) {
      const double speed = f.normal.dot(way);
      if (speed <= 0.1) continue;
      const double distance = f.normal.dot(f.corners[0] - from) / speed;
      if (distance <= tiny || distance >= nearest) continue;
      const Vec3 p = from + distance * way;
      bool inside = true;
      for (int k = 0; k < 3 && inside; ++k) {
        const Vec3 &a = f.corners[k], &b = f.corners[(k + 1) % 3];
        inside = (b - a).cross(p - a).dot(f.normal) >= -tiny * (b - a).norm();
      }
      if (inside) nearest = distance;
    }
    if (!std::isfinite(nearest)) continue;
    walls.emplace_back(nearest, area(facets[i]));
    total += walls.back().second;
  }
  std::sort(walls.begin(), walls.end());
  double sum = 0;
  for (const auto& [thickness, a] : walls) {
    sum += a;
    if (sum >= 0.05 * total) return thickness;
  }
  return (upper - lower).minCoeff();
}

}  // namespace firn
