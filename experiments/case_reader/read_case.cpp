#include "experiments/case_reader/read_case.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "experiments/case/case.h"
#include "experiments/case_reader/initial_state.h"
#include "experiments/case_reader/material_values.h"
#include "experiments/case_reader/model/boundaries.h"
#include "experiments/case_reader/model/boundary_contacts.h"
#include "experiments/case_reader/model/couplings.h"
#include "experiments/case_reader/model/materials.h"
#include "experiments/case_reader/model/motion_frames.h"
#include "experiments/case_reader/model/shapes.h"
#include "experiments/case_reader/process/bonds.h"
#include "experiments/case_reader/process/contact_statistics.h"
#include "experiments/case_reader/process/drained_repose.h"
#include "experiments/case_reader/process/insertion.h"
#include "experiments/case_reader/process/measures.h"
#include "experiments/case_reader/process/samples.h"
#include "experiments/case_reader/process/stages.h"
#include "experiments/storage/sha256.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/toml_document.h"
#include "experiments/text/toml_names.h"

namespace firn {
namespace {

void read_case_table(const TomlTable& root, Case& c) {
  const TomlTable t = root.required_table("case");
  t.allow({"name", "duration", "seed", "gravity", "timestep", "steps_per_loading"});
  c.name = t.string("name", std::filesystem::path(c.source).stem().string());
  c.duration = t.quantity("duration", dimension::time, Sign::positive);
  if (!t.has("seed")) t.set("seed", 1);
  c.seed = static_cast<std::uint64_t>(t.integer64("seed", 0));
  c.model.gravity = t.vector("gravity", dimension::acceleration, "0 0 -9.81 m/s^2");
  c.steps_per_loading = t.number("steps_per_loading", c.steps_per_loading);
  if (!(c.steps_per_loading >= 1 && c.steps_per_loading <= 1e6)) {
    t.fail("steps_per_loading",
           fmt::format("is {}; expected a number from 1 to 1e6", c.steps_per_loading));
  }
  c.automatic_timestep = t.string("timestep", "auto") == "auto";
  if (!c.automatic_timestep) {
    c.model.timestep = t.quantity("timestep", dimension::time, Sign::positive);
    c.timestep_reason = "given in the case";
  }
}

void read_numerics(const TomlTable& root, Case& c) {
  Numerics& n = c.model.numerics;
  const TomlTable t = root.table("numerics");
  t.allow({"contact_margin", "contact_margin_limit", "contact_update_fraction", "skin",
           "overlap_limit", "allow_unstable_timestep"});
  const auto fraction = [&](std::string_view key, double& value, bool zero_allowed) {
    value = t.number(key, value);
    if (!(zero_allowed ? value >= 0 : value > 0)) {
      t.fail(key, fmt::format("is {}; expected a number {} 0", value,
                              zero_allowed ? "of at least" : "above"));
    }
  };
  const auto length = [&](std::string_view key, double& value, Sign sign) {
    value = t.quantity(key, dimension::length, sign, si_text(value, dimension::length));
  };
  fraction("contact_margin", n.contact_margin, false);
  length("contact_margin_limit", n.contact_margin_limit, Sign::positive);
  fraction("contact_update_fraction", n.contact_update_fraction, true);
  length("skin", n.skin, Sign::non_negative);
  fraction("overlap_limit", n.overlap_limit, false);
  c.allow_unstable_timestep = t.boolean("allow_unstable_timestep", false);
}

// Refuses a step that is not stable.
void check_timestep(const TomlTable& root, Case& c) {
  const TimestepAdvice stable = advise_timestep(c.model, kStableSteps);
  if (!stable.limited_by_spring) return;
  c.steps_taken = kStableSteps * stable.timestep / c.model.timestep;
  if (c.allow_unstable_timestep || c.steps_taken >= kStableSteps * (1 - 1e-9)) return;
  root.table("case").fail(
      c.automatic_timestep ? "steps_per_loading" : "timestep",
      fmt::format(
          "{:.4g} s is not stable; expected at most {:.4g} s ({}), {:.4g} s for an accurate "
          "restitution, or numerics.allow_unstable_timestep = true",
          c.model.timestep, stable.timestep, stable.reason,
          stable.timestep * kStableSteps / kAccurateSteps));
}

void read_output(const TomlTable& root, Case& c) {
  const TomlTable t = root.table("output");
  t.allow({"frame_interval", "state_interval", "samples"});
  c.frame_interval = t.quantity("frame_interval", dimension::time, Sign::positive, "10 ms");
  if (t.has("state_interval"))
    c.state_interval = t.quantity("state_interval", dimension::time, Sign::positive);
}

void read_experiment(const TomlTable& root, Case& c) {
  if (!root.has("experiment")) return;
  const TomlTable t = root.required_table("experiment");
  if (root.has("stages")) root.fail("stages", "the experiment sets the stages; expected none here");
  t.choice("kind", {"drained_repose"});
  read_drained_repose(t, c);
}

void check_names(const TomlTable& root, const std::vector<Boundary>& boundaries) {
  for (std::size_t i = 0; i < boundaries.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (boundaries[i].name != boundaries[j].name) continue;
      const auto tables = root.tables("boundaries");
      tables[std::min(i, tables.size() - 1)].fail(
          "name",
          fmt::format("\"{}\" is taken already; expected another name", boundaries[i].name));
    }
  }
}

// Those of fills, then those of inlets.
void add_coming_particles(Case& c) {
  const auto add = [&](const std::string& shape_name, std::size_t count, int tag) {
    const auto shape = std::ranges::find(c.model.shapes, shape_name, &Shape::name);
    const int index = static_cast<int>(shape - c.model.shapes.begin());
    c.model.particles.insert(c.model.particles.end(), count, Particle{index, tag});
  };
  for (const Fill& fill : c.fills) add(fill.shape, static_cast<std::size_t>(fill.count), fill.tag);
  for (const Inlet& source : c.inlets) {
    const std::size_t places = static_cast<std::size_t>(source.batches) * source.positions.size();
    for (std::size_t place = 0; place < places; ++place)
      for (const Inlet::Piece& piece : source.pieces) add(piece.shape, 1, source.tag);
  }
}

// Every pair of materials that can meet must have a contact law.
void check_interactions(const TomlTable& root, const Model& model, const std::vector<char>& given) {
  const std::size_t n = model.materials.size();
  const auto require = [&](int a, int b, const std::string& first, const std::string& second) {
    if (given[a * n + b]) return;
    const std::string pair = model.materials[a].name + "-" + model.materials[b].name;
    root.fail("interactions", fmt::format("{} can meet {}, but nothing is said about \"{}\"; "
                                          "expected a table [interactions.{}]",
                                          first, second, pair, pair));
  };
  std::vector<int> count(model.shapes.size(), 0);
  for (const Particle& p : model.particles) ++count[p.shape];
  for (std::size_t i = 0; i < count.size(); ++i) {
    if (count[i] == 0) continue;
    const std::string shape = fmt::format("shape \"{}\"", model.shapes[i].name);
    for (std::size_t j = i; j < count.size(); ++j) {
      if (count[j] == 0 || (i == j && count[i] == 1)) continue;
      require(model.shapes[i].material, model.shapes[j].material, shape,
              fmt::format("shape \"{}\"", model.shapes[j].name));
    }
    for (const Boundary& b : model.boundaries) {
      require(model.shapes[i].material, b.material, shape, fmt::format("boundary \"{}\"", b.name));
    }
  }
}

// The path of an override as the file spells it: both may name the two materials of an interaction
// in either order.
std::string in_order_of_file(const std::string& path, const toml::table& file) {
  const toml::table* interactions = file["interactions"].as_table();
  constexpr std::string_view kPrefix = "interactions.";
  if (!interactions || !path.starts_with(kPrefix)) return path;
  const std::size_t end = std::min(path.find('.', kPrefix.size()), path.size());
  const std::string key = path.substr(kPrefix.size(), end - kPrefix.size());
  if (interactions->contains(key)) return path;
  for (std::size_t dash = key.find('-'); dash != key.npos; dash = key.find('-', dash + 1)) {
    const std::string turned = key.substr(dash + 1) + "-" + key.substr(0, dash);
    if (interactions->contains(turned)) return std::string(kPrefix) + turned + path.substr(end);
  }
  return path;
}

// Time must advance, and its steps must be counted: a double resolves k * timestep to far below a
// step up to here, and more steps take years.
void check_steps(const TomlTable& root, const Case& c) {
  constexpr double kMost = 1e12;
  const double dt = c.model.timestep, steps = c.duration / dt;
  const TomlTable head = root.table("case");
  if (steps > kMost)
    head.fail(c.automatic_timestep ? "duration" : "timestep",
              fmt::format("{:.3g} s in steps of {:.3g} s ({}) are {:.3g} steps; expected at most "
                          "{:g}: a duration up to {:.3g} s or a time step of at least {:.3g} s",
                          c.duration, dt, c.timestep_reason, steps, kMost, kMost * dt,
                          c.duration / kMost));
  const auto require_a_step = [&](const TomlTable& t, std::string_view key, double time) {
    if (time < dt)
      t.fail(key, fmt::format("is {:.3g} s, shorter than the time step of {:.3g} s ({}); expected "
                              "at least a step",
                              time, dt, c.timestep_reason));
  };
  require_a_step(head, "duration", c.duration);
  const std::vector<TomlTable> stages = root.tables("stages");
  for (std::size_t i = 0; i < std::min(stages.size(), c.stages.size()); ++i)
    require_a_step(stages[i], "max_duration", c.stages[i].max_duration);
  if (c.samples.interval > 0)
    require_a_step(root.table("output").table("samples"), "interval", c.samples.interval);
  // Two batches in one step would be put into each other.
  const std::vector<TomlTable> inlets = root.tables("inlets"), fills = root.tables("fills");
  for (std::size_t i = 0; i < std::min(inlets.size(), c.inlets.size()); ++i)
    if (c.inlets[i].batches > 1) require_a_step(inlets[i], "interval", c.inlets[i].interval);
  for (std::size_t i = 0; i < std::min(fills.size(), c.fills.size()); ++i)
    if (c.fills[i].interval > 0) require_a_step(fills[i], "interval", c.fills[i].interval);
}

void check_keys(const TomlTable& root) {
  root.allow({"case",       "material_records", "materials",  "interactions",      "shapes",
              "particles",  "motion_frames",    "boundaries", "boundary_contacts", "fills",
              "inlets",     "tag_rules",        "sensors",    "limit_switches",    "outlets",
              "stages",     "experiment",       "measure",    "numerics",          "output",
              "statistics", "initial_state",    "bonds",      "couplings"});
  root.require_at_most("materials", input_limits::materials);
  root.require_at_most("shapes", input_limits::shapes);
  root.require_at_most("interactions", input_limits::interactions);
}

// Materials, shapes and the machine. Returns which laws of contact the case gives.
InteractionTable read_model(const TomlTable& root, const std::string& directory, Model& model) {
  model.materials = read_materials(root);
  InteractionTable interactions = read_interactions(root, model.materials);
  model.interactions = std::move(interactions.laws);
  model.shapes = read_shapes(root, model.materials, directory);
  model.frames = read_motion_frames(root);
  model.couplings = read_couplings(root, model.frames);
  model.boundaries = read_boundaries(root, model.materials, model.frames, directory);
  complete_free_bodies(root, model);
  model.boundary_contacts = read_boundary_contacts(root, model);
  return interactions;
}

// Particles, their way through the machine, and what is measured of it.
void read_process(const TomlTable& root, const std::string& directory, Case& c) {
  Model& model = c.model;
  read_initial_state(root, directory, c);
  read_particles(root, c);
  c.fills = read_fills(root, model.shapes);
  c.inlets = read_inlets(root, model.shapes);
  c.outlets = read_outlets(root);
  c.sensors = read_sensors(root);
  c.tag_rules = read_tag_rules(root);
  c.limit_switches = read_limit_switches(root, model.frames);
  read_experiment(root, c);
  check_names(root, model.boundaries);
  for (const TomlTable& t : root.tables("boundaries")) c.boundary_places.push_back(t.place());
  for (const TomlTable& t : root.tables("fills")) c.fill_places.push_back(t.place());
  for (const TomlTable& t : root.tables("inlets")) c.inlet_places.push_back(t.place());
  c.allow_overlap_with = read_allowed_overlaps(root, model.boundaries);
  if (!c.drained_repose) c.stages = read_stages(root, c);
  check_stage_names(root, c);
  add_coming_particles(c);
  c.samples = read_samples(root, c);
  c.measures = read_measures(root, c);
  read_statistics(root, c);
  if (model.particles.empty()) {
    root.fail(
        "particles",
        "the case has none; expected [[particles]], [[fills]], [[inlets]], [initial_state] or "
        "[experiment]");
  }
}

// The time step, and the checks that need the whole case.
void complete_case(const TomlTable& root, Case& c) {
  if (c.automatic_timestep) {
    root.at("", [&] {
      const TimestepAdvice advice = advise_timestep(c.model, c.steps_per_loading);
      c.model.timestep = advice.timestep;
      c.timestep_reason = advice.reason;
    });
  }
  check_steps(root, c);
  root.at("", [&] { validate(c.model); });
  check_timestep(root, c);
}

}  // namespace

