// A case with everything that happens in a run: batches, stages, an outlet, a moving boundary,
// statistics.
#pragma once

#include "experiments/case/case.h"
#include "experiments/case_reader/read_case.h"

namespace firn {

// Two batches of cubes fall into a tray whose floor is taken away, and leave below it.
inline constexpr const char* kTray = R"(
[case]
name = "tray"
duration = "0.6 s"
seed = 3
steps_per_loading = 6

[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "0.5 MPa"
[materials.plastic]
young_modulus = "2 GPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.3
[interactions.ice-plastic]
static_friction = 0.3
restitution = 0.3

[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
rounding = "1 mm"

[[particles]]
shape = "cube"
position = "0 0 0.02 m"
orientation = [1, 0, 0, 0]
tag = 5

[[fills]]
shape = "cube"
count = 12
batch = 8
interval = "0.05 s"
region_min = "-0.08 -0.08 0.05 m"
region_max = "0.08 0.08 0.2 m"
velocity = "0 0 -0.3 m/s"

[[boundaries]]
name = "floor"
material = "plastic"
kind = "box"
position = "0 0 -0.05 m"
orientation = [1, 0, 0, 0]
size = "0.5 0.5 0.1 m"
[[boundaries]]
name = "lid"
material = "plastic"
kind = "box"
position = "0 0 0.5 m"
orientation = [1, 0, 0, 0]
size = "0.5 0.5 0.01 m"

[[outlets]]
name = "below"
point = "0 0 -0.2 m"
normal = [0, 0, -1]

[[stages]]
name = "settle"
end_when = "settled"
settle_energy = "2e-4 J"
settle_time = "0.02 s"
max_duration = "0.3 s"
[[stages]]
name = "drop"
remove_boundaries = ["floor"]
max_duration = "0.3 s"
[[stages.motions]]
boundary = "lid"
kind = "translation"
velocity = "0 0 0.1 m/s"
start = "0.05 s"
stop = "0.15 s"

[output]
frame_interval = "10 ms"

[statistics]
merge_gap = "0.1 ms"
compressive_loads = true
[statistics.events]
threshold = "0.05 N"
[statistics.boundary_maps]
boundaries = ["floor"]
edge = "0.1 m"
interval = "0.04 s"
specific_wear_rate = "1e-13 m^2/N"
[statistics.particle_maps]
edge = "10 mm"
[statistics.energy_spectrum]
lowest = "1e-9 J"
)";

inline Case tray(const std::vector<Override>& overrides = {}) {
  return read_case_text(kTray, "tray.toml", ".", overrides);
}

}  // namespace firn
