// The tests of ice that a laboratory can do on a bench, with what they cost and how well they can
// be read. The choice of the next measurement needs these data in addition to the simulations.
// Format and reasons: docs/bench-tests.md.
#pragma once

#include <string>
#include <vector>

namespace firn {

// One response of a test, as far as it is known before a measurement.
struct BenchResponse {
  std::string name;                   // docs/responses.md
  std::string measurement;            // path of the file that a laboratory fills in
  std::string unit;                   // as the response spells it
  double standard_deviation = 0;      // of one repeat
  double systematic_uncertainty = 0;  // one standard deviation, common to all repeats; 0: none
  std::string rationale;              // where both come from

  // One standard deviation of the mean, as of a Measurement.
  double standard_uncertainty(int repeats) const;
};

struct BenchTest {
  std::string name;       // unique: "tilt"
  std::string title;      // "one cube on a plate that tilts"
  std::string case_file;  // path
  std::string informs;    // on which parameter, in words
  std::string with;       // not empty: name of the test that it is read off; `setup` and
                          // `per_repeat` come on top of that one's
  double setup = 0;       // s of a person's time, once
  double per_repeat = 0;  // s
  int repeats = 1;        // that a laboratory would do
  std::string rationale;  // where the times come from
  std::vector<BenchResponse> responses;  // at least one

  double effort(int n) const { return setup + n * per_repeat; }  // s, of n repeats
};

// Paths are made from those in the file, which are relative to it. Throws InputError with one line
// `FILE:LINE: KEY: what is wrong; what is expected`.
std::vector<BenchTest> read_bench_tests(const std::string& file);

}  // namespace firn
