#include "experiments/results/results_schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "experiments/results/results_writer.h"

namespace firn::results {
namespace {

using hdf5::Error;
using hdf5::Shape;
using hdf5::Type;
using enum Presence;
using R = Rule;
constexpr auto real = Type::real, integer = Type::integer, text = Type::text, byte = Type::byte,
               natural = Type::natural;

constexpr Dataset kDatasets[] = {
    {"/particles/id", always, "", integer, "N", "", R::counting, "", "number of the particle"},
    {"/particles/shape", always, "", integer, "N", "", R::index, "H", "index into `/shapes`"},
    {"/particles/mass", always, "", real, "N", "kg", R::positive, "", ""},
    {"/particles/tag", always, "", integer, "N", "", R::any, "",
     "as the case gives it, or the last tag rule"},
    {"/particles/peak_normal_force", always, "", real, "N", "N", R::non_negative, "",
     "largest contact normal force over every step, not over frames"},
    {"/particles/exit_time", always, "", real, "N", "s", R::non_negative_or_nan, "",
     "when an outlet removed the particle; NaN: never"},
    {"/particles/discharge_time", always, "", real, "N", "s", R::non_negative_or_nan, "",
     "when the centre of mass was first below the floor's underside (drained angle of repose); "
     "NaN: never",
     "/particles/door_time"},
    {"/particles/insert_time", newer, "", real, "N", "s", R::finite_or_nan, "",
     "when the particle came; NaN: has not; before 0: in the earlier run that the case "
     "[starts](scenes.md#initial_state) from"},
    {"/particles/batch", newer, "", integer, "N", "", R::batch, "",
     "of its fill or inlet, from 0; -1: placed singly, or has not come"},
    {"/particles/outlet", newer, "", integer, "N", "", R::index_or_none, "O",
     "index into `/outlets/name`; -1: none"},
    {"/particles/sensor_time", together, "/sensors/name", real, "G,N", "s", R::non_negative_or_nan,
     "", "when its centre was first in each sensor of `/sensors/name`; NaN: never",
     "/particles/gate_time"},
    {"/particles/compressive_load", optional, "/statistics/boundary_name", real, "N", "N",
     R::non_negative, "", "largest load from two sides; 0: none ([statistics.md](statistics.md))",
     "/particles/opposed_load"},
    {"/particles/compressive_load_time", together, "/particles/compressive_load", real, "N", "s",
     R::non_negative_or_nan, "", "of that load; NaN: none", "/particles/opposed_load_time"},
    {"/particles/compressive_load_body_0", together, "/particles/compressive_load", real, "N", "1",
     R::body_or_nan, "W",
     "body on one side: a particle, or -1 - the index of a boundary; NaN: none",
     "/particles/opposed_load_by_0"},
    {"/particles/compressive_load_body_1", together, "/particles/compressive_load", real, "N", "1",
     R::body_or_nan, "W", "body on the other side", "/particles/opposed_load_by_1"},
    {"/shapes/name", always, "", text, "H", "", R::any, "", ""},
    {"/shapes/mass", always, "", real, "H", "kg", R::positive, "", ""},
    {"/shapes/volume", always, "", real, "H", "m^3", R::positive, "", ""},
    {"/sensors/name", optional, "", text, "G", "", R::any, "", "of a case with sensors",
     "/gates/name"},
    {"/outlets/name", newer, "", text, "O", "", R::any, "", ""},
    {"/frames/time", always, "", real, "T", "s", R::ascending, "", ""},
    {"/frames/position", always, "", real, "T,N,3", "m", R::vector_or_nan, "",
     "centre of mass, world; NaN while a particle does not exist, here and below"},
    {"/frames/orientation", always, "", real, "T,N,4", "1", R::rotation_or_nan, "",
     "unit quaternion w x y z, shape axes to world"},
    {"/frames/velocity", always, "", real, "T,N,3", "m/s", R::vector_or_nan, "", "world"},
    {"/frames/angular_velocity", always, "", real, "T,N,3", "rad/s", R::vector_or_nan, "", "world"},
    {"/boundaries/<boundary>/force", optional, "", real, "T,3", "N", R::finite, "",
     "by contacts; mean over the interval that the frame ends, 0 in frame 0"},
    {"/boundaries/<boundary>/torque", together, "/boundaries/<boundary>/force", real, "T,3", "N m",
     R::finite, "", "about the boundary's origin; mean over the interval"},
    {"/boundaries/<boundary>/peak_normal_force", together, "/boundaries/<boundary>/force", real,
     "T", "N", R::non_negative, "", "largest single contact within the interval"},
    {"/boundaries/<boundary>/position", together, "/boundaries/<boundary>/force", real, "T,3", "m",
     R::vector_or_nan, "", "where it is; NaN once it has been removed"},
    {"/boundaries/<boundary>/orientation", together, "/boundaries/<boundary>/force", real, "T,4",
     "1", R::rotation_or_nan, "", "boundary axes to world; NaN once it has been removed"},
    {"/motion_frames/<frame>/position", optional, "", real, "T,3", "m", R::finite, "",
     "of its origin"},
    {"/motion_frames/<frame>/orientation", together, "/motion_frames/<frame>/position", real, "T,4",
     "1", R::rotation, "", "its axes were the world's at t = 0"},
    {"/motion_frames/<frame>/force", together, "/motion_frames/<frame>/position", real, "T,3", "N",
     R::finite, "", "by contacts on all it carries; mean over the interval that the frame ends"},
    {"/motion_frames/<frame>/torque", together, "/motion_frames/<frame>/position", real, "T,3",
     "N m", R::finite, "", "about its origin; mean over the interval"},
    {"/motion_frames/<frame>/reaction_force", optional, "/motion_frames/<frame>/position", real,
     "T,3", "N", R::finite, "",
     "on a free one by what carries it: bearing, springs, motors and joint limits; mean over the "
     "interval"},
    {"/motion_frames/<frame>/reaction_torque", together, "/motion_frames/<frame>/reaction_force",
     real, "T,3", "N m", R::finite, "", "about its origin; mean over the interval"},
    {"/motion_frames/<frame>/angular_velocity", optional, "/motion_frames/<frame>/position", real,
     "T,3", "rad/s", R::finite, "", "of one that turns freely: against what carries it, world axes",
     "/motion_frames/<frame>/spin"},
    {"/motion_frames/<frame>/coordinate", optional, "/motion_frames/<frame>/position", real, "T,A",
     "SI", R::finite, "", "of each joint of a free one, m or rad"},
    {"/motion_frames/<frame>/rate", together, "/motion_frames/<frame>/coordinate", real, "T,A",
     "SI", R::finite, "", "m/s or rad/s"},
    {"/motion_frames/<frame>/motor_load", together, "/motion_frames/<frame>/coordinate", real,
     "T,A", "SI", R::finite, "", "load by the motor, N or N m; mean over the interval",
     "/motion_frames/<frame>/drive"},
    {"/motion_frames/<frame>/limit_load", together, "/motion_frames/<frame>/coordinate", real,
     "T,A", "SI", R::finite, "", "load by the joint limits, N or N m; mean over the interval",
     "/motion_frames/<frame>/stop"},
    {"/boundary_contacts/<contact>/force", optional, "", real, "T,3", "N", R::finite, "",
     "of a case with [boundary contacts](scenes.md#boundary-contacts): on the first of the two, or "
     "on "
     "the solid that touches a plane; mean over the interval"},
    {"/boundary_contacts/<contact>/peak_normal_force", together,
     "/boundary_contacts/<contact>/force", real, "T", "N", R::non_negative, "",
     "largest sum over its patches within the interval"},
    {"/boundary_contacts/<contact>/dissipated", together, "/boundary_contacts/<contact>/force",
     real, "T", "J", R::finite, "", "by impacts and friction, since the start"},
    {"/limit_switches/name", optional, "", text, "C", "", R::any, "",
     "of a case with limit switches: which one changed, in order of time", "/switches/name"},
    {"/limit_switches/time", together, "/limit_switches/name", real, "C", "s", R::ascending, "", "",
     "/switches/time"},
    {"/limit_switches/closed", together, "/limit_switches/name", integer, "C", "", R::flag, "", "",
     "/switches/closed"},
    {"/bonds/name", optional, "", text, "B", "", R::any, "",
     "of a case with [bonds](scenes.md#bonds): name of the table"},
    {"/bonds/a", together, "/bonds/name", integer, "B", "", R::index, "N", "one particle"},
    {"/bonds/b", together, "/bonds/name", integer, "B", "", R::index, "N", "the other"},
    {"/bonds/break_mode", together, "/bonds/name", text, "B", "", R::choice,
     "intact|tension|bending|shear|torsion|removed", "`removed`: a body has left"},
    {"/bonds/break_time", together, "/bonds/name", real, "B", "s", R::non_negative_or_nan, "",
     "NaN: has not broken, here and below"},
    {"/bonds/break_stress", together, "/bonds/name", real, "B", "Pa", R::finite_or_nan, "", ""},
    {"/bonds/break_position", together, "/bonds/name", real, "B,3", "m", R::vector_or_nan, "",
     "world"},
    {"/events/start", optional, "/statistics/boundary_name", real, "E", "s", R::non_negative, "",
     "of a contact, of a case that asks for them one by one ([statistics.md](statistics.md))"},
    {"/events/duration", together, "/events/start", real, "E", "s", R::non_negative, "", ""},
    {"/events/peak_time", together, "/events/start", real, "E", "s", R::non_negative, "", ""},
    {"/events/peak_normal_force", together, "/events/start", real, "E", "N", R::non_negative, "",
     ""},
    {"/events/peak_friction", together, "/events/start", real, "E", "N", R::non_negative, "", ""},
    {"/events/normal_impulse", together, "/events/start", real, "E", "N s", R::finite, "", ""},
    {"/events/tangential_impulse", together, "/events/start", real, "E", "N s", R::finite, "", ""},
    {"/events/impulse", together, "/events/start", real, "E,3", "N s", R::finite, "",
     "vector, world"},
    {"/events/impact_velocity_normal", together, "/events/start", real, "E", "m/s", R::finite, "",
     "", "/events/approach_normal"},
    {"/events/impact_velocity_tangential", together, "/events/start", real, "E", "m/s", R::finite,
     "", "", "/events/approach_tangential"},
    {"/events/normal", together, "/events/start", real, "E,3", "1", R::finite, "", ""},
    {"/events/position", together, "/events/start", real, "E,3", "m", R::finite, "", "world",
     "/events/place"},
    {"/events/position_on_body_a", together, "/events/start", real, "E,3", "m", R::finite, "",
     "axes of the body", "/events/place_on_body"},
    {"/events/position_on_body_b", together, "/events/start", real, "E,3", "m", R::finite, "",
     "axes of the other body", "/events/place_on_other"},
    {"/events/dissipated", together, "/events/start", real, "E", "J", R::finite, "", ""},
    {"/events/body_a", together, "/events/start", real, "E", "1", R::index, "N", "a particle",
     "/events/body"},
    {"/events/body_b", together, "/events/start", real, "E", "1", R::body, "W",
     "a particle, or -1 - the index of a boundary", "/events/other"},
    {"/events/open_at_end", together, "/events/start", real, "E", "1", R::flag, "",
     "1: under way at the end of the run", "/events/lasts"},
    {"/statistics/boundary_name", optional, "", text, "W", "", R::any, "",
     "boundaries in order of the case; of a case with [statistics](statistics.md)"},
    {"/statistics/intervals/start", optional, "/statistics/boundary_name", real, "I", "s",
     R::non_negative, "", "of the intervals over which loads on triangles are summed"},
    {"/statistics/intervals/end", together, "/statistics/intervals/start", real, "I", "s",
     R::non_negative, "", ""},
    {"/statistics/boundaries/<boundary>/vertices", optional, "/statistics/intervals/start", real,
     "V,3", "m", R::finite, "", "of the mesh, boundary axes"},
    {"/statistics/boundaries/<boundary>/triangles", together,
     "/statistics/boundaries/<boundary>/vertices", integer, "P,3", "", R::index, "V", "corners"},
    {"/statistics/boundaries/<boundary>/normal_force", together,
     "/statistics/boundaries/<boundary>/vertices", real, "I,P", "N", R::finite, "",
     "mean over the interval"},
    {"/statistics/boundaries/<boundary>/tangential_force", together,
     "/statistics/boundaries/<boundary>/vertices", real, "I,P", "N", R::finite, "",
     "mean over the interval"},
    {"/statistics/boundaries/<boundary>/impulse_x", together,
     "/statistics/boundaries/<boundary>/vertices", real, "I,P", "N s", R::finite, "", ""},
    {"/statistics/boundaries/<boundary>/impulse_y", together,
     "/statistics/boundaries/<boundary>/vertices", real, "I,P", "N s", R::finite, "", ""},
    {"/statistics/boundaries/<boundary>/impulse_z", together,
     "/statistics/boundaries/<boundary>/vertices", real, "I,P", "N s", R::finite, "", ""},
    {"/statistics/boundaries/<boundary>/peak_stress", together,
     "/statistics/boundaries/<boundary>/vertices", real, "I,P", "Pa", R::finite, "",
     "largest normal force of a step over the area"},
    {"/statistics/boundaries/<boundary>/sliding_distance", together,
     "/statistics/boundaries/<boundary>/vertices", real, "I,P", "m", R::finite, "", ""},
    {"/statistics/boundaries/<boundary>/frictional_power", together,
     "/statistics/boundaries/<boundary>/vertices", real, "I,P", "W", R::finite, "",
     "mean over the interval"},
    {"/statistics/boundaries/<boundary>/wear_depth", optional,
     "/statistics/boundaries/<boundary>/vertices", real, "I,P", "m", R::finite, "",
     "with a wear rate"},
    {"/statistics/shapes/<shape>/vertices", optional, "/statistics/boundary_name", real, "V,3", "m",
     R::finite, "", "of the mesh of the shape with this index, shape axes"},
    {"/statistics/shapes/<shape>/triangles", together, "/statistics/shapes/<shape>/vertices",
     integer, "P,3", "", R::index, "V", "corners"},
    {"/statistics/shapes/<shape>/contacts", optional, "/statistics/shapes/<shape>/vertices", real,
     "P", "1", R::non_negative, "", "on each triangle, over all particles of the shape"},
    {"/statistics/shapes/<shape>/normal_impulse", together, "/statistics/shapes/<shape>/contacts",
     real, "P", "N s", R::finite, "", ""},
    {"/statistics/shapes/<shape>/peak_normal_force", together,
     "/statistics/shapes/<shape>/contacts", real, "P", "N", R::non_negative, "", ""},
    {"/statistics/energy_spectrum/lower_bound", optional, "/statistics/boundary_name", real, "K",
     "J", R::ascending, "", "of the classes of energy", "/statistics/energies/lower_bound"},
    {"/statistics/energy_spectrum/contacts", optional, "/statistics/energy_spectrum/lower_bound",
     real, "1+W,K", "1", R::non_negative, "", "that ended, between particles and on each boundary",
     "/statistics/energies/contacts"},
    {"/statistics/energy_spectrum/dissipated", together, "/statistics/energy_spectrum/contacts",
     real, "1+W,K", "J", R::finite, "", "by them", "/statistics/energies/dissipated"},
    {"/energy/kinetic", always, "", real, "T", "J", R::non_negative, "", ""},
    {"/energy/gravitational", newer, "", real, "T", "J", R::finite, "", ""},
    {"/energy/elastic", newer, "", real, "T", "J", R::finite, "", ""},
    {"/energy/dissipated", newer, "", real, "T", "J", R::finite, "",
     "since the start: the sum of the three below"},
    {"/energy/dissipated_normal", newer, "", real, "T", "J", R::finite, "", "restitution"},
    {"/energy/dissipated_friction", newer, "", real, "T", "J", R::finite, "", ""},
    {"/energy/dissipated_bonds", optional, "/bonds/name", real, "T", "J", R::finite, "",
     "by dampers of bonds, and what bonds held when they broke"},
    {"/energy/dissipated_boundaries", newer, "", real, "T", "J", R::finite, "",
     "the part of the first two that was lost against boundaries", "/energy/dissipated_walls"},
    {"/energy/boundary_work", newer, "", real, "T", "J", R::finite, "",
     "done by moving boundaries on particles"},
    {"/energy/removed", newer, "", real, "T", "J", R::finite, "",
     "carried away by removals less that inserted"},
    {"/diagnostics/largest_overlap", newer, "", real, "T", "m", R::non_negative, "",
     "over all steps so far", "/health/largest_overlap"},
    {"/diagnostics/overlap_now", newer, "", real, "T", "m", R::finite_or_nan, "",
     "largest overlap of the contacts that bear a force in this frame; NaN when nothing touches",
     "/health/overlap_now"},
    {"/diagnostics/overlap_p99", newer, "", real, "T", "m", R::finite_or_nan, "",
     "the one that 99 % of them stay below", "/health/overlap_p99"},
    {"/diagnostics/overlap_median", newer, "", real, "T", "m", R::finite_or_nan, "", "the median",
     "/health/overlap_median"},
    {"/diagnostics/energy_error", newer, "", real, "T", "J", R::finite, "",
     "sum of unexplained energy rises so far", "/health/energy_rise"},
    {"/diagnostics/late_contacts", newer, "", real, "T", "1", R::non_negative, "",
     "contacts detected with an overlap already, so far", "/health/deep_births"},
    {"/diagnostics/patches", newer, "", real, "T", "1", R::non_negative, "", "contact patches now",
     "/health/patches"},
    {"/diagnostics/points", newer, "", real, "T", "1", R::non_negative, "", "contact points now",
     "/health/points"},
    {"/stages/name", always, "", text, "S", "", R::any, "", ""},
    {"/stages/start", always, "", real, "S", "", R::non_negative_or_nan, "", "s; NaN: not reached"},
    {"/stages/end", always, "", real, "S", "", R::non_negative_or_nan, "", "s; NaN: not reached"},
    {"/stages/end_reason", always, "", text, "S", "", R::any, "",
     "`settled`, `empty`, `switch \"NAME\"`, `passed \"NAME\"`, `stalled: ...`, `torque`, `time`, "
     "`time limit` (with `passed`: and how many passed the sensor), `end of the case`, or what "
     "blocked an inlet; empty: not ended",
     "/stages/ended_by"},
    {"/responses/<response>", optional, "", real, "k", "", R::finite_or_nan, "",
     "what [was measured](responses.md), once the run is finished; NaN: not defined"},
    {"/checkpoint/slot_0", optional, "", byte, "b", "", R::any, "",
     "state to resume from, with its hash; removed once the run is finished"},
    {"/checkpoint/slot_1", optional, "", byte, "b", "", R::any, "", "the same, written in turn"},
    {"/states/<step>", optional, "", byte, "b", "", R::any, "",
     "states kept on the way, with `output.state_interval` alone"},
};

constexpr Attribute kAttributes[] = {
    {"/", "case", always, text, "", R::any, "", "the whole resolved case, TOML"},
    {"/", "format_version", newer, natural, "", R::positive, "",
     "number of the format; files without it are of format 1"},
    {"/", "firn_version", always, text, "", R::any, "",
     "written last: a file without it was never begun"},
    {"/", "git_commit", always, text, "", R::any, "", ""},
    {"/", "contact_model", newer, natural, "", R::positive, "",
     "number of the [contact model](contact.md#contact-models); files without it are of model 1"},
    {"/", "seed", always, natural, "", R::any, "", ""},
    {"/", "timestep", always, real, "", R::positive, "", "s"},
    {"/", "status", always, text, "", R::choice, "running|finished|interrupted|failed", ""},
    {"/", "wall_time", always, real, "", R::non_negative, "", "s, over all sessions"},
    {"/", "responses_complete", optional, natural, "", R::flag, "",
     "1 once all responses are there", "measured"},
    {"/responses/<response>", "unit", always, text, "", R::any, "", ""},
    {"/responses/<response>", "method", always, text, "", R::any, "", ""},
    {"/responses/<response>", "method_version", always, natural, "", R::any, "", ""},
    {"/responses/<response>", "uncertainty", always, real, "k", R::non_negative_or_nan, "",
     "one standard deviation; NaN: not known"},
};

constexpr Symbol kSymbols[] = {
    {"N", "/particles/id", false, "particles that will ever exist, in order of their ids"},
    {"T", "/frames/time", true, "frames"},
    {"H", "/shapes/name", false, "shapes"},
    {"O", "/outlets/name", false, "outlets"},
    {"G", "/sensors/name", false, "sensors"},
    {"S", "/stages/name", false, "stages"},
    {"C", "/limit_switches/name", false, "changes of limit switches"},
    {"B", "/bonds/name", false, "bonds"},
    {"A", "/motion_frames/<frame>/coordinate", false, "joints of a free frame"},
    {"E", "/events/start", true, "contacts"},
    {"W", "/statistics/boundary_name", false, "boundaries"},
    {"I", "/statistics/intervals/start", true, "intervals of loads"},
    {"K", "/statistics/energy_spectrum/lower_bound", false, "classes of energy"},
};
struct RenamedText {
  std::string_view path, first, current;
};
constexpr RenamedText kRenamedTexts[] = {
    {"/bonds/break_mode", "whole", "intact"},
    {"/bonds/break_mode", "parted", "removed"},
    {"/stages/end_reason", "at rest", "settled"},
};

// Of meshes, in each group that has one.
constexpr std::string_view kMeshSymbols[][2] = {{"V", "vertices"}, {"P", "triangles"}};

// A path of the schema: what stands before and after the name that it leaves open.
struct Pattern {
  std::string_view before, after;
  bool open = false;

