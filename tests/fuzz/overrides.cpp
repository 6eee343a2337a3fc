// --set: every line of the input is one KEY=VALUE over a fixed case.
#include <sstream>

#include "experiments/case/case.h"
#include "experiments/case_reader/read_case.h"
#include "tests/fuzz/case_promises.h"

namespace {

constexpr const char* kCase = R"([case]
name = "c"
duration = "1 s"
[materials.ice]
density = "900 kg/m^3"
young_modulus = "1 MPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.5
[shapes.cube]
kind = "box"
size = "1 1 1 m"
material = "ice"
[[particles]]
shape = "cube"
position = "0 0 1 m"
[[boundaries]]
name = "floor"
material = "ice"
kind = "plane"
point = "0 0 0 m"
normal = [0, 0, 1]
[[stages]]
name = "fall"
end_when = "settled"
max_duration = "1 s"
)";

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace firn;
  static const fuzz::CaseFolder folder;
  fuzz::accepts([&] {
    std::istringstream lines{std::string(fuzz::text_of(data, size))};
    std::vector<Override> overrides;
    for (std::string line; std::getline(lines, line, '\n');) {
      overrides.push_back(parse_override(line));
    }
    fuzz::require_round_trip(read_case_text(kCase, "case.toml", folder.path("."), overrides),
                             folder);
  });
  return 0;
}
