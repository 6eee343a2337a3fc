// States of particles, boundaries, motion frames and bonds that a solver returns.
#pragma once

#include <cstdint>
#include <vector>

#include "firn/model.h"

namespace firn {

// pending: not inserted yet.
enum class Presence : std::uint8_t { pending, present, removed };

// State of all particles at the end of a step. Arrays [particles] in the order of ids, including
// pending and removed particles.
struct ParticleState {
  std::vector<Presence> presence;
  std::vector<Vec3> position;          // m, center of mass, world
  std::vector<Quat> orientation;       // body (principal) axes -> world
  std::vector<Vec3> velocity;          // m/s, world
  std::vector<Vec3> angular_velocity;  // rad/s, world
  // N, largest patch force over all steps, or since Solver::start_statistics()
  std::vector<double> peak_normal_force;
};

// A boundary, at the end of a step.
struct BoundaryState {
  Vec3 position = Vec3::Zero();          // m, of its origin, world
  Quat orientation = Quat::Identity();   // boundary axes -> world
  Vec3 velocity = Vec3::Zero();          // m/s, of the origin
  Vec3 angular_velocity = Vec3::Zero();  // rad/s
  bool present = true;
  // Since the last clear_boundary_loads():
  Vec3 impulse = Vec3::Zero();          // N s, on the boundary
  Vec3 angular_impulse = Vec3::Zero();  // N m s, about the moving origin
  double peak_normal_force = 0;         // N, largest single patch
};

// Initial pose of a motion frame in place of that of the model.
struct FrameStart {
  int frame = 0;
  // World axes. The pose of a free frame follows from its joint coordinates instead, with free
  // rotation also from `orientation`.
  Vec3 position = Vec3::Zero();  // m, of its origin
  Quat orientation = Quat::Identity();
  std::vector<double> coordinates, rates;  // [joints of a free frame] m or rad, m/s or rad/s
  // rad/s, world, relative to the parent, of a frame with free rotation.
  Vec3 relative_angular_velocity = Vec3::Zero();
};

// A motion frame, at the end of a step.
struct FrameState {
  Vec3 position = Vec3::Zero();          // m, of its origin, world
  Quat orientation = Quat::Identity();   // its axes -> world
  Vec3 velocity = Vec3::Zero();          // m/s, of the origin
  Vec3 angular_velocity = Vec3::Zero();  // rad/s
  bool driven = false;                   // a motor acted in the last step
  // rad/s, world, relative to the parent, of a frame with free rotation.
  Vec3 relative_angular_velocity = Vec3::Zero();
  // N s, N m s, of contacts, about the moving origin, since the last clear_boundary_loads().
  Vec3 impulse = Vec3::Zero(), angular_impulse = Vec3::Zero();
  struct JointState {
    double coordinate = 0, rate = 0;  // m or rad, m/s or rad/s
    // N s or N m s, of motors and of the joint limits, since the last clear_boundary_loads().
    double motor_impulse = 0, limit_impulse = 0;
    double dissipated_friction = 0;  // J, by the friction of the joint since the start
  };
  std::vector<JointState> joints;  // [joints of a free frame]
  // N s, N m s: reaction of the parent on a free frame through the joint (bearing, springs, motors,
  // limits), about the moving origin, since the last clear_boundary_loads().
  Vec3 reaction_impulse = Vec3::Zero(), reaction_angular_impulse = Vec3::Zero();
};

// Load of a coupling on its body b, at the end of a step.
struct CouplingState {
  Vec3 position = Vec3::Zero();  // m, world, of the coupling's point
  // N s, N m s about that point, world, since the last clear_boundary_loads(). Of a gear or cam:
  // along or about the axis of joint_b.
  Vec3 impulse = Vec3::Zero(), angular_impulse = Vec3::Zero();
  double dissipated_friction = 0;  // J, by the friction of the coupling since the start
};

// A contact between two boundaries, at the end of a step.
struct BoundaryContactState {
  double gap = 0;                // m, smallest; negative: overlap; a lower bound without contact
  Vec3 force = Vec3::Zero();     // N, world, on boundary a
  double normal_force = 0;       // N, sum over its patches
  int patches = 0;               // patches with a force
  int sliding = 0;               // patches that slide
  Vec3 impulse = Vec3::Zero();   // N s, on boundary a, since the last clear_boundary_loads()
  double peak_normal_force = 0;  // N, largest sum, since then
  double elastic = 0;            // J, recoverable
  double dissipated_normal = 0, dissipated_friction = 0;  // J, since the start
};

// Begin and end of a bond.
struct BondRecord {
  BondMode mode = BondMode::intact;
  double time = 0;               // s, when it broke, its lifetime ended or a body was removed
  double stress = 0;             // Pa, at breakage
  Vec3 position = Vec3::Zero();  // m, world, center of the bond at that time
  double made = 0;               // s, when both bodies were there; 0 before
};

// Load of a bond at the end of a step; zero unless it is intact and both bodies are present.
struct BondState {
  bool acts = false;
  Vec3 middle = Vec3::Zero();           // m, world, center of the beam
  Quat orientation = Quat::Identity();  // beam axes -> world
  BeamForces forces;                    // elastic part
  BeamStress stress;
  BeamLoad load;  // on the bodies in the last step, damping included
};

}  // namespace firn
