// Detailed data of a measurement from CSV files: single values, counts by class, traces of a load
// cell or an accelerometer, and curves. Format: docs/measurements.md.
#pragma once

#include <string>
#include <vector>

#include "experiments/text/toml_document.h"
#include "experiments/text/units.h"

namespace firn {

struct MeasuredData {
  enum class Kind {
    values,   // one per repeat, particle or event
    classes,  // counts by class
    trace,    // a signal over time; its peaks are the values
    curve     // one quantity over another
  };
  Kind kind = Kind::values;
  std::string file;      // CSV
  bool present = false;  // the file exists
  std::string response;  // response of a run with comparable values or counts
  std::string unit;      // of the values and of the response
  std::string source;
  std::vector<double> values;          // of a trace: its peaks, in order of time
  std::vector<double> right_censored;  // lower bounds of right-censored values
  std::vector<std::string> classes;    // in the order of the file
  std::vector<double> counts;          // [classes]
  std::vector<double> time, samples;   // of a trace: s; filtered, in `unit`
  // Repeats of a curve in the order of the file, x in `x_unit` and y in `unit`.
  struct Repeat {
    std::vector<double> x, y;
  };
  std::vector<Repeat> repeats;
  std::string x_unit;
  std::string x_name, y_name;  // headings of the columns
  // Alignment of curves along x: none; onset: x = 0 where |y| first reaches a twentieth of its
  // maximum; best: least difference.
  enum class Alignment { none, onset, best };
  Alignment align = Alignment::none;
  std::string response_place = {};  // "FILE:LINE: KEY" for messages
};

// Reads the table [data] of a measurement. `directory`: folder of the measurement file. Throws
// InputError for wrong keys and for a defective CSV file; the CSV file may be missing.
MeasuredData read_measured_data(const TomlTable& table, const std::string& directory);

// The numbers of one column of a CSV file with a header, in `unit`. Throws InputError.
std::vector<double> read_csv_values(const std::string& file, const std::string& column,
                                    const Unit& unit);

// Peaks of a signal: the sample of largest magnitude in each interval with magnitudes above
// `threshold`. Intervals less than `dead_time` (s) apart are merged. Samples keep their sign.
std::vector<double> peaks(const std::vector<double>& time, const std::vector<double>& samples,
                          double threshold, double dead_time);

}  // namespace firn
