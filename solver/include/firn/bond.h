// Breakable bonds: short elastic beams between two particles, such as ice bridges between cubes, or
// between a particle and a boundary at rest, such as the ice that holds a cube in its mold.
//
// The law is that of a Timoshenko beam between two ends, each fixed to a body, formulated with the
// relative pose of the ends instead of increments: errors do not accumulate, and a rigid motion of
// both bodies, by any angle, has no effect. Strengths, and stresses from force and moment, are
// those of the parallel bond of Potyondy and Cundall (2004). docs/contact.md.
#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "firn/shape.h"

namespace firn {

// Cross section. Axes of a beam: x along it from a to b, y along the width of its section, z along
// the height.
struct BeamSection {
  double area = 0;               // m^2
  double shear_coefficient = 1;  // shear area over area; Cowper (1966)
  Vec3 inertia = Vec3::Zero();   // m^4: torsion constant, second moments about y and about z
  double half_width = 0;         // m, distance of the outermost fiber for bending about z
  double half_height = 0;        // m, the same for bending about y
  double torsion_modulus = 0;    // m^3: torsion over the largest shear stress
};
// Solid sections; lengths in m. Torsion of the rectangle: formulas of Roark, error below 0.5 %.
BeamSection rectangular_section(double width, double height, double poisson_ratio);
BeamSection round_section(double radius, double poisson_ratio);

struct BeamLaw {
  std::string name;
  BeamSection section;
  double length = 0;                            // m
  double young_modulus = 0, shear_modulus = 0;  // Pa
  double tensile_strength = 0;                  // Pa, by normal force and bending
  double shear_strength = 0;                    // Pa, by shear force and torsion
  double damping_ratio = 0;                     // of each of the six deformations separately
  // s, from the time at which both bodies are there until the bond ends, if it has not broken.
  double lifetime = std::numeric_limits<double>::infinity();
};

// A beam between the bodies a and b. The ends are given in body axes, from the centers of mass; an
// end on a boundary, in the axes of the boundary, from its origin. The beam is free of stress if
// both ends have equal axes and end b is at the distance `length` along x from end a.
struct Bond {
  int a = 0;    // particle
  int b = 0;    // particle, or number of particles + a boundary that nothing moves
  int law = 0;  // index into Model::beams
  Vec3 end_a = Vec3::Zero(), end_b = Vec3::Zero();            // m
  Quat axes_a = Quat::Identity(), axes_b = Quat::Identity();  // beam axes -> body axes
  double strength = 1;  // both strengths of this bond over those of its law
};

// Pose and velocity of a body, world axes. Body axes are the principal axes.
struct BodyInMotion {
  Vec3 position = Vec3::Zero();          // m, center of mass
  Vec3 velocity = Vec3::Zero();          // m/s, of the center of mass
  Vec3 angular_velocity = Vec3::Zero();  // rad/s
  Quat orientation = Quat::Identity();   // body axes -> world
};

// A bond between two bodies that is free of stress in their current poses. The beam has its center
// at `middle` (m, world), x along `axis` (any length, from a to b) and z along the component of
// `up` normal to `axis`. `length`: m.
Bond make_bond(int a, int b, int law, double length, const BodyInMotion& at_a,
               const BodyInMotion& at_b, const Vec3& middle, const Vec3& axis, const Vec3& up);

// A body that no load accelerates: mass and inertia are infinite, and it has no parts. It takes the
// place of the shape of a boundary in the functions below.
const Shape& immovable_shape();

// Six stiffnesses, or damping constants: along x (stretch), y and z (shear), and about x (torsion),
// y and z (bending) of the beam. N/m and N m/rad, or N s/m and N m s/rad.
struct BeamSprings {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};
BeamSprings stiffness_of(const BeamLaw& law);
// Damping constants for BeamLaw::damping_ratio, for each deformation separately, from the stiffness
// and the mobility of both bodies.
BeamSprings damping_of(const BeamLaw& law, const Bond& bond, const Shape& a, const Shape& b);
// Mobility of the six deformations under forces of the same kind, with the bodies free: rate of one
// over impulse of another, beam axes, in the pose without stress. Three displacements, then three
// rotations: 1/kg, 1/(kg m) and 1/(kg m^2).
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Vec6 = Eigen::Matrix<double, 6, 1>;
Mat6 mobility_of(const BeamLaw& law, const Bond& bond, const Shape& a, const Shape& b);
// Largest angular frequency (rad/s) of two bodies on the beam with the fractions `mass_fraction_a`
// and `mass_fraction_b` of their mass and inertia. With the fractions 1 / (number of bonds of the
// body), the maximum over all bonds is an upper bound for the assembly (Irons and Treharne, 1971).
double highest_frequency(const BeamLaw& law, const Bond& bond, const Shape& a,
                         double mass_fraction_a, const Shape& b, double mass_fraction_b);

// Deformation and pose of a beam. Deformations are expressed in axes midway between those of the
// ends, so that both ends are equivalent.
struct BeamPose {
  Vec3 displacement = Vec3::Zero();  // m, stretch and two shears, beam axes
  Vec3 rotation = Vec3::Zero();      // rad, rotation vector from a's end to b's, beam axes
  // Tangent of a quarter of the angle of that rotation, along its axis, beam axes.
  Vec3 quarter_tangent = Vec3::Zero();
  Vec3 end_offset = Vec3::Zero();  // m, from end a to end b, world
  // m, from the centers of mass to the ends, world.
  Vec3 arm_a = Vec3::Zero(), arm_b = Vec3::Zero();
  Mat3 axes = Mat3::Identity();  // of the middle of the beam: beam axes -> world
};
BeamPose pose_of(const BeamLaw& law, const Bond& bond, const BodyInMotion& a,
                 const BodyInMotion& b);

// Internal forces along x, y, z of the beam (tension positive) and moments about them.
struct BeamForces {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();  // N, N m, in the middle of the beam
};
BeamForces elastic_forces(const BeamSprings& stiffness, const BeamPose& pose);
double elastic_energy(const BeamSprings& stiffness, const BeamPose& pose);  // J

// Rates of the deformations, m/s and rad/s, beam axes: stretch and two shears, then the rotations.
Vec6 rates_of(const BeamPose& pose, const BodyInMotion& a, const BodyInMotion& b);

// Load of the beam on the bodies, world axes. The force on b is opposite to that on a; forces and
// moments are in equilibrium.
struct BeamLoad {
  Vec3 force = Vec3::Zero();                              // N, on a
  Vec3 moment_a = Vec3::Zero(), moment_b = Vec3::Zero();  // N m, about the centers of mass
};
BeamLoad load_of(const BeamPose& pose, const BeamForces& forces);

// Largest stresses by cause, Pa. Normal stresses are added, and so are shear stresses.
struct BeamStress {
  double tension = 0;  // below 0: compression
  double bending = 0;  // in the outermost fiber, the larger one of both ends
  double shear = 0;    // mean over the section
  double torsion = 0;
};
BeamStress stress_of(const BeamLaw& law, const BeamForces& forces);

// State of a bond: intact, failure mode, the removal of one of its bodies, or the end of its
// lifetime.
enum class BondMode : std::int64_t { intact, tension, bending, shear, torsion, removed, lifetime };
// Failure mode: the larger contribution to the exceeded strength. intact: no strength is exceeded.
// `strength`: Bond::strength.
BondMode failure_mode(const BeamLaw& law, const BeamStress& stress, double strength);
const char* to_string(BondMode mode);  // "tension"

}  // namespace firn