  explicit Pattern(std::string_view path) : before(path) {
    const std::size_t from = path.find('<');
    if (from == std::string_view::npos) return;
    open = true;
    before = path.substr(0, from);
    after = path.substr(path.find('>') + 1);
  }

  std::optional<std::string> name_in(std::string_view path) const {
    if (!open) return path == before ? std::optional<std::string>("") : std::nullopt;
    if (path.size() <= before.size() + after.size() || !path.starts_with(before) ||
        !path.ends_with(after))
      return std::nullopt;
    return std::string(path.substr(before.size(), path.size() - before.size() - after.size()));
  }
  std::string with(std::string_view name) const {
    return open ? fmt::format("{}{}{}", before, name, after) : std::string(before);
  }
};

// Names of files of format 1, from the columns `first_name` of the tables above.
std::string converted_path(const std::string& path, std::string_view Dataset::*from,
                           std::string_view Dataset::*to) {
  for (const Dataset& d : kDatasets) {
    if (d.first_name.empty()) continue;
    if (const std::optional<std::string> name = Pattern(d.*from).name_in(path))
      return Pattern(d.*to).with(*name);
  }
  return path;
}

hdf5::Names first_names() {
  hdf5::Names names;
  names.stored = [](const std::string& path) {
    return converted_path(path, &Dataset::path, &Dataset::first_name);
  };
  names.current = [](const std::string& path) { return current_path(path); };
  names.stored_attribute = [](const std::string& path, const std::string& name) {
    for (const Attribute& a : kAttributes)
      if (!a.first_name.empty() && a.object == path && a.name == name)
        return std::string(a.first_name);
    return name;
  };
  names.current_text = [](const std::string& path, const std::string& value) {
    for (const RenamedText& t : kRenamedTexts)
      if (t.path == path && t.first == value) return std::string(t.current);
    return value;
  };
  return names;
}

std::vector<std::string_view> split(std::string_view list, char separator) {
  std::vector<std::string_view> parts;
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(separator), list.size());
    parts.push_back(list.substr(0, end));
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return parts;
}

const Symbol* symbol_of(std::string_view name) {
  const auto found = std::ranges::find(kSymbols, name, &Symbol::name);
  return found == std::end(kSymbols) ? nullptr : found;
}

// The symbol whose rows a dataset has, when they grow.
const Symbol* growing(const Dataset& d) {
  const Symbol* first = symbol_of(split(d.shape, ',').empty() ? "" : split(d.shape, ',')[0]);
  return first && first->grows ? first : nullptr;
}

bool is_number(Type type) { return type == Type::real || type == Type::integer; }

std::string type_name(Type type) {
  switch (type) {
    case Type::real:
      return "numbers of 64 bits (floating point)";
    case Type::integer:
      return "whole numbers of 32 bits";
    case Type::natural:
      return "whole numbers of 64 bits without sign";
    case Type::byte:
      return "bytes";
    case Type::text:
      return "text";
    case Type::other:
      break;
  }
  return "another type";
}

std::string shape_text(const Shape& shape) {
  return shape.empty() ? "a scalar" : fmt::format("[{}]", fmt::join(shape, ", "));
}

std::string symbols_text(std::string_view shape) {
  if (shape.empty()) return "a scalar";
  if (shape == "k") return "a scalar or a list";
  return fmt::format("[{}]", fmt::join(split(shape, ','), ", "));
}

[[noreturn]] void refuse(std::string_view path, const std::string& what) {
  throw Error(fmt::format("{}: {}", path, what));
}

// Bounds of indices, from lengths that are known.
struct Limits {
  double count = 0;       // one above the largest index
  double boundaries = 0;  // of the rules for bodies
};

// `length` is that of the symbol which the rule names.
Limits limits_of(Rule rule, std::size_t length, std::size_t particles) {
  const auto n = static_cast<double>(length);
  if (rule != R::body && rule != R::body_or_nan) return {n, 0};
  return {static_cast<double>(particles), n};
}

bool is_whole(double v) { return v == std::floor(v); }
bool is_finite(double v) { return std::abs(v) <= kLargestNumber; }

bool keeps(Rule rule, double v, const Limits& limits) {
  switch (rule) {
    case R::any:
      return true;
    case R::finite:
    case R::rotation:
      return is_finite(v);
    case R::positive:
      return v > 0 && is_finite(v);
    case R::non_negative:
    case R::ascending:
      return v >= 0 && is_finite(v);
    case R::finite_or_nan:
    case R::vector_or_nan:
    case R::rotation_or_nan:
      return std::isnan(v) || is_finite(v);
    case R::non_negative_or_nan:
      return std::isnan(v) || (v >= 0 && is_finite(v));
    case R::flag:
      return v == 0 || v == 1;
    case R::batch:
      return v >= -1;
    case R::index:
      return v >= 0 && v < limits.count && is_whole(v);
    case R::index_or_none:
      return v >= -1 && v < limits.count && is_whole(v);
    case R::body:
      return v >= -limits.boundaries && v < limits.count && is_whole(v);
    case R::body_or_nan:
      return std::isnan(v) || keeps(R::body, v, limits);
    case R::counting:
    case R::choice:
      return true;
  }
  return true;
}

std::string range_text(Rule rule, const Limits& limits) {
  switch (rule) {
    case R::any:
      return "any";
    case R::finite:
      return "a finite number";
    case R::positive:
      return "a finite number above 0";
    case R::non_negative:
      return "a finite number, 0 or more";
    case R::ascending:
      return "finite numbers from 0 on, none below the one before";
    case R::finite_or_nan:
      return "a finite number, or NaN";
    case R::vector_or_nan:
      return "finite numbers, or NaN in all of a vector";
    case R::rotation:
      return "a unit quaternion";
    case R::rotation_or_nan:
      return "a unit quaternion, or NaN in all of it";
    case R::non_negative_or_nan:
      return "a finite number, 0 or more, or NaN";
    case R::flag:
      return "0 or 1";
    case R::batch:
      return "-1 or more";
    case R::index:
      return limits.count > 0 ? fmt::format("0 ... {}", limits.count - 1) : "none at all";
    case R::index_or_none:
      return fmt::format("-1 ... {}", limits.count - 1);
    case R::body:
      return fmt::format("{} ... {}", -limits.boundaries, limits.count - 1);
    case R::body_or_nan:
      return range_text(R::body, limits) + ", or NaN";
    case R::counting:
      return "0, 1, 2, ...";
    case R::choice:
      break;
  }
  return "one of the known texts";
}

// The first value that breaks the rule, which may be one for several of them.
std::optional<std::size_t> first_wrong(Rule rule, std::span<const double> v, std::size_t width,
                                       const Limits& limits) {
  for (std::size_t i = 0; i < v.size(); ++i)
    if (!keeps(rule, v[i], limits)) return i;
  if (rule == R::counting) {
    for (std::size_t i = 0; i < v.size(); ++i)
      if (v[i] != static_cast<double>(i)) return i;
  }
  if (rule == R::ascending) {
    for (std::size_t i = 1; i < v.size(); ++i)
      if (v[i] < v[i - 1]) return i;
  }
  const bool is_rotation = rule == R::rotation || rule == R::rotation_or_nan;
  if (!is_rotation && rule != R::vector_or_nan) return std::nullopt;
  constexpr double kUnit = 1e-3;  // of the squared length
  for (std::size_t i = 0; i + width <= v.size(); i += width) {
    std::size_t absent = 0;
    double square = 0;
    for (std::size_t k = i; k < i + width; ++k) {
      absent += std::isnan(v[k]);
      square += v[k] * v[k];
    }
    if (absent == width) continue;
    if (absent > 0 || (is_rotation && std::abs(square - 1) > kUnit)) return i;
  }
  return std::nullopt;
}

std::string place_text(std::size_t at, const Shape& shape, std::size_t first_row) {
  if (shape.empty()) return "its value";
  std::vector<std::size_t> place(shape.size());
  for (std::size_t k = shape.size(); k-- > 0;) {
    const std::size_t n = k == 0 ? at + 1 : std::max<std::size_t>(shape[k], 1);
    place[k] = at % n + (k == 0 ? first_row : 0);
    at /= n;
  }
  return shape.size() == 1 ? fmt::format("entry {}", place[0])
                           : fmt::format("entry [{}]", fmt::join(place, ", "));
}

void check_numbers(std::string_view path, Rule rule, std::span<const double> values,
                   const Shape& shape, const Limits& limits, std::size_t first_row) {
  const std::size_t width = shape.empty() ? 1 : shape.back();
  if (const auto wrong = first_wrong(rule, values, width, limits))
    refuse(path, fmt::format("{} is {:.9g}; expected {}", place_text(*wrong, shape, first_row),
                             values[*wrong], range_text(rule, limits)));
}

bool is_choice(std::string_view value, std::string_view choices) {
  return std::ranges::any_of(split(choices, '|'), [&](std::string_view one) {
    return value == one || (value.starts_with(one) && value.substr(one.size()).starts_with(": "));
  });
}

std::string choices_text(std::string_view choices) {
  return fmt::format("{}", fmt::join(split(choices, '|'), ", "));
}

// Looks at a file part after part; each may rely on those before it.
class Check {
 public:
  explicit Check(const hdf5::File& file) : file_(file) {}

