// A case as plain data in SI units, read from TOML and checked.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "firn/solver.h"

namespace firn {

// Particles inserted in batches at random positions in a box ([[fills]]).
struct Fill {
  std::string shape;
  int count = 0;
  int tag = 0;
  Vec3 region_min = Vec3::Zero();  // m, world: particles are wholly inside this box
  Vec3 region_max = Vec3::Zero();
  double start = 0;              // s
  double interval = 0;           // s between batches; 0: all at once
  int batch = 0;                 // particles per batch; 0: all
  Vec3 velocity = Vec3::Zero();  // m/s, initial
  bool random_orientation = true;
  std::string stage;          // inserted in it only, `start` counts from its begin; empty: always
  bool tag_by_batch = false;  // the n-th batch has the tag `tag` + n, n from 0
};

// Particles inserted in batches at given positions ([[inlets]]): cubes in the cavities of a mold.
struct Inlet {
  std::string name;
  // Particles at each place, as their shapes are drawn in common axes: one, or pieces of one body.
  struct Piece {
    std::string shape;
    Vec3 offset = Vec3::Zero();  // m, shape axes, center of mass from that of all pieces
  };
  std::vector<Piece> pieces;
  std::vector<Vec3> positions;  // m, places: centers of mass of all pieces, world
  Quat orientation = Quat::Identity();
  Vec3 velocity = Vec3::Zero();               // m/s, initial
  Vec3 position_jitter = Vec3::Zero();        // m, half-widths of a uniform distribution
  double rotation_jitter = 0;                 // rad, half-width, about rotation_jitter_axis
  Vec3 rotation_jitter_axis = Vec3::UnitZ();  // unit, world
  bool random_orientation = false;
  int tag = 0;
  bool tag_by_batch = false;
  double start = 0, interval = 0;  // s
  int batches = 1;                 // at most
  std::string stage;               // as of a fill

  std::size_t batch_size() const { return positions.size() * pieces.size(); }  // particles
};

// A region of space in which particles are counted: a box, or the half-space into which `normal`
// points ([[sensors]]).
struct Sensor {
  std::string name;
  bool is_box = false;
  Vec3 region_min = Vec3::Zero(), region_max = Vec3::Zero();  // m
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ();

  bool contains(const Vec3& p) const {
    if (is_box) return (p - region_min).minCoeff() >= 0 && (region_max - p).minCoeff() >= 0;
    return (p - point).dot(normal) > 0;
  }
};

// Sets the tags of the particles in a box by position at the begin of a stage ([[tag_rules]]).
struct TagRule {
  std::string stage;
  int first = 1;                                              // tag in the first bin
  int bins = 1;                                               // of equal width along `axis`
  int axis = 0;                                               // 0 x, 1 y, 2 z
  Vec3 region_min = Vec3::Zero(), region_max = Vec3::Zero();  // m
};

// A switch at a joint of a free body. It closes when the joint coordinate has been at or above
// `closes_at` for the time `hold` while no motor drives the joint. It opens below `opens_at`.
struct LimitSwitch {
  std::string name;
  int frame = 0, axis = 0;
  double closes_at = 0, opens_at = 0;  // m or rad
  double hold = 0;                     // s
};

// Particles with their center of mass in this half-space are removed ([[outlets]]).
struct Outlet {
  std::string name;
  Vec3 point = Vec3::Zero();     // m
  Vec3 normal = Vec3(0, 0, -1);  // unit, into the half-space
};

// A part of the run that ends with an event ([[stages]]). On entry, boundaries are removed, and
// motions and motors start.
struct Stage {
  enum class EndEvent { time, settled, empty, switched, passed, stalled, force, torque, filled };
  std::string name;
  std::vector<EndEvent> end_when;  // the first event that occurs ends the stage; empty: time
  double max_duration = 0;         // s, after which the stage ends in any case
  double min_duration = 0;         // s, before which no event ends the stage
  // empty: all particles were inserted and have left through an outlet.
  // settled: mean kinetic energy below `settle_energy`, all particles inserted, and none removed,
  // for the time `settle_time`.
  double settle_energy = 0;  // J per particle in the simulation
  double settle_time = 0;    // s
  int closed_switch = 0;     // switched: index of the limit switch that closes
  // passed: this number or mass of particles has been in a sensor since the stage began.
  int sensor = 0;
  int count = 0;    // 0: by mass
  double mass = 0;  // kg
  // stalled: within `stall_hold`, a motor has moved its joint by less than a tenth of the distance
  // at the speed of the motor.
  int stall_frame = 0, stall_axis = 0;
  double stall_hold = 0;  // s
  // force, torque: magnitude of the sum over all contacts on a motion frame, about its origin.
  int force_frame = 0;
  double force = 0, force_hold = 0;  // N, s
  int torque_frame = 0;
  double torque = 0, torque_hold = 0;  // N m, s
  // filled: `fill_count` particles slower than 0.1 m/s have their center at or above `fill_height`,
  // for the time `fill_hold`. Heights count against gravity from the origin of the world.
  double fill_height = 0;  // m
  int fill_count = 0;
  double fill_hold = 0;             // s
  std::vector<std::string> remove;  // names of boundaries
  // Started on entry; times count from the begin of the stage.
  struct StartedMotion {
    int boundary = -1, frame = -1;  // index of one of the two; -1: the other
    Motion motion;
    bool ends_with_stage = false;
  };
  struct StageMotor {
    int frame = 0, axis = 0;
    Motor motor;
    bool ends_with_stage = true;
  };
  std::vector<StartedMotion> motions;
  std::vector<StageMotor> motors;

