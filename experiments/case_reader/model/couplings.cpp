#include "experiments/case_reader/model/couplings.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "experiments/case_reader/model/motion_frames.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/toml_names.h"

namespace firn {
namespace {

constexpr std::string_view kWorld = "world";

int body_index(const TomlTable& t, const std::string& name,
               const std::vector<MotionFrame>& frames) {
  if (name == kWorld && std::ranges::find(frames, kWorld, &MotionFrame::name) == frames.end())
    return -1;
  return index_of(t, "between", name, frames, "motion frame");
}

bool turns(const TomlTable& t, const std::vector<MotionFrame>& frames, int frame, int joint) {
  if (frame < 0 || !frames[index(frame)].free)
    t.fail("between", "names a body without joints; expected two free motion frames");
  const std::vector<Joint>& joints = frames[index(frame)].free->joints;
  if (joint >= static_cast<int>(joints.size()))
    t.fail("joints",
           fmt::format("asks for joint {} of \"{}\", which has {}; expected a number from 0", joint,
                       frames[index(frame)].name, joints.size()));
  return joints[index(joint)].kind == Joint::Kind::rotation;
}

void read_cam(const TomlTable& t, bool follower_turns, Coupling& c) {
  c.angles = t.quantities("angles", dimension::angle);
  c.lifts = t.quantities("lifts", follower_turns ? dimension::angle : dimension::length);
  if (c.angles.size() < 4 || c.angles.size() != c.lifts.size())
    t.fail("lifts", fmt::format("has {} values for {} angles; expected as many, at least four",
                                c.lifts.size(), c.angles.size()));
  for (std::size_t i = 1; i < c.angles.size(); ++i)
    if (!(c.angles[i] > c.angles[i - 1]))
      t.fail("angles", fmt::format("go from {} rad to {} rad; expected each above the one before",
                                   c.angles[i - 1], c.angles[i]));
  if (!(c.angles.back() - c.angles.front() < 2 * std::numbers::pi))
    t.fail("angles", "span a turn or more; expected less, as the first one follows on the last");
}

// Keys of the friction of a coupling of this kind.
std::vector<std::string_view> friction_keys(Coupling::Kind kind) {
  switch (kind) {
    case Coupling::Kind::ball:
      return {"direction", "friction", "friction_coefficient", "bearing_radius"};
    case Coupling::Kind::hinge:
      return {"friction", "friction_coefficient", "bearing_radius"};
    case Coupling::Kind::slot:
      return {"friction", "friction_coefficient"};
    default:
      return {};
  }
}

// Friction of a pin or slot. Not filled in where it is left out. The axis of a hinge or slot has
// been read before.
void read_coupling_friction(const TomlTable& t, Coupling& c) {
  const bool slides = c.kind == Coupling::Kind::slot;
  if (t.has("friction"))
    c.friction =
        t.quantity("friction", slides ? dimension::force : dimension::torque, Sign::non_negative);
  const bool follows_load =
      read_friction_coefficient(t, {"bearing_radius"}, c.friction_coefficient);
  if (follows_load && !slides)
    c.bearing_radius = t.quantity("bearing_radius", dimension::length, Sign::positive);
  if (c.kind != Coupling::Kind::ball) return;
  if (follows_load || t.has("friction"))
    c.direction = t.direction("direction");
  else if (t.has("direction"))
    t.fail("direction", "has no use without friction; expected both or none");
}

// Key of a coupling of joints, with its dimension: of the second joint over the first.
double read_ratio(const TomlTable& t, bool first_turns, bool second_turns) {
  const Dimension per_angle{1, 0, 0, -1}, per_length{-1, 0, 0, 1};
  const double ratio = first_turns == second_turns
                           ? t.number("ratio")
                           : t.quantity("ratio", first_turns ? per_angle : per_length, Sign::any);
  if (ratio == 0) t.fail("ratio", "is 0; expected another value");
  return ratio;
}

}  // namespace

std::vector<Coupling> read_couplings(const TomlTable& root,
                                     const std::vector<MotionFrame>& frames) {
  root.require_at_most("couplings", input_limits::couplings);
  std::vector<Coupling> couplings;
  for (const TomlTable& t : root.tables("couplings")) {
    Coupling c;
    const std::string kind = t.choice("kind", {"ball", "hinge", "weld", "slot", "gear", "cam"});
    const std::vector<std::string> names = t.strings("between");
    if (names.size() != 2 || names[0] == names[1])
      t.fail("between", "does not name two bodies; expected such as [\"rod\", \"piston\"]");
    c.a = body_index(t, names[0], frames);
    c.b = body_index(t, names[1], frames);
    if (!t.has("name")) t.set("name", names[0] + "-" + names[1]);
    c.name = unique_table_name(t, couplings);
    std::vector<std::string_view> keys{"kind", "between", "name"};
    if (kind == "gear" || kind == "cam") {
      keys.emplace_back("joints");
      keys.emplace_back(kind == "gear" ? "ratio" : "angles");
      if (kind == "cam") keys.emplace_back("lifts");
      t.allow(keys);
      const std::vector<int> joints = t.integers("joints");
      if (!joints.empty() && (joints.size() != 2 || std::ranges::min(joints) < 0))
        t.fail("joints", "does not give a number for each body; expected such as [0, 0]");
      if (!joints.empty()) {
        c.joint_a = joints[0];
        c.joint_b = joints[1];
      }
      const bool first = turns(t, frames, c.a, c.joint_a),
                 second = turns(t, frames, c.b, c.joint_b);
      if (kind == "gear") {
        c.kind = Coupling::Kind::gear;
        c.ratio = read_ratio(t, first, second);
      } else {
        if (!first) t.fail("between", "names a cam that does not turn; expected a rotation first");
        c.kind = Coupling::Kind::cam;
        read_cam(t, second, c);
      }
    } else {
      const bool has_axis = kind == "hinge" || kind == "slot";
      keys.emplace_back("position");
      if (has_axis) keys.emplace_back("direction");
      c.kind = kind == "ball"    ? Coupling::Kind::ball
               : kind == "hinge" ? Coupling::Kind::hinge
               : kind == "weld"  ? Coupling::Kind::weld
                                 : Coupling::Kind::slot;
      for (const std::string_view key : friction_keys(c.kind)) keys.push_back(key);
      t.allow(keys);
      c.position = t.vector("position", dimension::length);
      if (has_axis) c.direction = t.direction("direction");
      read_coupling_friction(t, c);
    }
    couplings.push_back(std::move(c));
  }
  return couplings;
}

}  // namespace firn
