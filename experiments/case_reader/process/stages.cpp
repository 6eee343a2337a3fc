#include "experiments/case_reader/process/stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <string>
#include <string_view>

#include "experiments/case_reader/model/boundaries.h"
#include "experiments/case_reader/model/motion_frames.h"
#include "experiments/text/toml_names.h"

namespace firn {
namespace {

using EndEvent = Stage::EndEvent;

struct Word {
  std::string_view word;
  EndEvent event;
  std::initializer_list<std::string_view> keys;  // that have a meaning with it alone
};
const std::initializer_list<Word> kWords = {
    {"time", EndEvent::time, {}},
    {"settled", EndEvent::settled, {"settle_energy", "settle_time"}},
    {"empty", EndEvent::empty, {}},
    {"switch", EndEvent::switched, {"switch"}},
    {"passed", EndEvent::passed, {"sensor", "count", "mass"}},
    {"stalled", EndEvent::stalled, {"stall_frame", "stall_axis", "stall_hold"}},
    {"force", EndEvent::force, {"force_frame", "force", "force_hold"}},
    {"torque", EndEvent::torque, {"torque_frame", "torque", "torque_hold"}},
    {"filled", EndEvent::filled, {"fill_height", "fill_count", "fill_hold"}}};

std::vector<EndEvent> read_end_when(const TomlTable& t) {
  std::vector<std::string> asked{"time"};
  if (t.has("end_when"))
    asked = t.is_list("end_when") ? t.strings("end_when")
                                  : std::vector<std::string>{t.string("end_when")};
  else
    t.set("end_when", "time");
  std::vector<std::string_view> words;
  for (const Word& w : kWords) words.push_back(w.word);
  std::vector<EndEvent> events;
  for (const std::string& one : asked) {
    const auto known = std::ranges::find(kWords, one, &Word::word);
    if (known == kWords.end())
      t.fail("end_when", fmt::format("is \"{}\"; expected one of {}", one, comma_list(words)));
    events.push_back(known->event);
  }
  for (const Word& w : kWords) {
    if (std::ranges::count(events, w.event)) continue;
    for (const std::string_view key : w.keys) {
      if (t.has(key))
        t.fail(key, fmt::format("has no meaning without end_when = \"{}\"; expected both", w.word));
    }
  }
  return events;
}

int axis_of(const TomlTable& t, std::string_view key, const MotionFrame& frame) {
  const int axis = t.integer(key, 0, 0);
  if (!frame.free || axis >= static_cast<int>(frame.free->joints.size())) {
    t.fail(t.has(key) ? key : "motion_frame",
           fmt::format("motion frame \"{}\" has no joint {}; expected one of its {}", frame.name,
                       axis, frame.free ? frame.free->joints.size() : 0));
  }
  return axis;
}

void read_passed(const TomlTable& t, const Case& c, Stage& stage) {
  stage.sensor = index_of(t, "sensor", t.string("sensor"), c.sensors, "sensor");
  if (t.has("count") == t.has("mass"))
    t.fail(t.has("mass") ? "mass" : "count", "expected one of count and mass");
  if (t.has("count")) stage.count = t.integer("count", 1);
  if (t.has("mass")) stage.mass = t.quantity("mass", dimension::mass, Sign::positive);
}

void read_stall(const TomlTable& t, const Case& c, Stage& stage) {
  stage.stall_frame = frame_index(t, "stall_frame", c.model.frames);
  stage.stall_axis =
      axis_of(t, "stall_axis", c.model.frames[static_cast<std::size_t>(stage.stall_frame)]);
  stage.stall_hold = t.quantity("stall_hold", dimension::time, Sign::positive, "0.5 s");
}

void read_force(const TomlTable& t, const Case& c, Stage& stage) {
  stage.force_frame = frame_index(t, "force_frame", c.model.frames);
  stage.force = t.quantity("force", dimension::force, Sign::positive);
  stage.force_hold = t.quantity("force_hold", dimension::time, Sign::non_negative, "0 s");
}

void read_torque(const TomlTable& t, const Case& c, Stage& stage) {
  stage.torque_frame = frame_index(t, "torque_frame", c.model.frames);
  stage.torque = t.quantity("torque", dimension::torque, Sign::positive);
  stage.torque_hold = t.quantity("torque_hold", dimension::time, Sign::positive, "0.1 s");
}

void read_filled(const TomlTable& t, const Case& c, Stage& stage) {
  if (c.model.gravity.norm() == 0)
    t.fail("end_when", "is \"filled\" without gravity; expected a case with one");
  stage.fill_height = t.quantity("fill_height", dimension::length, Sign::any);
  stage.fill_count = t.integer("fill_count", 1, 3);
  stage.fill_hold = t.quantity("fill_hold", dimension::time, Sign::positive, "0.2 s");
}

Stage::StartedMotion read_started_motion(const TomlTable& t, const Case& c) {
  Stage::StartedMotion start;
  start.motion = read_motion(t, {"boundary", "motion_frame", "ends_with_stage"});
  if (t.has("boundary") == t.has("motion_frame"))
    t.fail("boundary", "expected one of boundary and motion_frame");
  const std::vector<MotionFrame>& frames = c.model.frames;
  if (t.has("boundary")) {
    start.boundary = boundary_index(t, "boundary", t.string("boundary"), c.model.boundaries);
  } else {
    start.frame = frame_index(t, "motion_frame", frames);
    if (free_frame(frames, start.frame) >= 0)
      t.fail("motion_frame", fmt::format("\"{}\" is a free body or a child of one; expected motors",
                                         frames[static_cast<std::size_t>(start.frame)].name));
  }
  start.ends_with_stage = t.boolean("ends_with_stage", false);
  return start;
}

Stage::StageMotor read_started_drive(const TomlTable& t, const Case& c) {
  Stage::StageMotor start;
  start.frame = frame_index(t, "motion_frame", c.model.frames);
  const MotionFrame& frame = c.model.frames[static_cast<std::size_t>(start.frame)];
  start.axis = axis_of(t, "axis", frame);
  start.motor = read_motor(t, frame.free->joints[static_cast<std::size_t>(start.axis)].kind,
                           {"motion_frame", "axis", "ends_with_stage"});
  start.ends_with_stage = t.boolean("ends_with_stage", true);
  return start;
}

Stage read_stage(const TomlTable& t, const Case& c) {
  std::vector<std::string_view> keys{
      "name", "end_when", "max_duration", "min_duration", "remove_boundaries", "motions", "motors"};
  for (const Word& w : kWords) keys.insert(keys.end(), w.keys.begin(), w.keys.end());
  t.allow(keys);
  Stage stage;
  stage.name = t.string("name");
  stage.max_duration = t.quantity("max_duration", dimension::time, Sign::positive);
  stage.min_duration = t.quantity("min_duration", dimension::time, Sign::non_negative, "0 s");
  if (stage.max_duration < stage.min_duration) {
    t.fail("min_duration", fmt::format("is {} s, above max_duration of {} s; expected less",
                                       stage.min_duration, stage.max_duration));
  }
  stage.end_when = read_end_when(t);
  if (stage.ends_on(EndEvent::settled)) {
    stage.settle_energy = t.quantity("settle_energy", dimension::energy, Sign::positive, "1e-6 J");
    stage.settle_time = t.quantity("settle_time", dimension::time, Sign::positive, "0.05 s");
  }
  if (stage.ends_on(EndEvent::switched))
    stage.closed_switch = index_of(t, "switch", t.string("switch"), c.limit_switches, "switch");
  if (stage.ends_on(EndEvent::passed)) read_passed(t, c, stage);
  if (stage.ends_on(EndEvent::stalled)) read_stall(t, c, stage);
  if (stage.ends_on(EndEvent::force)) read_force(t, c, stage);
  if (stage.ends_on(EndEvent::torque)) read_torque(t, c, stage);
  if (stage.ends_on(EndEvent::filled)) read_filled(t, c, stage);
  stage.remove = t.strings("remove_boundaries");
  for (const std::string& name : stage.remove)
    boundary_index(t, "remove_boundaries", name, c.model.boundaries);
  for (const TomlTable& m : t.tables("motions")) stage.motions.push_back(read_started_motion(m, c));
  for (const TomlTable& d : t.tables("motors")) stage.motors.push_back(read_started_drive(d, c));
  return stage;
}

}  // namespace

std::vector<Stage> read_stages(const TomlTable& root, const Case& c) {
  std::vector<Stage> stages;
  for (const TomlTable& t : root.tables("stages")) {
    unique_table_name(t, stages);
    stages.push_back(read_stage(t, c));
  }
  return stages;
}

int optional_stage(const TomlTable& t, std::string_view key, const std::vector<Stage>& stages) {
  if (!t.has(key)) return -1;
  const std::string name = t.string(key);
  const auto it = std::ranges::find(stages, name, &Stage::name);
  if (it != stages.end()) return static_cast<int>(it - stages.begin());
  std::vector<std::string> names;
  names.reserve(stages.size());
  for (const Stage& stage : stages) names.push_back(fmt::format("\"{}\"", stage.name));
  t.fail(key, fmt::format(
                  "\"{}\" is no stage of the case; expected {}", name,
                  names.empty() ? "none, as it has no [[stages]]" : "one of " + comma_list(names)));
}

void check_stage_names(const TomlTable& root, const Case& c) {
  for (const char* kind : {"fills", "inlets", "tag_rules"}) {
    for (const TomlTable& t : root.tables(kind))
      if (t.has("stage")) index_of(t, "stage", t.string("stage"), c.stages, "stage");
  }
}

}  // namespace firn
