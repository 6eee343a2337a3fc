// Measurement files. What is accepted has a finite value and an uncertainty that is none below 0.
#include "experiments/measurements/measurement.h"

#include <cmath>

#include "tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace firn;
  fuzz::accepts([&] {
    const Measurement m =
        read_measurement_text(std::string(fuzz::text_of(data, size)), "measurement.toml");
    fuzz::require_one_line(m.sentence());
    for (const Criterion& c : m.criteria)
      fuzz::require(c.factor > 0 && c.observed_once_in >= 0, "a criterion is a relation");
    if (m.status == MeasurementStatus::qualitative) return;
    fuzz::require(std::isfinite(m.value), "a measured value is finite");
    fuzz::require(m.standard_uncertainty() >= 0 && std::isfinite(m.standard_uncertainty()),
                  "its uncertainty is finite and not below 0");
    fuzz::require(m.repeats >= 1, "it was measured at least once");
  });
  return 0;
}
