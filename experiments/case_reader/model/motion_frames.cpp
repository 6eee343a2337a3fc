#include "experiments/case_reader/model/motion_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "experiments/case_reader/model/motion_csv.h"
#include "experiments/text/toml_names.h"
#include "firn/mesh.h"
#include "firn/mesh_conflicts.h"

namespace firn {
namespace {

// Faster than anything in a machine: a slip of the keyboard, or a jump in a table.
constexpr double kFastest = 20, kFastestTurn = 1000;  // m/s, rad/s
// A table of at least so many rows that leaves out so many of its usual intervals has a gap.
constexpr std::size_t kRowsOfASeries = 20;
constexpr double kGap = 20;

constexpr Dimension kDamping{0, 1, -1, 0};         // N s/m
constexpr Dimension kTurnStiffness{2, 1, -2, -1};  // N m/rad
constexpr Dimension kTurnDamping{2, 1, -1, -1};    // N m s/rad

// Of what moves along an axis, or turns about it.
struct AxisUnits {
  Dimension position, rate, load, stiffness, damping;
  const char* zero_position;
  const char* zero_load;
  const char* no_stiffness;
  const char* no_damping;
};
const AxisUnits& units_of(bool turns) {
  static const AxisUnits along{dimension::length,
                               dimension::velocity,
                               dimension::force,
                               dimension::stiffness,
                               kDamping,
                               "0 m",
                               "0 N",
                               "0 N/m",
                               "0 N s/m"};
  static const AxisUnits about{dimension::angle,  dimension::angular_velocity,
                               dimension::torque, kTurnStiffness,
                               kTurnDamping,      "0 rad",
                               "0 N m",           "0 N m/rad",
                               "0 N m s/rad"};
  return turns ? about : along;
}

void read_schedule(const TomlTable& t, Schedule& s) {
  s.start = t.quantity("start", dimension::time, Sign::non_negative, "0 s");
  s.stop = t.optional_quantity("stop", dimension::time, Sign::positive).value_or(kUnbounded);
  if (s.stop <= s.start) {
    t.fail("stop", fmt::format("is {} s, not after the start at {} s; expected a later time",
                               s.stop, s.start));
  }
  s.period = t.optional_quantity("period", dimension::time, Sign::positive).value_or(0);
  if (s.period > 0 && !(s.stop - s.start <= s.period)) {
    t.fail("period", fmt::format("is {} s, shorter than what is repeated, from start to stop; "
                                 "expected at least that",
                                 s.period));
  }
}

struct TableFault {
  std::size_t row = 0;
  const char* key = "times";  // or "positions"
  std::string what;
};

// Jumps, gaps, times that do not ascend from 0.
std::optional<TableFault> fault_of(const Motion& m) {
  const bool turns = m.kind == Motion::Kind::rotation;
  if (m.times.size() != m.positions.size() || m.times.size() < 2)
    return TableFault{0, "positions",
                      fmt::format("has {} values for {} times; expected as many, at least two",
                                  m.positions.size(), m.times.size())};
  if (m.times.front() != 0)
    return TableFault{
        0, "times",
        fmt::format("begin at {} s; expected 0, the start of the motion", m.times.front())};
  std::vector<double> intervals;
  for (std::size_t i = 1; i < m.times.size(); ++i) {
    const double interval = m.times[i] - m.times[i - 1];
    if (!(interval > 0))
      return TableFault{i, "times",
                        fmt::format("go from {} s to {} s; expected each later than the one before",
                                    m.times[i - 1], m.times[i])};
    intervals.push_back(interval);
    const double rate = std::abs(m.positions[i] - m.positions[i - 1]) / interval;
    const double fastest = turns ? kFastestTurn : kFastest;
    if (rate > fastest)
      return TableFault{i, "positions",
                        fmt::format("jump from {} to {} {} within {} s; expected at most {} {}",
                                    m.positions[i - 1], m.positions[i], turns ? "rad" : "m",
                                    interval, fastest, turns ? "rad/s" : "m/s")};
  }
  if (m.times.size() < kRowsOfASeries) return std::nullopt;
  std::vector<double> sorted = intervals;
  std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2));
  const double usual = sorted[sorted.size() / 2];
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    if (intervals[i] > kGap * usual)
      return TableFault{i + 1, "times",
                        fmt::format("have a gap from {} s to {} s, where others are {} s apart; "
                                    "expected a value in between",
                                    m.times[i], m.times[i + 1], usual)};
  }
  return std::nullopt;
}