  bool ends_on(EndEvent event) const {
    return std::find(end_when.begin(), end_when.end(), event) != end_when.end();
  }
};

// Parameters of the experiment "drained_repose" that its responses need.
struct DrainedRepose {
  Vec3 box = Vec3::Zero();     // m, inner length (x), depth (y), height (z)
  double door_width = 0;       // m, in the middle of the floor, full depth
  double floor_thickness = 0;  // m
  double end_margin = 0;       // m, distance of the fit window from the end wall
  double door_margin = 0;      // m, distance of the fit window from the lip of the opening
  std::string door = "door";   // name of the boundary
  double drop_height = 0;      // m, depth below the floor at which particles are removed
};

// A measurement that the case requests in addition to the default responses ([[measure]]).
struct Measure {
  enum class Kind { slip, slide, rebound, heap, accelerometer, drum, curve, load, above };
  Kind kind = Kind::slip;
  std::string name;        // may be empty
  std::optional<int> tag;  // only particles with this tag; none: all
  // slip, slide: motion in the x, y plane of the axes of a boundary.
  std::string boundary;
  double slip = 0;          // m, displacement at which a body counts as sliding
  double run = 0;           // m, displacement up to which a sliding body can still tip over
  double tip_angle = 0;     // rad, rotation relative to the boundary at which a body tips over
  double from = 0, to = 0;  // slide: m, marks between which the time is measured
  // heap: inner box of a bin with its floor at region_min.z, filled from above at x = `peak`.
  Vec3 region_min = Vec3::Zero(), region_max = Vec3::Zero();  // m
  double peak = 0;                                            // m, world x
  double peak_margin = 0, end_margin = 0;                     // m, excluded from the fit window
  // accelerometer: on a free motion frame.
  int frame = 0, axis = 0;
  double cfc = 0;  // Hz, channel frequency class
  // drum: rotates about the horizontal axis `axis` (0 x, 1 y) of the world, steadily from `begin`
  // on.
  double begin = 0;  // s
  // curve: quantity `y` over `x` of the boundary, or of the motion frame and its joint if
  // `boundary` is empty. Filtered with the channel frequency class `cfc`; 0: unfiltered.
  std::string x, y;
  int points = 0;
  // Folded: the remainder of x after division by this period; m, rad or s. 0: not folded.
  double x_period = 0;
  // load: contact force on the boundary, or on the motion frame if `boundary` is empty, along
  // `direction` (0: the magnitude), during `stage` (empty: the whole run).
  // above: particles on the boundary in the last frame of `stage` or of the run.
  // load, curve: index of a boundary contact or of a coupling, which replaces boundary and frame;
  // -1: none.
  int contact = -1, coupling = -1;
  Vec3 direction = Vec3::Zero();  // unit, world
  std::string stage;

