// Contacts of one particle, one pair or a whole instant, and their history over time. Works on the
// state of a solver; replay() provides it.
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
bool is_particle(const Model& model, int body);
std::string body_name(const Model& model, int body);  // "particle 17", "floor"
// A particle's id or a boundary's name. Throws InputError, `option` first, naming what there is.
int find_body(const Model& model, const std::string& text, const std::string& option);
// Smallest edge of the bounding box of a body's shape, m; of the smaller one of two particles.
double thickness(const Model& model, const Contact& contact);

// Selected contacts: of one pair, or of one body with all others.
struct ContactChoice {
  int body = -1;   // -1: all contacts
  int other = -1;  // -1: every neighbour
  bool takes(const Contact& contact) const;
};

// A contact seen from the selected body: reversed when that is Contact::b.
struct ContactView {
  Contact contact;  // a is the body of the choice, whatever it is
  int neighbour() const { return contact.b; }
  bool bears() const { return contact.normal_force > 0; }
  // Part of the friction that is used, |T| / (mu F); 0 where nothing can be.
  double friction_used() const;
};
// In order of neighbours; patches that are merely near come along.
std::vector<ContactView> chosen_contacts(const Solver& solver, const ContactChoice& choice);

// Whether the forces listed are those that move the particle.
struct Balance {
  Vec3 contacts = Vec3::Zero();  // N, sum of the forces listed, and of those of bonds
  Vec3 moment = Vec3::Zero();    // N m, sum of their moments about the centre of mass
  Vec3 weight = Vec3::Zero();    // N
  // Mass times the acceleration over the next step, which is taken on a copy, N.
  Vec3 mass_acceleration = Vec3::Zero();
  // Velocity Verlet kicks by half of the forces of both ends of a step. What remains of
  //   m (v' - v) / dt - (F + F') / 2 - m g  and  (H' - H) / dt - (M + M') / 2
  // (H: angular momentum in world axes) is rounding, or a force that is not listed.
  double force_error = 0;   // N
  double moment_error = 0;  // N m
  double used_error = 0;    // N, sum of the forces listed less what the solver has summed
  double scale = 0;         // N, sum of the sizes of all these forces
  double moment_scale = 0;  // N m
};
Balance balance_of(const Solver& solver, int particle);

// A whole instant in numbers.
struct ContactSummary {
  std::size_t present = 0;                                // particles
  std::size_t unsupported = 0;                            // particles that nothing touches
  std::size_t pairs = 0;                                  // that touch
  std::size_t patches = 0, near_patches = 0, points = 0;  // bearing; only near; bearing
  std::size_t sliding = 0;                                // patches
  double neighbours = 0;                                  // touching bodies a particle, mean
  double force_mean = 0, force_median = 0, force_p99 = 0, force_largest = 0;  // N, of a patch
  double friction_used = 0;  // |T| / (mu F), mean over the bearing patches that have friction
  double overlap_median = 0, overlap_p99 = 0, overlap_largest = 0;  // m, of a bearing patch
  std::vector<Contact> most_loaded, deepest;                        // bearing, in falling order
};
ContactSummary summary_of(const Solver& solver, std::size_t listed);

// Contacts at one instant, copied from the solver.
struct Instant {
  double time = 0;  // s
  std::uint64_t step = 0;
  ParticleState particles;
  std::vector<Quat> shape_orientation;  // [particles] shape axes -> world
  std::vector<BoundaryState> boundaries;
  std::vector<ContactView> contacts;  // of the choice
  std::optional<Balance> balance;     // of the choice's body, when that is a particle
  ContactSummary summary;
};
// Throws InputError, `option` first, when the body or the other one is not there.
Instant take_instant(const Solver& solver, const ContactChoice& choice, std::size_t listed,
                     const std::string& option);

// One row of a history: the contacts of the choice together.
struct HistoryRow {
  double time = 0;  // s
  std::uint64_t step = 0;
  int patches = 0, sliding = 0;  // bearing; of these, sliding
  double gap = 0;                // m, the smallest; NaN: no body near
  double normal_force = 0;       // N, sum
  double peak_normal_force = 0;  // N, largest sum over the steps since the last row
  double friction = 0;           // N, size of the sum
  double friction_used = 0;      // of the patch that uses most
  Vec3 force = Vec3::Zero();     // N, world, on the first body
  double approach = 0;           // m/s, at the patch with the smallest gap; NaN: none
  double slip = 0;               // m/s, there
  double work_normal = 0;        // J taken from the bodies since the first row ...
  double work_friction = 0;      // ... by normal forces and by friction
  int births = 0, ends = 0;      // bearing patches that came and went since the last row
};

struct PatchEvent {
  double time = 0;  // s
  std::uint64_t step = 0;
  int a = 0, b = 0;           // bodies
  int before = 0, after = 0;  // bearing patches of the pair
};

// Follows the contacts of a choice from step to step. Work is that of the mean force of both ends
// of a step on its mean velocity: what velocity Verlet changes of the translational energy to
// rounding, of the rotational energy to second order.
class ContactHistory {
 public:
  // A row every `every` steps, and for the last one seen.
  ContactHistory(ContactChoice choice, std::uint64_t every);
  ~ContactHistory();
  // With each step, in order.
  void see(const Solver& solver, bool last);

  const std::vector<HistoryRow>& rows() const { return rows_; }
  const std::vector<PatchEvent>& events() const { return events_; }

 private:
  struct PairForces;  // of one pair, at one step
  static PairForces pair_of(const Solver& solver, const Contact& contact);
  static const PairForces* find(const std::vector<PairForces>& pairs, const PairForces& like);
  void add_work(const std::vector<PairForces>& now, double timestep);
  void note_events(const Solver& solver, const std::vector<PairForces>& now);

  ContactChoice choice_;
  std::uint64_t every_, first_step_ = 0;
  bool begun_ = false;
  HistoryRow now_;  // sums since the last row
  std::vector<PairForces> before_;
  std::vector<HistoryRow> rows_;
  std::vector<PatchEvent> events_;
};

// Comma-separated, SI, one header row with units; numbers read back exactly. Throws InputError when
// the file cannot be written.
void write_contacts_csv(const Model& model, const std::vector<ContactView>& contacts,
                        const std::string& file);
// The points as vertices of a VTK file (.vtp), world axes, m, with what belongs to each:
// force (N, the normal force on the first body), friction (N, of its patch, on the first body), and
// the numbers normal_force, overlap (m; below 0: gap), stiffness_fraction, friction_mobilization,
// sliding, body, neighbour and patch.
void write_contacts_vtk(const std::vector<ContactView>& contacts, const std::string& file);
void write_history_csv(const std::vector<HistoryRow>& rows, const std::string& file);

}  // namespace firn
