// The simulation: one mutable state over one constant model.
//
// `const` members do not modify the state, and several threads may call them at the same time.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firn/body_state.h"
#include "firn/diagnostics.h"
#include "firn/model.h"

namespace firn {

// One contact point of a patch.
struct ContactPointInfo {
  Vec3 position = Vec3::Zero();  // m, world, midway between the two surfaces
  double gap = 0;                // m, along the patch's normal; negative: overlap
  // Of the stiffness K of the pair. The sum over a patch may differ from 1 (docs/contact.md).
  double stiffness_fraction = 0;
  double force = 0;  // N, normal
  double area = 0;   // m^2, its part of the area of the patch
};

// One patch: the load of body b on body a over one touching region, at the end of a step. Points
// with a positive gap have no force.
struct Contact {
  int a = 0;                     // particle
  int b = 0;                     // particle above a, or number of particles + boundary
  int patch = 0;                 // number of the patch of this pair, from 0
  Vec3 position = Vec3::Zero();  // m, world: the reference point, where friction acts
  Vec3 normal = Vec3::UnitZ();   // unit, world, from a to b
  double normal_force = 0;       // N, sum over the points
  Vec3 friction = Vec3::Zero();  // N, world, on a, tangential
  double friction_limit = 0;     // N, friction limit: static while sticking, dynamic while sliding
  bool sliding = false;
  double torsion = 0;                    // N m, about the normal, on a
  double torsion_limit = 0;              // N m, torsion limit
  Vec3 rolling = Vec3::Zero();           // N m, world, on a
  double overlap = 0;                    // m, of the deepest point; 0 when no point touches
  double gap = 0;                        // m, the smallest; negative: overlap
  double stiffness = 0;                  // N/m, K of the pair, loading, equation (4)
  double unloading_stiffness_ratio = 1;  // K_u / K = 1 / epsilon^2
  double adhesion = 0;                   // N, against the normal force
  Vec3 force = Vec3::Zero();     // N, world, on a: friction - (normal_force - adhesion) * normal
  Vec3 moment_a = Vec3::Zero();  // N m, world, on a about its center of mass
  Vec3 moment_b = Vec3::Zero();  // N m, world, on b about its center of mass (boundary: origin)
  std::vector<ContactPointInfo> points;
};

// Instruction set of new solvers: "baseline", or "avx2" where build and processor support it. The
// environment variable FIRN_INSTRUCTIONS selects one of them; results are the same. Throws
// InputError when the selected one is not available.
std::string instruction_set();

// A pointer for solvers that share `model`. It does not own the model, which must outlive them.
inline std::shared_ptr<const Model> unowned(const Model& model) {
  return {std::shared_ptr<const Model>(), &model};
}

// Unless a member says otherwise, it does not check index arguments: an index out of range is
// undefined behavior.
class Solver {
 public:
  struct Load {
    Vec3 force = Vec3::Zero();   // N, world
    Vec3 moment = Vec3::Zero();  // N m, world, about the center of mass (frames: the origin)
  };

  // Stores a copy of the model. Initially all particles are pending and all boundaries are present.
  // Throws InputError as validate(model) does.
  explicit Solver(Model model);
  // Shares a model that has passed validate() and does not change while the solver exists, without
  // a copy. `threads` overrides the number of the model; 0: no override.
  Solver(std::shared_ptr<const Model> model, int threads);
  ~Solver();
  Solver(Solver&&) noexcept;
  Solver& operator=(Solver&&) noexcept;

  const Model& model() const;

  // Inserts a pending particle (else std::logic_error): center of mass (m, world), orientation
  // (shape axes -> world), velocity (m/s, world) and angular velocity (rad/s, world).
  void insert(int particle, const Vec3& center_of_mass, const Quat& orientation,
              const Vec3& velocity, const Vec3& angular_velocity);
  // Sets the initial pose of a frame, before the first step (else std::logic_error). Parents must
  // be set before children, which move with them.
  void start_frame(const FrameStart& start);
  void remove_particle(int particle);  // throws std::logic_error unless it is present
  // Throws std::out_of_range unless `boundary` is an index into Model::boundaries. No effect if it
  // was removed before.
  void remove_boundary(int boundary);
  // Add a motion or motor that acts from the current time on, for stages that begin on events.
  // `boundary`: index into Model::boundaries. `frame`: index into Model::frames; that of a motor
  // must be free. `joint`: index into FreeBody::joints of that frame. stop_stage_motions() ends all
  // motions and motors of a group above 0 at `time` (s).
  void add_motion(int boundary, const Motion& motion, int group = 0);
  void add_frame_motion(int frame, const Motion& motion, int group = 0);
  void add_motor(int frame, int joint, const Motor& motor, int group = 0);
  void stop_stage_motions(int group, double time);