toml::array texts_of(const std::vector<double>& values, const Dimension& dimension) {
  toml::array texts;
  for (const double value : values) texts.push_back(si_text(value, dimension));
  return texts;
}

// Written out as `times` and `positions`, so that the resolved case needs the file no more.
void take_csv(const TomlTable& t, const Dimension& position, Motion m) {
  const std::string file =
      std::filesystem::absolute(std::filesystem::path(t.document().directory()) / t.string("file"))
          .lexically_normal()
          .string();
  const std::string time_column = t.string("time_column", "time"),
                    position_column_name = t.string("position_column", "way");
  std::error_code unreadable;  // as a name that is too long
  if (!std::filesystem::is_regular_file(file, unreadable))
    t.fail("file", fmt::format("\"{}\" is not a file; expected a CSV file", file));
  const MotionCsv table = read_motion_csv(file, time_column, position_column_name, position);
  m.times = table.times;
  m.positions = table.positions;
  if (const auto fault = fault_of(m)) {
    const bool of_times = fault->key == std::string_view("times");
    throw InputError(fmt::format("{}:{}: {}: {}", file,
                                 table.lines.empty() ? 1 : table.lines[fault->row],
                                 of_times ? time_column : position_column_name, fault->what));
  }
  t.set("file", file);
  t.set("times", texts_of(m.times, dimension::time));
  t.set("positions", texts_of(m.positions, position));
}

void read_motion_table(const TomlTable& t, const Dimension& position, Motion& m) {
  m.profile = Motion::Profile::table;
  const auto is_overridden = [&](const char* key) {
    return t.document().overridden(t.path() + "." + key);
  };
  if (t.has("file") && (!t.has("times") || is_overridden("file") || is_overridden("time_column") ||
                        is_overridden("position_column")))
    take_csv(t, position, m);
  m.times = t.quantities("times", dimension::time);
  m.positions = t.quantities("positions", position);
  if (const auto fault = fault_of(m)) t.fail(fault->key, fault->what);
}

void read_profile(const TomlTable& t, const std::string& kind, Motion& m) {
  const AxisUnits& units = units_of(m.kind == Motion::Kind::rotation);
  if (kind.ends_with("ramp")) {
    m.profile = Motion::Profile::ramp;
    m.rate = t.quantity("from", units.rate, Sign::any);
    m.end_rate = t.quantity("to", units.rate, Sign::any);
    m.ramp_time = t.quantity("ramp_time", dimension::time, Sign::positive);
  } else if (kind.ends_with("table")) {
    read_motion_table(t, units.position, m);
  } else {
    m.profile = Motion::Profile::sinusoidal;
    m.amplitude = t.quantity("amplitude", units.position, Sign::positive);
    m.frequency = t.quantity("frequency", dimension::frequency, Sign::positive);
    m.phase = t.quantity("phase", dimension::angle, Sign::any, "0 rad");
  }
}

// Friction that follows the load of the bearing. Not filled in where it is left out.
void read_bearing(const TomlTable& t, Joint& axis) {
  if (!read_friction_coefficient(t, {"bearing_radius", "bearing_length"},
                                 axis.friction_coefficient))
    return;
  if (t.has("bearing_length"))
    axis.bearing_length = t.quantity("bearing_length", dimension::length, Sign::positive);
  if (axis.kind == Joint::Kind::rotation)
    axis.bearing_radius = t.quantity("bearing_radius", dimension::length, Sign::positive);
  else if (t.has("bearing_radius"))
    t.fail("bearing_radius", "has no use; expected a joint of the kind \"rotation\"");
}