  Contents all() {
    if (!file_.has_attribute("/", "firn_version"))
      throw Error("no attribute firn_version; expected a file written by firn run");
    find_datasets();
    check_presence();
    check_attributes("/", "/", {});
    check_format();
    contents_.finished = file_.text_attribute("/", "status") == "finished";
    for (const Found& found : found_) check_kind(found);
    find_lengths();
    for (const Found& found : found_) check_shape(found);
    for (const Found& found : found_) check_storage(found);
    for (const Found& found : found_) check_attributes_of(found);
    for (const Found& found : found_)
      if (!growing(*found.dataset)) check_contents(found);
    cut_back();
    return std::move(contents_);
  }

 private:
  void check_format() const {
    if (!file_.has_attribute("/", "format_version")) return;
    if (const auto format = file_.integer_attribute("/", "format_version"); format != kFormat)
      refuse("/",
             fmt::format("is of format {}; expected {} or no format_version", format, kFormat));
  }

  struct Found {
    const Dataset* dataset;
    const hdf5::Object* object;
    std::string name;  // that the path of the schema leaves open
  };

  void find_datasets() {
    objects_ = file_.objects();
    for (const hdf5::Object& object : objects_) {
      for (const Dataset& d : kDatasets) {
        const std::optional<std::string> name = Pattern(d.path).name_in(object.path);
        // A group may be on the way to a dataset whose name has a slash.
        if (!name || (object.is_group && Pattern(d.path).open)) continue;
        if (object.is_group) refuse(object.path, "is a group; expected a dataset");
        if (d.path == "/states/<step>" &&
            name->find_first_not_of("0123456789") != std::string::npos)
          refuse(object.path, "is no number of a step; expected digits");
        found_.push_back({&d, &object, *name});
        contents_.datasets.emplace(object.path, &d);
        contents_.shapes.emplace(object.path, object.shape);
        break;
      }
    }
  }

