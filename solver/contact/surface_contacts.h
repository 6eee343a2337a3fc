// Merges the contacts of parts that are pieces of one plane surface into one contact of that
// surface.
#pragma once

#include <span>
#include <vector>

#include "solver/contact/patch_builder.h"

namespace firn {

struct SurfacePair {
  std::span<const ConvexPart> parts_a, parts_b;  // b: none for a plane
  const FlatSurfaces& surfaces_a;
  const FlatSurfaces& surfaces_b;
  const Pose& b_in_a;
  double plane_offset = 0;    // m, of a plane
  double contact_margin = 0;  // m
};

// Replaces the contacts of each pair of surfaces among the first `count` by one contact with the
// region of all of them. A contact at a border of a surface that is deeper than this region stays.
// Moves the remaining contacts to the front and returns their number.
std::size_t join_surface_contacts(const SurfacePair& pair, std::vector<PartContact>& contacts,
                                  std::size_t count);

}  // namespace firn
