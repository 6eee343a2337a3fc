// Motion of boundaries: prescribed motions, and motion frames, which carry boundaries and other
// frames. Frames have prescribed motions or are free bodies.
//
// All data are in world axes at t = 0. Children move with their parent frame, and so do their
// directions and points.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "firn/math.h"

namespace firn {

inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// Active times of a motion or motor: from start to stop, or between them in every period.
struct Schedule {
  double start = 0;          // s
  double stop = kUnbounded;  // s
  double period = 0;         // s; 0: once; otherwise stop - start is at most one period
  double end = kUnbounded;   // s, end of all activity

  bool acts(double t) const;
};

// Prescribed motion, active according to its schedule. In a list, each motion is relative to the
// previous ones, as to a parent frame: its axis, center and direction are given at t = 0 and move
// with them. The pose at t is T_1(t) T_2(t) ... T_n(t) applied to the pose at t = 0.
struct Motion : Schedule {
  enum class Kind { translation, rotation };
  enum class Profile {
    constant,    // at `velocity` or `angular_speed`
    ramp,        // rate from `rate` to `end_rate` within `ramp_time`, then at end_rate
    sinusoidal,  // amplitude (sin(2 pi frequency t + phase) - sin phase): vibration, pendulum
    table        // `positions` at `times`, linear in between, constant after the last
  };
  Kind kind = Kind::translation;
  Profile profile = Profile::constant;
  Vec3 velocity = Vec3::Zero();  // m/s (translation at constant velocity)
  Vec3 axis = Vec3::UnitZ();     // unit; direction of any other translation
  Vec3 center = Vec3::Zero();    // m, a point on the axis of a rotation
  double angular_speed = 0;      // rad/s about the axis (rotation at constant speed)
  // m/s and m, or rad/s and rad; times from the start of each period.
  double rate = 0, end_rate = 0, ramp_time = 0;
  double amplitude = 0, frequency = 0, phase = 0;  // frequency in 1/s
  std::vector<double> times, positions;            // equally many; s, ascending from 0; m or rad

  // Displacement within [t, t + dt], m or rad; for a translation at constant velocity the active
  // time in s.
  double displacement(double t, double dt) const;
  // Displacement from the start to t, in all periods.
  double total_displacement(double t) const;
};

// A motor at a joint of a free body: accelerates it to a speed with a force or torque up to
// `max_load`.
struct Motor : Schedule {
  double speed = 0;              // m/s or rad/s; with a target, the maximum
  std::optional<double> target;  // m or rad: coordinate to approach and keep
  double max_load = kUnbounded;  // N or N m
  // m/s or rad/s: the load limit decreases linearly from `max_load` at rest (stall) to zero at this
  // speed in the direction of the load.
  double no_load_speed = kUnbounded;
};

// One degree of freedom of a free body. Its coordinate is 0 at t = 0.
struct Joint {
  enum class Kind { translation, rotation };
  Kind kind = Kind::rotation;
  Vec3 direction = Vec3::UnitZ();  // unit; a rotation is about the frame's origin
  // Spring with the coordinate `spring_reference` without a load: N/m and m, or N m/rad and rad.
  double stiffness = 0, spring_reference = 0;
  double damping = 0;   // N s/m or N m s/rad
  double friction = 0;  // N or N m, against any motion
  // Coulomb friction of the bearing adds to it: the coefficient times the sum of the forces that
  // the bearing bears across the axis at its two ends, which are `bearing_length` (m) apart with
  // the frame's origin in the middle; 0: at one place, and moments cause none. Of a rotation, times
  // `bearing_radius` (m), and the force along the axis counts, too.
  double friction_coefficient = 0, bearing_radius = 0, bearing_length = 0;
  double lower = -kUnbounded, upper = kUnbounded;  // m or rad, limits
  double limit_restitution = 0;  // speed after over speed before the impact at a limit
  double armature = 0;           // kg or kg m^2, inertia of a rotor geared to the joint
  std::vector<Motor> motors;

  bool has_friction() const { return friction > 0 || friction_coefficient > 0; }
};

// A rigid body that moves along its joints under gravity, contacts, springs and motors.
struct FreeBody {
  double mass = 0;              // kg
  Vec3 center = Vec3::Zero();   // m, center of mass, world at t = 0
  Mat3 inertia = Mat3::Zero();  // kg m^2 about the center of mass, world axes at t = 0
  std::vector<Joint> joints;    // at most kMaxJoints; at most one rotation
  bool free_rotation = false;   // ball joint; none of `joints` is then a rotation

  bool has_joint_friction() const { return std::ranges::any_of(joints, &Joint::has_friction); }
};
inline constexpr int kMaxJoints = 6;

struct MotionFrame {
  std::string name;
  int parent = -1;              // an earlier frame; -1: the world
  Vec3 origin = Vec3::Zero();   // m, world at t = 0; axes are the world's at t = 0
  std::vector<Motion> motions;  // empty for a free body
  std::optional<FreeBody> free;
};

inline bool has_free_body(const std::vector<MotionFrame>& frames) {
  return std::ranges::any_of(frames, [](const MotionFrame& f) { return f.free.has_value(); });
}

// Constraint between two bodies of a mechanism in addition to the joints of its tree: closes loops,
// couples joints. A body is a free frame with all frames fixed to it, or the parent frame of the
// mechanism.
struct Coupling {
  enum class Kind {
    ball,   // the bodies share the point `position`
    hinge,  // and the axis through it along `direction`
    weld,   // no relative motion
    slot,   // the point of b is on the line along `direction`, which is fixed to a
    gear,   // the coordinate of joint_b is `ratio` times that of joint_a
    cam     // the coordinate of joint_b is the lift at that of joint_a, a rotation
  };
  Kind kind = Kind::ball;
  std::string name;
  int a = -1, b = -1;                                       // frames; -1: the world
  Vec3 position = Vec3::Zero(), direction = Vec3::UnitZ();  // m, unit; world at t = 0
  int joint_a = 0, joint_b = 0;                             // of free frames a and b
  double ratio = 1;                                         // of the units of the joints
  // Of a cam: rad, ascending within one revolution, and m or rad; repeated in every revolution. The
  // lift at the angle 0 is 0, as at t = 0.
  std::vector<double> angles, lifts;
  // Friction as of Joint, with the force of the coupling as load: of a ball or hinge against the
  // turn about `direction`, which is fixed to a, and of a slot against the motion along it.
  double friction = 0;                                  // N m; of a slot N
  double friction_coefficient = 0, bearing_radius = 0;  // 1, m; a slot has no radius

  bool ties_joints() const { return kind == Kind::gear || kind == Kind::cam; }
  bool has_friction() const { return friction > 0 || friction_coefficient > 0; }
};

// True when `frame` is `above` or a descendant of it. -1: the world, which has no parent.
bool descends_from(const std::vector<MotionFrame>& frames, int frame, int above);
// The free frame among `frame` and its ancestors; -1: none.
int free_frame(const std::vector<MotionFrame>& frames, int frame);

}  // namespace firn
