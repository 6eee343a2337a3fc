// A case whose results file has every object of the schema, in a few milliseconds of motion.
#pragma once

#include <atomic>
#include <string>

#include "experiments/case/case.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/run/run.h"

namespace firn::test {

inline constexpr const char* kFullCase = R"(
[case]
name = "full"
duration = "8 ms"
seed = 5
steps_per_loading = 6

[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "1 MPa"
[materials.plastic]
density = "1000 kg/m^3"
young_modulus = "2 MPa"
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
[shapes.pebble]
kind = "box"
size = "10 12 14 mm"
material = "ice"
rounding = "1 mm"

[[particles]]
shape = "cube"
position = "0 0 9.9 mm"
tag = 1
[[particles]]
shape = "cube"
position = "0 0 30.5 mm"
[[particles]]
shape = "pebble"
position = "0.14 0.2 0.05 m"
velocity = "8 0 0 m/s"

[[fills]]
shape = "pebble"
count = 2
region_min = "-60 -60 50 mm"
region_max = "-20 60 120 mm"
velocity = "0 0 -0.1 m/s"

[[inlets]]
name = "chute"
shape = "pebble"
position = "60 60 40 mm"
batches = 2
interval = "3 ms"
velocity = "0 0 -8 m/s"

[[motion_frames]]
name = "carriage"
motions = [{ kind = "translation", velocity = "1 0 0 mm/s" }]
[[motion_frames]]
name = "arm"
position = "0 0 0.5 m"
[motion_frames.free]
mass = "20 g"
center = "0 0 0.5 m"
inertia = "1e-5 1e-5 1e-5 kg m^2"
[[motion_frames.free.joints]]
kind = "translation"
direction = [0, 0, 1]
stiffness = "20000 N/m"
spring_reference = "1 mm"
[[motion_frames]]
name = "ball"
position = "0 0 0.8 m"
[motion_frames.free]
mass = "20 g"
center = "0 0.001 0.8 m"
inertia = "1e-5 1e-5 1e-5 kg m^2"
free_rotation = true
[[motion_frames.free.joints]]
kind = "translation"
direction = [1, 0, 0]
[[motion_frames.free.joints]]
kind = "translation"
direction = [0, 0, 1]

[[motion_frames]]
name = "hammer"
parent = "arm"
position = "0 0 0.6 m"
[motion_frames.free]
mass = "10 g"
center = "0 0.05 0.6 m"
inertia = "1e-5 1e-5 1e-5 kg m^2"
joints = [{ kind = "rotation", direction = [1, 0, 0], friction = "1e-9 N m" }]
[[motion_frames]]
name = "link"
position = "0 0 0.9 m"
[motion_frames.free]
mass = "5 g"
center = "0.02 0 0.9 m"
inertia = "1e-6 1e-6 1e-6 kg m^2"
[[motion_frames.free.joints]]
kind = "translation"
direction = [1, 0, 0]
[[motion_frames.free.joints]]
kind = "translation"
direction = [0, 0, 1]
[[motion_frames.free.joints]]
kind = "rotation"
direction = [0, 1, 0]
[[couplings]]
kind = "gear"
between = ["arm", "hammer"]
ratio = "100 rad/m"
[[couplings]]
kind = "ball"
between = ["world", "link"]
position = "0 0 0.9 m"
direction = [0, 1, 0]
friction_coefficient = 0.2
bearing_radius = "2 mm"

[[boundaries]]
name = "floor"
material = "plastic"
kind = "plane"
point = "0 0 0 m"
normal = [0, 0, 1]
[[boundaries]]
name = "panel"
material = "plastic"
kind = "box"
position = "20 0 20 mm"
size = "20 40 30 mm"
motion_frame = "carriage"
[[boundary_contacts]]
between = ["lever", "panel"]
stiffness = "1e5 N/m"
static_friction = 0.2
restitution = 0.5
[[boundaries]]
name = "lever"
material = "plastic"
kind = "box"
position = "0 0 0.5 m"
size = "20 20 20 mm"
motion_frame = "arm"
[[boundaries]]
name = "weight"
material = "plastic"
kind = "box"
position = "0 0 0.8 m"
size = "20 20 20 mm"
motion_frame = "ball"
[[boundaries]]
name = "cover"
material = "plastic"
kind = "box"
position = "0 0.3 0.3 m"
size = "20 20 20 mm"

[[limit_switches]]
name = "limit"
motion_frame = "arm"
closes_at = "0.2 mm"
hysteresis = "0.1 mm"

[[sensors]]
name = "low"
region_min = "-1 -1 -1 m"
region_max = "1 1 0.03 m"
[[sensors]]
name = "high"
point = "0 0 0.06 m"
normal = [0, 0, 1]
[[outlets]]
name = "side"
point = "0.15 0 0 m"
normal = [1, 0, 0]
[[outlets]]
name = "bottom"
point = "0 0 -0.5 m"
normal = [0, 0, -1]

[[stages]]
name = "settle"
max_duration = "4 ms"
[[stages]]
name = "hold"
remove_boundaries = ["cover"]
max_duration = "4 ms"
[[tag_rules]]
stage = "hold"
region_min = "-0.1 -0.1 0 m"
region_max = "0.1 0.1 0.1 m"
bins = 2
first = 7

[[bonds]]
name = "bridge"
pairs = [[0, 1]]
height_direction = [0, 1, 0]
width = "4 mm"
height = "4 mm"
length = "1 mm"
young_modulus = "1 MPa"
poisson_ratio = 0.3
tensile_strength = "0.7 MPa"
shear_strength = "0.7 MPa"

[[measure]]
kind = "load"
name = "press"
boundary = "floor"
stage = "hold"
[[measure]]
kind = "above"
name = "rest"
boundary = "floor"
stage = "hold"
[[measure]]
kind = "curve"
name = "way"
motion_frame = "arm"
x = "coordinate"
y = "force"
points = 5
[[measure]]
kind = "curve"
name = "jolt"
motion_frame = "arm"
x_period = "2 ms"
y = "acceleration"
points = 4
[[measure]]
kind = "curve"
name = "push"
boundary = "panel"
x = "displacement"
y = "force"
[[measure]]
kind = "accelerometer"
name = "arm"
motion_frame = "arm"
cfc = "100 Hz"
[[measure]]
kind = "rebound"
name = "drop"
[[measure]]
kind = "heap"
name = "pile"
region_min = "-0.1 -0.1 0 m"
region_max = "0.1 0.1 0.2 m"
peak = "0 m"
peak_margin = "5 mm"
end_margin = "5 mm"

[statistics]
compressive_loads = true
[statistics.events]
threshold = "0 N"
[statistics.boundary_maps]
boundaries = ["panel"]
edge = "20 mm"
interval = "2 ms"
specific_wear_rate = "1e-13 m^2/N"
[statistics.particle_maps]
edge = "20 mm"
[statistics.energy_spectrum]
lowest = "1e-9 J"

[output]
frame_interval = "0.5 ms"
state_interval = "3 ms"
[output.samples]
interval = "0.3 ms"
motion_frames = ["arm"]
boundaries = ["panel"]
)";

inline Case full_case() { return read_case_text(kFullCase, "full.toml", "."); }

// A finished run of it, measured.
inline void run_full_case(const std::string& results_file) {
  RunOptions options;
  options.results_file = results_file;
  run(full_case(), options);
}

// The same, interrupted half way: it can be resumed.
inline void run_half_of_full_case(const std::string& results_file) {
  std::atomic<bool> enough = false;
  RunOptions options;
  options.results_file = results_file;
  options.interrupt = &enough;
  options.checkpoint_every = 0;  // both slots
  options.each_step = [&](const Solver& solver, bool) { enough = solver.time() > 5e-3; };
  run(full_case(), options);
}

}  // namespace firn::test