Case read_case_text(const std::string& text, const std::string& source,
                    const std::string& directory, const std::vector<Override>& overrides,
                    const MaterialRequest& materials, OldNames old_names) {
  TomlDocument document(text, source, TomlFormat::case_file, old_names);
  document.include(directory);
  require_kind(document, "case");
  document.apply(overrides,
                 [&](const std::string& path) { return in_order_of_file(path, document.root()); });
  std::vector<AppliedMaterial> applied = apply_materials(document, materials);
  const TomlTable root = TomlTable::root(document);
  check_keys(root);
  Case c;
  c.source = source;
  c.material_records = std::move(applied);
  read_case_table(root, c);
  read_numerics(root, c);
  read_output(root, c);
  const InteractionTable interactions = read_model(root, directory, c.model);
  read_process(root, directory, c);
  check_interactions(root, c.model, interactions.given);
  read_bonds(root, c);
  complete_case(root, c);
  c.resolved = document.text();
  c.identity = document.first_names_text();
  return c;
}

Case read_case(const std::string& file, const std::vector<Override>& overrides,
               const MaterialRequest& materials) {
  const std::string text = read_input_file(file, "a case file", input_limits::toml_bytes);
  const std::string directory = std::filesystem::path(file).parent_path().string();
  return read_case_text(text, file, directory, overrides, materials);
}

Override parse_override(const std::string& text) {
  const std::size_t equals = text.find('=');
  Override result;
  if (equals != std::string::npos) {
    result = {trimmed(text.substr(0, equals)), trimmed(text.substr(equals + 1))};
  }
  if (result.first.empty() || result.second.empty()) {
    throw InputError(
        fmt::format("--set {}: not an override; expected KEY=VALUE, such as "
                    "interactions.ice-ice.static_friction=0.2",
                    text));
  }
  return result;
}

std::uint64_t to_steps(const Case& c, double seconds) {
  constexpr double kMost = 1e15;  // beyond the end of every case
  const double steps = std::clamp(seconds / c.model.timestep, 0.0, kMost);
  return static_cast<std::uint64_t>(std::llround(steps));
}

std::string case_identity(const std::string& resolved) {
  return TomlDocument(resolved, "case", TomlFormat::case_file, OldNames::accept).first_names_text();
}

std::string case_hash(const Case& c) { return sha256(c.identity); }

}  // namespace firn
