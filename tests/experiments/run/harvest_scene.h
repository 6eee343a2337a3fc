// The text of a scene with frames, inlets, limit switches and sensors, for tests.
#pragma once

#include <string>
#include <vector>

#include "experiments/case_reader/read_case.h"
#include "tests/support/error_of.h"

namespace firn::harvest_scene {

inline constexpr const char* kMaterials = R"(
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "2 MPa"
[materials.plastic]
young_modulus = "2 GPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.2
[interactions.ice-plastic]
static_friction = 0.1
restitution = 0.2
[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
rounding = "1 mm"
)";

// A shaft 22 mm wide.
inline constexpr const char* kWalls = R"(
[[boundaries]]
name = "left"
kind = "plane"
material = "plastic"
point = "-11 0 0 mm"
normal = [1, 0, 0]
[[boundaries]]
name = "right"
kind = "plane"
material = "plastic"
point = "11 0 0 mm"
normal = [-1, 0, 0]
[[boundaries]]
name = "front"
kind = "plane"
material = "plastic"
point = "0 -11 0 mm"
normal = [0, 1, 0]
[[boundaries]]
name = "back"
kind = "plane"
material = "plastic"
point = "0 11 0 mm"
normal = [0, -1, 0]
)";

// An icemaker in small. A cube comes into a shaft every 0.3 s while a plate is held up; then the
// plate is let go and rests on the column. Held high enough by it, it closes a limit switch; the
// floor vanishes, and the cubes fall through a sensor.
inline const std::string kHarvest = std::string(R"(
[case]
duration = "5 s"
steps_per_loading = 6

[[motion_frames]]
name = "lift"
[[motion_frames]]
name = "plate"
parent = "lift"
position = "0 0 30 mm"
[motion_frames.free]
mass = "20 g"
[[motion_frames.free.joints]]
kind = "translation"
direction = [0, 0, 1]
lower = "0 mm"
upper = "100 mm"

[[boundaries]]
name = "plate"
kind = "box"
material = "plastic"
size = "20 20 10 mm"
position = "0 0 35 mm"
motion_frame = "plate"
[[boundaries]]
name = "floor"
kind = "box"
material = "plastic"
size = "100 100 20 mm"
position = "0 0 -10 mm"
[[inlets]]
name = "mold"
shape = "cube"
position = "0 0 72 mm"
interval = "0.3 s"
start = "0.1 s"
batches = 20
stage = "harvest"
tag = 10
tag_mode = "batch"

[[limit_switches]]
name = "full"
motion_frame = "plate"
closes_at = "25 mm"
hysteresis = "5 mm"
hold_time = "120 ms"

[[sensors]]
name = "below"
point = "0 0 -30 mm"
normal = [0, 0, -1]

[[outlets]]
name = "bottom"
point = "0 0 -200 mm"
normal = [0, 0, -1]

[[tag_rules]]
stage = "drop"
axis = "z"
bins = 4
first = 1
region_min = "-20 -20 0 mm"
region_max = "20 20 80 mm"

[[stages]]
name = "harvest"
end_when = "switch"
switch = "full"
max_duration = "4 s"
[[stages.motors]]
motion_frame = "plate"
speed = "1 m/s"
target = "80 mm"
stop = "0.15 s"
period = "0.3 s"
[[stages]]
name = "drop"
end_when = ["passed", "settled"]
sensor = "below"
count = 3
min_duration = "0.01 s"
max_duration = "1 s"
remove_boundaries = ["floor"]
)") + kWalls;

inline Case read(const std::string& text, const std::vector<Override>& overrides = {}) {
  return read_case_text(std::string(text) + kMaterials, "scene.toml", ".", overrides);
}

// Empty: the scene is accepted.
inline std::string scene_error(const std::string& text,
                               const std::vector<Override>& overrides = {}) {
  return test::error_if_any([&] { read(text, overrides); });
}

}  // namespace firn::harvest_scene
