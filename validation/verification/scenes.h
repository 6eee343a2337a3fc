// Small models that the verification suite, tests and benchmarks share. SI, world axes with z up.
#pragma once

#include <cstdint>
#include <numbers>

#include "solver/solver.h"

namespace firn::scenes {

inline constexpr double kGravity = 9.81;  // m/s^2
inline constexpr double kDegree = std::numbers::pi / 180;
inline constexpr int kIce = 0, kPlastic = 1;  // materials of every scene

// Static and dynamic friction alike.
Interaction law(double friction, double restitution);

// No bodies; ice of 916.7 kg/m^3 and 0.01 GPa, and a plastic for walls.
Model empty(const Interaction& ice_ice, const Interaction& ice_plastic);

// Options of a shape whose mass (kg) and stiffness (N/m) are given. Rounding in m.
ShapeOptions ice_options(double mass, double stiffness, double rounding);
// The icemaker's crescent with its own density and Young's modulus and edges rounded by 1 mm.
Shape crescent(
    const CrescentParameters& parameters = named_crescent("mass-matched", {}).parameters);

// Append to the model; return the index (the first one).
int add_shape(Model& model, Shape shape);
int add_particles(Model& model, int shape, int count = 1);
// A half-space, solid below. A rigid one leaves the pair the stiffness of the particle.
int add_plane(Model& model, const Vec3& point, const Vec3& normal, bool rigid = true);
// A solid box at rest, by its two corners; edges rounded (m).
int add_panel(Model& model, const std::string& name, const Vec3& lower, const Vec3& upper,
              double rounding = 1e-3);
// Walls and floor of a box with its inner lower corner and size given, as planes of plastic.
void add_box_of_planes(Model& model, const Vec3& corner, const Vec3& size);

// One body of this shape over the plane z = 0; the pair has the stiffness of the shape.
Model body_on_plane(Shape shape, const Interaction& ice_plastic);

// Random numbers whose stream does not depend on the standard library.
class Random {
 public:
  explicit Random(std::uint64_t seed);
  double uniform(double low, double high);
  Quat orientation();  // uniform over all rotations
 private:
  std::uint64_t next();
  std::uint64_t state_;
};

// Places waiting particles [first, last) at rest, at random in the region and clear of all others.
// Throws RunError when one finds no room.
void scatter(Solver& solver, int first, int last, const Vec3& lower, const Vec3& upper,
             std::uint64_t seed);

// The box of the drained repose experiment, 23.5 x 5.5 in, with a door in the middle of its floor
// (z = 0), and cubes that wait.
struct ReposeBox {
  Model model;
  int door = 0;       // boundary
  Vec3 lower, upper;  // m, where cubes may be placed
};
ReposeBox repose_box(int cubes);

// Centre of mass of a body of shape axes placed by `pose` (shape axes -> world).
Vec3 center_of_mass(const Shape& shape, const Pose& pose);

// Kinetic, gravitational and elastic.
double mechanical(const Energy& energy);

void run(Solver& solver, double duration);

}  // namespace firn::scenes
