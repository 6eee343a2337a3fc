// Case files that the tests of the command line share.
#pragma once

namespace firn::cli {

// Two boxes fall onto a plane; 50 ms.
inline constexpr const char* two_boxes = R"([case]
name = "two boxes"
duration = "50 ms"

[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "1 MPa"
[materials.plastic]
young_modulus = "2 GPa"

[interactions.ice-ice]
static_friction = 0.1
dynamic_friction = 0.1
restitution = 0.3
[interactions.ice-plastic]
static_friction = 0.3
dynamic_friction = 0.3
restitution = 0.3

[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
rounding = "0.5 mm"

[[particles]]
shape = "cube"
position = "0 0 0.012 m"
[[particles]]
shape = "cube"
position = "0 0.005 0.035 m"

[[boundaries]]
name = "floor"
material = "plastic"
kind = "plane"
point = "0 0 0 m"
normal = [0, 0, 1]

[output]
frame_interval = "10 ms"
)";

// A small box of the drained angle of repose with a few blocks in it: a case that has responses.
inline constexpr const char* small_drain = R"([case]
name = "small drain"
duration = "2 s"
steps_per_loading = 6

[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "1 MPa"
[materials.plastic]
young_modulus = "2 GPa"

[interactions.ice-ice]
static_friction = 0.4
restitution = 0.3
[interactions.ice-plastic]
static_friction = 0.4
restitution = 0.3

[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
rounding = "1 mm"

[experiment]
kind = "drained_repose"
box = "320 60 200 mm"
door_width = "80 mm"
wall_material = "plastic"

[experiment.fill]
shape = "cube"
count = 30
pour_height = "0.4 m"
max_duration = "0.6 s"

[experiment.drain]
max_duration = "1 s"

[output]
frame_interval = "20 ms"
)";

}  // namespace firn::cli
