// Parameter sweeps: a case with varied keys and seeds. docs/sweeps.md.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "experiments/analysis/elementary_effects.h"
#include "experiments/analysis/power_law.h"
#include "experiments/batch/batch_folder.h"
#include "experiments/case/case.h"
#include "experiments/system/value_place.h"

namespace firn {

// A varied quantity: its name, the case keys that it sets, and its values as TOML. Without keys,
// its values are material records.
struct SweptKey {
  std::string name;
  std::vector<std::string> keys;
  std::vector<std::string> values;
  std::vector<std::string> labels = {};  // [values] for people; empty: the values themselves
  std::vector<ValuePlace> key_places = {}, value_places = {};  // [keys], [values] for messages

  bool is_material() const { return keys.empty(); }
};

enum class SweepDesign {
  grid,   // all combinations
  list,   // the k-th values of all quantities together
  morris  // trajectories of a screening
};

struct Sweep {
  std::string source, text;
  std::string name, case_file;
  std::vector<Override> set;           // for all runs
  std::vector<ValuePlace> set_places;  // [set] for messages
  std::vector<std::string> materials;  // records, for all runs
  std::vector<std::string> responses;  // expressions; empty: all responses of one value
  std::vector<ValuePlace> material_places, response_places;  // [materials], [responses]
  std::vector<std::uint64_t> seeds;
  std::vector<SweptKey> vary;
  SweepDesign design = SweepDesign::grid;
  ScreeningDesign screening;  // of SweepDesign::morris; its factors are `vary`
  int threads = 1;
  Execution execution;

  std::size_t combinations() const;
  // Which of its values each quantity has in a combination [vary]; in a grid, the last quantity
  // varies fastest.
  std::vector<std::size_t> levels(std::size_t combination) const;
  // Its values [vary].
  std::vector<std::string> values(std::size_t combination) const;
  // The same for people: labels, or values as plain_value() has them.
  std::vector<std::string> value_labels(std::size_t combination) const;
  std::string label(std::size_t combination) const;  // "friction=0.1 density=900 kg/m^3"
};

// A TOML value as people write it: strings without their quotes, tables and lists on one line.
std::string plain_value(const std::string& value);

// Throws InputError with one line `FILE:LINE: KEY: FAULT; EXPECTATION`.
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

// Runs or resumes the sweep and writes runs.csv and results.json to the directory. Throws
// InputError for a wrong file, a directory with other content, and a response that the case does
// not have.
SweepResult sweep(const SweepOptions& options);

// A response as a power law of the varied quantity.
struct SweptPower {
  std::string response;
  PowerLaw law;
};
// Power laws of the means over seeds. Empty unless exactly one quantity is varied in a grid or a
// list, over numbers above 0 with or without units. Responses that are not above 0 everywhere are
// omitted.
std::vector<SweptPower> powers(const SweepResult& result);

// Effects of the varied quantities on a response, by a screening.
struct ScreenedResponse {
  std::string response;
  std::vector<ElementaryEffects> effects;  // [vary]
  // [vary] mean absolute effect by the scatter over seeds alone; empty with one seed.
  std::vector<double> noise;
};
// [responses] Of the means over seeds. Empty for other designs.
std::vector<ScreenedResponse> screened_responses(const SweepResult& result);

std::string render_table(const SweepResult& result);  // as text: means and scatter
std::string render_json(const SweepResult& result);

}  // namespace firn
