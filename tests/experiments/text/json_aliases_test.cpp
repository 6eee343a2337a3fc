// Renamed keys and words of results.json files and material records: those of earlier versions are
// read.
#include "experiments/text/json_aliases.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

// A document of a kind: results of studies have the key "study" instead.
Json document_of(std::string_view kind) {
  return kind == "study" ? Json{{"study", "s"}} : Json{{"kind", std::string(kind)}};
}

void use_current(Json& document, std::string_view kind) {
  if (kind == "material record")
    use_current_record_names(document);
  else
    use_current_json_names(document);
}

// The object at a path such as "comparisons[].value", made below `node`.
Json& object_at(Json& node, std::string_view path) {
  if (path.empty()) return node;
  const std::size_t end = std::min(path.find('.'), path.size());
  std::string key(path.substr(0, end));
  const std::string_view rest = path.substr(std::min(end + 1, path.size()));
  const bool is_list = key.ends_with("[]");
  if (is_list) key.resize(key.size() - 2);
  Json& inner = node[key];
  if (!is_list) return object_at(inner, rest);
  if (inner.empty()) inner = Json::array({Json::object()});
  return object_at(inner[0], rest);
}

TEST(JsonAliases, EveryOldKeyAndWordIsRead) {
  for (const JsonAlias& k : renamed_json_keys()) {
    Json document = document_of(k.document);
    Json& object = object_at(document, k.path);
    object["before"] = 1;
    object[std::string(k.old_name)] = "kept";
    object["behind"] = 2;
    use_current(document, k.document);
    const Json& now = object_at(document, k.path);
    EXPECT_EQ(now.value(std::string(k.name), ""), "kept") << k.old_name;
    EXPECT_FALSE(now.contains(std::string(k.old_name))) << k.old_name;
    EXPECT_TRUE(now.dump().ends_with("\"kept\",\"behind\":2}")) << now;
    const Json once = document;
    use_current(document, k.document);
    EXPECT_EQ(document, once);
  }
  for (const JsonAlias& w : renamed_json_words()) {
    Json document = document_of(w.document);
    object_at(document, w.path)[std::string(w.key)] = std::string(w.old_name);
    use_current(document, w.document);
    EXPECT_EQ(object_at(document, w.path)[std::string(w.key)], std::string(w.name));
  }
}

// A record with every renamed key, in current names, comes back from the first names.
TEST(JsonAliases, RecordsHaveFirstNamesAndBack) {
  const Json record = Json::parse(
      R"({"kind": "published", "note": "n", "parameters": [{"note": "p"}, {"name": "q"}],
          "posterior_ensemble": {"samples": [], "reference_sets": [{"name": "note"}],
                                 "combinations": [{"identifiable": true}]}})");
  Json first = record;
  use_first_record_names(first);
  EXPECT_EQ(first, Json::parse(R"({"kind": "printed", "remark": "n",
                                   "parameters": [{"remark": "p"}, {"name": "q"}],
                                   "family": {"points": [], "anchors": [{"name": "note"}],
                                              "combinations": [{"identified": true}]}})"));
  Json back = first;
  use_current_record_names(back);
  EXPECT_EQ(back, record);
}

TEST(JsonAliases, OldNamesAreNoCurrentNames) {
  std::set<std::string> current, first;
  for (const JsonAlias& k : renamed_json_keys()) {
    const auto at = [&](std::string_view name) {
      return std::string(k.document) + ' ' + std::string(k.path) + ' ' + std::string(name);
    };
    // A name may have changed twice, but the first names of records must be known.
    const bool once = current.insert(at(k.name)).second;
    EXPECT_TRUE(once || k.document != "material record") << k.name;
    EXPECT_TRUE(first.insert(at(k.old_name)).second) << k.old_name;
  }
  for (const std::string& name : first) EXPECT_FALSE(current.contains(name)) << name;
}

TEST(JsonAliases, OtherDocumentsStayAsTheyAre) {
  for (const char* text :
       {"[1]", "3", "null", R"({"kind": 3, "comparisons": [{"claims": []}]})",
        R"({"kind": "sweep", "comparisons": [{"claims": []}]})",
        R"({"kind": "validation", "comparisons": {"claims": 1}})",
        R"({"kind": "validation", "comparisons": [3, [], null, {"value": [], "verdict": 4}]})",
        R"({"kind": "validation", "comparisons": [{"claims": 1, "criteria": 2}]})"}) {
    Json document = Json::parse(text);
    use_current_json_names(document);
    EXPECT_EQ(document, Json::parse(text)) << text;
  }
}

}  // namespace
}  // namespace firn
