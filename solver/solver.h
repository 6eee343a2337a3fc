// The simulation: one mutable state over one constant model.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "solver/model.h"

namespace firn {

enum class Presence : std::uint8_t { waiting, present, left };

// What a user may read of the particles at the end of a step. Arrays have one entry a particle, in
// order of the ids, particles that wait or have left included.
struct ParticleState {
  std::vector<Presence> presence;
  std::vector<Vec3> position;             // m, centre of mass, world
  std::vector<Quat> orientation;          // body (principal) axes -> world
  std::vector<Vec3> velocity;             // m/s, world
  std::vector<Vec3> angular_velocity;     // rad/s, world
  std::vector<double> peak_normal_force;  // N, largest patch force over all steps so far
};

struct BoundaryState {
  Vec3 position = Vec3::Zero();          // m, of its origin, world
  Quat orientation = Quat::Identity();   // boundary axes -> world
  Vec3 velocity = Vec3::Zero();          // m/s, of the origin
  Vec3 angular_velocity = Vec3::Zero();  // rad/s
  bool present = true;
  // Since the last take_boundary_loads():
  Vec3 impulse = Vec3::Zero();          // N s, on the boundary
  Vec3 angular_impulse = Vec3::Zero();  // N m s, about the moving origin
  double peak_normal_force = 0;         // N, largest single patch
};

// Where a motion frame stands before the first step, other than as drawn.
struct FrameStart {
  int frame = 0;
  // World. Of a free frame the coordinates say it, and the orientation of one that turns freely.
  Vec3 position = Vec3::Zero();  // m, of its origin
  Quat orientation = Quat::Identity();
  std::vector<double> coordinates, rates;  // of a free one's axes: m or rad, m/s or rad/s
  Vec3 spin = Vec3::Zero();  // rad/s, world, against the parent, of one that turns freely
};

// A motion frame, at the end of a step.
struct FrameState {
  Vec3 position = Vec3::Zero();          // m, of its origin, world
  Quat orientation = Quat::Identity();   // its axes -> world
  Vec3 velocity = Vec3::Zero();          // m/s, of the origin
  Vec3 angular_velocity = Vec3::Zero();  // rad/s
  bool driven = false;                   // a drive acted in the last step
  Vec3 free_spin = Vec3::Zero();  // rad/s, world, against the parent, of one that turns freely
  // N s, N m s, of contacts, about the moving origin, since the last clear_boundary_loads().
  Vec3 impulse = Vec3::Zero(), angular_impulse = Vec3::Zero();
  struct Axis {
    double coordinate = 0, rate = 0;  // m or rad, m/s or rad/s
    double drive_impulse = 0, stop_impulse = 0;
  };
  std::vector<Axis> axes;  // of a free one
};

// What has become of a bond.
struct BondRecord {
  BondMode mode = BondMode::whole;
  double time = 0;            // s, when it broke or parted
  double stress = 0;          // Pa, that broke it
  Vec3 place = Vec3::Zero();  // m, of its middle then, world
};

// What a bond bears at the end of a step; zero unless it is whole and both particles are there.
struct BondState {
  bool acts = false;
  Vec3 middle = Vec3::Zero();           // m, world
  Quat orientation = Quat::Identity();  // beam axes -> world
  BeamForces forces;                    // elastic ones
  BeamStress stress;
  BeamLoad load;  // as the last step has put it on the bodies, damping included
};

struct Energy {  // J
  double kinetic = 0;
  double gravitational = 0;      // relative to the world's origin
  double elastic = 0;            // recoverable part of the contact springs, and of bonds
  double dissipated_normal = 0;  // since the start, by restitution
  double dissipated_friction = 0;
  double dissipated_walls = 0;  // the part of both that was lost against boundaries
  double dissipated_bonds = 0;  // since the start, by damping of bonds and when they break
  double boundary_work = 0;     // done by moving boundaries on the particles since the start
  double removed = 0;           // mechanical energy carried away by removals, less that inserted
};

// Health of the run: what a user should see when an answer looks odd.
struct Health {
  double largest_overlap = 0;  // m, over all steps
  int largest_overlap_particle = -1;
  std::uint64_t deep_births = 0;  // patches first seen already deeper than 1 % of the sweep radii
  double energy_rise = 0;         // J, sum of unexplained rises
  std::uint64_t rebuilds = 0;     // of the neighbour list
  std::uint64_t queries = 0;      // narrow-phase queries of part pairs
  std::uint64_t refreshes = 0;    // of body pairs with patches
  std::uint64_t patches = 0;      // now
  std::uint64_t points = 0;       // now
  std::uint64_t pairs = 0;        // in the neighbour list now
};

// One contact point of a patch, as the force law sees it.
struct ContactSpot {
  Vec3 position = Vec3::Zero();  // m, world, midway between the two surfaces
  double gap = 0;                // m, along the patch's normal; negative: overlap
  double share = 0;              // of the stiffness K of the pair; may not add up to 1 (contact.md)
  double force = 0;              // N, normal
  double area = 0;               // m^2 that it stands for
};

// One patch: what body b does to body a over one touching region, at the end of a step. Points that
// are merely near (gap above 0) bear nothing; a patch of such points alone bears nothing.
struct Contact {
  int a = 0;                     // particle
  int b = 0;                     // particle above a, or number of particles + boundary
  int patch = 0;                 // counts the patches of this pair from 0
  Vec3 place = Vec3::Zero();     // m, world: the reference point, where friction acts
  Vec3 normal = Vec3::UnitZ();   // unit, world, from a to b
  double normal_force = 0;       // N, sum over the points
  Vec3 friction = Vec3::Zero();  // N, world, on a, across the normal
  double friction_cap = 0;       // N: static while it sticks, dynamic while it slides
  bool sliding = false;
  double torsion = 0;            // N m, about the normal, on a
  double torsion_cap = 0;        // N m
  Vec3 rolling = Vec3::Zero();   // N m, world, on a
  double overlap = 0;            // m, of the deepest point; 0 when none touches
  double gap = 0;                // m, the smallest; negative: overlap
  double stiffness = 0;          // N/m, K of the pair, loading, equation (4)
  double unloading_ratio = 1;    // K_u / K = 1 / epsilon^2
  double adhesion = 0;           // N, against the normal force
  Vec3 force = Vec3::Zero();     // N, world, on a: friction - (normal_force - adhesion) * normal
  Vec3 moment_a = Vec3::Zero();  // N m, world, on a about its centre of mass
  Vec3 moment_b = Vec3::Zero();  // N m, world, on b about its centre of mass (origin)
  std::vector<ContactSpot> spots;
};

// Hashes of the state's arrays in groups, so that two runs that part can be told what parted first.
struct GroupHash {
  const char* group;
  std::uint64_t hash;
};

struct PhaseTime {
  const char* name;
  double seconds;
};

// The instructions that a solver made now would use: "baseline", or "avx2" where build and
// processor have them. The environment variable FIRN_INSTRUCTIONS asks for one of them; results are
// the same. Throws InputError when it asks for what is not there.
std::string instruction_set();

class Solver {
 public:
  struct Load {
    Vec3 force, moment;  // N, N m about the centre of mass (frames: the origin), world
  };

