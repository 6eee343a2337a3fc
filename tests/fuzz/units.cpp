// Quantities with units, each read as what its unit says it is and as something else. What is
// accepted is finite, and its text in SI reads back to the same bits.
#include "experiments/text/units.h"

#include <cmath>
#include <cstdlib>

#include "tests/fuzz/fuzz_target.h"

namespace {

using namespace firn;

void read(std::string_view text, const Dimension& d) {
  fuzz::accepts([&] {
    const double value = parse_quantity(text, d);
    fuzz::require(std::isfinite(value), "a quantity is finite");
    const double again = parse_quantity(si_text(value, d), d);
    if (again != value || std::signbit(again) != std::signbit(value))
      fuzz::broken("SI text reads back: " + si_text(value, d));
  });
  fuzz::accepts([&] { fuzz::require(parse_vector(text, d).allFinite(), "a vector is finite"); });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = fuzz::text_of(data, size);
  const std::size_t unit = text.find_first_not_of("+-.0123456789eE ");
  Dimension d = dimension::length;
  const bool readable = fuzz::accepts([&] {
    const Dimension found = parse_unit(unit == text.npos ? text : text.substr(unit)).dimension;
    constexpr int kMost = 20;  // products of powers have more, and no text
    for (const int e : {found.length, found.mass, found.time, found.angle, found.temperature})
      if (std::abs(e) > kMost) return;
    d = found;
  });
  read(text, d);
  if (readable) read(text, dimension::none);
  return 0;
}