  bool has(const std::string& path) const { return contents_.datasets.contains(path); }

  void check_presence() const {
    for (const Dataset& d : kDatasets)
      if (d.presence == always && !has(std::string(d.path)))
        refuse(d.path, fmt::format("is missing; expected {}", type_name(d.type)));
    for (const Found& found : found_) {
      const std::string with = Pattern(found.dataset->with).with(found.name);
      if (!with.empty() && !has(with))
        refuse(found.object->path, fmt::format("is there without {}; expected both", with));
      for (const Dataset& other : kDatasets) {
        if (other.presence != together || other.with != found.dataset->path) continue;
        const std::string path = Pattern(other.path).with(found.name);
        if (!has(path))
          refuse(path, fmt::format("is missing; expected it together with {}", found.object->path));
      }
    }
  }

  static void check_kind(const Found& found) {
    const hdf5::Object& o = *found.object;
    const Dataset& d = *found.dataset;
    if (o.type != d.type)
      refuse(o.path, fmt::format("holds {}; expected {}", type_name(o.type), type_name(d.type)));
    if (!o.has_space)
      refuse(o.path, fmt::format("has no values and no shape; expected {}", symbols_text(d.shape)));
    const std::size_t rank = split(d.shape, ',').size();
    if (d.shape == "k" ? o.shape.size() > 1 : o.shape.size() != rank)
      refuse(o.path, fmt::format("has the wrong shape, {}; expected {}", shape_text(o.shape),
                                 symbols_text(d.shape)));
  }

