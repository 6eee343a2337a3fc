// A case over values of its keys and over seeds: what `firn sweep` does. docs/sweeps.md.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "experiments/analysis/power_law.h"
#include "experiments/batch/batch_folder.h"
#include "experiments/case/case.h"

namespace firn {

// One varied quantity: a name, the keys that take it, and its values as TOML.
struct SweptKey {
  std::string name;
  std::vector<std::string> keys;
  std::vector<std::string> values;
};

struct Sweep {
  std::string source, text;
  std::string name, case_file;
  std::vector<Override> set;           // for all runs
  std::vector<std::string> materials;  // records, for all runs
  std::vector<std::string> responses;  // operands; empty: all single-valued ones
  std::vector<std::uint64_t> seeds;
  std::vector<SweptKey> vary;
  bool grid = true;  // every combination; else the first values together, the second, ...
  int threads = 1;
  Execution execution;

  std::size_t combinations() const;
  // Values of a combination, one a swept key; the last key varies fastest.
  std::vector<std::string> values(std::size_t combination) const;
};

// Throws InputError with one line `FILE:LINE: KEY: what is wrong; what is expected`.
Sweep read_sweep(const std::string& file);

struct SweepOptions : BatchOptions {
  std::string sweep_file;  // TOML
};

struct SweepRun {
  std::size_t combination = 0;
  std::uint64_t seed = 0;
  std::string key;
  JobResult result;
  std::vector<double> values;  // of SweepResult::responses; NaN: not finished, or undefined
};

struct SweepResult {
  Sweep sweep;
  std::vector<std::string> responses, units;
  std::vector<SweepRun> runs;  // by combination, then by seed
  std::string directory;
  bool interrupted = false;
};

// Runs or resumes the sweep and writes runs.csv and results.json into the directory. Throws
// InputError for a wrong file, a directory that holds something else, or a response that the case
// does not have.
SweepResult sweep(const SweepOptions& options);

// A response as a power of the one key that a sweep varies.
struct SweptPower {
  std::string response;
  PowerLaw law;
};
// Of the means over seeds. Empty unless one key alone is varied, over numbers above zero (with
// units or without); a response that is not above zero everywhere is left out.
std::vector<SweptPower> powers(const SweepResult& result);

std::string render_table(const SweepResult& result);  // as text: means and scatter
std::string render_json(const SweepResult& result);

}  // namespace firn
