#include "experiments/text/toml_aliases.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "experiments/text/response_aliases.h"
#include "experiments/text/toml_messages.h"

namespace firn {
namespace {

using toml_text::join_path;
using toml_text::line_of;

constexpr TomlFormat kCase = TomlFormat::case_file;
constexpr TomlFormat kMeasurement = TomlFormat::measurement;
constexpr TomlFormat kBench = TomlFormat::bench_tests;
constexpr TomlFormat kStudy = TomlFormat::study;
constexpr TomlFormat kSuite = TomlFormat::suite;

constexpr TomlAlias kKeys[] = {
    {kCase, "", "sources", "inlets"},
    {kCase, "", "gates", "sensors"},
    {kCase, "", "tags", "tag_rules"},
    {kCase, "", "switches", "limit_switches"},
    {kCase, "", "start", "initial_state"},
    {kCase, "case", "steps_per_quarter_period", "steps_per_loading"},
    {kCase, "numerics", "contact_shell", "contact_margin"},
    {kCase, "numerics", "shell_limit", "contact_margin_limit"},
    {kCase, "numerics", "refresh_fraction", "contact_update_fraction"},
    {kCase, "output", "frames_every", "frame_interval"},
    {kCase, "output", "states_every", "state_interval"},
    {kCase, "shapes.*", "size_for_stiffness", "stiffness_length"},
    {kCase, "shapes.*", "tip", "tip_height"},
    {kCase, "shapes.*", "dish", "top_concavity_depth"},
    {kCase, "interactions.*", "unloading_floor", "minimum_unloading_ratio"},
    {kCase, "interactions.*", "sliding_speed", "restick_velocity"},
    {kCase, "boundary_contacts[]", "unloading_floor", "minimum_unloading_ratio"},
    {kCase, "boundary_contacts[]", "sliding_speed", "restick_velocity"},
    {kCase, "boundaries[]", "may_touch", "allow_overlap_with"},
    {kCase, "boundaries[]", "tip", "tip_height"},  // of molds
    {kCase, "boundaries[]", "dish", "top_concavity_depth"},
    {kCase, "boundaries[].motions[]", "every", "period"},
    {kCase, "boundaries[].motions[]", "ways", "positions"},
    {kCase, "boundaries[].motions[]", "way_column", "position_column"},
    {kCase, "motion_frames[].motions[]", "every", "period"},
    {kCase, "motion_frames[].motions[]", "ways", "positions"},
    {kCase, "motion_frames[].motions[]", "way_column", "position_column"},
    {kCase, "motion_frames[].free", "turns_freely", "free_rotation"},
    {kCase, "motion_frames[].free", "axes", "joints"},
    {kCase, "motion_frames[].free.joints[]", "drives", "motors"},
    {kCase, "motion_frames[].free.joints[]", "rest", "spring_reference"},
    {kCase, "motion_frames[].free.joints[]", "stop_restitution", "limit_restitution"},
    {kCase, "motion_frames[].free.joints[].motors[]", "every", "period"},
    {kCase, "motion_frames[].free.joints[].motors[]", "to", "target"},
    {kCase, "motion_frames[].free.joints[].motors[]", "limit", "max_load"},
    {kCase, "stages[]", "until", "end_when"},
    {kCase, "stages[]", "rest_kinetic_energy", "settle_energy"},
    {kCase, "stages[]", "rest_hold", "settle_time"},
    {kCase, "stages[]", "gate", "sensor"},
    {kCase, "stages[]", "remove", "remove_boundaries"},
    {kCase, "stages[]", "drives", "motors"},
    {kCase, "stages[].motions[]", "every", "period"},
    {kCase, "stages[].motions[]", "ways", "positions"},
    {kCase, "stages[].motions[]", "way_column", "position_column"},
    {kCase, "stages[].motors[]", "every", "period"},
    {kCase, "stages[].motors[]", "to", "target"},
    {kCase, "stages[].motors[]", "limit", "max_load"},
    {kCase, "experiment.fill", "rest_kinetic_energy", "settle_energy"},
    {kCase, "experiment.fill", "rest_hold", "settle_time"},
    {kCase, "experiment.drain", "rest_kinetic_energy", "settle_energy"},
    {kCase, "experiment.drain", "rest_hold", "settle_time"},
    {kCase, "particles[]", "scatter", "position_jitter"},
    {kCase, "particles[]", "turn", "rotation_jitter"},
    {kCase, "particles[]", "turn_axis", "rotation_jitter_axis"},
    {kCase, "inlets[]", "scatter", "position_jitter"},
    {kCase, "inlets[]", "turn", "rotation_jitter"},
    {kCase, "inlets[]", "turn_axis", "rotation_jitter_axis"},
    {kCase, "fills[]", "tag_by", "tag_mode"},
    {kCase, "inlets[]", "tag_by", "tag_mode"},
    {kCase, "tag_rules[]", "columns", "bins"},
    {kCase, "initial_state.motion_frames[]", "spin", "relative_angular_velocity"},
    {kCase, "limit_switches[]", "hold", "hold_time"},
    {kCase, "bonds[]", "source", "inlet"},
    {kCase, "statistics", "merge", "merge_gap"},
    {kCase, "statistics", "energies", "energy_spectrum"},
    {kCase, "statistics", "triangles", "boundary_maps"},
    {kCase, "statistics", "surfaces", "particle_maps"},
    {kCase, "statistics", "opposed_loads", "compressive_loads"},
    {kCase, "measure[]", "run", "tip_window"},
    {kCase, "measure[]", "tip_turn", "tip_rotation"},
    {kCase, "material_records[]", "anchor", "reference_set"},
    {kCase, "material_records[]", "sets", "applied_keys"},

    {kMeasurement, "", "reading", "systematic"},
    {kMeasurement, "", "claims", "criteria"},
    {kMeasurement, "systematic", "because", "rationale"},
    {kMeasurement, "data", "at_least", "right_censored"},
    {kMeasurement, "scatter", "assumed_because", "assumption"},
    {kMeasurement, "criteria[]", "larger", "lhs"},
    {kMeasurement, "criteria[]", "than", "rhs"},
    {kMeasurement, "criteria[]", "times", "factor"},
    {kMeasurement, "criteria[]", "once_in", "observed_once_in"},
    {kMeasurement, "criteria[]", "because", "rationale"},

    {kBench, "tests[]", "tells", "informs"},
    {kBench, "tests[]", "with", "extends_test"},
    {kBench, "tests[]", "per_repeat", "time_per_repeat"},
    {kBench, "tests[]", "because", "rationale"},
    {kBench, "tests[].responses[]", "reading", "systematic_uncertainty"},
    {kBench, "tests[].responses[]", "because", "rationale"},

    {kStudy, "budget", "centre_runs", "center_replicates"},
    {kStudy, "budget", "numerics_runs", "numerics_replicates"},
    {kStudy, "budget", "runs_per_point", "replicates_per_point"},
    {kStudy, "budget", "confirm_runs", "confirmation_replicates"},
    {kStudy, "budget", "anchor_runs", "endpoint_replicates"},
    {kStudy, "budget", "compare_runs", "compare_replicates"},
    {kStudy, "budget", "least_gain", "min_improvement"},

    {kSuite, "comparisons[]", "made_to_match", "calibrated_by_design"},
    {kSuite, "comparisons[]", "expects", "expected_outcome"},
};

constexpr TomlAlias kWords[] = {
    {kCase, "shapes.*", "table1-heavy", "table1-mass-override", "variant"},
    {kCase, "boundaries[]", "table1-heavy", "table1-mass-override", "variant"},
    {kCase, "stages[]", "at_rest", "settled", "end_when"},
    {kCase, "inlets[]", "source", "inlet", "tag_mode"},
    {kCase, "measure[]", "slip", "sliding_onset", "kind"},
    {kCase, "measure[]", "drive", "motor_load", "y"},
    {kMeasurement, "", "printed", "published", "status"},
    {kMeasurement, "", "digitised", "digitized", "status"},
    {kSuite, "comparisons[]", "claims", "criteria", "kind"},
    {kSuite, "comparisons[]", "damage", "breakage", "kind"},
    {kSuite, "comparisons[]", "softening", "stiffness_scaling", "kind"},
    {kSuite, "comparisons[]", "choices", "numerical_variants", "kind"},
    {kSuite, "comparisons[]", "damage", "breakage", "expected_outcome"},
    {kSuite, "comparisons[]", "no damage", "no breakage", "expected_outcome"},
};

// The aliases that apply to a table and those below it. `rest`: the path still to go.
struct Pending {
  const TomlAlias* alias;
  std::string_view rest;
};
using Active = std::vector<Pending>;

Active all_of(TomlFormat format) {
  static const auto lists = [] {
    std::vector<Active> lists(static_cast<std::size_t>(TomlFormat::suite) + 1);
    for (const std::span<const TomlAlias> table :
         {std::span<const TomlAlias>(kKeys), std::span<const TomlAlias>(kWords)})
      for (const TomlAlias& a : table)
        lists[static_cast<std::size_t>(a.document)].push_back({&a, a.path});
    return lists;
  }();
  return lists[static_cast<std::size_t>(format)];
}

// Those that apply below `key`; `array`: whether some say that it is an array.
Active below(const Active& active, std::string_view key, bool* array = nullptr) {
  Active result;
  for (const Pending& p : active) {
    if (p.rest.empty()) continue;
    const std::size_t end = std::min(p.rest.find('.'), p.rest.size());
    std::string_view first = p.rest.substr(0, end);
    const bool list = first.ends_with("[]");
    if (list) first.remove_suffix(2);
    if (first != "*" && first != key) continue;
    if (array != nullptr && list) *array = true;
    result.push_back({p.alias, p.rest.substr(std::min(end + 1, p.rest.size()))});
  }
  return result;
}

bool applies(const Pending& p) { return p.rest.empty(); }

void move_key(toml::table& table, std::string_view from, std::string_view to) {
  const auto found = table.find(from);
  const toml::key key(to, found->first.source());
  table.insert(key, std::move(found->second));  // a copy would lose its place
  table.erase(from);
}

// Replaces `from` where a string, or a string of a list, is it. Returns the first; null: none was.
const toml::node* replace_word(toml::node& node, std::string_view from, std::string_view to) {
  if (toml::value<std::string>* text = node.as_string()) {
    if (text->get() != from) return nullptr;
    *text = std::string(to);
    return text;
  }
  const toml::node* first = nullptr;
  if (toml::array* list = node.as_array())
    for (toml::node& element : *list)
      if (toml::value<std::string>* text = element.as_string(); text && text->get() == from) {
        *text = std::string(to);
        if (first == nullptr) first = text;
      }
  return first;
}

void modernize(toml::table& table, const Active& active, const std::string& path,
               const std::function<void(const OldNameUse&)>& report) {
  for (const Pending& p : active) {
    const TomlAlias& r = *p.alias;
    if (!applies(p) || !r.key.empty() || !table.contains(r.old_name)) continue;
    const bool both = table.contains(r.name);
    const OldNameUse use{join_path(path, r.old_name), line_of(*table.get(r.old_name)),
                         std::string(r.old_name), std::string(r.name), both};
    if (!both) move_key(table, r.old_name, r.name);
    report(use);
  }
  for (const Pending& p : active) {
    const TomlAlias& r = *p.alias;
    if (!applies(p) || r.key.empty()) continue;
    toml::node* node = table.get(r.key);
    const toml::node* word = node == nullptr ? nullptr : replace_word(*node, r.old_name, r.name);
    if (word != nullptr)
      report({join_path(path, r.key), line_of(*word), std::string(r.old_name), std::string(r.name),
              false});
  }
  for (auto&& [key, value] : table) {
    const Active inner = below(active, key.str());
    if (inner.empty()) continue;
    const std::string inside = join_path(path, key.str());
    if (toml::table* t = value.as_table()) {
      modernize(*t, inner, inside, report);
    } else if (toml::array* list = value.as_array()) {
      for (std::size_t i = 0; i < list->size(); ++i)
        if (toml::table* element = list->get(i)->as_table())
          modernize(*element, inner, fmt::format("{}.{}", inside, i), report);
    }
  }
}

void restore(toml::table& table, const Active& active) {
  for (auto&& [key, value] : table) {
    const Active inner = below(active, key.str());
    if (inner.empty()) continue;
    if (toml::table* t = value.as_table()) {
      restore(*t, inner);
    } else if (toml::array* list = value.as_array()) {
      for (toml::node& element : *list)
        if (toml::table* one = element.as_table()) restore(*one, inner);
    }
  }
  for (const Pending& p : active)
    if (applies(p) && !p.alias->key.empty())
      if (toml::node* node = table.get(p.alias->key))
        replace_word(*node, p.alias->name, p.alias->old_name);
  for (const Pending& p : active)
    if (applies(p) && p.alias->key.empty() && table.contains(p.alias->name))
      move_key(table, p.alias->name, p.alias->old_name);
}

// Keys of a path with their renames; `convert` returns the other name of a key, if it has one.
template <class Convert, class Visit>
void walk_path(std::vector<std::string>& keys, Convert convert, Visit visit) {
  Active active = all_of(TomlFormat::case_file);
  for (std::size_t i = 0; i < keys.size() && !active.empty(); ++i) {
    const auto found = std::ranges::find_if(active, [&](const Pending& p) {
      return applies(p) && p.alias->key.empty() && convert(*p.alias).first == keys[i];
    });
    std::string current = keys[i];
    if (found != active.end()) {
      current = found->alias->name;
      visit(i, *found->alias);
      keys[i] = convert(*found->alias).second;
    }
    bool array = false;
    active = below(active, current, &array);
    if (array) ++i;  // an index or a name
  }
}

// A dotted path without quoted keys; quoted ones have no renamed keys below them to find.
std::vector<std::string> keys_of(const std::string& path) {
  std::vector<std::string> keys;
  bool quoted = false;
  std::string key;
  for (const char c : path) {
    if (c == '"') quoted = !quoted;
    if (c == '.' && !quoted)
      keys.push_back(std::exchange(key, {}));
    else
      key += c;
  }
  keys.push_back(key);
  return keys;
}

template <class Convert>
std::string converted(const std::string& path, Convert convert) {
  std::vector<std::string> keys = keys_of(path);
  bool changed = false;
  walk_path(keys, convert, [&](std::size_t, const TomlAlias&) { changed = true; });
  if (!changed) return path;
  std::string text;
  for (const std::string& key : keys) text += (text.empty() ? "" : ".") + key;
  return text;
}

const auto kToCurrent = [](const TomlAlias& r) { return std::pair(r.old_name, r.name); };
const auto kToFirst = [](const TomlAlias& r) { return std::pair(r.name, r.old_name); };

}  // namespace

std::span<const TomlAlias> renamed_keys() { return kKeys; }
std::span<const TomlAlias> renamed_words() { return kWords; }

void use_current_names(TomlFormat format, toml::table& root,
                       const std::function<void(const OldNameUse&)>& report) {
  modernize(root, all_of(format), "", report);
}

namespace {

// Responses that a study names, those of the user's programs included: the identity alone uses
// them.
void use_first_responses(toml::table& root) {
  for (const std::string_view list : {"targets", "observe"})
    if (toml::array* tables = root[list].as_array())
      for (toml::node& element : *tables)
        if (toml::table* table = element.as_table())
          if (toml::value<std::string>* text = (*table)["response"].as_string())
            *text = first_response_name(text->get());
}

// Paths into cases that a study gives.
void use_first_paths(toml::table& table) {
  std::vector<std::pair<std::string, std::string>> moved;
  for (auto&& [key, value] : table) {
    toml::table* inner = value.as_table();
    toml::array* list = value.as_array();
    if (key.str() == "set" && inner != nullptr) {
      for (const auto& [path, text] : *inner)
        if (std::string first = first_case_path(std::string(path.str()));
            first != path.str() && !inner->contains(first))
          moved.emplace_back(path.str(), std::move(first));
      for (const auto& [from, to] : moved) move_key(*inner, from, to);
      moved.clear();
    } else if (inner != nullptr) {
      use_first_paths(*inner);
    } else if (list != nullptr) {
      for (toml::node& element : *list) {
        if (toml::table* one = element.as_table()) use_first_paths(*one);
        if (toml::value<std::string>* text = element.as_string(); text && key.str() == "keys")
          *text = first_case_path(text->get());
      }
    }
  }
}

}  // namespace

void use_first_names(TomlFormat format, toml::table& root) {
  if (format == TomlFormat::study) {
    use_first_paths(root);
    use_first_responses(root);
  }
  if (format == TomlFormat::case_file)
    if (toml::array* records = root["material_records"].as_array())
      for (toml::node& record : *records)
        if (toml::table* t = record.as_table())
          if (toml::array* keys = (*t)["applied_keys"].as_array())
            for (toml::node& key : *keys)
              if (toml::value<std::string>* text = key.as_string())
                *text = first_case_path(text->get());
  restore(root, all_of(format));
}

void use_current_names(std::vector<std::string>& keys,
                       const std::function<void(const OldNameUse&)>& report) {
  const std::string path = fmt::format("{}", fmt::join(keys, "."));
  walk_path(keys, kToCurrent, [&](std::size_t, const TomlAlias& r) {
    report({path, 0, std::string(r.old_name), std::string(r.name), false});
  });
}

std::string current_case_path(const std::string& path) { return converted(path, kToCurrent); }
std::string first_case_path(const std::string& path) { return converted(path, kToFirst); }

}  // namespace firn
