// Whether the contacts of a run can be trusted, and what most likely spoils them.
#pragma once

#include <optional>
#include <set>
#include <string>

#include "experiments/results/results_file.h"

namespace firn {

// What a run says about its contacts. Lengths in m.
struct ContactDiagnostics {
  double largest_overlap = 0;  // over all steps
  double edge = 0;             // smallest box edge of the shapes in use
  bool stopped = false;        // an overlap beyond numerics.overlap_limit ended the run
  double late_contacts = 0;    // contacts first seen deeper than 1 % of the sweep radii
  double particles = 0;        // in all
  double rounding = 0;         // of the sharpest shape, and the edge of its box
  double rounding_edge = 0;
  double expected_overlap = 0;      // of the softest shape: impact at top speed, and the load on it
  double speed = 0;                 // m/s, largest in the frames
  bool automatic_timestep = false;  // by case.steps_per_loading
  double steps_per_quarter = 0;     // time steps in the quarter period of the stiffest contact
};

enum class ContactCause { none, rounding, stiffness, timestep };

// `none` for a run without faults: no overlap above a tenth of the edge, and late contacts of less
// than one particle in ten (ten at least).
ContactCause likely_cause(const ContactDiagnostics& diagnostics);

// From the recording alone. Speeds are those of at most 200 frames.
ContactDiagnostics contact_diagnostics(const Recording& recording, const Case& c);

// One sentence: what is wrong, the likely cause and what to change. Empty for a run without faults.
std::string contact_warning(const ContactDiagnostics& diagnostics);

// The energy account of a run: kinetic + gravitational + elastic + dissipated - done by boundaries
// + carried away stays as it is but for the error of the time step. J.
struct EnergyAccount {
  double gained = 0;       // largest rise of it over an earlier frame
  double turned_over = 0;  // dissipated and done by boundaries, whichever is more
};
// Nothing where the file has no whole account.
std::optional<EnergyAccount> energy_account(const Recording& recording);

// One sentence for an account that gains more than 0.2 % of what was turned over; else empty.
// Contacts take energy: what the time step adds is an error that dissipation hides from the check
// of a run under way, which sees what is left of the energy alone.
std::string energy_warning(const EnergyAccount& account);

// One sentence for a shape whose contact parts deviate from its mesh by more than 2 % of its
// smallest edge (5 % where only a rounding that the case states is the reason), or would need more
// parts than max_parts allows. Empty for all others.
std::string deviation_warning(const Shape& shape, bool rounding_is_stated = false);
// Names of the shapes whose rounding the case states.
std::set<std::string> shapes_with_stated_rounding(const Case& c);

}  // namespace firn
