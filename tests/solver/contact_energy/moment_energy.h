// Contact energy from the moments of the overlap volume. docs/contact-energy.md explains the law
// and lists what was measured of it. Like contact_energy.h this is a reference: it cuts whole
// solids.
#pragma once

#include <vector>

#include "tests/solver/contact_energy/contact_energy.h"

namespace firn::contact_energy {

// A convex solid as disjoint convex pieces. Without pieces the solid is one piece.
// Faces of pieces that are no faces of the solid are seams: they have no effect.
struct PiecedSolid {
  Solid solid;
  std::vector<Solid> pieces;
  // Share of this solid among solids of the same body that overlap at a contact, e.g. the area of
  // the facet that bounds it.
  double weight = 1;
};

// A body as the union of convex solids that may overlap. Each is as large as the body permits.
using PiecedBody = std::vector<PiecedSolid>;

struct MomentContact {
  double energy = 0;   // J
  double deepest = 0;  // m
  int regions = 0;     // pairs of solids that overlap
  Wrench wrench;       // the negative gradient of the energy
};

// Elastic contact of two bodies; stiffness (N/m) is that of a face.
MomentContact moment_contact(double stiffness, const PiecedBody& a, const Pose& pose_a,
                             const PiecedBody& b, const Pose& pose_b);

}  // namespace firn::contact_energy