  // True if a body of this shape and pose would overlap a particle or boundary, or be within
  // `clearance` (m) of it. `shape`: index into Model::shapes.
  bool overlaps(int shape, const Vec3& center_of_mass, const Quat& orientation,
                double clearance) const;
  // The first body within `clearance`: a particle, or number of particles + boundary; empty: none.
  std::optional<int> obstacle(int shape, const Vec3& center_of_mass, const Quat& orientation,
                              double clearance) const;

  // Advances by one time step. Throws RunError (non-finite state, runaway energy, overlap beyond
  // the limit) naming the particle and the time.
  void step();
  // The same step without its second half-kick, for loops that do not read every step. The next
  // step merges that half-kick with its first one, which saves a pass over all bodies. Results have
  // the same bits. After it, accessors of velocities, loads of particles, energy, bonds, hashes and
  // the saved state throw std::logic_error until complete_step() or the next step().
  void step_deferred();
  // Computes the second half-kick of a deferred step, if there is one.
  void complete_step();

  double time() const;  // s
  std::uint64_t steps() const;
  // A copy, made once for each state. The reference is valid while the solver exists; its contents,
  // until the state changes.
  const ParticleState& particles() const;
  // Orientation of a particle, shape axes -> world, as in a results file. `particle`: index into
  // Model::particles.
  Quat shape_orientation(int particle) const;
  const std::vector<BoundaryState>& boundaries() const;
  std::vector<FrameState> frames() const;
  std::vector<CouplingState> couplings() const;                 // [couplings of the model]
  std::vector<BoundaryContactState> boundary_contacts() const;  // [boundary contacts of the model]
  // Force and moment (about the origin of the frame) of contacts on all boundaries that a frame
  // carries, at the end of the step. `frame`: index into Model::frames.
  Load frame_load(int frame) const;
  void clear_boundary_loads();  // and those of frames, after they were recorded
  Energy energy() const;
  Diagnostics diagnostics() const;
  // Overlap of the deepest point of every patch with a force now, m.
  std::vector<double> contact_overlaps() const;
  const std::vector<BondRecord>& bonds() const;  // [bonds of the model]
  BondState bond(int number) const;              // `number`: index into Model::bonds
  // All patches of the neighbor list, in the order of (a, b): a copy. Its forces are those of the
  // next half-kick. A particle or boundary removed since the last step still has its last contacts.
  std::vector<Contact> contacts() const;
  // Of a model with StatisticsOptions::deferred, once (else std::logic_error): statistics count
  // from the current time on. The largest forces of particles (ParticleState::peak_normal_force)
  // start again from 0. A contact that is under way begins with the next step.
  void start_statistics();
  // Contacts that have ended since the last call, in order of their ends, and open_events(): open
  // contacts, in order of their starts, with any force. Empty unless the statistics of the model
  // include events.
  std::vector<ContactEvent> take_events();
  std::vector<ContactEvent> open_events() const;
  // Loads on the triangles of monitored boundaries over the intervals that have ended since the
  // last call; `up_to_now`: ends the open interval first, if it has a step.
  std::vector<LoadInterval> take_load_intervals(bool up_to_now = false);
  // Sums since the start, empty without the statistics: [particles]; [triangles of all shapes,
  // concatenated]; [1 + boundaries][classes], pairs of particles first.
  const std::vector<CompressiveLoad>& compressive_loads() const;
  const std::vector<SurfaceSums>& surface_sums() const;
  const std::vector<EnergySums>& energy_sums() const;
  // Force and moment of all contacts and bonds on a particle at the end of the step, as used for
  // its motion. Throws std::out_of_range unless `particle` is an index into Model::particles.
  Load load(int particle) const;
  std::vector<PhaseTime> profile() const;  // time spent in each phase of the step so far

  // Every byte that the next step reads. After restore(), a solver over the same model continues
  // with identical bits. It throws RunError when the bytes were made by another program version or
  // model.
  std::vector<std::byte> save() const;
  void restore(const std::vector<std::byte>& bytes);
  // Hash of the same state: equal hashes mean equal continuations. FNV hash over words (Fowler,
  // Noll and Vo): it detects accidental differences, not forgery.
  std::uint64_t hash() const;
  std::vector<GroupHash> group_hashes() const;  // together, the bytes of save() without the model

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
