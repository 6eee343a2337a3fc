// The verification suite: the solver compared with known solutions.
//
// A case sets up a small scene through the public Solver alone, runs it, and returns checks: one
// number each, compared with a closed form, a published value, a second method or an equivalent
// setup. `firn verify` prints them as a table and writes a page; the test suite runs the same ones.
// Cases are pure: no files, no clock, no global state, so that they can run in parallel.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace firn::verification {

// How `tolerance` is meant.
enum class Bound {
  relative,  // |measured - expected| <= tolerance |expected|
  absolute,  // |measured - expected| <= tolerance, in the unit of the value
  at_most,   // measured <= expected; no tolerance
  at_least,  // measured >= expected; no tolerance
};

struct Check {
  std::string what;  // one line: "rebound speed, m = 1 kg, v = 1 m/s, e = 0.5"
  double measured = 0;
  double expected = 0;
  double tolerance = 0;
  Bound bound = Bound::relative;
  std::string unit = "1";
};

// True when the measured value is finite and keeps its bound.
bool passed(const Check& check);
// Tolerance fraction: error over tolerance; above 1 the check fails. For at_most and at_least,
// measured / expected or its inverse.
double tolerance_fraction(const Check& check);

enum class Tier { quick, full };  // seconds; minutes

struct VerificationCase {
  std::string name;   // "impact.normal": group, dot, name
  std::string title;  // "Sphere on a rigid wall, hysteretic spring"
  std::string
      reference;  // the closed form or reference solution, in words and symbols, with its source
  std::string remark;  // reason for the tolerance; assumptions; limits
  Tier tier = Tier::quick;
  std::function<std::vector<Check>()> run;
};

// The part of a case's name before the dot.
std::string group(const VerificationCase& c);

// All cases of the suite, in the order of the page: one function a group, cases_GROUP*.cpp.
std::vector<VerificationCase> all_cases();
std::vector<VerificationCase> impact_cases();        // "impact.": one contact, normal and oblique
std::vector<VerificationCase> energy_cases();        // "energy.": elastic impacts
std::vector<VerificationCase> body_cases();          // "body.": one rigid body, free and on a plane
std::vector<VerificationCase> structure_cases();     // "structure.": stacks, arches
std::vector<VerificationCase> bulk_cases();          // "bulk.": packings, silos, heaps
std::vector<VerificationCase> machine_cases();       // "machine.": parts in contact, joints, motors
std::vector<VerificationCase> invariance_cases();    // "invariance.": equivalent setups
std::vector<VerificationCase> mesh_cases();          // "invariance.": other meshes, other parts
std::vector<VerificationCase> tessellation_cases();  // "invariance.": the same solid cut otherwise
std::vector<VerificationCase> curved_wall_cases();   // "invariance.": facets that are refined
std::vector<VerificationCase> robustness_cases();    // "robustness.": extreme setups

}  // namespace firn::verification
