// Pieces of a solid that is cut by planes: their hulls, measures, cuts and unions.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "firn/convex_part.h"
#include "solver/geometry/point_in_mesh.h"
#include "solver/shapes/convex_decomposition.h"
#include "solver/shapes/facets.h"

namespace firn {

// The solid and the limits of its decomposition, the same for all pieces.
struct CutSettings {
  const PointInMesh& interior;  // of the solid
  DecomposeOptions options;
  double size;                 // m, diagonal of the bounding box of the solid
  double snap;                 // m, points as close to a plane count as on it
  Vec3 origin = Vec3::Zero();  // m, center of the bounding box
};

struct CutPiece {
  std::vector<Facet> boundary;
  std::vector<HalfSpace> path;    // cuts that lead from the solid to the piece, which is below all
  std::vector<HalfSpace> cuts;    // those that the piece reaches
  std::vector<HalfSpace> planes;  // of the hull; internal: on a cut
  std::vector<Vec3> corners;      // m, of the hull
  std::vector<Vec3> inner_corners;  // m, points within the solid in which three cuts intersect
  double volume = 0;                // m^3
  double surplus = 0;               // m^3, volume of the hull less that of the piece
  double outer_area = 0;            // m^2, of the hull's faces that are on no cut
  double deviation = 0;             // m, deepest point of the surface below the hull's outer faces
  // Written by the search for cuts.
  bool final = false;                      // no cut helps
  std::shared_ptr<const CutPiece> parent;  // the piece that was cut; set if the rule backtracks
  std::vector<HalfSpace> rejected;         // cuts of the piece that were undone
};

bool is_convex_enough(const CutPiece& piece, const CutSettings& settings);

// True for equal normals and offsets, to 1e-6 and a millionth of the size.
bool same_plane(const HalfSpace& a, const HalfSpace& b, const CutSettings& settings);

// True if the facet is in the plane of a cut. It is then surface of the solid and on the hull.
bool is_in_cut(const Facet& f, const CutPiece& piece, const CutSettings& settings);

// Depth (m) of a point below the nearest outer face of the hull. 0 if all faces are on cuts. Where
// it is at most `enough`, it may be overestimated, up to `enough`.
double depth_below_hull(const Vec3& point, const CutPiece& piece, double enough = -1);

// Least width (m) of the hull, normal to one of its faces.
double hull_thickness(const CutPiece& piece);

// Computes hull and measures from `boundary`, `cuts` and `inner_corners`. `cuts` that the hull does
// not reach are removed. False for a flat or empty piece, whose measures are then undefined. The
// deviation is sampled on about 700 facets. It is at least twice the surplus over the outer area,
// since a void may be bounded by cuts alone.
bool measure_piece(CutPiece& piece, const CutSettings& settings);

// The sides below and above `cut`, measured. Nothing when a side is empty, flat or thinner than
// allowed, when rounding errors change the volume, or after 32 cuts.
std::optional<std::array<CutPiece, 2>> split_piece(const CutPiece& piece, const HalfSpace& cut,
                                                   const CutSettings& settings);

// The union of two pieces, measured, within its hull. Cuts between the two are removed. Nothing
// for a flat union.
std::optional<CutPiece> join_pieces(const CutPiece& a, const CutPiece& b,
                                    const CutSettings& settings);

// True if the bounding boxes touch.
bool boxes_touch(const CutPiece& a, const CutPiece& b, const CutSettings& settings);

// True if a plane of either hull separates the two. Overlaps up to a millionth of the size count as
// touch.
bool hulls_are_separate(const CutPiece& a, const CutPiece& b, const CutSettings& settings);

// Corners of the hull. Of more than 1000 only those that keep it within a tenth of the tolerance,
// and all on cuts, so that neighbors still share their faces.
std::vector<Vec3> reduced_corners(const CutPiece& piece, const CutSettings& settings);

}  // namespace firn
