// A case as the user wrote it, read and checked once, in SI.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/text/toml_aliases.h"
#include "firn/solver.h"

namespace firn {

// A batch of particles dropped into a region with random positions and orientations.
struct Fill {
  std::string shape;
  int count = 0;
  int tag = 0;
  Vec3 region_min = Vec3::Zero();  // m, world: bodies are placed wholly inside this box
  Vec3 region_max = Vec3::Zero();
  double start = 0;              // s
  double interval = 0;           // s between batches; 0: all at once
  int batch = 0;                 // particles per batch; 0: all
  Vec3 velocity = Vec3::Zero();  // m/s at placement
  bool random_orientation = true;
  std::string stage;  // batches come while it is under way, times from its start; empty: always
  bool tag_batches = false;  // the n-th batch carries tag + n
};

// Batches of bodies at given places, on a schedule: cubes in the cavities of a mold.
struct Inlet {
  std::string name, shape;
  std::vector<Vec3> positions;  // m, centres of mass, world; one body each in every batch
  Quat orientation = Quat::Identity();
  Vec3 velocity = Vec3::Zero(), scatter = Vec3::Zero();  // m/s; m, half widths
  double turn = 0;                                       // rad, half width about turn_axis
  Vec3 turn_axis = Vec3::UnitZ();
  bool random_orientation = false;
  int tag = 0;
  bool tag_batches = false;
  double start = 0, interval = 0;  // s
  int batches = 1;                 // at most
  std::string stage;               // as for fills
};

// A region of space: a box, or the half-space that `normal` points into.
struct Sensor {
  std::string name;
  bool is_box = false;
  Vec3 region_min = Vec3::Zero(), region_max = Vec3::Zero();  // m
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ();

  bool holds(const Vec3& p) const {
    if (is_box) return (p - region_min).minCoeff() >= 0 && (region_max - p).minCoeff() >= 0;
    return (p - point).dot(normal) > 0;
  }
};

// Gives particles in a region a tag by where they are when a stage begins.
struct TagRule {
  std::string stage;
  int first = 1;                                              // tag of the first column
  int columns = 1;                                            // of equal width
  int axis = 0;                                               // 0 x, 1 y, 2 z
  Vec3 region_min = Vec3::Zero(), region_max = Vec3::Zero();  // m
};

// Closes when a free frame's coordinate has been at or above `closes_at` for the hold time without
// being driven, and opens below `opens_at`.
struct LimitSwitch {
  std::string name;
  int frame = 0, axis = 0;
  double closes_at = 0, opens_at = 0;  // m or rad
  double hold = 0;                     // s
};

// Particles whose centre of mass enters this half-space leave the simulation and are counted.
struct Outlet {
  std::string name;
  Vec3 point = Vec3::Zero();     // m
  Vec3 normal = Vec3(0, 0, -1);  // unit, pointing out
};

// A part of the run, ended by an event. On entry, boundaries are removed and motions started.
struct Stage {
  enum class Until { time, at_rest, empty, switched, passed, stalled, force, torque, filled };
  std::string name;
  std::vector<Until> until;  // the first of them ends the stage; none: time
  double max_duration = 0;   // s; a stage that has not ended by then ends anyway
  double min_duration = 0;   // s, before which it does not end
  // Empty: all particles were inserted and have left through an outlet.
  // At rest: every particle inside slower than this and none left, for the hold time.
  double settle_energy = 0;  // J, mean per present particle
  double settle_time = 0;    // s
  int closed_switch = 0;     // switched: this one is closed
  // passed: so many particles, or so much mass, have been in a sensor since the stage began.
  int sensor = 0;
  int count = 0;    // 0: by mass
  double mass = 0;  // kg
  // stalled: a free frame's axis is driven, and has come less than a tenth of its way.
  int stall_frame = 0, stall_axis = 0;
  double stall_hold = 0;  // s
  // force, torque: of all contacts on a frame, about its origin, whatever their direction.
  int force_frame = 0;
  double force = 0, force_hold = 0;  // N, s
  int torque_frame = 0;
  double torque = 0, torque_hold = 0;  // N m, s
  // filled: so many particles lie (centres, slower than 0.1 m/s) at a height or above it, for the
  // hold time; against gravity from the world's origin.
  double fill_height = 0;  // m
  int fill_count = 0;
  double fill_hold = 0;             // s
  std::vector<std::string> remove;  // boundaries
  // On entry, times relative to the stage. Some end with it.
  struct StartedMotion {
    int boundary = -1, frame = -1;  // one of the two
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

