#include "solver/shapes/cut_piece.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "solver/geometry/quick_hull.h"
#include "solver/shapes/clip_facets.h"

namespace firn {
namespace {

constexpr std::size_t kMaxCuts = 32;   // of one piece
constexpr std::size_t kSamples = 700;  // facets whose depth is measured
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Signed volume of a closed boundary, m^3.
double volume_of(const std::vector<Facet>& boundary, const CutSettings& s) {
  double sum = 0;
  for (const auto& f : boundary) {
    sum += (f.corners[0] - s.origin).dot((f.corners[1] - s.origin).cross(f.corners[2] - s.origin));
  }
  return sum / 6;
}

// Appends the inner corners of both sides of a cut.
void add_inner_corners(const CutPiece& piece, const HalfSpace& cut, const CutSettings& s,
                       std::vector<Vec3>& below, std::vector<Vec3>& above) {
  for (const Vec3& p : piece.inner_corners) {
    const double height = cut.normal.dot(p) - cut.offset;
    if (height <= s.snap) below.push_back(p);
    if (height >= -s.snap) above.push_back(p);
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
                      [&](const HalfSpace& h) { return h.normal.dot(p) - h.offset <= s.snap; });
      if (!in_cell || !s.interior.contains(p)) continue;
      below.push_back(p);
      above.push_back(p);
    }
  }
}

// Computes the hull of `points`, the surplus and the outer area from the volume and the cuts of the
// piece. False if the points are in a plane.
bool compute_hull(CutPiece& piece, const std::vector<Vec3>& points, const CutSettings& s) {
  const auto hull = quick_hull(points, s.snap);
  if (!hull) return false;
  piece.planes = hull->planes;
  piece.corners.clear();
  piece.outer_area = 0;
  for (const int i : hull->corners) piece.corners.push_back(points[i]);
  piece.surplus = hull->volume - piece.volume;
  // Cuts that the piece does not reach do not bound it.
  std::erase_if(piece.cuts, [&](const HalfSpace& cut) {
    return std::all_of(piece.corners.begin(), piece.corners.end(), [&](const Vec3& p) {
      return cut.normal.dot(p) < cut.offset - 1e-6 * s.size;
    });
  });
  for (std::size_t i = 0; i < piece.planes.size(); ++i) {
    HalfSpace& h = piece.planes[i];
    for (const auto& cut : piece.cuts) h.internal |= same_plane(h, cut, s);
    const auto& [a, b, c] = hull->triangles[i];
    if (!h.internal) {
      piece.outer_area += 0.5 * (points[b] - points[a]).cross(points[c] - points[a]).norm();
    }
  }
  return true;
}

void compute_deviation(CutPiece& piece, const CutSettings& s) {
  piece.deviation = 0;
  std::size_t surface = 0;
  for (const auto& f : piece.boundary) surface += !f.cap;
  if (surface == 0) return;
  const std::size_t stride = 1 + surface / kSamples;
  std::vector<HalfSpace> faces;  // outer ones; cuts all around count where there are no others
  for (const auto& h : piece.planes) {
    if (!h.internal) faces.push_back(h);
  }
  if (faces.empty()) faces = piece.planes;
  std::size_t near = 0;  // face that is nearest to the last point
  for (std::size_t i = 0; i < piece.boundary.size(); i += stride) {
    const Facet& f = piece.boundary[i];
    if (f.cap || is_in_cut(f, piece, s)) continue;
    const auto& c = f.corners;
    for (const Vec3& p : {facet_centroid(f), c[0], Vec3((c[0] + c[1]) / 2), Vec3((c[1] + c[2]) / 2),
                          Vec3((c[2] + c[0]) / 2), c[1], c[2]}) {
      double depth = faces[near].offset - faces[near].normal.dot(p);
      for (std::size_t k = 0; k < faces.size() && depth > piece.deviation; ++k) {
        const double d = faces[k].offset - faces[k].normal.dot(p);
        if (d < depth) {
          depth = d;
          near = k;
        }
      }
      piece.deviation = std::max(piece.deviation, depth);
    }
  }
  // A void may be bounded by cuts alone: its mean depth below the hull's outer faces.
  if (piece.outer_area > 0) {
    piece.deviation = std::max(piece.deviation, 2 * piece.surplus / piece.outer_area);
  }
}

}  // namespace

bool is_convex_enough(const CutPiece& piece, const CutSettings& s) {
  return piece.deviation <= s.options.tolerance;
}

bool same_plane(const HalfSpace& a, const HalfSpace& b, const CutSettings& s) {
  return (a.normal - b.normal).squaredNorm() < 1e-12 &&
         std::abs(a.offset - b.offset) < 1e-6 * s.size;
}

bool is_in_cut(const Facet& f, const CutPiece& piece, const CutSettings& s) {
  for (const auto& cut : piece.cuts) {
    if ((cut.normal - f.normal).squaredNorm() < 1e-12 &&
        std::abs(cut.normal.dot(f.corners[0]) - cut.offset) < 1e-6 * s.size) {
      return true;
    }
  }
  return false;
}

double depth_below_hull(const Vec3& p, const CutPiece& piece, double enough) {
  double depth = kInfinity;
  for (const auto& h : piece.planes) {
    if (!h.internal) depth = std::min(depth, h.offset - h.normal.dot(p));
    if (depth <= enough) break;
  }
  return std::isfinite(depth) ? depth : 0;
}