  // Keeps its own copy of the model. Particles start waiting, boundaries present.
  // Throws InputError when validate(model) does.
  explicit Solver(Model model);
  ~Solver();
  Solver(Solver&&) noexcept;
  Solver& operator=(Solver&&) noexcept;

  const Model& model() const;

  // Places a waiting particle. orientation: shape axes -> world; velocities in world axes.
  void insert(int particle, const Vec3& center_of_mass, const Quat& orientation,
              const Vec3& velocity, const Vec3& angular_velocity);
  // Before the first step, parents before their children: takes along what hangs on the frame.
  void start_frame(const FrameStart& start);
  void remove_particle(int particle);
  void remove_boundary(int boundary);
  // Starts an extra motion or drive now or later (stages that begin on events). Those of a group
  // above 0 end together.
  void add_motion(int boundary, const Motion& motion, int group = 0);
  void add_frame_motion(int frame, const Motion& motion, int group = 0);
  void add_drive(int frame, int axis, const Drive& drive, int group = 0);
  void end_started(int group, double time);

  // True when a body of this shape placed there would touch a present particle or boundary, or
  // come nearer than `clearance` (m). For placement; does not change the state.
  bool overlaps(int shape, const Vec3& center_of_mass, const Quat& orientation,
                double clearance) const;
  // What it would touch first: a particle, or number of particles + boundary; none: nothing.
  std::optional<int> obstacle(int shape, const Vec3& center_of_mass, const Quat& orientation,
                              double clearance) const;