  static std::string group_of(const std::string& path) {
    return path.substr(0, path.rfind('/') + 1);
  }

  // Lengths of a file, and those within a group under the group's path and the symbol's name.
  void find_lengths() {
    for (const Found& found : found_) {
      const std::vector<std::string_view> extents = split(found.dataset->shape, ',');
      for (const Symbol& s : kSymbols) {
        if (s.anchor != found.dataset->path) continue;
        const auto at = std::ranges::find(extents, s.name) - extents.begin();
        known_[key(s.name, found.object->path)] = {
            found.object->shape[static_cast<std::size_t>(at)], found.object->path};
      }
      for (const auto& [symbol, dataset] : kMeshSymbols)
        if (found.object->path.ends_with(fmt::format("/{}", dataset)))
          known_[key(symbol, found.object->path)] = {found.object->shape[0], found.object->path};
    }
    for (const Symbol& s : kSymbols)
      if (const auto length = known_.find(s.name); length != known_.end())
        contents_.lengths.emplace(s.name, length->second.count);
    contents_.particles = contents_.lengths.at("N");
    if (contents_.particles == 0) refuse("/particles/id", "is empty; expected particles");
  }

  static std::string key(std::string_view symbol, const std::string& path) {
    const Symbol* s = symbol_of(symbol);
    const bool local = !s || Pattern(s->anchor).open;
    return local ? group_of(path) + std::string(symbol) : std::string(symbol);
  }

