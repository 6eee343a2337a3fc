// The constant model of a simulation.
#pragma once

#include <string>
#include <vector>

#include "firn/bond.h"
#include "firn/contact_statistics.h"
#include "firn/motion.h"
#include "firn/shape.h"

namespace firn {

struct Material {
  std::string name;
  double density = 0;        // kg/m^3; not used for boundaries
  double young_modulus = 0;  // Pa
  double poisson_ratio = 0;  // stored only: no equation of this contact model uses it
};

// Contact law of a pair of materials, equations (3)-(9) of docs/contact.md.
struct Interaction {
  double static_friction = 0;
  double dynamic_friction = 0;
  double restitution = 1;                  // epsilon of equation (5), in (0, 1]
  double tangential_stiffness_ratio = 1;   // K_tau / K_nl
  double minimum_unloading_ratio = 0.001;  // lambda of equation (3)
  double rolling_resistance = 0;           // limit of the rolling moment / (normal force * L)
  double restick_velocity = 1e-3;          // m/s, below which a sliding contact sticks again
  double adhesion_force = 0;               // N, attraction while two bodies overlap, per patch
  double adhesion_stiffness_fraction = 0;  // attraction over K_nl times the overlap
};

struct Particle {
  int shape = 0;
  int tag = 0;
};

struct Boundary {
  enum class Kind { plane, solid };
  std::string name;
  int material = 0;
  bool rigid = false;    // no compliance in series; Young's modulus is not used
  double stiffness = 0;  // N/m; 0: E_b * L of the particle, equation (7)
  Kind kind = Kind::plane;
  // Axes of the boundary. A plane is the half-space z <= 0 in these axes, solid below.
  Vec3 origin = Vec3::Zero();           // m, world, at t = 0
  Quat orientation = Quat::Identity();  // boundary axes -> world, at t = 0
  std::vector<ConvexPart> parts;        // m, boundary axes (solids)
  TriangleMesh mesh;                    // m, boundary axes, for display
  std::vector<Motion> motions;          // in addition to those of its frame
  int frame = -1;                       // motion frame that carries it; -1: the world
};

// Contact of two boundaries with each other, at least one of them on a free frame. Without one,
// boundaries pass through each other.
struct BoundaryContact {
  std::string name;
  int a = 0, b = 0;      // boundaries; a is a solid
  Interaction law;       // rolling resistance and adhesion are not used
  double stiffness = 0;  // N/m, loading
  double rounding = 0;   // m, rounding radius in this contact; faces do not move
};

struct Numerics {
  // Points with a gap below the contact margin are tracked as contact points. The margin is this
  // fraction of the smaller rounding radius of a pair, at most contact_margin_limit.
  double contact_margin = 0.06;
  double contact_margin_limit = 60e-6;  // m
  // Contacts are linearized until the relative motion of the two bodies exceeds this fraction of
  // the contact margin. 0: a contact search for every pair in every step.
  double contact_update_fraction = 1;
  double skin = 0;  // m, skin of the neighbor list; 0: 0.16 of the smallest bounding radius
  int threads = 1;
  // A run whose overlap exceeds this fraction of the smaller shape's smallest box edge is stopped.
  double overlap_limit = 0.5;
};

struct Model {
  Vec3 gravity = Vec3(0, 0, -9.81);  // m/s^2
  double timestep = 0;               // s
  std::vector<Material> materials;
  std::vector<Interaction> interactions;  // [material a * materials.size() + b], symmetric
  std::vector<Shape> shapes;
  std::vector<Particle> particles;  // all particles of the simulation, in order of their ids
  std::vector<Boundary> boundaries;
  std::vector<MotionFrame> frames;
  std::vector<Coupling> couplings;  // of free frames
  std::vector<BoundaryContact> boundary_contacts;
  std::vector<BeamLaw> beams;
  std::vector<Bond> bonds;  // act while both bodies are present, until they end
  Numerics numerics;
  StatisticsOptions statistics;

  const Interaction& interaction(int material_a, int material_b) const {
    return interactions[static_cast<std::size_t>(material_a) * materials.size() + material_b];
  }
};

inline const Shape& shape_of(const Model& model, int particle) {
  return model.shapes[index(model.particles[index(particle)].shape)];
}

// Bodies are numbered particles first, then boundaries.
inline bool is_particle(const Model& model, int body) {
  return body < static_cast<int>(model.particles.size());
}
// The boundary with this number of a body.
inline const Boundary& boundary_of(const Model& model, int body) {
  return model.boundaries[index(body) - model.particles.size()];
}
// The shape of a body at the end of a bond: that of a boundary is immovable_shape().
inline const Shape& bonded_shape(const Model& model, int body) {
  return is_particle(model, body) ? shape_of(model, body) : immovable_shape();
}

// Loading stiffness of a pair, equation (4), N/m.
double particle_pair_stiffness(const Shape& a, const Shape& b);
double boundary_pair_stiffness(const Model& model, const Shape& a, const Boundary& b);

// The largest stable time step and the reason: `steps` per quarter period (pi/2 sqrt(m_eff / K)) of
// the stiffest loading or unloading spring over all pairs of shapes and boundaries of the model, of
// its bonds and of the springs of free bodies.
struct TimestepAdvice {
  double timestep = 0;             // s
  bool limited_by_spring = false;  // false: no spring in the model, the step is a default
  std::string reason;              // one sentence naming the pair, stiffness, mass and period
};
TimestepAdvice advise_timestep(const Model& model, double steps);
// Minimum numbers of steps per quarter period: for a stable bed, and for an error of the
// restitution below 1 %. docs/contact.md, "Time step".
inline constexpr double kStableSteps = 3, kAccurateSteps = 6;

// Throws InputError (one sentence) for a model that cannot be simulated: no interaction for a pair
// that can be in contact, restitution outside (0, 1], dynamic above static friction, no time step,
// ...
void validate(const Model& model);

}  // namespace firn
