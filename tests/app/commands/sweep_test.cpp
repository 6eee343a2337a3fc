// firn sweep, end to end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/app/program.h"
#include "tests/support/replaced.h"
#include "tests/support/small_cases.h"

namespace firn::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr const char* sweep = R"([sweep]
name = "boxes"
case = "case.toml"
seeds = 2
responses = ["present_mass", "peak_normal_force"]
[[vary]]
name = "density"
keys = ["materials.ice.density"]
values = ["900 kg/m^3", "1800 kg/m^3"]
[[vary]]
name = "friction"
keys = ["interactions.ice-ice.static_friction", "interactions.ice-ice.dynamic_friction"]
values = [0.1, 0.2, 0.3]
)";

struct Sweep : Folder {
  Sweep() {
    write("case.toml", two_boxes);
    write("sweep.toml", sweep);
  }
  Outcome with(const std::string& part, const std::string& other) const {
    write("changed.toml", test::replaced(sweep, part, other));
    return firn({"sweep", "changed.toml", "-o", "changed", "--progress", "none", "--json"});
  }
};

TEST(SweepCommand, RunsEveryCombinationOnce) {
  const Sweep folder;
  const Outcome o = folder.firn({"sweep", "sweep.toml", "-o", "out", "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  const json result = json::parse(o.out);
  ASSERT_EQ(result["combinations"].size(), 6u);
  EXPECT_EQ(result["runs"].size(), 12u);
  // The last key varies fastest. The mass shows which density a run had.
  for (std::size_t c = 0; c < 6; ++c) {
    const json& row = result["combinations"][c];
    EXPECT_EQ(row["values"]["density"], c < 3 ? "900 kg/m^3" : "1800 kg/m^3");
    EXPECT_NEAR(row["responses"]["present_mass"]["mean"], (c < 3 ? 900 : 1800) * 2 * 8e-6, 3e-4);
    EXPECT_EQ(row["responses"]["present_mass"]["runs"], 2);
  }
  EXPECT_EQ(result["combinations"][4]["values"]["friction"], "0.2");
  // The table: a header and a line for every run.
  std::istringstream csv(read_text(folder.path() / "out/runs.csv"));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line,
            "density,friction,seed,status,wall [s],key,present_mass [kg],peak_normal_force [N]");
  int lines = 0;
  while (std::getline(csv, line)) ++lines;
  EXPECT_EQ(lines, 12);
  const Outcome again =
      folder.firn({"sweep", "sweep.toml", "-o", "out", "--json", "--progress", "json"});
  EXPECT_EQ(again.out, o.out);
  EXPECT_THAT(again.err, testing::Not(HasSubstr("\"started\"")));
}

TEST(SweepCommand, TakesListsAndRepetitions) {
  const Sweep folder;
  const Outcome lists = folder.with("seeds = 2", "seeds = 1\ndesign = \"list\"");
  EXPECT_EQ(lists.status, 2);
  EXPECT_THAT(lists.err, HasSubstr("has 3 values; expected 2"));
  folder.write(
      "list.toml",
      "[sweep]\nname = \"l\"\ncase = \"case.toml\"\ndesign = \"list\"\n"
      "[[vary]]\nname = \"a\"\nkeys = [\"materials.ice.density\"]\n"
      "values = [\"900 kg/m^3\", \"1000 kg/m^3\"]\n"
      "[[vary]]\nname = \"b\"\nkeys = [\"case.duration\"]\nvalues = [\"10 ms\", \"20 ms\"]\n");
  const Outcome list = folder.firn({"sweep", "list.toml", "--json", "--progress", "none"});
  ASSERT_EQ(list.status, 0) << list.err;
  const json result = json::parse(list.out);
  ASSERT_EQ(result["combinations"].size(), 2u);
  EXPECT_EQ(result["combinations"][1]["values"]["b"], "20 ms");
  EXPECT_GT(result["responses"].size(), 3u);  // all single-valued ones
  EXPECT_TRUE(folder.contains("runs/l/runs.csv"));
  folder.write("repeat.toml", "[sweep]\nname = \"r\"\ncase = \"case.toml\"\nseeds = 3\n");
  const Outcome repeat = folder.firn({"sweep", "repeat.toml", "--progress", "none"});
  ASSERT_EQ(repeat.status, 0) << repeat.err;
  EXPECT_THAT(repeat.out, HasSubstr("r: 3 of 3 runs finished"));
}

TEST(SweepCommand, LeavesAPageInAFolderWithoutBlanks) {
  const Sweep folder;
  std::string text = sweep;
  folder.write("named.toml", text.replace(text.find("boxes"), 5, "two boxes, soft"));
  const Outcome o = folder.firn({"sweep", "named.toml", "--progress", "none"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.err, HasSubstr("to be read: runs/two-boxes-soft/report.html"));
  const std::string page = read_text(folder.path() / "runs/two-boxes-soft/report.html");
  EXPECT_THAT(page, HasSubstr("12 of 12 runs finished"));
  EXPECT_THAT(page, HasSubstr("present mass over density"));
  const Outcome made = folder.firn({"report", "runs/two-boxes-soft", "-o", "again.html"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_EQ(read_text(folder.path() / "again.html"), page);
  // A folder of an earlier version is gone on with.
  std::filesystem::rename(folder.path() / "runs/two-boxes-soft",
                          folder.path() / "runs/two boxes, soft");
  const Outcome again = folder.firn({"sweep", "named.toml", "--progress", "none"});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_FALSE(folder.contains("runs/two-boxes-soft"));
}

TEST(SweepCommand, StatesTheExponentOverOneKeyThatIsANumber) {
  const Sweep folder;
  const auto swept = [&](const char* name, const char* key, const char* values) {
    folder.write("one.toml", std::string("[sweep]\nname = \"") + name +
                                 "\"\ncase = \"case.toml\"\nresponses = [\"present_mass\"]\n"
                                 "[[vary]]\nname = \"x\"\nkeys = [\"" +
                                 key + "\"]\nvalues = " + values + "\n");
    return folder.firn({"sweep", "one.toml", "--progress", "none"});
  };
  // Mass goes with density to the first power, whatever the unit.
  const Outcome three =
      swept("three", "materials.ice.density", R"(["900 kg/m^3", "1.8 g/cm^3", "3600 kg/m^3"])");
  ASSERT_EQ(three.status, 0) << three.err;
  EXPECT_THAT(three.out, HasSubstr("as a power of x:"));
  EXPECT_THAT(three.out, testing::ContainsRegex("present_mass +1\\.00 ± 0\\.0"));
  const Outcome two = swept("two", "materials.ice.density", R"(["900 kg/m^3", "1800 kg/m^3"])");
  ASSERT_EQ(two.status, 0) << two.err;
  EXPECT_THAT(two.out, testing::ContainsRegex("present_mass +1\\.00 \\(two values"));
  const Outcome vectors = swept("vectors", "case.gravity", R"(["0 0 -9 m/s^2", "0 0 -8 m/s^2"])");
  ASSERT_EQ(vectors.status, 0) << vectors.err;
  EXPECT_THAT(vectors.out, testing::Not(HasSubstr("as a power")));
}

// Mass is the product of density and volume; friction does not matter to it.
TEST(SweepCommand, ScreensFactors) {
  const Sweep folder;
  folder.write("screen.toml", R"([sweep]
name = "screen"
case = "case.toml"
design = "morris"
trajectories = 4
seeds = 2
responses = ["present_mass", "peak_normal_force"]
[[vary]]
name = "friction"
keys = ["interactions.ice-ice.static_friction", "interactions.ice-ice.dynamic_friction"]
values = [0.1, 0.3]
[[vary]]
name = "density"
keys = ["materials.ice.density"]
values = ["900 kg/m^3", "1000 kg/m^3", "1100 kg/m^3", "1200 kg/m^3"]
[[vary]]
name = "end"
keys = ["case.duration"]
values = ["10 ms", "20 ms"]
)");
  const Outcome o = folder.firn({"sweep", "screen.toml", "-o", "out", "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  const json result = json::parse(o.out), mass = result["effects"]["present_mass"];
  EXPECT_LE(result["combinations"].size(), 16u);
  EXPECT_EQ(mass.size(), 3u);
  EXPECT_NEAR(mass["density"]["mean_absolute"], 300 * 2 * 8e-6, 1e-9);
  EXPECT_NEAR(mass["density"]["mean"], 300 * 2 * 8e-6, 1e-9);
  EXPECT_EQ(mass["friction"]["mean_absolute"], 0);
  EXPECT_EQ(mass["friction"]["count"], 4);
  EXPECT_EQ(mass["friction"]["noise"], 0);
  EXPECT_FALSE(result.contains("powers"));
  const Outcome table = folder.firn({"sweep", "screen.toml", "-o", "out", "--progress", "none"});
  ASSERT_EQ(table.status, 0) << table.err;
  EXPECT_THAT(table.out, HasSubstr("present_mass kg, change over the range of a factor:"));
  EXPECT_THAT(table.out, testing::ContainsRegex("density +0\\.0048 +0\\.0048 to 0\\.0048"));
  const std::string page = read_text(folder.path() / "out/report.html");
  EXPECT_THAT(page, HasSubstr("Which factor matters"));
  EXPECT_THAT(page, HasSubstr("Effects on present mass"));
}

TEST(SweepCommand, TakesMaterialRecordsAsValues) {
  const Sweep folder;
  folder.write("records.toml", R"([sweep]
name = "records"
case = "case.toml"
responses = ["peak_normal_force"]
[[vary]]
name = "ice"
materials = ["paper-text", "paper-table-1"]
)");
  const Outcome o = folder.firn({"sweep", "records.toml", "--progress", "none", "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  const json result = json::parse(o.out);
  ASSERT_EQ(result["combinations"].size(), 2u);
  EXPECT_EQ(result["combinations"][1]["values"]["ice"], "paper-table-1");
  EXPECT_NE(result["runs"][0]["key"], result["runs"][1]["key"]);
}

// A key of `set` is a path, or the parts of one.
TEST(SweepCommand, SetsKeysInEveryFormOfTheTable) {
  const Sweep folder;
  std::vector<std::string> keys;
  for (const char* set :
       {"set = { \"materials.ice.density\" = \"1800 kg/m^3\", \"case.duration\" = \"10 ms\" }\n",
        "[sweep.set]\n\"materials.ice.density\" = \"1800 kg/m^3\"\ncase.duration = \"10 ms\"\n",
        "set.\"materials.ice\".density = \"1800 kg/m^3\"\nset.case.duration = \"10 ms\"\n",
        "[sweep.set.materials.ice]\ndensity = \"1800 kg/m^3\"\n"
        "[sweep.set.case]\nduration = \"10 ms\"\n"}) {
    folder.write("set.toml", std::string("[sweep]\nname = \"s\"\ncase = \"case.toml\"\n") + set);
    const Outcome o = folder.firn({"sweep", "set.toml", "-o", "set" + std::to_string(keys.size()),
                                   "--json", "--progress", "none"});
    ASSERT_EQ(o.status, 0) << o.err;
    const json run = json::parse(o.out)["runs"][0];
    ASSERT_EQ(run["status"], "finished");
    keys.push_back(run["key"].get<std::string>());
  }
  EXPECT_THAT(keys, testing::Each(keys.front()));
}

TEST(SweepCommand, WarnsOfAnOldNameAtItsLine) {
  const Sweep folder;
  folder.write("old.toml", R"([sweep]
name = "old"
case = "case.toml"
responses = [
  "present_mass",
  "covered_fraction_left",
]
[sweep.set]
"case.duration" = "20 ms"
"numerics.contact_shell" = 0.07
[[vary]]
name = "a"
keys = [
  "interactions.ice-ice.restitution",
  "case.steps_per_quarter_period",
]
values = []
)");
  const Outcome o = folder.firn({"sweep", "old.toml"});
  EXPECT_EQ(o.status, 2);
  EXPECT_THAT(o.err, HasSubstr("old.toml:6: sweep.responses: \"covered_fraction_left\" is now "));
  EXPECT_THAT(o.err, HasSubstr("old.toml:10: sweep.set: \"numerics.contact_shell\" is now "));
  EXPECT_THAT(o.err, HasSubstr("old.toml:15: vary.a.keys: \"case.steps_per_quarter_period\" is "));
  EXPECT_THAT(o.err, HasSubstr("old.toml:17: vary.a.values: is missing"));
}

// Known after a run alone, and of the first one.
TEST(SweepCommand, AResponseThatTheCaseLacksEndsTheSweepAfterItsFirstRun) {
  const Sweep folder;
  folder.write("changed.toml", test::replaced(sweep, "\"present_mass\"", "\"absent_mass\""));
  const Outcome o = folder.firn(
      {"sweep", "changed.toml", "-o", "out", "--jobs", "1", "--no-cache", "--progress", "json"});
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(lines_with(o.err, "\"started\""), 1U) << o.err;
  EXPECT_THAT(o.err,
              HasSubstr("changed.toml:5: sweep.responses: \"absent_mass\" is not a response"));
}

TEST(SweepCommand, LabelsStandForValues) {
  const Sweep folder;
  const Outcome o = folder.with("values = [\"900 kg/m^3\", \"1800 kg/m^3\"]",
                                "values = [\"900 kg/m^3\", \"1800 kg/m^3\"]\n"
                                "labels = [\"clear, hard\", \"with air\"]");
  ASSERT_EQ(o.status, 0) << o.err;
  const json result = json::parse(o.out);
  ASSERT_EQ(result["combinations"].size(), 6u);
  EXPECT_EQ(result["combinations"][2]["values"]["density"], "clear, hard");
  EXPECT_EQ(result["combinations"][3]["values"]["density"], "with air");
  EXPECT_NEAR(result["combinations"][3]["responses"]["present_mass"]["mean"], 1800 * 2 * 8e-6,
              3e-4);
  EXPECT_THAT(read_text(folder.path() / "changed/runs.csv"), HasSubstr("\n\"clear, hard\",0.1,1,"));
  EXPECT_THAT(read_text(folder.path() / "changed/report.html"), HasSubstr("with air"));
}

// A table is one value, however many lines it has.
TEST(SweepCommand, ATableIsShownOnOneLine) {
  const Sweep folder;
  folder.write("tables.toml", R"([sweep]
name = "tables"
case = "case.toml"
responses = ["present_mass"]
[[vary]]
name = "cubes"
keys = ["particles"]
values = [
  [
    { shape = "cube", position = "0 0 12 mm" },
    { shape = "cube", position = "0 0 40 mm" },
  ],
  [{ shape = "cube", position = "0 0 12 mm" }],
]
)");
  const Outcome o = folder.firn({"sweep", "tables.toml", "-o", "tables", "--progress", "none"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("cubes=[ { position = '0 0 12 mm', shape = 'cube' }, { position = "
                               "'0 0 40 mm', shape = 'cube' } ]: 1 of 1 "));
  EXPECT_EQ(lines(read_text(folder.path() / "tables/runs.csv")), 3U);
}

TEST(SweepCommand, RefusesInOneLine) {
  const Sweep folder;
  const auto refused = [&](const char* part, const char* other, const char* says) {
    const Outcome o = folder.with(part, other);
    EXPECT_EQ(o.status, 2) << other;
    EXPECT_THAT(o.err, HasSubstr(says));
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  };
  refused("case.toml", "none.toml", "changed.toml:3: sweep.case");
  refused("seeds = 2", "seds = 2", "seeds");
  refused("materials.ice.density", "materials.ice.densty", "densty");
  refused("\"materials.ice.density\"", "\"case.seed\"", "is the sweep's own");
  refused("values = [0.1, 0.2, 0.3]", "values = []", "is missing");
  refused("values = [0.1, 0.2, 0.3]", "values = 0.1", "expected a list");
  refused("\"present_mass\"", "\"present mass\"", "is not an operand");
  refused("case.toml", ".", "is a folder; expected a case file, relative to the sweep");
  refused("seeds = 2", "seeds = 2\nmaterials = [\n\"absent\"]",
          "changed.toml:6: sweep.materials: material absent: unknown");
  refused("seeds = 2", "seeds = 2\nmaterials = [\"paper-text\",\n\"paper-table-1\"]",
          "changed.toml:6: sweep.materials: material paper-table-1@1: sets ");
  refused("[[vary]]", "[[vary]]\nname = \"m\"\nmaterials = [\"paper-text\",\n\"absent\"]\n[[vary]]",
          "changed.toml:9: vary.m.materials: material absent: unknown");
  refused("\"present_mass\", ", "\"present_mass\",\n\"absent_mass\", ",
          "changed.toml:6: sweep.responses: \"absent_mass\" is not a response");
  refused("name = \"friction\"", "name = \"density\"", "is taken already");
  refused("[0.1, 0.2, 0.3]", "[0.1, 0.2, 0.3]\nlabels = [\"a\", \"b\"]",
          "changed.toml:14: vary.friction.labels: has 2 texts; expected 3, one a value");
  refused("[0.1, 0.2, 0.3]", "[0.1, 0.2, 0.3]\nlabels = [\"a\", \"b\",\n\"a\"]",
          "vary.friction.labels: \"a\" is there twice");
  refused("[0.1, 0.2, 0.3]", "[0.1, 0.2, 0.3]\nlabels = [\"a\", \"\", \"b\\n\"]",
          "changed.toml:14: vary.friction.labels: cannot be shown on one line");
  refused("keys = [\"materials.ice.density\"]\nvalues = [\"900 kg/m^3\", \"1800 kg/m^3\"]",
          "materials = [\"paper-text\"]\nlabels = [\"a\"]",
          "vary.density.labels: is given with `materials`; expected");
  refused("seeds = 2", "seeds = 2\ndesign = \"morris\"", "expected an even number of levels");
  refused("seeds = 2", "seeds = 2\ntrajectories = 5", "needs `design = \"morris\"`");
  refused("seeds = 2", "seeds = 2\ndesign = \"random\"", "expected one of grid, list, morris");
  refused("values = [0.1, 0.2, 0.3]", "values = [0.1]\nmaterials = [\"ice\"]",
          "expected either keys and values, or materials");
  refused("values = [\"900 kg/m^3\", \"1800 kg/m^3\"]\n", "", "is missing");
}

}  // namespace
}  // namespace firn::cli