  // Advances by one time step. Throws RunError (non-finite state, runaway energy, overlap beyond
  // the limit) naming the particle and the time. The second half kick is left for the next step to
  // make together with its first one; who asks for velocities, loads or energy, or saves the state,
  // gets it made before, and pays for a pass over all bodies. What is computed is the same.
  void step();

  double time() const;  // s
  std::uint64_t steps() const;
  // A copy made when asked for: valid until the next step(), insert() or removal; ask again then.
  const ParticleState& particles() const;
  // Orientation as the results file wants it: shape axes -> world.
  Quat shape_orientation(int particle) const;
  const std::vector<BoundaryState>& boundaries() const;
  std::vector<FrameState> frames() const;
  // Contacts' force and moment, about its origin, on all that a frame carries, at this step.
  Load frame_load(int frame) const;
  void clear_boundary_loads();  // and those of frames, after they were recorded
  Energy energy() const;
  const Health& health() const;
  // Overlap of the deepest point of every patch that bears a force now, m.
  std::vector<double> contact_overlaps() const;
  const std::vector<BondRecord>& bonds() const;  // [bonds of the model]
  BondState bond(int number) const;
  // Every patch of the neighbour list, in order of (a, b): a copy, nothing is changed. What it says
  // of forces is what the next half kick reads. A particle or boundary removed since the last step
  // still has its last contacts.
  std::vector<Contact> contacts() const;
  // Contacts that have ended since the last call, in order of their ends, and those under way, in
  // order of their starts, whatever their force. None unless the model's statistics ask for them.
  std::vector<ContactEvent> take_events();
  std::vector<ContactEvent> open_events() const;
  // Loads on the triangles of watched boundaries over the intervals that have ended since the last
  // call; `up_to_now`: ends the one under way first, if a step has been taken in it.
  std::vector<LoadInterval> take_load_intervals(bool up_to_now = false);
  // Since the start, empty unless asked for: [particles]; [triangles of all shapes, one behind the
  // other]; [1 + boundaries][classes], pairs of particles first.
  const std::vector<OpposedLoad>& opposed_loads() const;
  const std::vector<SurfaceSums>& surface_sums() const;
  const std::vector<EnergySums>& energy_sums() const;
  // Force and moment of all contacts and bonds on a particle at the end of the step, as the motion
  // uses them.
  Load load(int particle) const;
  std::vector<PhaseTime> profile() const;  // time spent in each phase of the step so far

  // Every byte that the next step reads. restore() makes a solver over the same model go on bit
  // for bit; it throws RunError when the bytes were made by another program version or model.
  std::vector<std::byte> save() const;
  void restore(const std::vector<std::byte>& bytes);
  // Hash of the same state: equal for equal futures. Fowler, Noll and Vo's, over words: it tells
  // chance apart, not malice.
  std::uint64_t hash() const;
  std::vector<GroupHash> group_hashes() const;  // together, all that save() packs but the model

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
