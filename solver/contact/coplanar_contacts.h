// Contacts of coplanar faces as one contact: the division of a surface into convex parts has no
// effect on it.
#pragma once

#include <span>
#include <vector>

#include "solver/contact/patch_builder.h"

namespace firn {

// True for two contacts whose faces are in one plane on each body, within `tolerance` (m): both are
// pieces of one face, or of surfaces of several parts.
bool is_coplanar(const Manifold& c, const Manifold& d, double tolerance);

// Corners of the convex hull of the outlines of coplanar contacts, with the weights of one face.
// Their mean is the centroid of the faces, also where these are not convex together. `contacts`:
// indices into `all`. Empty if the hull has no area.
void merge_coplanar_contacts(std::span<const PartContact> all, std::span<const int> contacts,
                             std::vector<ManifoldPoint>& out);

}  // namespace firn
