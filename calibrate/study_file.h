// A study as the user wrote it: which case, which parameters within which ranges, which
// measurements to meet, and how many runs it may cost. Keys: docs/calibration.md.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/parameters.h"

namespace firn {

// A response that the simulation has to reproduce.
struct Target {
  std::string response;
  double value = 0;        // in the response's unit
  double uncertainty = 0;  // one standard deviation of the measured value, same unit, > 0
  std::string unit;        // as the response spells it: "deg", "1", ...
  std::string source;      // measurement file, or the study file for a value given in place
};

// Parameters held at given values for comparison: what does this solver say of them?
struct CompareSet {
  std::string name;
  std::vector<double> values;  // in order of Study::parameters
};

// How many simulations, and for what. One "point" is one set of parameters.
struct Budget {
  int centre_runs = 0;     // seeds at the middle of the ranges
  int design_points = 0;   // spread over the ranges, besides the middle
  int runs_per_point = 0;  // seeds at each point of the design and of the refinement
  int refine_rounds = 0;   // batches that look closer at what may be the answer
  int refine_points = 0;   // points in each
  int confirm_runs = 0;    // fresh seeds at the answer; only these are reported
  int anchor_runs = 0;     // fresh seeds at either end of a valley of equal answers; 0: none
  int compare_runs = 0;    // seeds at each compare set

  int largest_total(std::size_t compare_sets) const;
};

struct Study {
  std::string name;
  std::string source;     // file it was read from
  std::string text;       // its whole text: a directory belongs to one text
  std::string case_file;  // path, resolved against the study's folder
  std::uint64_t seed = 1;
  int threads = 1;  // of each simulation
  Budget budget;
  std::vector<Parameter> parameters;
  std::vector<Target> targets;
  std::vector<std::string> observed;  // responses modelled and reported, though not targets
  std::vector<CompareSet> compare;
};

// Reads and checks a study. Throws InputError with one line
// `FILE:LINE: KEY: what is wrong; what is expected`.
Study read_study(const std::string& file);

}  // namespace firn