  bool ends_on(Until event) const {
    return std::find(until.begin(), until.end(), event) != until.end();
  }
};

// Parameters of the drained angle of repose experiment, as its responses need them again.
struct DrainedRepose {
  Vec3 box = Vec3::Zero();     // m, inner length (x), depth (y), height (z)
  double door_width = 0;       // m, in the middle of the floor, full depth
  double floor_thickness = 0;  // m
  double end_margin = 0;       // m: fit window starts this far from the end wall
  double door_margin = 0;      // m: and ends this far from the door's lip
  std::string door = "door";   // names of the boundaries that make it
  double drop_height = 0;      // m below the floor where drained particles leave
};

// A measurement that the case requests in addition to the responses of every case.
struct Measure {
  enum class Kind { slip, slide, rebound, heap, accelerometer, drum, curve, load };
  Kind kind = Kind::slip;
  std::string name;        // stands before the names of its responses; may be empty
  std::optional<int> tag;  // only particles that carry it; none: all
  // slip, slide: motion along the x, y plane of a boundary's own axes.
  std::string boundary;
  double slip = 0;          // m: a body that has moved so far has lost its hold
  double run = 0;           // m: until it has moved so far it may still tip
  double tip_turn = 0;      // rad: one that has turned so far against the boundary tips
  double from = 0, to = 0;  // m, marks of a slide
  // heap: inside of a bin, its floor at region_min.z, poured into at `peak`.
  Vec3 region_min = Vec3::Zero(), region_max = Vec3::Zero();  // m
  double peak = 0;                                            // m, world x
  double peak_margin = 0, end_margin = 0;                     // m: the fit window leaves them out
  // accelerometer: on a free motion frame.
  int frame = 0, axis = 0;
  double cfc = 0;  // Hz, channel frequency class
  // drum: turns about the horizontal axis `axis` (0 x, 1 y) of the world, steadily from `begin` on.
  double begin = 0;  // s
  // curve: one quantity of a boundary (or of a motion frame and its axis, when there is none) over
  // another, filtered by `cfc` unless that is 0.
  std::string x, y;
  int points = 0;
  // load: force of contacts on a boundary (or on a motion frame, when there is none) along a
  // direction of the world (0: its magnitude), during one stage (empty: all the time).
  // load, curve: `contact` is a boundary contact and `coupling` a coupling, in place of both; -1:
  // none.
  int contact = -1, coupling = -1;
  Vec3 direction = Vec3::Zero();  // unit
  std::string stage;
};

// m: middle edge of the bounding box, the particle size of responses of heaps.
inline double middle_edge(const Shape& shape) {
  Vec3 edges = shape.box;
  std::sort(edges.data(), edges.data() + 3);
  return edges[1];
}

// What a material record brought into a case.
struct AppliedMaterial {
  std::string record;     // "ice-plastic@2"
  std::string selection;  // "sample 3", "reference set \"answer\""; empty: its values as they stand
  std::string sha256;     // of the record
  std::vector<std::string> sets;    // case keys
  std::vector<std::string> kept;    // keys of it for which the case, or --set, says otherwise
  std::vector<std::string> unused;  // keys about materials that the case does not have
  // Of a calibrated record: the contact model that it was calibrated with.
  std::optional<int> contact_model;
};

// Records that the command line names, "NAME[@VERSION][#SAMPLE]", and where records are.
struct MaterialRequest {
  std::vector<std::string> records;
  std::string database;  // empty: as material_database_file() says
};

struct Case {
  std::string name;
  std::string source;   // file it was read from, for messages
  double duration = 0;  // s, latest end
  std::uint64_t seed = 1;
  double steps_per_loading = 10;  // for timestep = "auto"
  bool automatic_timestep = true;
  std::string timestep_reason;  // printed with the time step
  bool allow_unstable_timestep = false;
  double steps_taken = 0;  // in the shortest quarter period; 0: nothing swings
  Model model;             // complete but for particles of fills: they are appended in order
  // [[particles]]: placed at the start, ids first.
  struct Placed {
    int particle = 0;  // id
    Vec3 position, velocity, angular_velocity;
    Quat orientation;        // shape axes -> world
    double insert_time = 0;  // s; before 0 for those of an earlier run
    int batch = -1;          // of its fill or inlet in that run
  };
  std::vector<Placed> placed;            // those of [initial_state] before those of [[particles]]
  std::vector<FrameStart> frame_starts;  // of [initial_state], parents first
  std::string start;                     // source of [initial_state], in words; empty: none
  std::vector<Fill> fills;
  std::vector<Inlet> inlets;                            // their particles follow those of the fills
  std::vector<std::pair<int, int>> allow_overlap_with;  // boundaries that may overlap each other
  // For messages, "FILE:LINE: KEY": of the boundaries that the case names, and of placed particles.
  std::vector<std::string> boundary_places, particle_places;
  std::vector<Sensor> sensors;
  std::vector<TagRule> tag_rules;
  std::vector<LimitSwitch> limit_switches;
  std::vector<Outlet> outlets;
  std::vector<Stage> stages;  // empty: one stage until `duration`
  std::optional<DrainedRepose> drained_repose;
  std::vector<Measure> measures;
  double wear_rate = 0;       // 1/Pa, of boundaries: Archard's k / H; 0: not asked for
  double frame_interval = 0;  // s
  double state_interval = 0;  // s; 0: no states are kept in the results file
  std::vector<AppliedMaterial> material_records;
  std::string resolved;  // TOML text of the whole case, defaults filled in, mesh files embedded
                         // by content hash and path made absolute; read_case_text() of it
                         // gives the same case
};

using Override = std::pair<std::string, std::string>;  // TOML path, TOML value text

// Reads, checks and completes a case. Throws InputError with one line
// `FILE:LINE: KEY: what is wrong; what is expected`.
Case read_case(const std::string& file, const std::vector<Override>& overrides = {},
               const MaterialRequest& materials = {});
// The same from text; `source` names it in messages, `directory` is where mesh files lie.
Case read_case_text(const std::string& text, const std::string& source,
                    const std::string& directory, const std::vector<Override>& overrides = {},
                    const MaterialRequest& materials = {}, OldNames old_names = OldNames::warn);

// Parses "KEY=VALUE" of --set. Throws InputError.
Override parse_override(const std::string& text);

// The number of time steps nearest to a time, s; 0 for one before the start.
std::uint64_t to_steps(const Case& c, double seconds);

// The text of which hashes of a case and keys of its runs are made: a resolved case in which each
// renamed key has its first name, so that a rename changes none of them.
std::string case_identity(const std::string& resolved);

// SHA-256 of case_identity() in hexadecimal: equal for equal cases, seed and mesh files included.
std::string case_hash(const Case& c);

}  // namespace firn