  struct Length {
    std::size_t count = 0;
    std::string anchor;
  };

  // Of a symbol in the shape or the rule of a dataset.
  const Length& length(std::string_view symbol, const std::string& path) const {
    const auto found = known_.find(key(symbol, path));
    if (found != known_.end()) return found->second;
    const Symbol* s = symbol_of(symbol);
    refuse(path, fmt::format("is there without {}; expected both",
                             s ? std::string(s->anchor) : "the mesh that it belongs to"));
  }

  void check_shape(const Found& found) const {
    const Shape& shape = found.object->shape;
    const std::string& path = found.object->path;
    if (found.dataset->shape == "k" || found.dataset->shape == "b") return;
    const std::vector<std::string_view> extents = split(found.dataset->shape, ',');
    Shape expected = shape;
    std::string as;  // the dataset that says so
    for (std::size_t k = 0; k < extents.size(); ++k) {
      std::string_view symbol = extents[k];
      if (symbol[0] >= '0' && symbol[0] <= '9' && symbol.size() == 1) {
        expected[k] = static_cast<std::size_t>(symbol[0] - '0');
        continue;
      }
      std::size_t more = 0;
      if (symbol.starts_with("1+")) {
        more = 1;
        symbol.remove_prefix(2);
      }
      const Length& is = length(symbol, path);
      const Symbol* s = symbol_of(symbol);
      // A writer that was killed leaves tables of different lengths.
      if (s && s->grows && !contents_.finished) continue;
      expected[k] = is.count + more;
      if (expected[k] != shape[k] && as.empty()) as = is.anchor;
    }
    if (expected == shape) return;
    const std::string source = as.empty() ? "" : ", as " + as;
    if (shape.size() == 1)
      refuse(path, fmt::format("has {} entr{}; expected {}{}", shape[0],
                               shape[0] == 1 ? "y" : "ies", expected[0], source));
    refuse(path, fmt::format("has the wrong shape, {}; expected {}{}", shape_text(shape),
                             shape_text(expected), source));
  }

