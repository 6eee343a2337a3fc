// Numerical quality of a run, and the likely cause of faults.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "experiments/results/results_file.h"

namespace firn {

// Indicators of the quality of the contacts of a run. Lengths in m.
struct ContactDiagnostics {
  double largest_overlap = 0;   // over all steps
  double edge = 0;              // smallest box edge of the shapes in use
  bool stopped = false;         // an overlap beyond numerics.overlap_limit ended the run
  double late_contacts = 0;     // detected at an overlap above 1 % of the rounding radii
  double particles = 0;         // number of particles of the case
  double rounding = 0;          // smallest rounding radius relative to the box edge of its shape
  double rounding_edge = 0;     // smallest box edge of that shape
  double expected_overlap = 0;  // of the softest shape: impact at `speed`, and its largest load
  double speed = 0;             // m/s, largest in the frames
  bool automatic_timestep = false;  // timestep = "auto", from steps_per_loading
  double steps_per_quarter = 0;     // time steps per quarter period of the stiffest contact
};

enum class ContactCause { none, rounding, stiffness, timestep };

// `none` for a run without faults: no overlap above a tenth of `edge`, and no more late contacts
// than a tenth of the number of particles, or 10.
ContactCause likely_cause(const ContactDiagnostics& diagnostics);

// Reads at most 200 frames for the speeds.
ContactDiagnostics contact_diagnostics(const Recording& recording, const Case& c);

// One sentence: the fault, its likely cause and a remedy. Empty for a run without faults.
std::string contact_warning(const ContactDiagnostics& diagnostics);

// Energy balance of a run, J. The sum kinetic + gravitational + elastic + dissipated - work of
// boundaries + energy of removed particles is constant but for the error of the time step.
struct EnergyAccount {
  double gained = 0;       // largest rise of the sum over an earlier frame
  double turned_over = 0;  // the larger one of dissipated energy and work of boundaries
};
// Nothing where the file lacks a term of the balance.
std::optional<EnergyAccount> energy_account(const Recording& recording);

// One sentence if the balance gains more than 0.2 % of `turned_over`; else empty. The check during
// a run compares the remaining energy only, in which dissipation hides a gain.
std::string energy_warning(const EnergyAccount& account);

// Energy balance of the free bodies of a run, J. Each energy is compared over all frames.
struct FreeBodyBalance {
  double change = 0;  // of the sum of docs/results.md, which is constant but for errors
  // Largest change of kinetic, elastic or dissipated energy, or of the work.
  double turned_over = 0;
};
// Nothing without free bodies, or without frames.
std::optional<FreeBodyBalance> free_body_balance(const Recording& recording);

// One sentence if the balance changes by more than 2 % of `turned_over`; else empty.
std::string free_body_warning(const FreeBodyBalance& balance);

// Numbers of steps up to the last frame.
struct JointConvergence {
  double unconverged = 0;  // in which friction, motors and limits of mechanisms did not converge
  double steps = 0;
};
// Zeros for a file of an earlier version.
JointConvergence joint_convergence(const Recording& recording);

// One sentence with the likely cause and a remedy if there are such steps; else empty.
std::string convergence_warning(const JointConvergence& convergence);

// A warning on the results of a run, one sentence, and what it is about.
struct RunWarning {
  std::string subject;
  std::string text;
};
// All of the above that are not empty.
std::vector<RunWarning> run_warnings(const Recording& recording, const Case& c);

// One sentence for a shape whose convex parts deviate from its mesh by more than 2 % of its
// smallest edge, or that needs more parts than max_parts. The limit is 5 % if a rounding radius
// that the case states is the only reason. Empty for all other shapes.
std::string deviation_warning(const Shape& shape, bool rounding_is_stated = false);
// Names of the shapes whose rounding radius the case states.
std::set<std::string> shapes_with_stated_rounding(const Case& c);

}  // namespace firn
