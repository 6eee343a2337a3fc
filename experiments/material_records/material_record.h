// A material record: parameters of a material or of a pair of materials in contact, with their
// provenance. Plain data; docs/materials.md explains every field.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/text/units.h"

namespace firn {

enum class RecordKind {
  published,   // from a publication
  measured,    // by the author, with raw data
  calibrated,  // by a calibration study of this program
  assumed      // chosen; reason in provenance.source
};
const char* to_string(RecordKind kind);

// A number that sets one or more keys of a case.
struct MaterialParameter {
  std::string name;
  std::vector<std::string> keys;  // "interactions.ice-plastic.static_friction", ...
  double value = 0;
  std::string unit;                     // as in the source; "1" for a bare number
  std::optional<double> uncertainty;    // one standard deviation, same unit
  std::optional<Interval> interval_95;  // same unit
  std::string note;
};

// Further information without a case key: a strength, a range, a sentence.
struct MaterialProperty {
  std::string name;
  std::optional<double> value, uncertainty;  // one standard deviation
  std::optional<Interval> range;
  std::string unit;  // any text; empty for a sentence
  std::string conditions;
  std::string statement;
};

// A response of a simulation, or its prediction by a surrogate.
struct MaterialResponse {
  std::string name;
  double value = 0;
  std::optional<double> uncertainty;  // of a prediction, one standard deviation
  std::string unit;
};

// One simulation with the parameter values of a reference set.
struct ReferenceRun {
  std::string experiment;  // of the study; empty: its only one
  std::uint64_t seed = 0;
  std::vector<MaterialResponse> responses;
};

// A parameter set of the ensemble. Verified by simulation if it has runs.
struct ReferenceSet {
  std::string name;
  std::vector<double> values;  // in order of PosteriorEnsemble::axes
  std::vector<MaterialResponse> predicted;
  std::vector<ReferenceRun> runs;
};

enum class Scale { linear, logarithmic };

// One axis of the ensemble: a parameter of the record and its scale.
struct EnsembleAxis {
  std::string parameter;
  Scale scale = Scale::linear;
  Interval bounds;  // of the value; samples are within
  double mean = 0;  // of the value, or of its natural logarithm
};

// A combination of parameters:
// sum of coefficient * (value or its natural logarithm) = value +- uncertainty.
struct EnsembleCombination {
  std::vector<double> coefficients;  // in order of the axes
  bool identifiable = false;         // by the data; else only the ranges limit it
  double value = 0;
  std::optional<double> uncertainty;
};

struct EnsembleSample {
  std::vector<double> values;  // in order of the axes
  double weight = 0;           // sum over all samples: 1
};

// Posterior distribution of the parameters: moments, samples and reference sets.
struct PosteriorEnsemble {
  std::vector<EnsembleAxis> axes;
  std::vector<std::vector<double>> covariance;    // [axes][axes] in the scales of the axes
  std::vector<EnsembleCombination> combinations;  // best determined first
  std::vector<EnsembleSample> samples;            // ordered along the direction of largest variance
  std::vector<ReferenceSet> reference_sets;
};

// A limit of validity: "shape", "stiffness", "contact speed", "temperature", ...
struct ScopeLimit {
  std::string name;
  std::string statement;
};

struct UsedMeasurement {
  std::string name, response;
  double value = 0, uncertainty = 0;
  std::string unit;
  std::string source;           // publication or author
  std::string experiment = {};  // as stated by the measurement; empty: not stated
  // Prior standard deviation of the systematic error of the simulation in the study; 0: none.
  double discrepancy = 0;
};

struct UsedEstimator {
  std::string response, method;
  int version = 0;
};

// A file from which the values were computed.
struct RawData {
  std::string what, file;
  std::string sha256;  // of its bytes
};

// Complete case of an experiment of a study with the values of the first reference set.
struct SimulatedCase {
  std::string experiment;               // empty: the study's only one
  std::vector<std::string> parameters;  // parameters of the record that the case uses
  std::string text;
};

struct Provenance {
  std::string author;
  std::string date;    // 2026-11-21, or with the time: 2026-11-21T18:02:11Z
  std::string source;  // publication, section and table; notebook; reason of an assumption
  std::vector<RawData> raw_data;
  // Of a calibration:
  std::string program_version, program_commit;
  std::string program;    // program_identity()
  int contact_model = 1;  // of the program; 1: not stated in the record
  std::string study;      // name of the study
  std::vector<SimulatedCase> cases;
  std::vector<UsedMeasurement> measurements;
  std::vector<std::uint64_t> seeds;  // of all runs used
  std::vector<UsedEstimator> estimators;
  std::string command;  // command that repeats the calibration
};

struct MaterialRecord {
  std::string name;
  int version = 0;         // 0: not in a database
  std::string supersedes;  // hash of the previous version; empty: none
  std::string title;
  std::vector<std::string> materials;  // one, or a pair
  RecordKind kind = RecordKind::published;
  std::vector<MaterialParameter> parameters;
  std::vector<MaterialProperty> properties;
  std::optional<PosteriorEnsemble> ensemble;
  std::vector<ScopeLimit> scope;
  Provenance provenance;
  std::string note;  // assumptions, contradictions, missing information

  std::string reference() const;                     // "ice-plastic@2"
  std::size_t index(const std::string& name) const;  // of a parameter, which must exist
};

// Throws InputError `FIELD: FAULT; EXPECTATION` for a record that is incomplete, e.g. without
// provenance, or that no case can use. The version is not checked.
void check(const MaterialRecord& record);

// Components of a case key that a record can set: interactions.ice-plastic.static_friction.
struct MaterialKey {
  std::string table;                   // "materials", "interactions"
  std::vector<std::string> materials;  // one material, or two of a pair
  std::string key;
  Dimension dimension;
  // Values that a case accepts for it, in any unit.
  struct Range {
    double low;
    bool low_included;
    double high;
    bool high_included;
    const char* expected;  // in words, for messages
    bool contains(double value) const;
  } range;
};
// Throws InputError for any other key.
MaterialKey parse_material_key(const std::string& path);

// A value as TOML text of a case file: `0.1`, `"0.01 GPa"`.
std::string toml_value(double value, const std::string& unit);

// "NAME" or "NAME@VERSION", optionally followed by "#3" (a sample) or "#member 1" (a reference
// set).
struct MaterialChoice {
  std::string name;
  int version = 0;                      // 0: the newest
  std::optional<std::uint64_t> sample;  // from 1
  std::string reference_set;
  std::string selection() const;  // "sample 3", "reference set \"member 1\"", ""
};
MaterialChoice parse_material_choice(const std::string& text);

// Values of all parameters, in their order: the point values, those of a reference set, or the k-th
// draw from the ensemble. A draw depends on the record and k only. From stored samples, draws are
// selected by multiples of the golden ratio, so that the first few already cover the ensemble.
// Without samples, draws are from the normal distribution truncated at the bounds. Throws
// InputError without an ensemble or without that reference set.
std::vector<double> chosen_values(const MaterialRecord& record, const MaterialChoice& choice);

// Warning in one line for the record `reference`, calibrated with `contact_model`. Empty if this
// program has the same contact model.
std::string contact_model_warning(const std::string& reference, int contact_model);

}  // namespace firn
