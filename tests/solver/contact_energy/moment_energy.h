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

// What a contact remembers: the way back from its deepest overlap, linear over the base plane.
struct MomentMemory {
  bool is_set = false;
  Vec3 place = Vec3::Zero();     // m, axes of b
  Vec3 gradient = Vec3::Zero();  // 1, axes of b
  double slack = 0;              // m, at the place
};

struct MomentContact {
  double energy = 0;   // J, recoverable
  double deepest = 0;  // m
  int regions = 0;     // pairs of solids that overlap
  Wrench wrench;       // elastic: the negative gradient of the energy
  MomentMemory memory;
};

// Elastic contact of two bodies; stiffness (N/m) is that of a face.
MomentContact moment_contact(double stiffness, const PiecedBody& a, const Pose& pose_a,
                             const PiecedBody& b, const Pose& pose_b);

// Contact of two convex solids with restitution in (0, 1). `velocity` (m/s) and `spin` (rad/s): of
// a minus b, at the origin of a, world axes; dt (s): since `before` was returned.
MomentContact hysteretic_moment_contact(double stiffness, double restitution, const PiecedSolid& a,
                                        const Pose& pose_a, const PiecedSolid& b,
                                        const Pose& pose_b, const MomentMemory& before,
                                        const Vec3& velocity, const Vec3& spin, double dt);

}  // namespace firn::contact_energy
