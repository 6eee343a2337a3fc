#include "experiments/case_reader/model/materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "experiments/text/suggestions.h"
#include "experiments/text/toml_names.h"

namespace firn {
namespace {

double require(const TomlTable& t, std::string_view key, double value, bool fits,
               const char* wanted) {
  if (!fits) t.fail(key, fmt::format("is {}; expected {}", value, wanted));
  return value;
}

double not_negative(const TomlTable& t, std::string_view key, double value) {
  return require(t, key, value, value >= 0, "a number of at least 0");
}

Interaction read_interaction(const TomlTable& t) {
  Interaction law = read_dry_interaction(
      t, {"rolling_resistance", "adhesion_force", "adhesion_stiffness_fraction"});
  law.rolling_resistance = not_negative(
      t, "rolling_resistance", t.number("rolling_resistance", Interaction{}.rolling_resistance));
  // Not filled in where they are left out: most contacts are dry.
  if (t.has("adhesion_force"))
    law.adhesion_force = t.quantity("adhesion_force", dimension::force, Sign::non_negative);
  if (t.has("adhesion_stiffness_fraction")) {
    const double fraction = t.number("adhesion_stiffness_fraction");
    law.adhesion_stiffness_fraction =
        require(t, "adhesion_stiffness_fraction", fraction, fraction >= 0 && fraction < 1,
                "a number from 0 to below 1");
  }
  if (law.adhesion_force > 0 || law.adhesion_stiffness_fraction > 0)
    require(t, "minimum_unloading_ratio", law.minimum_unloading_ratio,
            law.minimum_unloading_ratio > 0,
            "a number above 0 together with adhesion, which acts while a contact is loaded");
  return law;
}

// The materials that a key such as ice-plastic joins, in either order.
std::pair<std::size_t, std::size_t> find_pair(const TomlTable& all, const std::string& key,
                                              const std::vector<Material>& materials) {
  std::vector<std::pair<std::size_t, std::size_t>> found;
  std::vector<std::string> names;
  for (std::size_t a = 0; a < materials.size(); ++a) {
    for (std::size_t b = a; b < materials.size(); ++b) {
      const std::string forward = materials[a].name + "-" + materials[b].name;
      const std::string backward = materials[b].name + "-" + materials[a].name;
      if (key == forward || key == backward) found.emplace_back(a, b);
      names.insert(names.end(), {forward, backward});
    }
  }
  if (found.empty()) {
    const auto likely = nearest(key, {names.begin(), names.end()});
    all.fail(
        key, "joins no two known materials",
        likely ? did_you_mean(*likely) : "expected two materials of the case, joined by a dash");
  }
  if (found.size() > 1) {
    all.fail(key,
             "can be read as two pairs of materials; expected material names that "
             "distinguish them, without dashes");
  }
  return found.front();
}

}  // namespace

Interaction read_dry_interaction(const TomlTable& t, std::vector<std::string_view> other_keys) {
  other_keys.insert(other_keys.end(),
                    {"static_friction", "dynamic_friction", "restitution",
                     "tangential_stiffness_ratio", "minimum_unloading_ratio", "restick_velocity"});
  t.allow(other_keys);
  const Interaction defaults;
  Interaction law;
  law.static_friction = not_negative(t, "static_friction", t.number("static_friction"));
  // Left out it follows the static one, also when that is overridden: no value is filled in.
  law.dynamic_friction = t.has("dynamic_friction")
                             ? not_negative(t, "dynamic_friction", t.number("dynamic_friction"))
                             : law.static_friction;
  if (law.dynamic_friction > law.static_friction) {
    t.fail("dynamic_friction",
           fmt::format("is {}, above the static friction {}; expected at most as much",
                       law.dynamic_friction, law.static_friction));
  }
  law.restitution = t.number("restitution");
  require(t, "restitution", law.restitution, law.restitution > 0 && law.restitution <= 1,
          "a number above 0 and up to 1");
  law.tangential_stiffness_ratio =
      t.number("tangential_stiffness_ratio", defaults.tangential_stiffness_ratio);
  require(t, "tangential_stiffness_ratio", law.tangential_stiffness_ratio,
          law.tangential_stiffness_ratio > 0, "a number above 0");
  law.minimum_unloading_ratio =
      t.number("minimum_unloading_ratio", defaults.minimum_unloading_ratio);
  require(t, "minimum_unloading_ratio", law.minimum_unloading_ratio,
          law.minimum_unloading_ratio >= 0 && law.minimum_unloading_ratio < 1,
          "a number from 0 to below 1");
  law.restick_velocity = t.quantity("restick_velocity", dimension::velocity, Sign::non_negative,
                                    si_text(defaults.restick_velocity, dimension::velocity));
  return law;
}

std::vector<Material> read_materials(const TomlTable& root) {
  const TomlTable all = root.required_table("materials");
  std::vector<Material> materials;
  for (const std::string& name : all.keys()) {
    const TomlTable t = all.required_table(name);
    t.allow({"density", "young_modulus", "poisson_ratio"});
    Material m;
    m.name = name;
    m.density = t.optional_quantity("density", dimension::density, Sign::positive).value_or(0);
    m.young_modulus =
        t.optional_quantity("young_modulus", dimension::pressure, Sign::positive).value_or(0);
    if (t.has("poisson_ratio")) m.poisson_ratio = t.number("poisson_ratio");
    if (!(m.poisson_ratio > -1 && m.poisson_ratio <= 0.5)) {
      t.fail("poisson_ratio",
             fmt::format("is {}; expected a number above -1 and up to 0.5", m.poisson_ratio));
    }
    materials.push_back(m);
  }
  if (materials.empty()) root.fail("materials", "is empty; expected a table [materials.NAME]");
  return materials;
}

InteractionTable read_interactions(const TomlTable& root, const std::vector<Material>& materials) {
  const std::size_t n = materials.size();
  InteractionTable result{std::vector<Interaction>(n * n), std::vector<char>(n * n, 0)};
  const TomlTable all = root.table("interactions");
  for (const std::string& key : all.keys()) {
    const TomlTable t = all.required_table(key);
    const auto [a, b] = find_pair(all, key, materials);
    if (result.given[a * n + b]) {
      all.fail(key, "is given twice, once in each order; expected one table a pair");
    }
    result.laws[a * n + b] = result.laws[b * n + a] = read_interaction(t);
    result.given[a * n + b] = result.given[b * n + a] = 1;
  }
  return result;
}

int material_index(const TomlTable& table, std::string_view key,
                   const std::vector<Material>& materials) {
  return index_of(table, key, table.string(key), materials, "material");
}

}  // namespace firn
