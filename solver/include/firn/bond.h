// Breakable bonds: two particles joined by a short beam of elastic material, such as the bridges of
// ice between the cubes of one harvest.
//
// The law is that of a Timoshenko beam between two ends, each fixed to a body, formulated with the
// relative pose of the ends instead of increments: errors do not accumulate, and a rigid motion of
// both bodies, by any angle, has no effect. Strengths, and stresses from force and moment, are
// those of the parallel bond of Potyondy and Cundall (2004). docs/contact.md.
#pragma once

#include <cstdint>
#include <string>

#include "firn/shape.h"

namespace firn {

// Axes of a beam: x along it from a to b, y along the width of its section, z along the height.
struct BeamSection {
  double area = 0;               // m^2
  double shear_coefficient = 1;  // part of the area that resists shear; Cowper (1966)
  Vec3 inertia = Vec3::Zero();   // m^4: torsion constant, second moments about y and about z
  double half_width = 0;         // m, farthest fibre when bent about z
  double half_height = 0;        // m, and about y
  double torsion_modulus = 0;    // m^3: torsion over the largest shear stress
};
// Full sections; lengths in m. Torsion of the rectangle: Roark's formulas, good to 0.5 %.
BeamSection rectangular_section(double width, double height, double poisson_ratio);
BeamSection round_section(double radius, double poisson_ratio);

struct BeamLaw {
  std::string name;
  BeamSection section;
  double length = 0;                            // m
  double young_modulus = 0, shear_modulus = 0;  // Pa
  double tensile_strength = 0;                  // Pa, by normal force and bending
  double shear_strength = 0;                    // Pa, by shear force and torsion
  double damping_ratio = 0;                     // of each of the six deformations by itself
};

// A beam between the particles a and b. Its ends are given in the principal axes of the bodies,
// about their centres of mass. Free of stress where both ends have the same axes and b's is
// `length` along x from a's.
struct Bond {
  int a = 0, b = 0;                                           // particles
  int law = 0;                                                // index into Model::beams
  Vec3 end_a = Vec3::Zero(), end_b = Vec3::Zero();            // m
  Quat axes_a = Quat::Identity(), axes_b = Quat::Identity();  // beam axes -> body axes
};

// Pose and velocity of a body, world axes; body axes are the principal ones.
struct BodyInMotion {
  Vec3 position, velocity, spin;  // m, m/s, rad/s
  Quat orientation;               // body axes -> world
};

// Joins two bodies in their present poses, free of stress: the beam lies about `middle` (m, world),
// along `axis` (any length, from a to b), its height along `up` as far as that is across the axis.
Bond make_bond(int a, int b, int law, double length, const BodyInMotion& at_a,
               const BodyInMotion& at_b, const Vec3& middle, const Vec3& axis, const Vec3& up);

// Six stiffnesses, or damping constants: along x (stretch), y and z (shear), and about x (torsion),
// y and z (bending) of the beam. N/m and N m/rad, or N s/m and N m s/rad.
struct BeamSprings {
  Vec3 ways = Vec3::Zero(), turns = Vec3::Zero();
};
BeamSprings stiffness_of(const BeamLaw& law);
// A given part of critical damping for each deformation by itself, with the masses of both bodies.
BeamSprings damping_of(const BeamLaw& law, const Bond& bond, const Shape& a, const Shape& b);
// Mobility of the six deformations under forces of the same kind, with the bodies free: rate of one
// over impulse of another, beam axes, in the pose without stress. Ways first, then turns.
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Vec6 = Eigen::Matrix<double, 6, 1>;
Mat6 mobility_of(const BeamLaw& law, const Bond& bond, const Shape& a, const Shape& b);
// Largest angular frequency, rad/s, of the two bodies on the beam, each with this part of its mass
// and inertia: with 1 / (number of its bonds) the largest over all bonds bounds that of the whole
// (Irons and Treharne, 1971).
double highest_frequency(const BeamLaw& law, const Bond& bond, const Shape& a, double share_a,
                         const Shape& b, double share_b);

// Deformation and pose of a beam. Deformations are expressed in axes midway between those of the
// ends, so that both ends are equivalent.
struct BeamPose {
  Vec3 way = Vec3::Zero();    // m, stretch and two shears, beam axes
  Vec3 turn = Vec3::Zero();   // rad, rotation vector from a's end to b's, beam axes
  Vec3 half = Vec3::Zero();   // tangent of a quarter of that angle, along its axis, beam axes
  Vec3 apart = Vec3::Zero();  // m, from end a to end b, world
  Vec3 arm_a = Vec3::Zero(), arm_b = Vec3::Zero();  // m, of the ends from the centres, world
  Mat3 axes = Mat3::Identity();                     // midway: beam axes -> world
};
BeamPose pose_of(const BeamLaw& law, const Bond& bond, const BodyInMotion& a,
                 const BodyInMotion& b);

// Forces and moments within the beam: along x, y, z (tension positive) and about them.
struct BeamForces {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();  // N, N m, in the middle of the beam
};
BeamForces elastic_forces(const BeamSprings& stiffness, const BeamPose& pose);
double elastic_energy(const BeamSprings& stiffness, const BeamPose& pose);  // J

// Rates of the deformations, m/s and rad/s, beam axes: stretch and two shears, then the turns.
Vec6 rates_of(const BeamPose& pose, const BodyInMotion& a, const BodyInMotion& b);

// Load of the beam on the bodies, world axes. The force on b is opposite to that on a; forces and
// moments are in equilibrium.
struct BeamLoad {
  Vec3 force = Vec3::Zero();                              // N, on a
  Vec3 moment_a = Vec3::Zero(), moment_b = Vec3::Zero();  // N m, about the centres of mass
};
BeamLoad load_of(const BeamPose& pose, const BeamForces& forces);

// Largest stresses by origin, Pa; normal stresses add up, and so do shear stresses.
struct BeamStress {
  double tension = 0;  // below 0: compression
  double bending = 0;  // at the worse end, in the farthest fibre
  double shear = 0;    // mean over the section
  double torsion = 0;
};
BeamStress stress_of(const BeamLaw& law, const BeamForces& forces);

// Mode of breakage of a bond, or another reason why it does not act.
enum class BondMode : std::int64_t { whole, tension, bending, shear, torsion, parted };
// The larger contribution where a strength is exceeded; whole: none is exceeded.
BondMode broken_by(const BeamLaw& law, const BeamStress& stress);
const char* to_string(BondMode mode);  // "tension"

}  // namespace firn
