// Calibrates a simulator of the user: a block that slides down a ramp and out on the flat. Two
// frictions, two measured responses.
#include <firn/calibrate/calibrate.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <random>

using namespace firn::calibration;

// Energy balance. The seed changes the height from which the block starts, as a person would.
std::vector<Response> slide(const std::map<std::string, double>& values, std::uint64_t seed) {
  const double g = 9.81, length = 0.5, slope = 0.6;  // m/s^2, m, rad
  std::mt19937_64 random(seed);
  const double start = length * (1 + 0.02 * (static_cast<double>(random() >> 11) * 0x1p-53 - 0.5));
  const double pull = g * (std::sin(slope) - values.at("mu_ramp") * std::cos(slope));
  const double speed = std::sqrt(2 * std::max(0.0, pull) * start);
  return {{"time_on_ramp", pull > 0 ? std::sqrt(2 * start / pull) : NAN, "s"},
          {"run_out", speed * speed / (2 * values.at("mu_flat") * g), "m"}};
}

int main() try {
  Problem problem;
  problem.name = "slide";
  problem.parameters = {{.name = "mu_ramp", .min = 0.02, .max = 0.5, .logarithmic = true},
                        {.name = "mu_flat", .min = 0.02, .max = 0.5, .logarithmic = true}};
  // Measured where mu_ramp was 0.1 and mu_flat 0.2.
  problem.targets = {{"time_on_ramp", 0.4598, 0.005, "s"}, {"run_out", 1.205, 0.03, "m"}};
  problem.runs = 60;

  const Result result = calibrate(problem, slide);
  std::printf("%s: %s\n", result.verdict.c_str(), result.headline.c_str());
  for (const Estimate& e : result.estimates)
    std::printf("%s = %.4f, 95 %% interval %.4f to %.4f\n", e.parameter.c_str(), e.best, e.low,
                e.high);
  std::printf("%d runs, %zu posterior samples\n", result.runs, result.weights.size());
  return result.verdict == "calibrated" ? 0 : 1;
} catch (const std::exception& e) {
  std::fprintf(stderr, "calibrate_simulator: %s\n", e.what());
  return 2;
}
