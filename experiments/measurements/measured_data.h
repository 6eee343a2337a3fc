// Data of an experiment beyond one number: values one by one, counts by class, or a trace of a load
// cell or an accelerometer. The user stores them as CSV files next to a measurement;
// docs/measurements.md.
#pragma once

#include <string>
#include <vector>

#include "experiments/text/toml_document.h"
#include "experiments/text/units.h"

namespace firn {

struct MeasuredData {
  enum class Kind {
    values,   // one a repeat, a particle, an event
    classes,  // counts
    trace,    // a signal over time, of which the peaks are taken as values
    curve     // one quantity over another
  };
  Kind kind = Kind::values;
  std::string file;      // CSV
  bool present = false;  // there may be none yet
  std::string response;  // that has the same values or counts in a run
  std::string unit;      // of the values: the response's
  std::string source;
  std::vector<double> values;          // of a trace: its peaks, in order of time
  std::vector<double> right_censored;  // right-censored values: lower bounds
  std::vector<std::string> classes;    // in order of the file, with
  std::vector<double> counts;          // so many each
  std::vector<double> time, samples;   // of a trace: s, and its filtered samples in `unit`
  // Of a curve: its repeats, each in order of the file, x in `x_unit` and y in `unit`.
  struct Repeat {
    std::vector<double> x, y;
  };
  std::vector<Repeat> repeats;
  std::string x_unit;
  std::string x_name, y_name;  // as the file heads them
  // How curves are laid over each other: as they are; each shifted so that x = 0 where y first
  // reaches a twentieth of its largest magnitude; or to where they differ least.
  enum class Alignment { none, onset, best };
  Alignment align = Alignment::none;
};

// [data] of a measurement; `directory`: where its file lies. Throws InputError for keys that are
// wrong and for a file that is; none is no mistake.
MeasuredData read_measured_data(const TomlTable& table, const std::string& directory);

// The numbers of one column of a CSV file with a header, in `unit`. Throws InputError.
std::vector<double> read_csv_values(const std::string& file, const std::string& column,
                                    const Unit& unit);

// The largest magnitude of each stretch in which a signal's magnitude stays above `threshold`,
// stretches less than `dead_time` apart taken as one. Signs are kept.
std::vector<double> peaks(const std::vector<double>& time, const std::vector<double>& samples,
                          double threshold, double dead_time);

}  // namespace firn
