// Quantities with units. What is accepted is finite, and its text in SI reads back to the same
// bits.
#include "experiments/units.h"

#include <cmath>

#include "tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace firn;
  const std::string_view text = fuzz::text_of(data, size);
  fuzz::accepts([&] { parse_unit(text); });
  for (const Dimension& d :
       {dimension::none, dimension::length, dimension::time, dimension::angle,
        dimension::angular_velocity, dimension::density, dimension::pressure}) {
    fuzz::accepts([&] {
      const double value = parse_quantity(text, d);
      fuzz::require(std::isfinite(value), "a quantity is finite");
      const double again = parse_quantity(si_text(value, d), d);
      fuzz::require(again == value && std::signbit(again) == std::signbit(value),
                    "SI text reads back: " + si_text(value, d));
    });
    fuzz::accepts([&] { fuzz::require(parse_vector(text, d).allFinite(), "a vector is finite"); });
  }
  return 0;
}
