// Laboratory tests of ice with their cost and measurement uncertainty, for the choice of the next
// measurement. Format and reasons: docs/bench-tests.md.
#pragma once

#include <string>
#include <vector>

namespace firn {

// A response of a test and its expected uncertainty.
struct BenchResponse {
  std::string name;               // docs/responses.md
  std::string measurement;        // path of the measurement file for the results of the laboratory
  std::string unit;               // of the response
  double standard_deviation = 0;  // of one repeat
  double systematic_uncertainty = 0;  // one standard deviation, common to all repeats; 0: none
  std::string rationale;              // source of both numbers

  // Standard uncertainty of the mean of `repeats`: see Measurement::standard_uncertainty().
  double standard_uncertainty(int repeats) const;
};

struct BenchTest {
  std::string name;       // unique: "tilt"
  std::string title;      // "one cube on a plate that tilts"
  std::string case_file;  // path
  std::string informs;    // parameter that the test determines, in words
  // Name of another test that gives this one in addition; `setup` and `per_repeat` are the extra
  // times. Empty: an independent test.
  std::string with;
  double setup = 0;                      // s, working time, once
  double per_repeat = 0;                 // s, working time
  int repeats = 1;                       // usual number
  std::string rationale;                 // source of the times
  std::vector<BenchResponse> responses;  // at least one

  double effort(int n) const { return setup + n * per_repeat; }  // s, working time of n repeats
};

// Paths in the file are relative to it; those in the result include its folder. Throws InputError
// with one line `FILE:LINE: KEY: FAULT; EXPECTATION`.
std::vector<BenchTest> read_bench_tests(const std::string& file);

}  // namespace firn
