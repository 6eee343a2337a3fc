// Renamed keys and words of TOML tables.
#include "experiments/text/toml_aliases.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "tests/experiments/text/renamed_names.h"

namespace firn {
namespace {

using test::current_names;
using test::toml_text;
using testing::HasSubstr;

// The table of a pattern such as "stages[].motors[]", made below `root`.
toml::table& table_at(toml::table& root, std::string_view pattern) {
  toml::table* table = &root;
  while (!pattern.empty()) {
    const std::size_t end = std::min(pattern.find('.'), pattern.size());
    std::string key(pattern.substr(0, end));
    pattern.remove_prefix(std::min(end + 1, pattern.size()));
    if (key == "*") key = "any";
    if (key.ends_with("[]")) {
      key.resize(key.size() - 2);
      auto* list = table->insert(key, toml::array()).first->second.as_array();
      if (list->empty()) list->push_back(toml::table());
      table = list->back().as_table();
    } else {
      table = table->insert(key, toml::table()).first->second.as_table();
    }
  }
  return *table;
}

TEST(TomlAliases, EveryOldKeyAndWordIsReadAndReported) {
  for (const TomlAlias& k : renamed_keys()) {
    toml::table root;
    table_at(root, k.path).insert(k.old_name, "kept");
    const std::string before = toml_text(root);
    const auto uses = current_names(k.document, root);
    ASSERT_EQ(uses.size(), 1u) << before;
    EXPECT_EQ(uses[0].old_name, k.old_name);
    EXPECT_EQ(uses[0].name, k.name);
    EXPECT_TRUE(uses[0].path.ends_with(k.old_name)) << uses[0].path;
    EXPECT_EQ(table_at(root, k.path)[k.name].value<std::string>(), "kept") << before;
    EXPECT_TRUE(current_names(k.document, root).empty()) << toml_text(root);
    // The tables around it may have an old name as well.
    const std::string now = toml_text(root);
    use_first_names(k.document, root);
    EXPECT_THAT(toml_text(root), HasSubstr(fmt::format("{} = 'kept'", k.old_name)));
    current_names(k.document, root);
    EXPECT_EQ(toml_text(root), now);
  }
  for (const TomlAlias& w : renamed_words()) {
    toml::table root;
    table_at(root, w.path).insert(w.key, toml::array{"other", w.old_name});
    const auto uses = current_names(w.document, root);
    ASSERT_EQ(uses.size(), 1u) << w.old_name;
    const toml::node_view<toml::node> list = table_at(root, w.path)[w.key];
    EXPECT_EQ(list[1].value<std::string>(), w.name);
    use_first_names(w.document, root);
    EXPECT_THAT(toml_text(root), HasSubstr(fmt::format("'other', '{}'", w.old_name)));
  }
}

TEST(TomlAliases, AWordOfAListIsReportedAtItsLine) {
  toml::table root = toml::parse("[[stages]]\nend_when = [\n\"passed\",\n\"at_rest\",\n]\n");
  const std::vector<OldNameUse> uses = current_names(TomlFormat::case_file, root);
  ASSERT_EQ(uses.size(), 1u);
  EXPECT_EQ(uses[0].path, "stages.0.end_when");
  EXPECT_EQ(uses[0].line, 4u);
}

// No old name is a current name of the same table: a reader could not decide which one is meant.
TEST(TomlAliases, OldNamesAreNoCurrentNames) {
  std::set<std::string> current, first;
  for (const TomlAlias& k : renamed_keys()) {
    const auto at = [&](std::string_view name) {
      return fmt::format("{} {} {}", static_cast<int>(k.document), k.path, name);
    };
    EXPECT_TRUE(current.insert(at(k.name)).second) << k.name;
    EXPECT_TRUE(first.insert(at(k.old_name)).second) << k.old_name;
  }
  for (const std::string& name : first) EXPECT_FALSE(current.contains(name)) << name;
}

// Any set of old and current names, in any table, with other keys between them.
TEST(TomlAliases, RandomTreesKeepTheirValues) {
  std::mt19937_64 random(4);
  const auto keys = renamed_keys();
  for (int round = 0; round < 300; ++round) {
    const TomlFormat format = keys[random() % keys.size()].document;
    toml::table old_names, new_names;
    for (const TomlAlias& k : keys) {
      const std::string path = fmt::format("{}{}{}", k.path, k.path.empty() ? "" : ".", k.name);
      const bool has_tables = std::ranges::any_of(keys, [&](const TomlAlias& other) {
        return other.document == format && other.path.starts_with(path);
      });
      if (k.document != format || has_tables || random() % 3 != 0) continue;
      toml::table& a = table_at(old_names, k.path);
      toml::table& b = table_at(new_names, k.path);
      // A renamed table that has been made for its own keys stays.
      if (a.contains(k.old_name) || a.contains(k.name)) continue;
      a.insert(random() % 2 == 0 ? k.old_name : k.name, static_cast<std::int64_t>(round));
      b.insert(k.name, static_cast<std::int64_t>(round));
      a.insert("other", 1);
      b.insert("other", 1);
    }
    current_names(format, old_names);
    ASSERT_EQ(toml_text(old_names), toml_text(new_names));
    use_first_names(format, old_names);
    use_first_names(format, new_names);
    ASSERT_EQ(toml_text(old_names), toml_text(new_names));
  }
}

TEST(TomlAliases, PathsIntoACase) {
  const std::pair<const char*, const char*> paths[] = {
      {"sources.mold.scatter", "inlets.mold.position_jitter"},
      {"sources.0.turn", "inlets.0.rotation_jitter"},
      {"motion_frames.arm.free.axes.0.drives.0.to",
       "motion_frames.arm.free.joints.0.motors.0.target"},
      {"interactions.ice-ice.sliding_speed", "interactions.ice-ice.restick_velocity"},
      {"switches.sources.hold", "limit_switches.sources.hold_time"},
      {"case.steps_per_quarter_period", "case.steps_per_loading"}};
  for (const auto& [first, current] : paths) {
    EXPECT_EQ(current_case_path(first), current);
    EXPECT_EQ(current_case_path(current), current);
    EXPECT_EQ(first_case_path(current), first);
    EXPECT_EQ(first_case_path(first), first);
  }
  for (const char* same : {"materials.tip.density", "stages.until.max_duration", "case.seed",
                           "particles.scatter.velocity", "", ".", "shapes.dish"})
    EXPECT_EQ(current_case_path(same), same);
}

}  // namespace
}  // namespace firn
