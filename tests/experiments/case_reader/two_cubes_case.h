// The text of a case with two cubes, variants of it, and the messages that its reader refuses them
// with.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/case_reader/read_case.h"
#include "tests/support/error_of.h"
#include "tests/support/replaced.h"

namespace firn::two_cubes {

// Line numbers matter below: the text starts with line 1.
inline const std::string kTwoCubes = R"([case]
name = "two cubes"
duration = "1 s"
seed = 7

[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "0.01 GPa"
poisson_ratio = 0.33

[materials.plastic]
young_modulus = "2 GPa"

[interactions.ice-ice]
static_friction = 0.2
dynamic_friction = 0.1
restitution = 0.3

[interactions.plastic-ice]
static_friction = 0.3
restitution = 0.3

[shapes.cube]
kind = "box"
size = "0.1 0.1 0.1 m"
material = "ice"
mass = "1 kg"
rounding = "0.1 mm"

[[particles]]
shape = "cube"
position = "0 0 0.2 m"
velocity = "0 0 -1 m/s"

[[particles]]
shape = "cube"
position = "0 0 40 cm"
orientation = [0.6, 0, 0.8, 0]
tag = 3

[[boundaries]]
name = "floor"
material = "plastic"
kind = "plane"
normal = [0, 0, 2]
rigid = true

[[boundaries]]
name = "lid"
material = "plastic"
kind = "box"
size = "1 1 0.1 m"
position = "0 0 1 m"

[[boundaries.motions]]
kind = "rotation"
axis = [0, 1, 0]
center = "0.5 0 1 m"
angular_velocity = "30 rpm"
stop = "0.5 s"

[[outlets]]
name = "side"
point = "1 0 0 m"
normal = [1, 0, 0]

[[stages]]
name = "settle"
end_when = "settled"
max_duration = "0.5 s"

[[stages]]
name = "open"
max_duration = "0.5 s"
remove_boundaries = ["lid"]

[[stages.motions]]
boundary = "floor"
kind = "translation"
velocity = "0 0 -1 m/s"

[output]
frame_interval = "1 ms"
)";

// The text with its first `from` replaced; a test that replaces nothing would prove nothing.
inline std::string with(const std::string& from, const std::string& to,
                        std::string text = kTwoCubes) {
  return test::replaced(std::move(text), from, to);
}

inline Case read(const std::string& text, const std::vector<Override>& overrides = {}) {
  return read_case_text(text, "c.toml", ".", overrides);
}

// Empty: the case is accepted.
inline std::string error_of(const std::string& text, const std::vector<Override>& overrides = {}) {
  return test::error_if_any([&] { read(text, overrides); });
}

inline std::string error_of_set(const std::string& override_text) {
  return error_of(kTwoCubes, {parse_override(override_text)});
}

}  // namespace firn::two_cubes
