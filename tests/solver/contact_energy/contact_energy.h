// Contact energy of polyhedral bodies: the reference formulation of a contact law that follows from
// a potential and does not depend on how a body or a surface is cut. docs/contact-energy.md
// explains it and lists what was compared. It is written for clarity: no faster path exists yet.
#pragma once

#include <vector>

#include "solver/types.h"

namespace firn::contact_energy {

// A convex polyhedron in body axes, m. Coplanar facets are one face.
struct Solid {
  struct Face {
    Vec3 normal;            // unit, outward
    double offset = 0;      // m: normal . x on the face
    std::vector<int> loop;  // vertices, counter-clockwise seen from outside
  };
  struct Edge {
    int vertex[2];
    int face[2];
  };
  // The solid without face f: the intersection of the half-spaces of all other faces.
  struct WedgeEdge {
    Vec3 origin, direction;  // points origin + z direction, lower <= z <= upper (m)
    double lower = 0, upper = 0;
    int face[2];
  };
  struct WedgeVertex {
    Vec3 position;
    double curvature = 0;  // solid angle of the normal cone
  };
  std::vector<Vec3> vertices;
  std::vector<double> curvature;  // [vertices] angle deficit
  std::vector<Face> faces;
  std::vector<Edge> edges;
  std::vector<std::vector<WedgeEdge>> wedge_edges;       // [faces]
  std::vector<std::vector<WedgeVertex>> wedge_vertices;  // [faces]
};

// The convex hull of points. Points inside the hull, on faces or on edges leave no trace.
// Throws InputError for fewer than four points or a flat set.
Solid make_solid(const std::vector<Vec3>& points);

// A body as the union of convex solids that may overlap. Each should be as large as the body
// permits, so that none ends where the body does not.
using Body = std::vector<Solid>;

struct Law {
  double stiffness = 0;    // N/m: K of a face, an edge and a corner
  double restitution = 1;  // in (0, 1]
  double floor = 0.001;    // least unloading force over loading force
  double smoothing = 0;    // m: difference of depth over which the weight falls by 1/e
  // How fast the stiffness of two contacts of one pair of bodies ceases to be shared as their
  // normals turn apart: exp(-(1 - cosine) / coupling).
  double coupling = 0.3;
};

// Forces on a, and moments about the origins of a and b, world axes; b feels the opposite force.
struct Wrench {
  Vec3 force = Vec3::Zero();     // N
  Vec3 moment_a = Vec3::Zero();  // N m
  Vec3 moment_b = Vec3::Zero();  // N m

  void add(double factor, const Wrench& other);
};

// What a contact point remembers of its deepest overlap.
struct Memory {
  Vec3 place;        // m, axes of a
  double slack = 0;  // m, way back from the deepest overlap
};

struct Contact {
  double energy = 0;   // J, recoverable
  double deepest = 0;  // m
  Wrench wrench;
  std::vector<Memory> memory;
};

// Elastic contact of two bodies: the wrench is the negative gradient of the energy.
Contact elastic_contact(const Law& law, const Body& a, const Pose& pose_a, const Body& b,
                        const Pose& pose_b);

// Contact of two convex solids with restitution. `velocity` (m/s) and `spin` (rad/s): of a minus b,
// at the origin of a, world axes; dt (s): since `before` was returned.
Contact hysteretic_contact(const Law& law, const Solid& a, const Pose& pose_a, const Solid& b,
                           const Pose& pose_b, const std::vector<Memory>& before,
                           const Vec3& velocity, const Vec3& spin, double dt);

}  // namespace firn::contact_energy