Joint read_joint(const TomlTable& t) {
  t.allow({"kind", "direction", "stiffness", "spring_reference", "damping", "friction", "lower",
           "upper", "friction_coefficient", "bearing_radius", "bearing_length", "limit_restitution",
           "armature", "motors"});
  Joint axis;
  const bool turns = t.choice("kind", {"translation", "rotation"}) == "rotation";
  axis.kind = turns ? Joint::Kind::rotation : Joint::Kind::translation;
  const AxisUnits& units = units_of(turns);
  axis.direction = t.direction("direction");
  axis.stiffness = t.quantity("stiffness", units.stiffness, Sign::non_negative, units.no_stiffness);
  axis.spring_reference =
      t.quantity("spring_reference", units.position, Sign::any, units.zero_position);
  axis.damping = t.quantity("damping", units.damping, Sign::non_negative, units.no_damping);
  axis.friction = t.quantity("friction", units.load, Sign::non_negative, units.zero_load);
  axis.lower = t.optional_quantity("lower", units.position, Sign::any).value_or(-kUnbounded);
  axis.upper = t.optional_quantity("upper", units.position, Sign::any).value_or(kUnbounded);
  if (axis.lower > 0 || axis.upper < 0) {
    t.fail(axis.lower > 0 ? "lower" : "upper",
           "leaves out 0, where the body is drawn; expected lower <= 0 <= upper");
  }
  axis.limit_restitution = t.number("limit_restitution", 0);
  if (!(axis.limit_restitution >= 0 && axis.limit_restitution < 1))
    t.fail("limit_restitution", "is not between 0 and 1; expected less than 1");
  // Not filled in where it is left out: few joints have a rotor.
  if (t.has("armature"))
    axis.armature = t.quantity("armature", turns ? dimension::moment_of_inertia : dimension::mass,
                               Sign::non_negative);
  read_bearing(t, axis);
  for (const TomlTable& motor : t.tables("motors")) {
    axis.motors.push_back(read_motor(motor, axis.kind));
  }
  return axis;
}

FreeBody read_free_body(const TomlTable& t) {
  t.allow({"mass", "density", "center", "inertia", "inertia_products", "free_rotation", "joints"});
  FreeBody body;
  body.free_rotation = t.boolean("free_rotation", false);
  for (const TomlTable& axis : t.tables("joints")) body.joints.push_back(read_joint(axis));
  return body;
}

// All meshes that are fixed to a free frame, in world axes at t = 0.
TriangleMesh carried_mesh(const TomlTable& t, const Model& model, int frame) {
  TriangleMesh all;
  for (const Boundary& b : model.boundaries) {
    if (free_frame(model.frames, b.frame) != frame) continue;
    if (!inspect(b.mesh).is_valid() || b.mesh.triangles.empty()) {
      t.fail("", fmt::format("carries \"{}\", whose mesh is not closed, so that it has no mass; "
                             "expected mass, center and inertia",
                             b.name));
    }
    if (const MeshConflicts found = find_conflicts(b.mesh); !found.none()) {
      t.fail("",
             fmt::format("carries \"{}\", whose mesh bounds no solid: {}; expected mass, center "
                         "and inertia",
                         b.name, found.to_message()));
    }
    const int first = static_cast<int>(all.vertices.size());
    for (const Vec3& v : b.mesh.vertices) all.vertices.push_back(b.origin + b.orientation * v);
    for (const auto& corner : b.mesh.triangles)
      all.triangles.push_back({corner[0] + first, corner[1] + first, corner[2] + first});
  }
  if (all.triangles.empty())
    t.fail("", "carries no boundary that could give it a mass; expected mass, center and inertia");
  return all;
}

void complete(const TomlTable& t, const Model& model, int frame, FreeBody& body) {
  const std::optional<double> density =
      t.optional_quantity("density", dimension::density, Sign::positive);
  const std::optional<double> mass = t.optional_quantity("mass", dimension::mass, Sign::positive);
  if (mass.has_value() == density.has_value())
    t.fail(mass ? "density" : "mass", "expected one of mass and density");
  const bool by_mesh = density || !t.has("center") || !t.has("inertia");
  MassProperties solid;
  if (by_mesh) solid = mass_properties(carried_mesh(t, model, frame));
  body.mass = mass ? *mass : *density * solid.volume;
  body.center = t.has("center") ? t.vector("center", dimension::length) : solid.centroid;
  if (t.has("inertia")) {
    const Vec3 about = t.vector("inertia", dimension::moment_of_inertia);
    const Vec3 products =
        t.vector("inertia_products", dimension::moment_of_inertia, "0 0 0 kg m^2");
    body.inertia << about.x(), products.x(), products.y(), products.x(), about.y(), products.z(),
        products.y(), products.z(), about.z();
    if (about.minCoeff() < 0)
      t.fail("inertia", "has a component below zero; expected three moments of at least zero");
    return;
  }
  body.inertia = solid.inertia * (body.mass / solid.volume);
}

}  // namespace

std::vector<MotionFrame> read_motion_frames(const TomlTable& root) {
  std::vector<MotionFrame> frames;
  for (const TomlTable& t : root.tables("motion_frames")) {
    t.allow({"name", "parent", "position", "motions", "free"});
    MotionFrame frame;
    frame.name = unique_table_name(t, frames);
    frame.parent = optional_frame(t, "parent", frames);
    frame.origin = t.vector("position", dimension::length, "0 0 0 m");
    for (const TomlTable& motion : t.tables("motions"))
      frame.motions.push_back(read_motion(motion));
    if (t.has("free")) frame.free = read_free_body(t.required_table("free"));
    frames.push_back(std::move(frame));
  }
  return frames;
}