  void check_storage(const Found& found) {
    const std::string& path = found.object->path;
    const auto [written, in_chunks] = file_.check_storage(path);
    const Symbol* s = growing(*found.dataset);
    // Their values are read later, and chunks are read without the library's help.
    if ((s || found.dataset->type == byte) && !in_chunks)
      refuse(path, "is kept in one piece; expected chunks");
    if (!s) return;
    if (written > 0) file_.read_rows(path, 0, 1);  // the way that readers take
    if (contents_.finished && written < found.object->shape[0])
      refuse(path,
             fmt::format("lacks the values of row {}; expected all of a finished run", written));
    const auto [rows, is_first] = contents_.rows.emplace(s->name, written);
    if (!is_first) rows->second = std::min(rows->second, written);
  }

  void check_attributes(const std::string& path, std::string_view object,
                        const Shape& shape) const {
    for (const Attribute& a : kAttributes) {
      if (a.object != object) continue;
      const std::string name(a.name);
      const std::string what = fmt::format("the attribute {} ", name);
      if (!file_.has_attribute(path, name)) {
        if (a.presence == always) refuse(path, what + "is missing; expected " + type_name(a.type));
        continue;
      }
      const hdf5::Attribute is = file_.attribute(path, name);
      if (is.type != a.type)
        refuse(path,
               what + fmt::format("holds {}; expected {}", type_name(is.type), type_name(a.type)));
      const Shape expected = a.shape == "k" ? shape : Shape{};
      if (!is.has_space || is.shape != expected)
        refuse(path, what + fmt::format("has the wrong shape; expected {}", shape_text(expected)));
      if (a.type == text) {
        const std::string value = file_.text_attribute(path, name);
        if (a.rule == R::choice && !is_choice(value, a.limit))
          refuse(path,
                 what + fmt::format("is \"{}\"; expected one of {}", value, choices_text(a.limit)));
        continue;
      }
      const std::vector<double> values = file_.number_attribute(path, name);
      if (const auto wrong = first_wrong(a.rule, values, 1, {}))
        refuse(path, what + fmt::format("is {:.9g}; expected {}", values[*wrong],
                                        range_text(a.rule, {})));
    }
  }

  void check_attributes_of(const Found& found) const {
    const std::string& path = found.object->path;
    check_attributes(path, found.dataset->path, found.object->shape);
    const std::string_view unit = found.dataset->unit;
    if (unit.empty()) return;
    if (!file_.has_attribute(path, "unit")) {
      if (growing(*found.dataset))
        refuse(path, fmt::format("the attribute unit is missing; expected \"{}\"", unit));
      return;
    }
    const hdf5::Attribute is = file_.attribute(path, "unit");
    if (is.type != text || !is.has_space || !is.shape.empty())
      refuse(path, fmt::format("the attribute unit is no single text; expected \"{}\"", unit));
    if (const std::string value = file_.text_attribute(path, "unit"); value != unit)
      refuse(path, fmt::format("the attribute unit is \"{}\"; expected \"{}\"", value, unit));
  }

  Limits limits_of(const Dataset& d, const std::string& path) const {
    if (d.limit.empty() || d.rule == R::choice) return {};
    return results::limits_of(d.rule, length(d.limit, path).count, contents_.particles);
  }

  void check_contents(const Found& found) const {
    const Dataset& d = *found.dataset;
    const std::string& path = found.object->path;
    if (d.type == text) {
      for (const std::string& value : file_.read_strings(path))
        if (d.rule == R::choice && !is_choice(value, d.limit))
          refuse(path, fmt::format("has \"{}\"; expected one of {}", value, choices_text(d.limit)));
      return;
    }
    if (!is_number(d.type)) return;
    std::vector<double> values;
    if (d.type == integer) {
      const std::vector<int> numbers = file_.read<int>(path);
      values.assign(numbers.begin(), numbers.end());
    } else {
      values = file_.read<double>(path);
    }
    check_numbers(path, d.rule, values, found.object->shape, limits_of(d, path), 0);
  }

  // How many rows of what grows are whole.
  void cut_back() {
    std::size_t& frames = contents_.rows.at("T");
    const std::vector<double> times = file_.read_rows("/frames/time", 0, frames);
    // A writer killed in the middle of a flush leaves rows whose time never arrived.
    if (!contents_.finished)
      while (frames > 0 && std::isnan(times[frames - 1])) --frames;
    check_numbers("/frames/time", R::ascending, std::span(times).first(frames), {frames}, {}, 0);
    contents_.frames = frames;
    if (contents_.finished) return;
    for (const auto& [symbol, path] :
         {std::pair{"E", "/events/body_a"}, {"I", "/statistics/intervals/end"}}) {
      const auto rows = contents_.rows.find(symbol);
      if (rows == contents_.rows.end()) continue;
      const std::vector<double> values = file_.read_rows(path, 0, rows->second);
      rows->second = static_cast<std::size_t>(
          std::ranges::find_if(values, [](double v) { return std::isnan(v); }) - values.begin());
    }
  }

