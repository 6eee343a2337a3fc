// A material record: what is known of a material, or of two that touch, and where it comes from.
// Plain data; docs/materials.md explains every field.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/text/units.h"

namespace firn {

enum class RecordKind {
  published,   // as a publication prints it
  measured,    // by the author, raw data kept
  calibrated,  // by a study of this program
  assumed      // chosen, for the reason that provenance.source gives
};
const char* to_string(RecordKind kind);

struct Interval {
  double low = 0, high = 0;
};

// One number that cases can take, bound to one or more of their keys.
struct MaterialParameter {
  std::string name;
  std::vector<std::string> keys;  // "interactions.ice-plastic.static_friction", ...
  double value = 0;
  std::string unit;                     // as its source spells it; "1" for a bare number
  std::optional<double> uncertainty;    // one standard deviation, same unit
  std::optional<Interval> interval_95;  // same unit
  std::string note;
};

// What is known besides, for which cases have no key: a strength, a range, a sentence.
struct MaterialProperty {
  std::string name;
  std::optional<double> value, uncertainty;  // one standard deviation
  std::optional<Interval> range;
  std::string unit;  // in any spelling; empty for a sentence
  std::string conditions;
  std::string statement;
};

// What a simulation gave, or a study's model of it.
struct MaterialResponse {
  std::string name;
  double value = 0;
  std::optional<double> uncertainty;  // of a model's word; one standard deviation
  std::string unit;
};

// One simulation with the values of a reference set.
struct ReferenceRun {
  std::string experiment;  // of the study; empty: its only one
  std::uint64_t seed = 0;
  std::vector<MaterialResponse> responses;
};

// A parameter set of the ensemble that a study reports. Verified when it has runs.
struct ReferenceSet {
  std::string name;
  std::vector<double> values;  // in order of PosteriorEnsemble::axes
  std::vector<MaterialResponse> predicted;
  std::vector<ReferenceRun> runs;
};

enum class Scale { linear, logarithmic };

// One axis of the ensemble: a parameter of the record, in the coordinate in which it scatters.
struct EnsembleAxis {
  std::string parameter;
  Scale scale = Scale::linear;
  Interval bounds;  // of the value; nothing is drawn beyond
  double mean = 0;  // of the value, or of its natural logarithm
};

// sum of coefficient * (value or its natural logarithm) = value +- uncertainty
struct EnsembleCombination {
  std::vector<double> coefficients;  // in order of the axes
  bool identifiable = false;         // by the data; else the range alone limits it
  double value = 0;
  std::optional<double> uncertainty;
};

struct EnsembleSample {
  std::vector<double> values;  // in order of the axes
  double weight = 0;           // all together: 1
};

// All parameter sets that agree with the measurements, not one of them.
struct PosteriorEnsemble {
  std::vector<EnsembleAxis> axes;
  std::vector<std::vector<double>> covariance;    // of the scaled coordinates
  std::vector<EnsembleCombination> combinations;  // strongest first
  std::vector<EnsembleSample> samples;            // of the posterior, along its longest direction
  std::vector<ReferenceSet> reference_sets;
};

// Where the values hold: "shape", "stiffness", "contact speed", "temperature", ...
struct ScopeLimit {
  std::string name;
  std::string statement;
};

struct UsedMeasurement {
  std::string name, response;
  double value = 0, uncertainty = 0;
  std::string unit;
  std::string source;           // the publication, or who measured it
  std::string experiment = {};  // as the measurement states it; empty: not stated
  // One standard deviation of the simulation's systematic error that the study allowed; 0: none.
  double discrepancy = 0;
};

struct UsedEstimator {
  std::string response, method;
  int version = 0;
};

// A file that the values were made from.
struct RawData {
  std::string what, file;
  std::string sha256;  // of its bytes
};

// The complete case of one of a study's experiments, as simulated at the first reference set.
struct SimulatedCase {
  std::string experiment;               // empty: the study's only one
  std::vector<std::string> parameters;  // of the record, that this case takes
  std::string text;
};

struct Provenance {
  std::string author;
  std::string date;    // 2026-11-21, or with the time: 2026-11-21T18:02:11Z
  std::string source;  // publication, section and table; notebook; reason of an assumption
  std::vector<RawData> raw_data;
  // Of a calibration, all of them:
  std::string program_version, program_commit;
  std::string program;    // identity of what decides its numbers: firn_program()
  int contact_model = 1;  // of the program; records made before it had a number: 1
  std::string study;      // its name
  std::vector<SimulatedCase> cases;
  std::vector<UsedMeasurement> measurements;
  std::vector<std::uint64_t> seeds;  // of every run that the values rest on
  std::vector<UsedEstimator> estimators;
  std::string command;  // makes the values again
};

struct MaterialRecord {
  std::string name;
  int version = 0;         // 0: not in a database yet
  std::string supersedes;  // hash of the version before; empty: none
  std::string title;
  std::vector<std::string> materials;  // one, or a pair
  RecordKind kind = RecordKind::published;
  std::vector<MaterialParameter> parameters;
  std::vector<MaterialProperty> properties;
  std::optional<PosteriorEnsemble> ensemble;
  std::vector<ScopeLimit> scope;
  Provenance provenance;
  std::string note;  // what is assumed, contradictory or missing

  std::string reference() const;                     // "ice-plastic@2"
  std::size_t index(const std::string& name) const;  // of a parameter; there must be one
};

// Throws InputError `FIELD: what is wrong; what is expected` for a record that lacks something, its
// provenance above all, or that no case could take. The name's version is not looked at.
void check(const MaterialRecord& record);

// The case key that a record may set, taken apart: interactions.ice-plastic.static_friction.
struct MaterialKey {
  std::string table;                   // "materials", "interactions"
  std::vector<std::string> materials;  // the one, or the two of a pair
  std::string key;
  Dimension dimension;
};
// Throws InputError for anything else.
MaterialKey parse_material_key(const std::string& path);

// A value as a case file spells it: `0.1`, `"0.01 GPa"`.
std::string toml_value(double value, const std::string& unit);

// "NAME", "NAME@VERSION", each with "#3" (a sample) or "#member 1" (a reference set) behind.
struct MaterialChoice {
  std::string name;
  int version = 0;                      // 0: the newest
  std::optional<std::uint64_t> sample;  // from 1
  std::string reference_set;
  std::string selection() const;  // "sample 3", "reference set \"member 1\"", ""
};
MaterialChoice parse_material_choice(const std::string& text);

// Values of all parameters, in order: the point values, those of a reference set, or the k-th draw
// from the ensemble. Draws depend on nothing but the record and k. With stored samples, k walks
// them by the golden ratio: the first few draws already spread over the ensemble. Without, they are
// draws from the Gaussian, cut at the bounds. Throws InputError where there is no ensemble or no
// such reference set.
std::vector<double> chosen_values(const MaterialRecord& record, const MaterialChoice& choice);

// One line about the record `reference`, calibrated with `contact_model`; empty: this build has the
// same contact model.
std::string contact_model_warning(const std::string& reference, int contact_model);

}  // namespace firn
