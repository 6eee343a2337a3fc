// Contacts of one particle, of one pair or of all bodies at one instant, and their history over
// time. All functions read the state of a solver, e.g. in a replay().
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/case/case.h"
#include "firn/solver.h"

namespace firn {

// Bodies are numbered particles first, then boundaries, as in Contact.
std::string body_name(const Model& model, int body);  // "particle 17", "floor"
// The number of the body for the id of a particle or the name of a boundary. Throws InputError
// `OPTION: ...` for any other text; the message lists the valid ids and names.
int find_body(const Model& model, const std::string& text, const std::string& option);
// Smallest edge of the bounding boxes of the shapes of the particles in contact, m. Boundaries do
// not count.
double smallest_extent(const Model& model, const Contact& contact);

// Which contacts are selected: those of one pair, or of one body with all others.
struct ContactSelection {
  int body = -1;   // -1: all contacts
  int other = -1;  // -1: all neighbors of `body`
  bool includes(const Contact& contact) const;
};

// A contact with the selected body as Contact::a. Forces and normals are reversed where the solver
// has that body as Contact::b.
struct ContactView {
  Contact contact;  // a: the body of the selection; as the solver has it without a selected body
  int neighbor() const { return contact.b; }
  bool is_active() const { return contact.normal_force > 0; }
  // |T| / (mu F) with the friction T and the normal force F; 0 where the friction limit is 0.
  double friction_mobilization() const;
};
// The selected contacts in the order of neighbors. Patches within the contact margin that do not
// touch are included.
std::vector<ContactView> select_contacts(const Solver& solver, const ContactSelection& choice);

// Comparison of the sum of the listed forces on a particle with its acceleration.
struct ForceBalance {
  Vec3 contacts = Vec3::Zero();  // N, sum of the forces of contacts and bonds
  Vec3 moment = Vec3::Zero();    // N m, sum of their moments about the center of mass
  Vec3 weight = Vec3::Zero();    // N
  // Mass times the mean acceleration over the next step, N. The step is computed on a copy of the
  // solver.
  Vec3 mass_acceleration = Vec3::Zero();
  // Velocity Verlet applies half of the forces at both ends of a step. The residuals are
  //   m (v' - v) / dt - (F + F') / 2 - m g  and  (H' - H) / dt - (M + M') / 2
  // with the angular momentum H in world axes. Above rounding, a force is not listed.
  double force_error = 0;   // N, magnitude of the first residual
  double moment_error = 0;  // N m, of the second
  double sum_mismatch = 0;  // N, listed forces less the solver's sum for the particle
  double scale = 0;         // N, sum of the magnitudes of the forces
  double moment_scale = 0;  // N m, of the moments
};
// Computes one step on a copy of the solver.
ForceBalance force_balance(const Solver& solver, int particle);

// Statistics of all contacts at one instant. "Active": with a normal force above 0.
struct ContactSummary {
  std::size_t present = 0;      // particles
  std::size_t unsupported = 0;  // particles without active contact
  std::size_t pairs = 0;        // of bodies with an active contact
  std::size_t patches = 0, non_touching_patches = 0, points = 0;  // active; not touching; active
  std::size_t sliding = 0;                                        // patches
  double neighbors = 0;  // mean number of bodies that touch a particle
  double force_mean = 0, force_median = 0, force_p99 = 0, force_largest = 0;  // N, of a patch
  double friction_mobilization = 0;  // |T| / (mu F), mean over active patches with friction
  double overlap_median = 0, overlap_p99 = 0, overlap_largest = 0;  // m, of an active patch
  std::vector<Contact> most_loaded, deepest;                        // active, largest first
};
// `listed`: largest size of `most_loaded` and of `deepest`.
ContactSummary summarize_contacts(const Solver& solver, std::size_t listed);

// Contacts at one instant, copied from the solver.
struct ContactSnapshot {
  double time = 0;  // s
  std::uint64_t step = 0;
  ParticleState particles;
  std::vector<Quat> shape_orientation;  // [particles] shape axes -> world
  std::vector<BoundaryState> boundaries;
  std::vector<ContactView> contacts;    // of the selection
  std::optional<ForceBalance> balance;  // of the selected body if it is a particle
  ContactSummary summary;
};
// `listed`: as for summarize_contacts(). Throws InputError `OPTION: ...` when a selected body is
// not in the simulation at that time.
ContactSnapshot take_snapshot(const Solver& solver, const ContactSelection& choice,
                              std::size_t listed, const std::string& option);

// One row of a history: sums over the selected contacts.
struct HistoryRow {
  double time = 0;  // s
  std::uint64_t step = 0;
  int patches = 0, sliding = 0;      // active; those of them that slide
  double gap = 0;                    // m, smallest; NaN: no body within the margin
  double normal_force = 0;           // N, sum
  double peak_normal_force = 0;      // N, largest sum over the steps since the last row
  double friction = 0;               // N, magnitude of the sum
  double friction_mobilization = 0;  // largest of a patch
  Vec3 force = Vec3::Zero();         // N, world axes, on the first body
  double approach = 0;               // m/s, normal, at the patch with the smallest gap; NaN: none
  double slip = 0;                   // m/s, tangential, at that patch; NaN: none
  // J, taken from the bodies since the first row.
  double work_normal = 0;                 // by normal forces
  double work_friction = 0;               // by friction
  int new_patches = 0, lost_patches = 0;  // active patches, since the last row
};

// A change of the number of active patches of a pair in one step.
struct PatchEvent {
  double time = 0;  // s
  std::uint64_t step = 0;
  int a = 0, b = 0;           // bodies
  int before = 0, after = 0;  // active patches of the pair
};

// Records the selected contacts over the steps of a run. Work is the mean force of both ends of a
// step times the mean velocity. For velocity Verlet, this equals the change of translational energy
// to rounding, and that of rotational energy to second order in the time step.
class ContactHistory {
 public:
  // One row for every `every` steps, and one for the last step.
  ContactHistory(ContactSelection choice, std::uint64_t every);
  ~ContactHistory();
  // To be called with the state of each step, in order. `last`: no step follows.
  void add_step(const Solver& solver, bool last);

  const std::vector<HistoryRow>& rows() const { return rows_; }
  const std::vector<PatchEvent>& events() const { return events_; }

 private:
  struct PairForces;  // of one pair, at one step
  static PairForces pair_of(const Solver& solver, const Contact& contact);
  static const PairForces* find(const std::vector<PairForces>& pairs, const PairForces& like);
  void add_work(const std::vector<PairForces>& now, double timestep);
  void note_events(const Solver& solver, const std::vector<PairForces>& now);

  ContactSelection choice_;
  std::uint64_t every_, first_step_ = 0;
  bool begun_ = false;
  HistoryRow now_;  // sums since the last row
  std::vector<PairForces> before_;
  std::vector<HistoryRow> rows_;
  std::vector<PatchEvent> events_;
};

// Writes a CSV file in SI units with one header row that has the units. Numbers read back to the
// same bits. Throws as OutputFile.
void write_contacts_csv(const Model& model, const std::vector<ContactView>& contacts,
                        const std::string& file);
// Writes the contact points as vertices of a VTK file (.vtp), world axes, m. Vectors: force (N, the
// normal force on the first body) and friction (N, of the patch, on the first body). Scalars:
// normal_force, overlap (m; below 0: gap), stiffness_fraction, friction_mobilization, sliding,
// body, neighbor and patch.
void write_contacts_vtk(const std::vector<ContactView>& contacts, const std::string& file);
void write_history_csv(const std::vector<HistoryRow>& rows, const std::string& file);

}  // namespace firn