  const hdf5::File& file_;
  std::vector<hdf5::Object> objects_;
  std::vector<Found> found_;
  std::map<std::string, Length, std::less<>> known_;
  Contents contents_;
};

std::string presence_text(const Dataset& d) {
  switch (d.presence) {
    case always:
      return "always";
    case newer:
      return "always, but for files of older builds";
    case together:
      return fmt::format("with `{}`", d.with);
    case optional:
      break;
  }
  return d.with.empty() ? "if the case has any" : fmt::format("may be, with `{}`", d.with);
}

std::string_view type_word(Type type) {
  switch (type) {
    case Type::real:
      return "float64";
    case Type::integer:
      return "int32";
    case Type::natural:
      return "uint64";
    case Type::byte:
      return "uint8";
    default:
      return "text";
  }
}

std::string rule_text(Rule rule, std::string_view limit) {
  switch (rule) {
    case R::any:
      return "";
    case R::finite:
      return "finite";
    case R::positive:
      return "> 0";
    case R::non_negative:
      return ">= 0";
    case R::finite_or_nan:
    case R::vector_or_nan:
      return "finite or NaN";
    case R::non_negative_or_nan:
      return ">= 0 or NaN";
    case R::rotation:
      return "unit length";
    case R::rotation_or_nan:
      return "unit length or NaN";
    case R::ascending:
      return ">= 0, not falling";
    case R::counting:
      return "0, 1, 2, ...";
    case R::flag:
      return "0 or 1";
    case R::batch:
      return ">= -1";
    case R::index:
      return fmt::format("0 ... {} - 1", limit);
    case R::index_or_none:
      return fmt::format("-1 ... {} - 1", limit);
    case R::body:
      return fmt::format("-{} ... N - 1", limit);
    case R::body_or_nan:
      return fmt::format("-{} ... N - 1 or NaN", limit);
    case R::choice:
      break;
  }
  std::string texts;
  for (const std::string_view one : split(limit, '|'))
    texts += fmt::format("{}`{}`", texts.empty() ? "" : ", ", one);
  return texts;
}

std::string shape_word(std::string_view shape) {
  if (shape.empty()) return "";
  if (shape == "k") return "scalar or [k]";
  return fmt::format("[{}]", fmt::join(split(shape, ','), ", "));
}

}  // namespace

std::span<const Dataset> datasets() { return kDatasets; }
std::span<const Attribute> attributes() { return kAttributes; }
std::span<const Symbol> symbols() { return kSymbols; }

std::optional<std::size_t> Contents::growing_rows(std::string_view path) const {
  const auto known = datasets.find(path);
  const Symbol* s = known == datasets.end() ? nullptr : growing(*known->second);
  return s ? std::optional(rows.find(s->name)->second) : std::nullopt;
}

std::string current_path(const std::string& path) {
  return converted_path(path, &Dataset::first_name, &Dataset::path);
}

hdf5::File open_file(const std::string& path, hdf5::File::Access access) {
  hdf5::File file = hdf5::File::open(path, access);
  if (!file.has_attribute("/", "format_version")) file.use_names(first_names());
  return file;
}

Contents check_file(const hdf5::File& file) { return Check(file).all(); }

void check_values(const Contents& contents, const std::string& path, std::span<const double> values,
                  std::size_t first) {
  const auto known = contents.datasets.find(path);
  if (known == contents.datasets.end()) return;
  const Dataset& d = *known->second;
  Limits limits;
  if (const auto length = contents.lengths.find(d.limit); length != contents.lengths.end())
    limits = limits_of(d.rule, length->second, contents.particles);
  check_numbers(path, d.rule, values, contents.shapes.at(path), limits, first);
}

void check_case(const Contents& contents, const hdf5::File& file, const Case& c) {
  const auto expect = [&](std::string_view symbol, std::size_t count, std::string_view what) {
    const auto length = contents.lengths.find(symbol);
    if (length == contents.lengths.end() || length->second == count) return;
    refuse(symbol_of(symbol)->anchor,
           fmt::format("has {} entries; expected {}, the {} of the case in the file",
                       length->second, count, what));
  };
  expect("N", c.model.particles.size(), "particles");
  expect("H", c.model.shapes.size(), "shapes");
  expect("O", c.outlets.size(), "outlets");
  expect("B", c.model.bonds.size(), "bonds");
  expect("W", c.model.boundaries.size(), "boundaries");
  expect("G", c.sensors.size(), "sensors");
  if (contents.datasets.contains("/sensors/name")) {
    const std::vector<std::string> names = file.read_strings("/sensors/name");
    for (std::size_t g = 0; g < names.size(); ++g)
      if (names[g] != c.sensors[g].name)
        refuse("/sensors/name",
               fmt::format("entry {} is \"{}\"; expected \"{}\", as the case in the "
                           "file",
                           g, names[g], c.sensors[g].name));
  }
  for (const Column& column : result_columns(c.model)) {
    const auto shape = contents.shapes.find(column.path);
    if (shape == contents.shapes.end()) continue;
    Shape expected{shape->second[0]};
    expected.insert(expected.end(), column.row.begin(), column.row.end());
    if (shape->second != expected)
      refuse(column.path,
             fmt::format("has the wrong shape, {}; expected {}, as the case in the file",
                         shape_text(shape->second), shape_text(expected)));
  }
}

std::string description() {
  std::string out = "Lengths: ";
  for (const Symbol& s : kSymbols)
    out += fmt::format("{}**{}** {}", &s == std::begin(kSymbols) ? "" : "; ", s.name, s.meaning);
  out +=
      "; of a mesh **V** its vertices and **P** its triangles.\n\n"
      "| attribute | type | values | meaning |\n|---|---|---|---|\n";
  for (const Attribute& a : kAttributes)
    out += fmt::format("| `{}` of `{}` | {} | {} | {} |\n", a.name, a.object,
                       shape_word(a.shape).empty()
                           ? std::string(type_word(a.type))
                           : fmt::format("{} {}", type_word(a.type), shape_word(a.shape)),
                       rule_text(a.rule, a.limit), a.meaning);
  out += "\n| dataset | shape, type, unit | values | present | meaning |\n|---|---|---|---|---|\n";
  for (const Dataset& d : kDatasets)
    out += fmt::format("| `{}` | {} {}{} | {} | {} | {} |\n", d.path, shape_word(d.shape),
                       type_word(d.type),
                       d.unit.empty() || d.unit == "1" ? "" : fmt::format(" {}", d.unit),
                       rule_text(d.rule, d.limit), presence_text(d), d.meaning);
  out += "\n| name | in files of format 1 |\n|---|---|\n";
  for (const Dataset& d : kDatasets)
    if (!d.first_name.empty()) out += fmt::format("| `{}` | `{}` |\n", d.path, d.first_name);
  for (const Attribute& a : kAttributes)
    if (!a.first_name.empty())
      out += fmt::format("| `{}` of `{}` | `{}` |\n", a.name, a.object, a.first_name);
  for (const RenamedText& t : kRenamedTexts)
    out += fmt::format("| `{}` in `{}` | `{}` |\n", t.current, t.path, t.first);
  return out;
}

}  // namespace firn::results
