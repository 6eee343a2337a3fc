// A validation suite: what is simulated, with which parameters, and which measurements it is
// compared with. Keys: docs/validation.md.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/batch/execution/execution_settings.h"
#include "experiments/case/case.h"
#include "experiments/measurements/measurement.h"
#include "experiments/system/value_place.h"

namespace firn {

// One choice of material parameters, for all experiments.
struct ParameterSet {
  std::string name, note;
  std::string material;       // record, "NAME[@VERSION]"; empty: none
  std::vector<Override> set;  // case keys
  int samples = 0;            // draws from the record's ensemble, for the uncertainty of the input
  std::vector<ValuePlace> set_places = {};              // [set] for messages
  std::string material_place = {}, samples_place = {};  // "FILE:LINE: KEY"
};

// Runs of the first parameter set with finer numerics, to estimate their effect on the results.
struct Refinement {
  std::vector<double>
      timesteps;  // factors on the time step of the case, descending; empty: not varied
  std::vector<double> stiffness;  // Young's moduli of `material`, Pa
  std::string material;           // of the particles
  std::vector<std::uint64_t> seeds;
  std::vector<ValuePlace> timestep_places = {}, stiffness_places = {};  // [timesteps], [stiffness]
  std::string material_place = {};                                      // "FILE:LINE: KEY"
};

// Runs of the first parameter set with other keys: a coarser mesh, another sampling rate.
struct Variant {
  std::string name;
  std::vector<Override> set;
  std::vector<std::uint64_t> seeds;
  bool numerics = true;  // its effect is a part of the uncertainty; else only for comparisons of
                         // numerical variants
  // An end of the range of an assumption, such as a dimension that no source gives. It adds to the
  // input uncertainty and may change a verdict.
  bool assumed = false;
  std::vector<ValuePlace> set_places = {};  // [set] for messages
};

struct SuiteExperiment {
  std::string name, case_file;
  std::vector<Override> set;
  std::vector<std::uint64_t> seeds;
  Refinement refine;
  std::vector<Variant> variants = {};
  std::vector<std::string> parameter_sets = {};  // with these only; empty: with all
  std::optional<int> samples = {};               // draws in place of those of the parameter sets
  std::vector<std::string> assumes = {};         // what is assumed without a range, in words
  std::vector<ValuePlace> set_places = {};       // [set] for messages
  std::string samples_place = {};                // "FILE:LINE: KEY"
  bool runs_with(const ParameterSet& set) const;
};

// Inputs that were chosen with a measurement: a dimension, an outlet, a friction. What they were
// chosen with cannot validate the experiments that have them.
struct Chosen {
  std::string what;
  Measurement with;
  std::vector<std::string> experiments;  // of the suite; empty: all
  bool belongs_to(const SuiteExperiment& experiment) const;
};

enum class ComparisonKind {
  value,              // a number against a number
  curve,              // one quantity over another, against the same measured
  criteria,           // observations as relations that hold in a run or not
  breakage,           // loads on particles against their breaking force
  stiffness_scaling,  // no measurement: effect of a reduced stiffness on responses
  numerical_variants  // no measurement: effect of numerics and variants of the experiment on
                      // responses
};
const char* to_string(ComparisonKind kind);
bool measures(ComparisonKind kind);  // has a measurement

struct SuiteComparison {
  std::string name, title, note;
  ComparisonKind kind = ComparisonKind::value;
  std::size_t experiment = 0;
  Measurement measurement;             // none for stiffness_scaling
  std::vector<std::string> responses;  // one for a value; expressions for all kinds but criteria
  // Smallest relevant difference: of a value in its unit, of a curve as a share of its range.
  std::optional<double> tolerance;
  bool expects_breakage = true;  // as the authors of the experiment state
  double real_modulus = 0;       // Pa, for stiffness_scaling
  std::string calibrated_by_design =
      {};  // why the case reproduces the measured value by construction; empty: it does not
  std::string not_comparable = {};  // why nothing can be concluded; empty: something can
  std::vector<std::string> response_places = {};  // [responses] "FILE:LINE: KEY" for messages
  // That of a response; empty: none is known.
  std::string response_place(std::size_t response) const {
    return response < response_places.size() ? response_places[response] : std::string();
  }
};

struct Suite {
  std::string source, text;
  std::string name, title, note;
  int threads = 1;  // of each run
  std::vector<ParameterSet> parameter_sets;
  std::vector<SuiteExperiment> experiments;
  std::vector<Chosen> chosen;
  std::vector<SuiteComparison> comparisons;
  Execution execution;
};

// Throws InputError with one line `FILE:LINE: KEY: what is wrong; what is expected`.
Suite read_suite(const std::string& file);

}  // namespace firn