  // Prefix of the names of its responses: "tilt_"; empty without a name.
  std::string prefix() const { return name.empty() ? "" : name + "_"; }
};

// What is recorded more often than frames ([output.samples]).
struct SampledParts {
  double interval = 0;                  // s; 0: nothing is sampled
  std::vector<int> boundaries, frames;  // indices in the model, each once
  int stage = -1;                       // index into the stages that begins them; -1: the run
};

// Middle one of the three edges of the bounding box, m: the particle size in responses of heaps.
inline double middle_edge(const Shape& shape) {
  Vec3 edges = shape.box;
  std::sort(edges.data(), edges.data() + 3);
  return edges[1];
}

// A material record that a case uses, and its effect.
struct AppliedMaterial {
  std::string record;     // "ice-plastic@2"
  std::string selection;  // "sample 3", "reference set \"answer\""; empty: the point values
  std::string sha256;     // of the record
  std::vector<std::string> applied_keys;     // case keys that have the value of the record
  std::vector<std::string> overridden_keys;  // of the record; the case or --set takes precedence
  std::vector<std::string> unmatched_keys;   // of the record, for materials that the case lacks
  // Contact model with which a calibrated record was calibrated.
  std::optional<int> contact_model;
};

// Material records that the command line names, and their database.
struct MaterialRequest {
  std::vector<std::string> records;  // "NAME[@VERSION][#SAMPLE]"
  std::string database;              // file; empty: material_database_file()
};

// An error in one of MaterialRequest::records: an unknown one, or one that the case does not take.
struct MaterialRequestError : InputError {
  MaterialRequestError(std::string of, const std::string& message)
      : InputError(message), record(std::move(of)) {}

  std::string record;  // as requested
};

struct Case {
  std::string name;
  std::string source;   // name of the file in messages
  double duration = 0;  // s, latest end
  std::uint64_t seed = 1;
  double steps_per_loading = 10;  // time steps in a loading half-contact, for timestep = "auto"
  bool automatic_timestep = true;
  std::string timestep_reason;  // why the time step has its value, for messages
  bool allow_unstable_timestep = false;
  double steps_taken = 0;  // time steps in the shortest quarter period of the model; 0: none
  Model model;             // all particles: [[particles]] first, then those of fills and inlets
  // A particle with a given initial state; its ids come first.
  struct InitialParticle {
    int particle = 0;  // id
    Vec3 position = Vec3::Zero(), velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();
    Quat orientation = Quat::Identity();  // shape axes -> world
    double insert_time = 0;               // s; below 0: inserted in an earlier run
    int batch = -1;                       // of its fill or inlet in that run; -1: none
  };
  std::vector<InitialParticle> placed;  // [initial_state], then [[particles]]
  // A bond of [[bonds]] of an earlier run that held there.
  struct InitialBond {
    std::string name;   // of the table
    Bond bond;          // between particles of this case; without law
    double length = 0;  // m, of its beam
  };
  std::vector<InitialBond> initial_bonds;  // of [initial_state]
  std::vector<FrameStart> frame_starts;    // of [initial_state], parents first
  std::string start;                       // description of [initial_state]; empty: none
  std::vector<Fill> fills;
  std::vector<Inlet> inlets;                            // particle ids after those of the fills
  std::vector<std::pair<int, int>> allow_overlap_with;  // pairs of boundaries
  // Positions in the case file for messages, "FILE:LINE: KEY": [boundaries], [placed], [fills] but
  // that of an experiment, and [inlets].
  std::vector<std::string> boundary_places, particle_places, fill_places, inlet_places;
  std::vector<Sensor> sensors;
  std::vector<TagRule> tag_rules;
  std::vector<LimitSwitch> limit_switches;
  std::vector<Outlet> outlets;
  std::vector<Stage> stages;  // empty: one stage until `duration`
  std::optional<DrainedRepose> drained_repose;
  std::vector<Measure> measures;
  int statistics_stage = -1;  // index into `stages`: statistics begin with it; -1: with the run
  double wear_rate = 0;  // 1/Pa, wear coefficient over hardness (Archard) of boundaries; 0: no wear
  double frame_interval = 0;  // s
  SampledParts samples;
  double state_interval = 0;  // s; 0: the results file has no states
  std::vector<AppliedMaterial> material_records;
  // Complete TOML text with all defaults. Paths are absolute, and content hashes identify mesh
  // files. read_case_text() of it gives the same case.
  std::string resolved;
  std::string identity;  // case_identity(resolved)
};

using Override = std::pair<std::string, std::string>;  // TOML path, TOML value text

}  // namespace firn
