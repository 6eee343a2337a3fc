// firn materials, and records in firn run and firn calibrate.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/app/program.h"
#include "tests/support/small_cases.h"

namespace firn::cli {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;

// A record as a user writes it: no version, no hash.
std::string draft(double friction) {
  return R"({"format": "firn material records", "format_version": 1, "records": [{
  "name": "mine", "title": "Measured by tilting", "materials": ["ice", "plastic"],
  "kind": "assumed",
  "parameters": [{"name": "friction", "keys": ["interactions.ice-plastic.static_friction",
    "interactions.ice-plastic.dynamic_friction"], "value": )" +
         std::to_string(friction) + R"(, "unit": "1", "uncertainty": 0.02}],
  "scope": [{"name": "temperature", "statement": "-10 C"}],
  "provenance": {"author": "me", "date": "2026-11-21", "source": "notebook 3, page 12"}}]})";
}

class Materials : public testing::Test {
 protected:
  Outcome firn(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--database", "m.db"});
    return folder.firn(arguments);
  }
  Folder folder;
};

TEST_F(Materials, ListShowHistoryDiff) {
  EXPECT_THAT(firn({"materials", "list"}).out, HasSubstr("paper-table-1@1"));
  EXPECT_FALSE(folder.contains("m.db"));  // reading writes nothing
  folder.write("a.json", draft(0.1));
  folder.write("b.json", draft(0.15));
  EXPECT_THAT(firn({"materials", "add", "a.json"}).out, HasSubstr("mine@1  sha256"));
  EXPECT_THAT(firn({"materials", "add", "b.json"}).out, HasSubstr("mine@2"));
  const Outcome shown = firn({"materials", "show", "mine@1"});
  EXPECT_EQ(shown.status, 0);
  EXPECT_THAT(shown.out, HasSubstr("0.100 ± 0.020"));
  EXPECT_THAT(shown.out, HasSubstr("notebook 3, page 12"));
  EXPECT_THAT(firn({"materials", "history", "mine"}).out,
              HasSubstr("parameters.friction.value  0.1 -> 0.15  (x 1.5)"));
  const Json json = Json::parse(firn({"materials", "diff", "mine@1", "mine@2", "--json"}).out);
  EXPECT_EQ(json["changes"].size(), 1u);
  EXPECT_EQ(json["changes"][0]["to"], 0.15);
  bool found = false;
  for (const Json& r : Json::parse(firn({"materials", "list", "--json"}).out))
    found = found || (r["name"] == "mine" && r["version"] == 2 && r["shipped"] == false);
  EXPECT_TRUE(found);
  EXPECT_EQ(Json::parse(firn({"materials", "show", "mine", "--json"}).out)["provenance"]["author"],
            "me");
}

TEST_F(Materials, ExportAndImportAreExact) {
  folder.write("a.json", draft(0.1));
  firn({"materials", "add", "a.json"});
  firn({"materials", "add", "a.json"});
  EXPECT_EQ(firn({"materials", "export", "--all", "-o", "all.json"}).status, 0);
  EXPECT_EQ(folder.firn({"materials", "import", "all.json", "--database", "other.db"}).status, 0);
  EXPECT_EQ(folder.firn({"materials", "export", "mine", "--database", "other.db"}).out,
            firn({"materials", "export", "mine"}).out);
  EXPECT_THAT(firn({"materials", "import", "all.json"}).err, HasSubstr("0 new records"));
  EXPECT_THAT(firn({"materials", "add", "all.json"}).err, HasSubstr("`firn materials import`"));
}

TEST_F(Materials, MistakesAreOneLineAndStatus2) {
  folder.write("bad.json", "{\n\"format\": \n}");
  folder.write("draft.json", draft(0.1));
  const std::vector<std::vector<std::string>> calls = {
      {"materials", "show", "nope"},
      {"materials", "show", "paper-text@7"},
      {"materials", "show", "paper-text#1"},
      {"materials", "add", "bad.json"},
      {"materials", "add", "missing.json"},
      {"materials", "import", "draft.json"},
      {"materials", "export"},
      {"materials", "verify", "nope"},
  };
  for (const auto& call : calls) {
    const Outcome o = firn(call);
    EXPECT_EQ(o.status, 2) << o.err;
    EXPECT_EQ(lines(o.err), 1u) << o.err;
    EXPECT_EQ(o.out, "");
  }
  EXPECT_THAT(firn({"materials", "add", "bad.json"}).err, HasSubstr("bad.json:3: JSON"));
}

// Records name files as they were called when the data were taken.
TEST_F(Materials, VerifyFindsShippedFilesThatHaveMoved) {
  std::filesystem::create_directories(folder.path() / "cases/heap");
  folder.write("cases/heap/data.csv", "1,2,3\n");
  std::string text = draft(0.1);
  text.insert(text.find("\"source\": \"notebook"),
              "\"raw_data\": [{\"what\": \"readings\", \"file\": \"experiments/heap/data.csv\", "
              "\"sha256\": "
              "\"d42d0ac86dcdfc6b8639b85cd5fe0e5ff3e5be69fc4e4ac2e5b4b8c4e5bd3c10\"}], ");
  folder.write("a.json", text);
  ASSERT_EQ(firn({"materials", "add", "a.json"}).status, 0);
  EXPECT_THAT(firn({"materials", "verify", "mine"}).out, HasSubstr("hash differs"));
}

