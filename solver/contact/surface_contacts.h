// Contacts of parts that are pieces of one plane surface become one contact of that surface.
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
  double plane_offset = 0;  // m, of a plane
  double shell = 0;         // m
};

// Keeps of the first `count` contacts one for each pair of surfaces, with the region of all of
// them, and moves the contacts that remain to the front. Returns how many these are.
std::size_t join_surface_contacts(const SurfacePair& pair, std::vector<PartContact>& contacts,
                                  std::size_t count);

}  // namespace firn