double hull_thickness(const CutPiece& piece) {
  double least = kInfinity;
  for (const auto& h : piece.planes) {
    double deepest = 0;
    for (const Vec3& p : piece.corners) {
      deepest = std::max(deepest, h.offset - h.normal.dot(p));
      if (deepest >= least) break;  // this face does not count
    }
    least = std::min(least, deepest);
  }
  return least;
}

bool measure_piece(CutPiece& piece, const CutSettings& s) {
  std::vector<Vec3> points = piece.inner_corners;
  points.reserve(points.size() + 3 * piece.boundary.size());
  for (const auto& f : piece.boundary) {
    if (!f.cap) points.insert(points.end(), f.corners.begin(), f.corners.end());
  }
  piece.volume = volume_of(piece.boundary, s);
  if (!compute_hull(piece, points, s)) return false;
  compute_deviation(piece, s);
  return true;
}

std::optional<std::array<CutPiece, 2>> split_piece(const CutPiece& piece, const HalfSpace& cut,
                                                   const CutSettings& s) {
  if (piece.cuts.size() >= kMaxCuts) return std::nullopt;
  std::array<CutPiece, 2> sides;
  ClippedFacets clipped = clip_facets(piece.boundary, cut, s.snap, s.origin);
  sides[0].boundary = std::move(clipped.below);
  sides[1].boundary = std::move(clipped.above);
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
    if (-lowest < s.options.min_thickness) return std::nullopt;
  }
  add_inner_corners(piece, cut, s, sides[0].inner_corners, sides[1].inner_corners);
  // The caps of a cut that rounding errors leave open would add or lose volume.
  const double exact = 1e-7 * s.size * s.size * s.size;
  for (auto& side : sides) {
    if (!measure_piece(side, s) || side.volume <= 1e-12 * s.size * s.size * s.size)
      return std::nullopt;
    if (side.surplus < -exact) return std::nullopt;
  }
  if (std::abs(sides[0].volume + sides[1].volume - piece.volume) > exact) return std::nullopt;
  return sides;
}

std::optional<CutPiece> join_pieces(const CutPiece& a, const CutPiece& b, const CutSettings& s) {
  CutPiece whole;
  const auto opposite = [&s](const HalfSpace& x, const HalfSpace& y) {
    return same_plane(x, {-y.normal, -y.offset, false}, s);
  };
  const auto add_cuts = [&](const CutPiece& from, const CutPiece& other) {
    for (const auto& cut : from.cuts) {
      const bool shared = std::any_of(other.cuts.begin(), other.cuts.end(),
                                      [&](const HalfSpace& h) { return opposite(cut, h); });
      const bool known = std::any_of(whole.cuts.begin(), whole.cuts.end(),
                                     [&](const HalfSpace& h) { return same_plane(cut, h, s); });
      if (!shared && !known) whole.cuts.push_back(cut);
    }
  };
  add_cuts(a, b);
  add_cuts(b, a);
  std::vector<Vec3> points = a.corners;
  points.insert(points.end(), b.corners.begin(), b.corners.end());
  whole.inner_corners = a.inner_corners;
  whole.inner_corners.insert(whole.inner_corners.end(), b.inner_corners.begin(),
                             b.inner_corners.end());
  whole.volume = a.volume + b.volume;
  if (!compute_hull(whole, points, s)) return std::nullopt;
  whole.boundary = a.boundary;
  whole.boundary.insert(whole.boundary.end(), b.boundary.begin(), b.boundary.end());
  compute_deviation(whole, s);
  return whole;
}

bool boxes_touch(const CutPiece& a, const CutPiece& b, const CutSettings& s) {
  Vec3 low[2], high[2];
  const CutPiece* both[2] = {&a, &b};
  for (int i = 0; i < 2; ++i) {
    low[i] = high[i] = both[i]->corners[0];
    for (const Vec3& p : both[i]->corners) {
      low[i] = low[i].cwiseMin(p);
      high[i] = high[i].cwiseMax(p);
    }
  }
  const double gap = 1e-6 * s.size;
  return ((low[0].array() <= high[1].array() + gap) && (low[1].array() <= high[0].array() + gap))
      .all();
}

bool hulls_are_separate(const CutPiece& a, const CutPiece& b, const CutSettings& s) {
  const double gap = 1e-6 * s.size;
  const auto separates = [gap](const CutPiece& x, const CutPiece& y) {
    return std::any_of(x.planes.begin(), x.planes.end(), [&](const HalfSpace& h) {
      return std::all_of(y.corners.begin(), y.corners.end(),
                         [&](const Vec3& p) { return h.normal.dot(p) >= h.offset - gap; });
    });
  };
  return separates(a, b) || separates(b, a);
}

std::vector<Vec3> reduced_corners(const CutPiece& piece, const CutSettings& s) {
  constexpr std::size_t kMaxCorners = 1000;
  if (piece.corners.size() <= kMaxCorners) return piece.corners;
  const auto coarse = quick_hull(piece.corners, 0.1 * s.options.tolerance);
  if (!coarse) return piece.corners;
  std::vector<char> kept(piece.corners.size(), 0);
  for (const int i : coarse->corners) kept[i] = 1;
  std::vector<Vec3> result;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const bool on_cut = std::any_of(piece.cuts.begin(), piece.cuts.end(), [&](const HalfSpace& h) {
      return std::abs(h.normal.dot(piece.corners[i]) - h.offset) <= 1e-6 * s.size;
    });
    if (kept[i] || on_cut) result.push_back(piece.corners[i]);
  }
  return result;
}

}  // namespace firn