TEST_F(Materials, VerifySeesDamage) {
  folder.write("data.csv", "1,2,3\n");
  std::string text = draft(0.1);
  // The hash of another text.
  text.insert(text.find("\"source\": \"notebook"),
              "\"raw_data\": [{\"what\": \"readings\", \"file\": \"data.csv\", \"sha256\": "
              "\"d42d0ac86dcdfc6b8639b85cd5fe0e5ff3e5be69fc4e4ac2e5b4b8c4e5bd3c10\"}], ");
  folder.write("a.json", text);
  ASSERT_EQ(firn({"materials", "add", "a.json"}).status, 0);
  const Outcome wrong = firn({"materials", "verify", "mine"});
  EXPECT_EQ(wrong.status, 3);
  EXPECT_THAT(wrong.out, HasSubstr("FAILS    mine@1: readings data.csv"));
  std::filesystem::remove(folder.path() / "data.csv");
  const Outcome gone = firn({"materials", "verify", "--json"});
  EXPECT_EQ(gone.status, 0);
  const Json json = Json::parse(gone.out);
  EXPECT_TRUE(json["holds"].get<bool>());
}

TEST_F(Materials, ProcessesThatAddAtOnceGetVersionsOfTheirOwn) {
  folder.write("a.json", draft(0.1));
  std::vector<pid_t> pids;
  for (int i = 0; i < 6; ++i)
    pids.push_back(folder.start({"materials", "add", "a.json", "--database", "m.db"}));
  for (const pid_t pid : pids) EXPECT_EQ(folder.wait(pid).status, 0);
  EXPECT_EQ(Json::parse(firn({"materials", "history", "mine", "--json"}).out).size(), 6u);
  EXPECT_EQ(firn({"materials", "verify", "mine"}).status, 0);
}

TEST_F(Materials, ARunTakesARecordAndListsItsKeys) {
  folder.write("case.toml", two_boxes);
  folder.write("a.json", draft(0.15));
  firn({"materials", "add", "a.json"});
  const Outcome o = firn({"run", "case.toml", "--material", "mine", "-o", "r.h5", "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.err, HasSubstr("material mine@1 sets interactions.ice-plastic.static_friction = "
                               "0.15, interactions.ice-plastic.dynamic_friction = 0.15"));
  EXPECT_EQ(Json::parse(o.out)["material_records"][0]["record"], "mine@1");
  EXPECT_THAT(firn({"run", "case.toml", "--material", "mine#1", "-o", "s.h5"}).err,
              HasSubstr("no posterior ensemble"));
  // What was run is in the results, whatever becomes of the database.
  std::filesystem::remove(folder.path() / "m.db");
  const Outcome again = folder.firn({"run", "--resume", "r.h5"});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_THAT(again.err, HasSubstr("material mine@1 sets"));
  EXPECT_EQ(firn({"run", "--resume", "r.h5", "--material", "paper-text"}).status, 2);
}

// A whole study of a small drain: fitted, saved, shown, sampled, replayed.
TEST(MaterialsLong, AStudyIsSavedSampledAndReplayed) {
  const Folder folder;
  folder.write("case.toml", small_drain);
  folder.write("study.toml", R"([study]
name = "small"
case = "case.toml"
[budget]
center_replicates = 2
design_points = 4
replicates_per_point = 1
refine_rounds = 0
confirmation_replicates = 2
[[parameters]]
name = "ice_plastic"
keys = ["interactions.ice-plastic.static_friction"]
min = 0.05
max = 0.6
scale = "log"
[[targets]]
response = "remaining_count"
value = "18 1"
uncertainty = "4 1"
)");
  // What no reader of records would take is refused before the work.
  for (const char* option : {"--author", "--note", "--scope"}) {
    const Outcome refused = folder.firn({"calibrate", "study.toml", "-o", "refused", "--save",
                                         "small", option, "a=b\x1b[2J", "--database", "m.db"});
    EXPECT_EQ(refused.status, 2);
    EXPECT_THAT(refused.err, HasSubstr(std::string(option) + ": has the character \\x1b"));
    EXPECT_FALSE(folder.contains("refused"));
  }
  const Outcome saved =
      folder.firn({"calibrate", "study.toml", "-o", "out", "--save", "small", "--author", "me",
                   "--scope", "temperature=none", "--database", "m.db"});
  ASSERT_EQ(saved.status, 0) << saved.err << saved.out;
  EXPECT_THAT(saved.err, HasSubstr("saved as material small@1 in m.db"));
  const Outcome shown = folder.firn({"materials", "show", "small", "--database", "m.db"});
  EXPECT_THAT(shown.out, HasSubstr("simulated 2 times"));
  const Outcome run = folder.firn({"run", "case.toml", "--material", "small#2", "--set",
                                   "case.duration=\"1 ms\"", "--database", "m.db"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("material small@1, sample 2 sets"));
  const Outcome replayed = folder.firn(
      {"materials", "verify", "small", "--replay", "--runs", "1", "--database", "m.db"});
  EXPECT_EQ(replayed.status, 0) << replayed.err << replayed.out;
  EXPECT_THAT(replayed.out, HasSubstr("the same bits in 1 runs"));
  std::ofstream(folder.path() / "study.toml", std::ios::app) << "# changed\n";
  const Outcome changed = folder.firn({"materials", "verify", "small", "--database", "m.db"});
  EXPECT_EQ(changed.status, 3);
  EXPECT_THAT(changed.out, HasSubstr("FAILS    small@1: study"));
}

}  // namespace
}  // namespace firn::cli
