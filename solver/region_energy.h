// The energy of a contact region, and its gradient, from the depth of one body's facets below a
// plane of the other body. docs/contact-energy.md explains the law. No phase of the step uses it
// yet.
//
// The axes of a region lie in the base plane: x, y (m). A facet of the mover covers a part of that
// plane; its depth below it is linear. With the integrals I_n of (depth > 0)^n over all facets,
//
//   W = K/2 I_3 / I_1
#pragma once

#include <span>

namespace firn {

struct RegionEdge {
  double x0, y0, x1, y1;  // m; the facet is on its left
};

// One plane of the mover. Where it was cut or split there is no edge: only the outline counts, and
// integrals over outlines add up.
struct RegionFacet {
  double depth = 0, slope_x = 0, slope_y = 0;  // m, 1: depth + slope_x x + slope_y y
  int edge_count = 0;                          // its edges follow those of the facet before it
};

// How the mover moved since the facets were made: it sank in by depth + slope_x x + slope_y y.
struct RegionMotion {
  double depth = 0, slope_x = 0, slope_y = 0;  // m, 1
};

struct RegionEnergy {
  double energy = 0;                  // J
  double force = 0;                   // N, -dW by the motion's depth, pushes the bodies apart
  double moment_x = 0, moment_y = 0;  // N m, sum of force times x, times y: by the slopes
  double area = 0;                    // m^2, of the part that overlaps
  double area_x = 0, area_y = 0;      // m^3, its first moments
  double volume = 0;                  // m^3, I_1
};

// Edges that do not close to outlines, or whose order is reversed, give a wrong result without an
// error. No facet below the plane: all zero. stiffness: N/m, of a face.
RegionEnergy region_energy(double stiffness, std::span<const RegionFacet> facets,
                           std::span<const RegionEdge> edges, const RegionMotion& motion);

// A region of one facet, about the centroid of its outline.
struct FlatRegion {
  double area = 0;                            // m^2
  double center_x = 0, center_y = 0;          // m
  double xx = 0, xy = 0, yy = 0;              // m^2, second moments over the area
  double xxx = 0, xxy = 0, xyy = 0, yyy = 0;  // m^3, third moments over the area
};
FlatRegion flat_region(std::span<const RegionEdge> edges);

// As region_energy, for a facet that is nowhere above the plane; `facet` includes the motion.
// That is not checked: see is_below.
RegionEnergy flat_region_energy(double stiffness, const FlatRegion& region,
                                const RegionFacet& facet);

// True if no corner of the outline is above the plane.
bool is_below(std::span<const RegionEdge> edges, const RegionFacet& facet);

}  // namespace firn