void complete_free_bodies(const TomlTable& root, Model& model) {
  const std::vector<TomlTable> tables = root.tables("motion_frames");
  for (std::size_t f = 0; f < model.frames.size(); ++f) {
    if (!model.frames[f].free) continue;
    complete(tables[f].required_table("free"), model, static_cast<int>(f), *model.frames[f].free);
  }
}

Motion read_motion(const TomlTable& t, std::initializer_list<std::string_view> also) {
  const std::string kind =
      t.choice("kind", {"translation", "rotation", "vibration", "pendulum", "translation_ramp",
                        "rotation_ramp", "translation_table", "rotation_table"});
  Motion m;
  const bool turns = kind.starts_with("rotation") || kind == "pendulum";
  m.kind = turns ? Motion::Kind::rotation : Motion::Kind::translation;
  const bool steady = kind == "translation" || kind == "rotation";
  std::vector<std::string_view> keys{"kind", "start", "stop", "period"};
  if (turns) keys.insert(keys.end(), {"axis", "center"});
  if (!turns && !steady) keys.push_back("direction");
  if (steady) keys.emplace_back(turns ? "angular_velocity" : "velocity");
  if (kind.ends_with("ramp")) keys.insert(keys.end(), {"from", "to", "ramp_time"});
  if (kind.ends_with("table"))
    keys.insert(keys.end(), {"times", "positions", "file", "time_column", "position_column"});
  if (kind == "vibration" || kind == "pendulum")
    keys.insert(keys.end(), {"amplitude", "frequency", "phase"});
  keys.insert(keys.end(), also.begin(), also.end());
  t.allow(keys);
  if (turns) {
    m.axis = t.direction("axis");
    m.center = t.vector("center", dimension::length, "0 0 0 m");
  }
  if (kind == "translation") {
    m.velocity = t.vector("velocity", dimension::velocity);
  } else if (kind == "rotation") {
    m.angular_speed = t.quantity("angular_velocity", dimension::angular_velocity, Sign::any);
  } else {
    if (!turns) m.axis = t.direction("direction");
    read_profile(t, kind, m);
  }
  read_schedule(t, m);
  return m;
}

Motor read_motor(const TomlTable& t, Joint::Kind kind,
                 std::initializer_list<std::string_view> also) {
  std::vector<std::string_view> keys{"start",  "stop",     "period",       "speed",
                                     "target", "max_load", "no_load_speed"};
  keys.insert(keys.end(), also.begin(), also.end());
  t.allow(keys);
  const AxisUnits& units = units_of(kind == Joint::Kind::rotation);
  Motor motor;
  motor.speed = t.quantity("speed", units.rate, Sign::any);
  motor.target = t.optional_quantity("target", units.position, Sign::any);
  motor.max_load = t.optional_quantity("max_load", units.load, Sign::positive).value_or(kUnbounded);
  if (t.has("no_load_speed")) {
    motor.no_load_speed = t.quantity("no_load_speed", units.rate, Sign::positive);
    if (motor.max_load == kUnbounded)
      t.fail("no_load_speed", "goes with max_load, which is the load at stall; expected both");
    if (std::abs(motor.speed) > motor.no_load_speed)
      t.fail("speed", "is above the no_load_speed, which is the fastest; expected less");
  }
  read_schedule(t, motor);
  return motor;
}

bool read_friction_coefficient(const TomlTable& t,
                               std::initializer_list<std::string_view> bearing_keys,
                               double& coefficient) {
  if (!t.has("friction_coefficient")) {
    for (const std::string_view key : bearing_keys)
      if (t.has(key)) t.fail(key, "has no use; expected a friction_coefficient with it");
    return false;
  }
  coefficient = t.number("friction_coefficient");
  if (!(coefficient >= 0)) t.fail("friction_coefficient", "is negative; expected at least 0");
  return true;
}

int frame_index(const TomlTable& t, std::string_view key, const std::vector<MotionFrame>& frames) {
  return index_of(t, key, t.string(key), frames, "motion frame");
}

int optional_frame(const TomlTable& t, std::string_view key,
                   const std::vector<MotionFrame>& frames) {
  return t.has(key) ? frame_index(t, key, frames) : -1;
}

}  // namespace firn
