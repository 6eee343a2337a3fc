// Calibration of a simulator that the caller supplies as a function. The method is that of
// `firn calibrate`: docs/calibration.md.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace firn::calibration {

struct Parameter {
  std::string name;         // letters, digits, _ and -
  double min = 0, max = 0;  // range, in `unit`
  std::string unit;         // "" for a number
  bool logarithmic = false;
  // Gaussian prior in the parameter's unit; both or neither.
  std::optional<double> prior_mean, prior_sd;
};

// A measured value that the simulator has to reproduce.
struct Target {
  std::string response;
  double value = 0;
  double uncertainty = 0;  // one standard deviation, > 0
  std::string unit = "1";  // of value and uncertainty, as the simulator states it
  // One standard deviation of the simulator's systematic error in this response, in the same unit;
  // 0: none.
  double discrepancy = 0;
};

struct Response {
  std::string name;
  double value = 0;  // NaN: undefined in this run
  std::string unit = "1";
};

// One run: values of all parameters by name, in their units, and the seed of all randomness. Equal
// arguments give equal responses. A RunError makes a failed run with unknown responses. Any other
// exception ends the calibration and is rethrown by calibrate().
using Simulator = std::function<std::vector<Response>(const std::map<std::string, double>& values,
                                                      std::uint64_t seed)>;

struct Problem {
  std::string name = "study";
  std::vector<Parameter> parameters;
  std::vector<Target> targets;
  int runs = 0;  // at most, at least about 10 and 4 per parameter
  std::uint64_t seed = 1;
};

struct Options {
  // Where finished runs and reports are kept; a later call with the same problem continues there.
  // Empty: a temporary folder.
  std::string directory;
  // Part of the identity of a run in `directory`: change it with every change of the simulator, or
  // outcomes of the old one are used again.
  std::string simulator_version = "1";
  int jobs = 1;  // runs side by side, on as many threads; the simulator must allow it
  // Called on the thread of calibrate() several times a second, and before each run; false stops.
  std::function<bool()> keep_going;
};

struct Estimate {
  std::string parameter, unit;
  double best = 0;                       // of the recommended set
  double median = 0, low = 0, high = 0;  // central 95 % interval of the posterior
  bool at_min = false, at_max = false;   // the interval reaches this end of the range
};

struct Result {
  // "calibrated", "not identifiable" (a ridge of equal responses), "unconfirmed", "infeasible",
  // "prior conflict", "too few runs", "interrupted"
  std::string verdict;
  std::string headline;             // one sentence
  std::vector<Estimate> estimates;  // in order of the parameters; empty without a fit
  // Posterior samples [S, number of parameters] row by row in the parameters' units, and their
  // weights [S], which add up to 1.
  std::vector<double> samples, weights;
  int runs = 0;       // used by the result
  std::string table;  // as text
  std::string json;   // everything, as results.json of `firn calibrate`
};

// Throws InputError for an invalid problem or a directory that holds another one, and WriteError (a
// RunError) when the directory cannot be written.
Result calibrate(const Problem& problem, const Simulator& simulator, const Options& options = {});

}  // namespace firn::calibration
